"""Machines designed by the papers' procedures."""

from __future__ import annotations

import governor_mechanism as gm


def design_flywheel(**inputs: float | str) -> gm.FlywheelDesign:
    """Design the flywheel of an air-expansion engine by Redtenbacher's procedure, or find the fluctuation of a given one.

    The inputs that are given replace those of the paper: numbers in SI, or texts with a unit. Of the engine area, stroke, cut_off,
    clearance, pump_area, pump_stroke, pump_clearance, atmospheric_pressure, supply_pressure, back_pressure, load_pressure ("closing": the
    load with which the cycle closes) and speed; of the requirement one of energy_ratio, coefficient and inertia; of the wheel rim_radius,
    rim_share, width_ratio, density, rim_stress, arms, hub_radius and arm_stress.

    Returns
    -------
    FlywheelDesign
        The design; it prints as text, `scene` is the engine with the flywheel under the load that closes its cycle, and `as_json` returns
        plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, or the engine cannot carry its load.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_flywheel(load_pressure="closing", coefficient=0.02)
    >>> round(design.inertia)
    3996
    """
    from governor_mechanism.studies.design import flywheel
    from governor_mechanism.units.fields import change_inputs

    return flywheel.design_flywheel(change_inputs(flywheel.PAPER_INPUTS, inputs))


def design_governed_engine(**inputs: float | str) -> gm.GovernedEngineDesign:
    """Design an engine with its flywheel and Porter governor for a power, a speed and a droop.

    The droop is the speed without load less that at full load, over their mean. The inputs that are given replace the defaults, 20 PS at
    120 rpm with 4 %: numbers in SI, or texts with a unit. Of the requirement power, speed, droop, speed_fluctuation and torque_reserve; of
    the engine stroke_ratio, pump_area_ratio, cut_off, clearance, pump_clearance, supply_pressure, back_pressure, atmospheric_pressure and
    rim_speed; of the governor arm, arm_angle, sleeve_travel or offset, mass_ratio or gear_ratio, resistance, insensitivity or ball_mass,
    dashpot and gravity.

    Returns
    -------
    GovernedEngineDesign
        The design; it prints as text, `scene` is the engine under a load that falls to the half, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, the pressures give no work, or the governor cannot have the droop.

    References
    ----------
    L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14; I. A. Wischnegradsky (Vyshnegradskii), Civilingenieur 23 (1877),
    pp. 95-132.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_governed_engine(power="20 PS", speed="120 rpm", droop=0.04)
    >>> round(design.flywheel.inertia)
    2926
    """
    from governor_mechanism.studies.design import engine_governor, governed_engine
    from governor_mechanism.units.fields import change_inputs

    return governed_engine.design_governed_engine(change_inputs(engine_governor.DEFAULT_INPUTS, inputs))


def design_pendulum(**inputs: float | str) -> gm.PendulumDesign:
    """Design a pendulum governor, after Watt or Porter, by Zehnder's procedure I to VIII.

    The inputs that are given replace the defaults, a Porter governor for 120 to 126 rpm against 6 kgf: numbers in SI, or texts with a unit.
    kind is "porter", "watt" or "improved-watt"; of the requirement lowest_speed, highest_speed, mass_ratio, insensitivity,
    speed_fluctuation and resistance; of the geometry start_radius, one of arm and offset, and joint_ratio; and gravity.

    Returns
    -------
    PendulumDesign
        The design; it prints as text, `scene` is the governor under a rising speed, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, or no such governor reaches the highest speed.

    References
    ----------
    L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_pendulum(arm="300 mm")
    >>> round(1e3 * design.sleeve_lift, 3)
    36.128
    """
    from governor_mechanism.studies.design import pendulum
    from governor_mechanism.units.fields import change_inputs

    return pendulum.design_pendulum(change_inputs(pendulum.DEFAULT_INPUTS, inputs))


def design_hartnell(**inputs: float | str) -> gm.HartnellDesign:
    """Design the spring of a Hartnell governor for two speeds, by the textbooks' formula and by exact statics.

    The inputs that are given replace those of a textbook example, 290 to 310 rpm over a lift of 15 mm: numbers in SI, or texts with a unit.
    ball_mass, sleeve_mass, ball_arm, sleeve_arm, bell_crank_angle, pivot_radius (inner_radius if left out), inner_radius, one of
    outer_radius and lift, lowest_speed, highest_speed and gravity.

    Returns
    -------
    HartnellDesign
        The design; it prints as text, `scene` is the governor under a rising speed, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, the arms do not give the lift, or no spring holds the two speeds.

    References
    ----------
    R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Hartnell governor".

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_hartnell(lift="15 mm")
    >>> round(design.textbook.rate / 1e3, 2), round(design.exact.rate / 1e3, 2)
    (19.75, 20.69)
    """
    from governor_mechanism.studies.design import hartnell
    from governor_mechanism.units.fields import change_inputs

    return hartnell.design_hartnell(change_inputs(hartnell.DEFAULT_INPUTS, inputs))

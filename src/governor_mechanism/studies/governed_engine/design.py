"""Design of an engine under a governor: cylinder, flywheel, governor, throttle and dashpot for a power, a speed and a droop.

It uses the closed forms only and does not round intermediate results. The droop is the speed without load less that at full load, over
their mean.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), for engine and flywheel. L. Zehnder, Dinglers Polytechnisches Journal 225
(1877), pp. 1-14, for the governor. I. A. Wischnegradsky (Vyshnegradskii), Civilingenieur 23 (1877), pp. 95-132, for the dashpot.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from governor_mechanism.closed_form.flywheel import throttle as throttling
from governor_mechanism.closed_form.flywheel import wheel
from governor_mechanism.closed_form.flywheel.engine import AirEngine, gas_work
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.governed_engine.dashpot import DashpotDesign, design_dashpot
from governor_mechanism.studies.governed_engine.governor import GovernorDesign, design_governor
from governor_mechanism.studies.governed_engine.inputs import DEFAULT_INPUTS, GovernedEngineInputs, validate_inputs
from governor_mechanism.studies.governed_engine.results import Check, Flywheel, GovernedEngineDesign, ThrottleSetting
from governor_mechanism.studies.governed_engine.scene_export import export_scene_document

THROTTLE_FRACTIONS = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Loads of the table of the throttle rod, relative to the rated torque."""

MASS_RATIO_CONSTANTS = (80.0, 15.0)
"""Zehnder's limits of the mass ratio m: w^2 / 80 - 1 to w^2 / 15 - 1, with the spindle speed w at full load in rad/s."""


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_governed_engine(inputs: GovernedEngineInputs = DEFAULT_INPUTS) -> GovernedEngineDesign:
    """Design an engine with its flywheel, governor, throttle rod and dashpot.

    Parameters
    ----------
    inputs
        The inputs.

    Returns
    -------
    GovernedEngineDesign
        The design.

    Raises
    ------
    MechanismError
        If the inputs are not valid, the pressures give no work, or the governor cannot have the droop.
    """
    validate_inputs(inputs)
    engine, bore = _size_cylinders(inputs)
    governor = design_governor(inputs)
    openings = [float(throttling.throttle_for_torque(engine, torque=torque)) for torque in (inputs.rated_torque, 0.0)]
    flywheel = _size_flywheel(inputs, engine, openings[0])
    torque_slope = -inputs.rated_torque / governor.sleeve_travel
    dashpot = design_dashpot(governor, flywheel.inertia, torque_slope, inputs.dashpot)
    design = GovernedEngineDesign(
        inputs=inputs,
        engine=engine,
        bore=bore,
        rated_torque=inputs.rated_torque,
        flywheel=flywheel,
        governor=governor,
        throttle=tuple(_throttle_setting(governor, engine, inputs.rated_torque, fraction) for fraction in THROTTLE_FRACTIONS),
        throttle_points=_throttle_points(governor, openings, inputs.torque_reserve),
        torque_slope=torque_slope,
        dashpot=dashpot,
        checks=tuple(_checks(inputs, governor, dashpot)),
    )
    return replace(design, scene_document=export_scene_document(design))


def _size_cylinders(inputs: GovernedEngineInputs) -> tuple[AirEngine, float]:
    """Return the engine that gives the rated torque and its reserve with an open throttle, and its bore (m)."""
    unit = inputs.engine(area=1.0, stroke=1.0)
    work = gas_work(unit)
    if not work > 0:
        raise MechanismError(
            f"these pressures give no work: in a stroke the air does {work / 1e3:.6g} kJ on the shaft for each m3 of the cylinder; "
            "increase supply_pressure or cut_off, or reduce back_pressure or pump_area_ratio"
        )
    volume = inputs.rated_torque * (1 + inputs.torque_reserve) / throttling.full_throttle_torque(unit)
    bore = math.cbrt(4 * volume / (math.pi * inputs.stroke_ratio))
    return inputs.engine(area=math.pi * bore**2 / 4, stroke=inputs.stroke_ratio * bore), bore


def _size_flywheel(inputs: GovernedEngineInputs, engine: AirEngine, opening: float) -> Flywheel:
    """Return the flywheel that keeps the fluctuation of speed at full load; the inertia of the governor comes on top."""
    energy = throttling.find_stored_work_range(engine, throttle=opening).energy
    full_load = {"mean_speed": inputs.full_load_speed, "coefficient": inputs.speed_fluctuation}
    inertia = float(wheel.inertia_for_coefficient(energy=energy, **full_load))
    radius = inputs.rim_speed / inputs.speed
    return Flywheel(inertia=inertia, energy=energy, rim_radius=radius, rim_mass=float(wheel.rim_mass(inertia=inertia, radius=radius)))


def _throttle_setting(governor: GovernorDesign, engine: AirEngine, rated_torque: float, fraction: float) -> ThrottleSetting:
    """Return lift, opening and speed at a load."""
    opening = float(throttling.throttle_for_torque(engine, torque=fraction * rated_torque))
    return ThrottleSetting(load_fraction=fraction, lift=governor.lift(fraction), opening=opening, speed=governor.shaft_speed(fraction))


def _throttle_points(governor: GovernorDesign, openings: list[float], reserve: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends (lift in m, opening) of the line through full load and no load: open, and closed as far as the reserve."""
    at_full_load, at_no_load = openings
    per_opening = governor.sleeve_travel / (at_full_load - at_no_load)
    closed = max(0.0, at_no_load - reserve * (at_full_load - at_no_load))
    return (
        (governor.full_load_lift - (1 - at_full_load) * per_opening, 1.0),
        (governor.no_load_lift + (at_no_load - closed) * per_opening, closed),
    )


def _checks(inputs: GovernedEngineInputs, governor: GovernorDesign, dashpot: DashpotDesign) -> Iterator[Check]:
    """Yield the rules of the design with their numbers."""
    force_cure = "reduce insensitivity" if inputs.ball_mass is None else "reduce resistance, or increase ball_mass"
    yield Check(
        rule="insensitivity below the droop, or the resistance hides the load (Zehnder, Dubois)",
        found=governor.insensitivity,
        highest=inputs.droop,
        cure=force_cure,
    )
    yield Check(
        rule="insensitivity above the speed fluctuation, or the sleeve moves in every turn (Zehnder)",
        found=governor.insensitivity,
        lowest=inputs.speed_fluctuation,
        cure="the dashpot has to hold it, or reduce speed_fluctuation",
    )
    yield Check(rule="effort at the sleeve over its resistance", found=governor.effort / inputs.resistance, lowest=1.0, cure=force_cure)
    squared_speed = (governor.gear_ratio * governor.full_load_speed) ** 2
    low, high = (squared_speed / constant - 1 for constant in MASS_RATIO_CONSTANTS)
    yield Check(
        rule="mass of the sleeve over that of one ball (Zehnder)",
        found=governor.mass_ratio,
        lowest=low,
        highest=high,
        cure="change the length of the arms",
    )
    yield Check(
        rule="Vyshnegradskii's x y at the worst load, stable above 1",
        found=dashpot.stability_margin,
        lowest=1.0,
        cure=f"give a dashpot above {dashpot.smallest_stable_damping:.4g} N s/m",
    )

"""A designed engine as a scene document: under its governor, with a load that falls from the rated torque to the half."""

import math
from typing import Any

from governor_mechanism.closed_form.flywheel import throttle as throttling
from governor_mechanism.closed_form.flywheel import wheel
from governor_mechanism.machines.flywheel_engine.dimensions import MEAN
from governor_mechanism.studies.governed_engine.results import GovernedEngineDesign

LOAD_CHANGE = (1.0, 0.5)
"""Load before and after its change, relative to the rated torque."""

N_DECAYS_BEFORE, N_DECAYS_AFTER = 8.0, 16.0
"""Decay times of the slowest motion before and after the change: the start has faded to exp(-8), 3e-4. With friction it takes longer."""

MIN_TURNS, MAX_TURNS = 8, 300
"""Turns of the shaft before and after the change: enough to judge the mean speed, and no more than take a minute."""

MIN_SCENE_TURNS = 45
"""Turns of the run of a scene file, at least: the study of a change of load at a tenth of the run then has turns enough before it."""

POINTS_PER_TURN = 100
"""Reported times in a turn."""

ACCURACY, MEAN_TORQUE_ACCURACY = 1e-4, 1e-8
"""Accuracy of the runs with the torque of every instant and with the mean torque.

In some hundred turns, each with kinks of the torque, errors of the angle add up to some 1e-5 rad. An accuracy of 1e-4 is one of 1e-5 of the
speed at 120 rpm, below a thousandth of droop and speed fluctuation. The mean torque has no kinks.
"""


def export_scene_document(design: GovernedEngineDesign, *, mean_torque: bool = False, with_resistance: bool = False) -> dict[str, Any]:
    """Return a runnable scene of a design, whose load falls to the half.

    Parameters
    ----------
    design
        The design.
    mean_torque
        Whether the torque of the air is averaged over a turn, as in the theory of governing.
    with_resistance
        Whether the resistance is in it, as dry friction at the sleeve.

    Returns
    -------
    dict[str, Any]
        The document of a scene file.
    """
    begin, end = change_times(design)
    duration = max(end, MIN_SCENE_TURNS * math.tau / design.inputs.full_load_speed)
    opening, closed = design.throttle_points
    kind = "mean torque" if mean_torque else "designed"
    return {
        "title": f"Air engine under a Porter governor, {kind}",
        "run": {
            "duration": f"{duration:.6g} s",
            "output_interval": f"{math.tau / design.inputs.speed / POINTS_PER_TURN:.6g} s",
            "accuracy": MEAN_TORQUE_ACCURACY if mean_torque else ACCURACY,
        },
        "load": {
            "angle": "engine.crank_angle",
            "rated_torque": f"{design.rated_torque:.15g} N m",
            "fraction": [[0, LOAD_CHANGE[0]], [begin, LOAD_CHANGE[0]], [begin, LOAD_CHANGE[1]]],
        },
        "part": {
            "engine": {
                "machine": "flywheel_engine",
                "dimensions": _engine_dimensions(design) | ({"gas_torque": MEAN} if mean_torque else {}),
                "start": {"crank_angle": "0 deg", "crank_rate": f"{_start_speed(design, mean_torque):.12g} rad/s"},
            },
            "governor": {
                "machine": "pendulum_governor",
                "dimensions": _governor_dimensions(design),
                "effects": {
                    "gravity": True if design.inputs.gravity == 9.81 else f"{design.inputs.gravity:.15g} m/s^2",
                    "centrifugal": True,
                    "dashpot": {"sleeve": f"{design.dashpot.damping:.12g} N s/m"},
                    **({"dry_friction": {"sleeve": f"{design.inputs.resistance:.15g} N"}} if with_resistance else {}),
                },
                "start": {"arm_angle": f"{math.degrees(design.governor.full_load_angle):.15g} deg"},
            },
        },
        "coupling": {
            "gear": {
                "type": "gear",
                "first": "engine.crank_angle",
                "second": "governor.spindle_angle",
                "ratio": design.governor.gear_ratio,
            },
            "throttle_rod": {
                "type": "control",
                "reading": "governor.sleeve_lift",
                "scales": "engine.throttle",
                "table": [[_format_mm(lift), value] for lift, value in (opening, closed)],
            },
        },
    }


def change_times(design: GovernedEngineDesign) -> tuple[float, float]:
    """Return the time of the change of load and that at which it is over, s: tenths of a second, by the slowest motion of the design.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    tuple[float, float]
        Both times, s.
    """
    period = math.tau / design.inputs.full_load_speed
    rate = design.dashpot.decay_rate

    def limited(duration: float) -> float:
        return math.ceil(10 * min(max(MIN_TURNS * period, duration), MAX_TURNS * period)) / 10

    # A motion that grows needs time after the change only.
    begin = limited(N_DECAYS_BEFORE / rate if rate > 0 else 0.0)
    after = limited(N_DECAYS_AFTER / abs(rate) if rate else math.inf)
    return begin, begin + after


def _engine_dimensions(design: GovernedEngineDesign) -> dict[str, Any]:
    engine = design.engine
    pressures = {name: getattr(engine, name) for name in ("supply_pressure", "back_pressure", "atmospheric_pressure")}
    return {
        "area": f"{engine.area * 1e4:.15g} cm^2",
        "stroke": _format_mm(engine.stroke),
        "cut_off": engine.cut_off,
        "clearance": engine.clearance,
        "pump_area": f"{engine.pump_area * 1e4:.15g} cm^2",
        "pump_clearance": engine.pump_clearance,
        **{name: f"{pressure / 1e5:.15g} bar" for name, pressure in pressures.items()},
        "throttle": 1.0,
        "load_torque": 0.0,
        "inertia": f"{design.flywheel.inertia:.15g} kg m^2",
        "rim_radius": _format_mm(design.flywheel.rim_radius),
    }


def _governor_dimensions(design: GovernedEngineDesign) -> dict[str, Any]:
    governor = design.governor.governor
    return {
        "arm": _format_mm(governor.arm),
        "offset": _format_mm(governor.offset),
        "ball_mass": f"{governor.ball_mass:.15g} kg",
        "sleeve_mass": f"{governor.sleeve_mass:.15g} kg",
    }


def _start_speed(design: GovernedEngineDesign, mean_torque: bool) -> float:
    """Return the speed (rad/s) at the dead centre of the periodic motion at full load."""
    mean_speed, inertia = design.governor.full_load_speed, design.flywheel.inertia
    if mean_torque:
        return mean_speed
    stored = throttling.find_stored_work_range(design.engine, throttle=design.throttle[0].opening)
    lowest, _ = wheel.speed_limits(inertia=inertia, energy=stored.energy, mean_speed=mean_speed)
    return float(wheel.speed_after_work(inertia=inertia, start_speed=lowest, work=-stored.lowest))


def _format_mm(length: float) -> str:
    return f"{length * 1e3:.15g} mm"

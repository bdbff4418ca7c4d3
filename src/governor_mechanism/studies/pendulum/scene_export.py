"""A designed pendulum governor as a scene: held by its resistance, then moved by a rise of its speed."""

import math
from typing import Any

from governor_mechanism.closed_form.pendulum import dynamics
from governor_mechanism.studies.pendulum.inputs import RPM
from governor_mechanism.studies.pendulum.results import PendulumDesign

DAMPING_RATIO = 0.7
"""Damping ratio of the dashpot half way up: the sleeve follows the speed without much overshoot."""

START_FRACTION, TARGET_FRACTION = 0.5, 0.75
"""Fractions of the lift at which the sleeve starts, and to which the rise of the speed brings it against the resistance."""

HOLD_TIME = 0.5
"""Time before the speed rises, s."""

RISE_PERIODS, SETTLING_PERIODS = 2.0, 2.5
"""Duration of the rise and time to settle after it, in periods of small oscillations half way up."""

DURATION_LIMITS = (0.5, 60.0)
"""Shortest and longest rise and settling, s: a governor near its astatic position has periods without bound."""

POINTS_PER_PERIOD = 200
"""Reported times in a period."""


def export_scene_document(design: PendulumDesign) -> dict[str, Any]:
    """Return a runnable scene of the design.

    Half way up and in equilibrium, the sleeve is held by its resistance while the speed rises within the band of insensitivity, then
    rises with it to three quarters of its lift.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    dict[str, Any]
        The document of a scene file.
    """
    inputs, governor = design.inputs, design.governor
    middle = design.middle_angle
    # Stable half way up even with too long an arm: its speed falls faster below the minimum than it rises above.
    period = math.tau / math.sqrt(float(dynamics.squared_oscillation_frequency(governor, arm_angle=middle)))
    rise, settling = (min(max(DURATION_LIMITS[0], ratio * period), DURATION_LIMITS[1]) for ratio in (RISE_PERIODS, SETTLING_PERIODS))
    first, last = design.equilibrium_speed(middle), target_speed(design)
    program = ((0.0, first), (HOLD_TIME, first), (HOLD_TIME + rise, last), (HOLD_TIME + rise + settling, last))
    duration = program[-1][0]
    joint = {} if inputs.joint_ratio == 1 else {"arm_joint": _format_mm(governor.joint_length)}
    sleeve = {"sleeve_mass": f"{governor.sleeve_mass:.15g} kg"} if governor.sleeve_mass else {}
    return {
        "title": f"{_TITLES[inputs.kind]}, designed for {_format_rpm(design)} rpm",
        "machine": "pendulum_governor",
        "dimensions": {
            "arm": _format_mm(governor.arm),
            "offset": _format_mm(governor.offset),
            **joint,
            "ball_mass": f"{governor.ball_mass:.15g} kg",
            **sleeve,
        },
        "effects": {
            "gravity": True if inputs.gravity == 9.81 else f"{inputs.gravity:.15g} m/s^2",
            "centrifugal": True,
            "dry_friction": {"sleeve": f"{design.requirement.resistance:.15g} N"},
            "dashpot": {"sleeve": f"{sleeve_damping(design):.4g} N s/m"},
            "stops": {"arm_angle": [_format_deg(angle) for angle in design.arm_angles]},
        },
        "spindle": {"speed": [[round(time, 6), f"{speed / RPM:.15g} rpm"] for time, speed in program]},
        "start": {"arm_angle": _format_deg(middle)},
        "run": {"duration": f"{duration:.6f} s", "output_interval": f"{min(0.02, duration / POINTS_PER_PERIOD):.3g} s", "accuracy": 1e-6},
    }


def target_speed(design: PendulumDesign) -> float:
    """Return the speed (rad/s) at which the sleeve comes to rest at TARGET_FRACTION of its lift as it rises: Zehnder's (1).

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    float
        Spindle speed, rad/s.
    """
    return design.equilibrium_speed(design.angle_at(TARGET_FRACTION)) * math.sqrt(1 + design.inputs.insensitivity)


def sleeve_damping(design: PendulumDesign) -> float:
    """Return the damping of the dashpot on the sleeve (N s/m), from the stiffness K and the inertia I half way up.

    The sleeve rises by z' = 2 l1 sin a per arm angle, so a damping ratio D takes c z'^2 = 2 D sqrt(K I).

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    float
        Damping, N s/m.
    """
    angle = design.middle_angle
    stiffness = float(dynamics.stiffness(design.governor, arm_angle=angle))
    squared_frequency = float(dynamics.squared_oscillation_frequency(design.governor, arm_angle=angle))
    lift_derivative = 2 * design.governor.joint_length * math.sin(angle)
    return 2 * DAMPING_RATIO * stiffness / math.sqrt(squared_frequency) / lift_derivative**2


_TITLES = {"watt": "Watt governor", "improved-watt": "Improved Watt governor", "porter": "Porter governor"}
"""Names of the governors by kind."""


def _format_rpm(design: PendulumDesign) -> str:
    return " to ".join(f"{speed / RPM:.5g}" for speed in (design.requirement.lowest_speed, design.requirement.highest_speed))


def _format_mm(length: float) -> str:
    return f"{length * 1e3:.15g} mm"


def _format_deg(angle: float) -> str:
    return f"{math.degrees(angle):.15g} deg"

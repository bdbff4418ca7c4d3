"""A designed Hartnell governor as a scene document."""

import math
from typing import Any

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.effects.gravity import DEFAULT_GRAVITY
from governor_mechanism.studies.hartnell.inputs import RPM
from governor_mechanism.studies.hartnell.results import HartnellDesign

SPEED_MARGIN_RATIO = 0.02
"""Distance of the simulated speeds from the wanted ones, relative to their difference; at these the sleeve would be at its stops."""
DAMPING_RATIO = 0.7
"""Damping ratio of the dashpot half way up: the sleeve follows the speed without much overshoot."""
STEP_TIMES = (0, 1, 2, 3, 4, 6)
"""Times of the program of the speed in units of a step, with rises from 1 to 2 and from 3 to 4."""
STEP_PERIODS, STEP_LIMITS = 2.0, (0.5, 30.0)
"""A step in periods of small oscillations half way, and its shortest and longest duration, s."""


def export_scene_document(design: HartnellDesign) -> dict[str, Any]:
    """Return a runnable scene of the design: the speed rises from the lowest to the highest in two steps, with stops and a dashpot.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    dict[str, Any]
        The document of a scene file.
    """
    inputs, spring = design.inputs, design.exact
    low, high = inputs.lowest_speed, inputs.highest_speed
    speeds = [low + fraction * (high - low) for fraction in (SPEED_MARGIN_RATIO, 0.5, 1 - SPEED_MARGIN_RATIO)]
    step = _step_duration(design)
    steps = zip(STEP_TIMES, (speed for speed in speeds for _ in range(2)), strict=True)
    sleeve = {"sleeve_mass": f"{inputs.sleeve_mass:.15g} kg"} if inputs.sleeve_mass else {}
    weight = {} if inputs.gravity == 0 else {"gravity": True if inputs.gravity == DEFAULT_GRAVITY else f"{inputs.gravity:.15g} m/s^2"}
    return {
        "title": f"Hartnell governor, designed for {low / RPM:.5g} to {high / RPM:.5g} rpm",
        "machine": "hartnell",
        "dimensions": {
            "ball_arm": _format_mm(inputs.ball_arm),
            "sleeve_arm": _format_mm(inputs.sleeve_arm),
            "bell_crank_angle": f"{math.degrees(inputs.bell_crank_angle):.15g} deg",
            "pivot_radius": _format_mm(inputs.pivot_radius or 0.0),
            "inner_radius": _format_mm(inputs.inner_radius),
            "ball_mass": f"{inputs.ball_mass:.15g} kg",
            **sleeve,
        },
        "effects": {
            **weight,
            "centrifugal": True,
            "spring": {"sleeve": {"rate": f"{spring.rate / 1e3:.15g} N/mm", "preload": f"{spring.forces[0]:.15g} N"}},
            "dashpot": {"sleeve": f"{sleeve_damping(design):.3g} N s/m"},
            "stops": {"sleeve": ["0 mm", _format_mm(design.travel.lift)]},
        },
        "spindle": {"speed": [[round(step * time, 6), f"{speed / RPM:.15g} rpm"] for time, speed in steps]},
        "start": {"arm_angle": "equilibrium"},
        "run": {"duration": f"{round(step * STEP_TIMES[-1], 6):g} s", "output_interval": f"{step / 50:.3g} s", "accuracy": 1e-6},
    }


def sleeve_damping(design: HartnellDesign) -> float:
    """Return the damping of the dashpot on the sleeve (N s/m), from the natural frequency half way along the arms' swing.

    With the inertia I of the arm angle and the derivative z' of the lift, a damping ratio D takes c z'^2 = 2 D I w.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    float
        Damping, N s/m.
    """
    governor, angle = design.governor, 0.5 * sum(design.travel.arm_angles)
    lift_derivative = governor.sleeve_arm * math.sin(governor.angle - angle)
    inertia = 2 * governor.ball_mass * governor.ball_arm**2 + governor.sleeve_mass * lift_derivative**2
    return 2 * DAMPING_RATIO * inertia * _natural_frequency(design) / lift_derivative**2


def _natural_frequency(design: HartnellDesign) -> float:
    """Return the frequency (rad/s) of small oscillations half way along the arms' swing."""
    governor, angle = design.governor, 0.5 * sum(design.travel.arm_angles)
    force = 0.5 * sum(design.exact.forces)
    speed = float(closed.equilibrium_speed(governor, arm_angle=angle, spring_force=force))
    load = {"spring_force": force, "spring_rate": design.exact.rate, "spindle_speed": speed}
    return math.sqrt(abs(float(closed.squared_natural_frequency(governor, arm_angle=angle, **load))))


def _step_duration(design: HartnellDesign) -> float:
    """Return the duration (s) of a step of the program of the speed."""
    return min(max(STEP_LIMITS[0], STEP_PERIODS * math.tau / _natural_frequency(design)), STEP_LIMITS[1])


def _format_mm(length: float) -> str:
    return f"{length * 1e3:.15g} mm"

"""A designed governor as a scene document."""

import math
from typing import Any

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.studies.hartung.design import HartungDesign

SPEED_MARGIN_RATIO = 0.02
"""Distance of the simulated speeds from the slow and the fast speed, relative to their difference; at these it would be at its stops."""
DAMPING_RATIO = 0.7
"""Damping ratio of the dashpot of the scene at mid stroke."""


def export_scene_document(design: HartungDesign) -> dict[str, Any]:
    """Return a runnable scene of the design: a run-up from the slow to the fast speed, with stops and a dashpot.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    dict[str, Any]
        The document of a scene file.
    """
    inputs, governor = design.inputs, design.layout.governor
    slow, fast = (speed * 30 / math.pi for speed in (inputs.slow_speed, inputs.fast_speed))
    swing = f"{math.degrees(inputs.swing):.12g} deg"
    return {
        "title": "Hartung governor, designed",
        "machine": "hartung",
        "dimensions": {
            "weight_arm": _format_mm(governor.weight_arm),
            "sleeve_arm": _format_mm(governor.sleeve_arm),
            "bell_crank_angle": f"{math.degrees(governor.angle):.12g} deg",
            "fulcrum_radius": _format_mm(governor.fulcrum_radius),
            "fulcrum_height": _format_mm(inputs.fulcrum_height),
            "weight_mass": f"{governor.weight_mass:.12g} kg",
            "sleeve_mass": f"{governor.sleeve_mass:.12g} kg",
            "hanger": "vertical",
            "inner_angle": swing,
            "outer_angle": f"-{swing}",
            "spring_wire": _format_mm(inputs.wire),
            "spring_coil": _format_mm(inputs.coil),
            "spring_turns": float(f"{design.turns:.12g}"),
            "spring_modulus": f"{inputs.modulus / 1e9:.12g} GPa",
            "spring_stress_limit": f"{inputs.stress_limit:.12g} Pa",
            "spring_preload": f"{design.preload:.12g} N",
            "preload_radius": _format_mm(float(design.layout.radii[0])),
            "insensitivity": inputs.insensitivity,
        },
        "effects": {
            "gravity": True,
            "centrifugal": True,
            "dashpot": {"sleeve": f"{_sleeve_damping(design):.3g} N s/m"},
            "stops": {"lever_angle": [f"-{swing}", swing]},
        },
        "spindle": {"speed": [[time, f"{speed:.12g} rpm"] for time, speed in _speed_steps(slow, fast)]},
        "start": {"lever_angle": "equilibrium"},
        "run": {"duration": "7 s", "output_interval": "10 ms", "accuracy": 1e-6},
    }


def _speed_steps(slow: float, fast: float) -> list[tuple[float, float]]:
    """Return (time s, speed rpm) of a run-up in two steps, each with time to settle."""
    low, middle, high = (slow + fraction * (fast - slow) for fraction in (SPEED_MARGIN_RATIO, 0.5, 1 - SPEED_MARGIN_RATIO))
    return [(0.0, low), (1.0, low), (2.0, middle), (4.0, middle), (5.0, high), (7.0, high)]


def _sleeve_damping(design: HartungDesign) -> float:
    """Return the damping of the dashpot on the sleeve (N s/m) from stiffness and inertia at mid stroke."""
    governor, forces = design.layout.governor, design.layout.spring_forces
    spring = {"spring_force": float(forces[len(forces) // 2]), "spring_rate": design.spring_rate}
    squared_frequency = float(closed.squared_natural_frequency(governor, lever_angle=0.0, **spring))
    lift_derivative = float(closed.lift_derivative(governor, lever_angle=0.0))
    inertia = float(closed.lever_inertia(governor, lever_angle=0.0))
    return 2 * DAMPING_RATIO * inertia * math.sqrt(abs(squared_frequency)) / lift_derivative**2


def _format_mm(metres: float) -> str:
    return f"{metres * 1e3:.12g} mm"

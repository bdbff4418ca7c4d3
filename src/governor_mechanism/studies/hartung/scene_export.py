"""The scene of a governor that was designed, as a document and as the text of a file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.studies.hartung.design import HartungDesign

WITHIN = 0.02
"""Of the way from the slow to the fast speed: so much nearer than these it is run, or it would rest on its stops."""
DAMPED = 0.7
"""Of the critical damping at mid stroke: the brake that a scene is given."""


def scene_of(design: HartungDesign, title: str = "Hartung governor, designed") -> dict[str, Any]:
    """A scene of the design, ready to run: run up from the slow to the fast speed, with stops and an oil brake."""
    inputs, governor = design.inputs, design.layout.governor
    slow, fast = (speed * 30 / math.pi for speed in (inputs.slow_speed, inputs.fast_speed))
    swing = f"{math.degrees(inputs.swing):.12g} deg"
    return {
        "title": title,
        "machine": "hartung",
        "dimensions": {
            "weight_arm": _mm(governor.weight_arm),
            "sleeve_arm": _mm(governor.sleeve_arm),
            "bell_crank_angle": f"{math.degrees(governor.angle):.12g} deg",
            "fulcrum_radius": _mm(governor.fulcrum_radius),
            "fulcrum_height": _mm(inputs.fulcrum_height),
            "weight_mass": f"{governor.weight_mass:.12g} kg",
            "sleeve_mass": f"{governor.sleeve_mass:.12g} kg",
            "hanger": "vertical",
            "inner_angle": swing,
            "outer_angle": f"-{swing}",
            "spring_wire": _mm(inputs.wire),
            "spring_coil": _mm(inputs.coil),
            "spring_turns": float(f"{design.turns:.12g}"),
            "spring_modulus": f"{inputs.modulus / 1e9:.12g} GPa",
            "spring_stress_limit": f"{inputs.stress_limit:.12g} Pa",
            "spring_preload": f"{design.preload:.12g} N",
            "preload_radius": _mm(float(design.layout.radii[0])),
            "insensitivity": inputs.insensitivity,
        },
        "effects": {
            "gravity": True,
            "centrifugal": True,
            "oil_brake": {"sleeve": f"{_brake(design):.3g} N s/m"},
            "stops": {"lever_angle": [f"-{swing}", swing]},
        },
        "spindle": {"speed": [[time, f"{speed:.12g} rpm"] for time, speed in _run_up(slow, fast)]},
        "start": {"lever_angle": "equilibrium"},
        "run": {"duration": "7 s", "every": "10 ms", "accuracy": 1e-6},
    }


def _run_up(slow: float, fast: float) -> list[tuple[float, float]]:
    """A program of speed (rpm): up in two steps, with time to settle after each."""
    low, middle, high = (slow + part * (fast - slow) for part in (WITHIN, 0.5, 1 - WITHIN))
    return [(0.0, low), (1.0, low), (2.0, middle), (4.0, middle), (5.0, high), (7.0, high)]


def _brake(design: HartungDesign) -> float:
    """Of the sleeve (N s/m), from stiffness and inertia at mid stroke."""
    governor, forces = design.layout.governor, design.layout.spring_forces
    middle = float(forces[len(forces) // 2])
    sprung: dict[str, Any] = {"lever_angle": 0.0, "spring_force": middle, "spring_rate": design.spring_rate}
    square = float(closed.squared_frequency(governor, **sprung))
    rise = float(closed.lift_slope(governor, lever_angle=0.0))
    whole = float(closed.inertia(governor, lever_angle=0.0))
    return 2 * DAMPED * whole * math.sqrt(abs(square)) / rise**2


def scene_text(document: Mapping[str, Any], remark: str) -> str:
    """The document of a scene as a TOML file that opens with a remark."""
    top = {key: value for key, value in document.items() if not isinstance(value, Mapping)}
    lines = [f"# {remark}", *(f"{key} = {_toml(value)}" for key, value in top.items())]
    for name, table in document.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.12g} mm"

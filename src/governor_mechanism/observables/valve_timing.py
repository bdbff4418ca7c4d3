"""When a slide valve's ports open and close: the events of steam on the mechanism itself, by kinematics alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slide_valve import SlideValve
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

CYLINDER_ENDS = ("crank end", "head end")

PORT_EVENTS = {"steam": ("admission", "cut-off"), "exhaust": ("release", "compression")}
"""By port, what it is called when it opens and when it closes."""

VALVE_DISPLACEMENT = "valve_displacement"

N_SCAN_ANGLES = 24
"""Crank angles in a turn at which the valve's dead centres are looked for; it has two."""

DEAD_CENTRE_TOLERANCE = 1e-8
"""rad: a dead centre found to that is found; near it the valve hardly moves."""

EVENT_ANGLE_TOLERANCE = 1e-13
"""rad: a crank angle found to that is found; rounding leaves about 1e-15."""

MAX_EVENT_ITERATIONS = 60
"""Of Newton's method, kept between two ends by halving; a dozen are the rule."""


def require_slide_valve(scene: Scene) -> None:
    """Refuse a scene whose machine has no slide valve."""
    machine = scene.part.machine
    if machine != SlideValve.name:
        raise MechanismError(f"events of steam are those of machine {SlideValve.name!r}; this scene has {machine!r}")


def valve_setting(scene: Scene) -> str:
    """What the centre of the valve's swing is set for, as the scene's file says; empty for a scene from no file."""
    dimensions = dict(scene.document.get("dimensions", {}))
    return str(dimensions.get("setting", SlideValve.setting)) if dimensions else ""


def port_reading_name(end: str, port: str) -> str:
    """The reading that tells how far a port of one of ENDS and PORTS is open."""
    return f"{end.replace(' ', '_')}_{port}"


class ValveKinematics(NamedTuple):
    """Readings by name (n,), with their first and second derivatives by the crank angle."""

    readings: Mapping[str, FloatArray]
    derivatives: Mapping[str, FloatArray]
    second_derivatives: Mapping[str, FloatArray]


def evaluate_at_crank_angles(scene: Scene, angles: FloatArray) -> ValveKinematics:
    """The mechanism at crank angles (n,), each reached from the next lower one."""
    order = np.argsort(angles)
    solution = solve_kinematics(scene, "crank_angle", angles[order])
    inverse_order = np.argsort(order)

    def in_given_order(sorted_arrays: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {name: values[inverse_order] for name, values in sorted_arrays.items()}

    return ValveKinematics(
        in_given_order(solution.readings), in_given_order(solution.rates), in_given_order(solution.reading_accelerations)
    )


def find_event_angles(scene: Scene) -> dict[str, float]:
    """Crank angles (rad, 0 to 2 pi) of all eight events, by names such as "crank end cut-off", to about 1e-13.

    Raises MechanismError for another machine.
    """
    require_slide_valve(scene)
    lowest, highest = _find_valve_dead_centres(scene)
    events: list[tuple[str, str, float, float]] = []
    for end in CYLINDER_ENDS:
        for port, (opens, closes) in PORT_EVENTS.items():
            reading = port_reading_name(end, port)
            displaced = evaluate_at_crank_angles(scene, np.array([lowest, highest])).readings[reading]
            closed_angle, open_angle = (lowest, highest) if displaced[1] > displaced[0] else (highest, lowest)
            events.append((f"{end} {opens}", reading, closed_angle, _next_angle(closed_angle, open_angle)))
            events.append((f"{end} {closes}", reading, open_angle, _next_angle(open_angle, closed_angle)))
    angles = _find_zero_crossings(scene, [(reading, low, high) for _, reading, low, high in events])
    return {name: angle % math.tau for (name, *_), angle in zip(events, angles.tolist(), strict=True)}


def _next_angle(start: float, angle: float) -> float:
    """The second angle, in the turn that follows the first."""
    return start + (angle - start) % math.tau


def _find_valve_dead_centres(scene: Scene) -> tuple[float, float]:
    """Crank angles (rad) at which the valve stands lowest and highest."""
    grid = np.linspace(0.0, math.tau, N_SCAN_ANGLES, endpoint=False)
    displacements = evaluate_at_crank_angles(scene, grid).readings[VALVE_DISPLACEMENT]
    angles = grid[[int(np.argmin(displacements)), int(np.argmax(displacements))]]
    for _ in range(MAX_EVENT_ITERATIONS):
        valve_kinematics = evaluate_at_crank_angles(scene, angles)
        steps = -valve_kinematics.derivatives[VALVE_DISPLACEMENT] / valve_kinematics.second_derivatives[VALVE_DISPLACEMENT]
        angles = angles + steps
        if np.max(np.abs(steps)) < DEAD_CENTRE_TOLERANCE:
            break
    return float(angles[0]), float(angles[1])


def _find_zero_crossings(scene: Scene, brackets: Sequence[tuple[str, float, float]]) -> FloatArray:
    """Where each reading passes nought between two crank angles (rad), by Newton's method kept between them."""
    names = [name for name, _, _ in brackets]
    low, high = (np.array(column) for column in list(zip(*brackets, strict=True))[1:])
    rising = _select_readings(evaluate_at_crank_angles(scene, high).readings, names) > 0
    angles = 0.5 * (low + high)
    for _ in range(MAX_EVENT_ITERATIONS):
        valve_kinematics = evaluate_at_crank_angles(scene, angles)
        values, derivatives = (_select_readings(valve_kinematics.readings, names), _select_readings(valve_kinematics.derivatives, names))
        is_past_zero = (values > 0) == rising
        low, high = np.where(is_past_zero, low, angles), np.where(is_past_zero, angles, high)
        steps = np.divide(-values, derivatives, out=np.full_like(values, np.inf), where=derivatives != 0)
        newton_angles = angles + steps
        is_bracketed = (newton_angles > low) & (newton_angles < high)
        if np.all(np.abs(steps) < EVENT_ANGLE_TOLERANCE):
            break
        angles = np.where(is_bracketed | (np.abs(steps) < EVENT_ANGLE_TOLERANCE), newton_angles, 0.5 * (low + high))
    zero_angles: FloatArray = angles
    return zero_angles


def _select_readings(readings: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
    """Each row's own reading."""
    return np.array([readings[name][k] for k, name in enumerate(names)])

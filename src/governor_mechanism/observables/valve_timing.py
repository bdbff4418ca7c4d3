"""When a slide valve's ports open and close: the events of steam on the mechanism itself, by kinematics alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slide_valve import SlideValve
from governor_mechanism.mechanics.kinematics.kinematic_analysis import follow
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

ENDS = ("crank end", "head end")

PORTS = {"steam": ("admission", "cut-off"), "exhaust": ("release", "compression")}
"""By port, what it is called when it opens and when it closes."""

DISPLACEMENT = "valve_displacement"

COARSE = 24
"""Crank angles in a turn at which the valve's dead centres are looked for; it has two."""

STILL = 1e-8
"""rad: a dead centre found to that is found; near it the valve hardly moves."""

CLOSE = 1e-13
"""rad: a crank angle found to that is found; rounding leaves about 1e-15."""

TRIES = 60
"""Of Newton's method, kept between two ends by halving; a dozen are the rule."""


def require_valve(scene: Scene) -> None:
    """Refuse a scene whose machine has no slide valve."""
    machine = scene.part.machine
    if machine != SlideValve.name:
        raise MechanismError(f"events of steam are those of machine {SlideValve.name!r}; this scene has {machine!r}")


def setting_of(scene: Scene) -> str:
    """What the centre of the valve's swing is set for, as the scene's file says; empty for a scene from no file."""
    given = dict(scene.document.get("dimensions", {}))
    return str(given.get("setting", SlideValve.setting)) if given else ""


def reading_of(end: str, port: str) -> str:
    """The reading that tells how far a port of one of ENDS and PORTS is open."""
    return f"{end.replace(' ', '_')}_{port}"


class Moving(NamedTuple):
    """Readings by name (n,), with their first and second derivatives by the crank angle."""

    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    bends: Mapping[str, FloatArray]


def at_angles(scene: Scene, angles: FloatArray) -> Moving:
    """The mechanism at crank angles (n,), each reached from the next lower one."""
    order = np.argsort(angles)
    found = follow(scene, "crank_angle", angles[order])
    back = np.argsort(order)

    def as_asked(named: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {name: values[back] for name, values in named.items()}

    return Moving(as_asked(found.readings), as_asked(found.rates), as_asked(found.accelerations_of))


def event_angles(scene: Scene) -> dict[str, float]:
    """Crank angles (rad, 0 to 2 pi) of all eight events, by names such as "crank end cut-off", to about 1e-13.

    Raises MechanismError for another machine.
    """
    require_valve(scene)
    lowest, highest = _dead_centres(scene)
    wanted: list[tuple[str, str, float, float]] = []
    for end in ENDS:
        for port, (opens, closes) in PORTS.items():
            reading = reading_of(end, port)
            outward = at_angles(scene, np.array([lowest, highest])).readings[reading]
            shut, open_ = (lowest, highest) if outward[1] > outward[0] else (highest, lowest)
            wanted.append((f"{end} {opens}", reading, shut, _after(shut, open_)))
            wanted.append((f"{end} {closes}", reading, open_, _after(open_, shut)))
    angles = _zeros(scene, [(reading, low, high) for _, reading, low, high in wanted])
    return {name: angle % math.tau for (name, *_), angle in zip(wanted, angles.tolist(), strict=True)}


def _after(first: float, second: float) -> float:
    """The second angle, in the turn that follows the first."""
    return first + (second - first) % math.tau


def _dead_centres(scene: Scene) -> tuple[float, float]:
    """Crank angles (rad) at which the valve stands lowest and highest."""
    grid = np.linspace(0.0, math.tau, COARSE, endpoint=False)
    there = at_angles(scene, grid).readings[DISPLACEMENT]
    angles = grid[[int(np.argmin(there)), int(np.argmax(there))]]
    for _ in range(TRIES):
        moving = at_angles(scene, angles)
        steps = -moving.rates[DISPLACEMENT] / moving.bends[DISPLACEMENT]
        angles = angles + steps
        if np.max(np.abs(steps)) < STILL:
            break
    return float(angles[0]), float(angles[1])


def _zeros(scene: Scene, wanted: Sequence[tuple[str, float, float]]) -> FloatArray:
    """Where each reading passes nought between two crank angles (rad), by Newton's method kept between them."""
    names = [name for name, _, _ in wanted]
    low, high = (np.array(column) for column in list(zip(*wanted, strict=True))[1:])
    rising = _picked(at_angles(scene, high).readings, names) > 0
    angles = 0.5 * (low + high)
    for _ in range(TRIES):
        moving = at_angles(scene, angles)
        values, slopes = _picked(moving.readings, names), _picked(moving.rates, names)
        beyond = (values > 0) == rising
        low, high = np.where(beyond, low, angles), np.where(beyond, angles, high)
        steps = np.divide(-values, slopes, out=np.full_like(values, np.inf), where=slopes != 0)
        there = angles + steps
        inside = (there > low) & (there < high)
        if np.all(np.abs(steps) < CLOSE):
            break
        angles = np.where(inside | (np.abs(steps) < CLOSE), there, 0.5 * (low + high))
    found: FloatArray = angles
    return found


def _picked(readings: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
    """Each row's own reading."""
    return np.array([readings[name][k] for k, name in enumerate(names)])

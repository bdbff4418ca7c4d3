"""The loads of a mechanism as rows of numbers, and the generalised forces they amount to, compiled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.kinematics.points import place
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import Program
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, RecordArray

SPRING, DAMPER, TORSION_SPRING, TORSION_DAMPER, TORQUE, FORCE = range(6)
"""Kinds. Numbers: (stiffness, free length), (damping), (stiffness, free angle), (damping), none, none."""

damper_force = kernel(forces.damper_force)
spring_force = kernel(forces.spring_force)


LOAD = np.dtype(
    [
        *((name, "i8") for name in ("kind", "first", "second")),
        *((name, "f8") for name in ("x1", "y1", "x2", "y2", "strength", "free")),
        *((name, "i8") for name in ("program", "program_y")),
    ]
)
"""One load: its kind, bodies, points on them, numbers; the programs of a torque, or of a force's two parts, or -1."""


@dataclass(frozen=True)
class _Numbers:
    kind: int
    first: Point
    second: Point
    number: tuple[float, float] = (0.0, 0.0)
    programs: tuple[Program, ...] = ()


@singledispatch
def _numbers(load: Load) -> _Numbers:
    raise TypeError(f"no law is written for loads of type {type(load).__name__}")


@_numbers.register
def _(load: Spring) -> _Numbers:
    return _Numbers(SPRING, load.first, load.second, (load.stiffness, load.free_length))


@_numbers.register
def _(load: Damper) -> _Numbers:
    return _Numbers(DAMPER, load.first, load.second, (load.damping, 0.0))


@_numbers.register
def _(load: TorsionSpring) -> _Numbers:
    ends = Point(body=load.first), Point(body=load.second)
    return _Numbers(TORSION_SPRING, *ends, (load.stiffness, load.free_angle))


@_numbers.register
def _(load: TorsionDamper) -> _Numbers:
    return _Numbers(TORSION_DAMPER, Point(body=load.first), Point(body=load.second), (load.damping, 0.0))


@_numbers.register
def _(load: Torque) -> _Numbers:
    return _Numbers(TORQUE, Point(body=load.first), Point(body=load.second), programs=(load.moment,))


@_numbers.register
def _(load: Force) -> _Numbers:
    return _Numbers(FORCE, Point(body=GROUND), load.point, programs=(load.x, load.y))


def load_table(
    mechanism: Mechanism, origins: Mapping[str, tuple[float, float]], taken: int
) -> tuple[RecordArray, tuple[Program, ...]]:
    """The loads as records, and their programs; these are counted from `taken` on."""
    every = [_numbers(load) for load in mechanism.loads]

    def anchor(point: Point) -> tuple[float, float]:
        x, y = origins.get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    programs: list[Program] = []
    table = np.zeros(len(every), dtype=LOAD)
    for at, load in enumerate(every):
        found = [taken + len(programs) + k for k in range(len(load.programs))]
        programs += load.programs
        ends = [mechanism.body_index(point.body) for point in (load.first, load.second)]
        table[at] = (load.kind, *ends, *anchor(load.first), *anchor(load.second), *load.number, *(*found, -1, -1)[:2])
    return table, tuple(programs)


@kernel
def _now(cubics: FloatArray, program: int, since: float) -> float:
    a, b, c, d = cubics[program, 0], cubics[program, 1], cubics[program, 2], cubics[program, 3]
    return float(((a * since + b) * since + c) * since + d)


@kernel
def _point(
    poses: FloatArray, velocities: FloatArray, body: int, x: float, y: float
) -> tuple[float, float, float, float]:
    """Arm from the body's origin to the point, and the point's velocity."""
    if body < 0:
        return x, y, 0.0, 0.0
    cosine, sine, turning = math.cos(poses[body, 2]), math.sin(poses[body, 2]), velocities[body, 2]
    arm_x, arm_y = cosine * x - sine * y, sine * x + cosine * y
    return arm_x, arm_y, velocities[body, 0] - arm_y * turning, velocities[body, 1] + arm_x * turning


@kernel
def _push(result: FloatArray, body: int, arm_x: float, arm_y: float, force_x: float, force_y: float) -> None:
    if body >= 0:
        result[body, 0] += force_x
        result[body, 1] += force_y
        result[body, 2] += arm_x * force_y - arm_y * force_x


@kernel
def add_loads(
    loads: RecordArray, poses: FloatArray, velocities: FloatArray, cubics: FloatArray, since: float, result: FloatArray
) -> float:
    """Add the generalised forces (bodies, 3) of all loads; the power (W) of those that have no potential."""
    power = 0.0
    for i in range(loads.size):
        load = loads[i]
        kind, first, second = load.kind, load.first, load.second
        if kind in (SPRING, DAMPER, FORCE):
            arm1_x, arm1_y, u1, v1 = _point(poses, velocities, first, load.x1, load.y1)
            arm2_x, arm2_y, u2, v2 = _point(poses, velocities, second, load.x2, load.y2)
            if kind == FORCE:
                force_x, force_y = _now(cubics, load.program, since), _now(cubics, load.program_y, since)
                _push(result, second, arm2_x, arm2_y, force_x, force_y)
                power += force_x * u2 + force_y * v2
                continue
            dx, dy = arm2_x - arm1_x, arm2_y - arm1_y
            if first >= 0:
                dx, dy = dx - poses[first, 0], dy - poses[first, 1]
            if second >= 0:
                dx, dy = dx + poses[second, 0], dy + poses[second, 1]
            length = math.hypot(dx, dy)
            if length == 0.0:
                continue  # no direction to pull in
            rate = ((u2 - u1) * dx + (v2 - v1) * dy) / length
            if kind == SPRING:
                pull = spring_force(load.strength, load.free, length)
            else:
                pull = damper_force(load.strength, rate)
                power -= pull * rate
            force_x, force_y = pull * dx / length, pull * dy / length
            _push(result, first, arm1_x, arm1_y, force_x, force_y)
            _push(result, second, arm2_x, arm2_y, -force_x, -force_y)
        else:
            turn = turning = 0.0
            if second >= 0:
                turn, turning = poses[second, 2], velocities[second, 2]
            if first >= 0:
                turn, turning = turn - poses[first, 2], turning - velocities[first, 2]
            if kind == TORSION_SPRING:
                moment = -spring_force(load.strength, load.free, turn)
            elif kind == TORSION_DAMPER:
                moment = -damper_force(load.strength, turning)
                power += moment * turning
            else:
                moment = _now(cubics, load.program, since)
                power += moment * turning
            if second >= 0:
                result[second, 2] += moment
            if first >= 0:
                result[first, 2] -= moment
    return power


def potential(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Energy (...) J stored in all springs at poses (..., bodies, 3)."""
    total = np.zeros(poses.shape[:-2])
    for load in mechanism.loads:
        if isinstance(load, Spring):
            line = place(mechanism, load.second).position(poses) - place(mechanism, load.first).position(poses)
            total += forces.spring_energy(load.stiffness, load.free_length, np.linalg.norm(line, axis=-1))
        elif isinstance(load, TorsionSpring):
            first, second = (mechanism.body_index(name) for name in load.bodies)
            turn = (poses[..., second, 2] if second >= 0 else 0.0) - (poses[..., first, 2] if first >= 0 else 0.0)
            total += forces.spring_energy(load.stiffness, load.free_angle, turn)
    return total

"""The loads of a mechanism as rows of numbers, and the generalised forces they amount to, compiled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.kinematics.points import body_point
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, RecordArray

SPRING_ELEMENT, DAMPER_ELEMENT, TORSION_SPRING_ELEMENT, TORSION_DAMPER_ELEMENT, TORQUE_ELEMENT, FORCE_ELEMENT = range(6)
"""Kinds. Numbers: (stiffness, free length), (damping), (stiffness, free angle), (damping), none, none."""

_damper_force = jit_internal(forces.damper_force)
_spring_force = jit_internal(forces.spring_force)


FORCE_ELEMENT_DTYPE = np.dtype(
    [
        *((name, "i8") for name in ("kind", "first", "second")),
        *((name, "f8") for name in ("x1", "y1", "x2", "y2", "coefficient", "free_value")),
        *((name, "i8") for name in ("input_index", "input_index_y")),
    ]
)
"""One load: its kind, bodies, points on them, numbers; the programs of a torque, or of a force's two parts, or -1."""


@dataclass(frozen=True)
class _ElementData:
    kind: int
    first: Point
    second: Point
    coefficients: tuple[float, float] = (0.0, 0.0)
    inputs: tuple[InputFunction, ...] = ()


@singledispatch
def _element_data(load: ForceElement) -> _ElementData:
    raise TypeError(f"no law is written for loads of type {type(load).__name__}")


@_element_data.register
def _(load: Spring) -> _ElementData:
    return _ElementData(SPRING_ELEMENT, load.first, load.second, (load.stiffness, load.free_length))


@_element_data.register
def _(load: Damper) -> _ElementData:
    return _ElementData(DAMPER_ELEMENT, load.first, load.second, (load.damping, 0.0))


@_element_data.register
def _(load: TorsionSpring) -> _ElementData:
    points = Point(body=load.first), Point(body=load.second)
    return _ElementData(TORSION_SPRING_ELEMENT, *points, (load.stiffness, load.free_angle))


@_element_data.register
def _(load: TorsionDamper) -> _ElementData:
    return _ElementData(TORSION_DAMPER_ELEMENT, Point(body=load.first), Point(body=load.second), (load.damping, 0.0))


@_element_data.register
def _(load: Torque) -> _ElementData:
    return _ElementData(TORQUE_ELEMENT, Point(body=load.first), Point(body=load.second), inputs=(load.moment,))


@_element_data.register
def _(load: Force) -> _ElementData:
    return _ElementData(FORCE_ELEMENT, Point(body=GROUND), load.point, inputs=(load.x, load.y))


def make_force_element_table(
    mechanism: Mechanism, origins: Mapping[str, tuple[float, float]], first_input: int
) -> tuple[RecordArray, tuple[InputFunction, ...]]:
    """The loads as records, and their programs; these are counted from `taken` on."""
    elements = [_element_data(element) for element in mechanism.force_elements]

    def anchor(point: Point) -> tuple[float, float]:
        x, y = origins.get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    inputs: list[InputFunction] = []
    table = np.zeros(len(elements), dtype=FORCE_ELEMENT_DTYPE)
    for i, element in enumerate(elements):
        input_indices = [first_input + len(inputs) + k for k in range(len(element.inputs))]
        inputs += element.inputs
        bodies = [mechanism.body_index(point.body) for point in (element.first, element.second)]
        table[i] = (
            element.kind,
            *bodies,
            *anchor(element.first),
            *anchor(element.second),
            *element.coefficients,
            *(*input_indices, -1, -1)[:2],
        )
    return table, tuple(inputs)


@jit_internal
def _evaluate_input(input_cubics: FloatArray, input_index: int, local_time: float) -> float:
    a, b, c, d = (input_cubics[input_index, 0], input_cubics[input_index, 1], input_cubics[input_index, 2], input_cubics[input_index, 3])
    return float(((a * local_time + b) * local_time + c) * local_time + d)


@jit_internal
def _point_kinematics(poses: FloatArray, velocities: FloatArray, body: int, x: float, y: float) -> tuple[float, float, float, float]:
    """Arm from the body's origin to the point, and the point's velocity."""
    if body < 0:
        return x, y, 0.0, 0.0
    cosine, sine, angular_velocity = math.cos(poses[body, 2]), math.sin(poses[body, 2]), velocities[body, 2]
    arm_x, arm_y = cosine * x - sine * y, sine * x + cosine * y
    return arm_x, arm_y, velocities[body, 0] - arm_y * angular_velocity, velocities[body, 1] + arm_x * angular_velocity


@jit_internal
def _add_force_at_point(result: FloatArray, body: int, arm_x: float, arm_y: float, force_x: float, force_y: float) -> None:
    if body >= 0:
        result[body, 0] += force_x
        result[body, 1] += force_y
        result[body, 2] += arm_x * force_y - arm_y * force_x


@jit_internal
def add_element_forces(
    elements: RecordArray, poses: FloatArray, velocities: FloatArray, input_cubics: FloatArray, local_time: float, result: FloatArray
) -> float:
    """Add the generalised forces (bodies, 3) of all loads; the power (W) of those that have no potential."""
    power = 0.0
    for i in range(elements.size):
        element = elements[i]
        kind, first, second = element.kind, element.first, element.second
        if kind in (SPRING_ELEMENT, DAMPER_ELEMENT, FORCE_ELEMENT):
            arm1_x, arm1_y, u1, v1 = _point_kinematics(poses, velocities, first, element.x1, element.y1)
            arm2_x, arm2_y, u2, v2 = _point_kinematics(poses, velocities, second, element.x2, element.y2)
            if kind == FORCE_ELEMENT:
                force_x, force_y = (
                    _evaluate_input(input_cubics, element.input_index, local_time),
                    _evaluate_input(input_cubics, element.input_index_y, local_time),
                )
                _add_force_at_point(result, second, arm2_x, arm2_y, force_x, force_y)
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
            if kind == SPRING_ELEMENT:
                tension = _spring_force(element.coefficient, element.free_value, length)
            else:
                tension = _damper_force(element.coefficient, rate)
                power -= tension * rate
            force_x, force_y = tension * dx / length, tension * dy / length
            _add_force_at_point(result, first, arm1_x, arm1_y, force_x, force_y)
            _add_force_at_point(result, second, arm2_x, arm2_y, -force_x, -force_y)
        else:
            relative_angle = relative_rate = 0.0
            if second >= 0:
                relative_angle, relative_rate = poses[second, 2], velocities[second, 2]
            if first >= 0:
                relative_angle, relative_rate = relative_angle - poses[first, 2], relative_rate - velocities[first, 2]
            if kind == TORSION_SPRING_ELEMENT:
                moment = -_spring_force(element.coefficient, element.free_value, relative_angle)
            elif kind == TORSION_DAMPER_ELEMENT:
                moment = -_damper_force(element.coefficient, relative_rate)
                power += moment * relative_rate
            else:
                moment = _evaluate_input(input_cubics, element.input_index, local_time)
                power += moment * relative_rate
            if second >= 0:
                result[second, 2] += moment
            if first >= 0:
                result[first, 2] -= moment
    return power


def spring_potential_energy(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Energy (...) J stored in all springs at poses (..., bodies, 3)."""
    total = np.zeros(poses.shape[:-2])
    for load in mechanism.force_elements:
        if isinstance(load, Spring):
            displacement = body_point(mechanism, load.second).position(poses) - body_point(mechanism, load.first).position(poses)
            total += forces.spring_energy(load.stiffness, load.free_length, np.linalg.norm(displacement, axis=-1))
        elif isinstance(load, TorsionSpring):
            first, second = (mechanism.body_index(name) for name in load.bodies)
            relative_angle = (poses[..., second, 2] if second >= 0 else 0.0) - (poses[..., first, 2] if first >= 0 else 0.0)
            total += forces.spring_energy(load.stiffness, load.free_angle, relative_angle)
    return total

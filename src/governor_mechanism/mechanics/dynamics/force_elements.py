"""Force elements of a mechanism as records, and their generalised forces as compiled kernels."""

import math
from enum import IntEnum
from operator import attrgetter

import numpy as np

from governor_mechanism.mechanics.dynamics.force_laws import damper_force, spring_energy, spring_force
from governor_mechanism.mechanics.kinematics.constraint_kernels import rotate_vector_jit
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives
from governor_mechanism.mechanics.kinematics.points import Origins, attachment_fields
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, RecordArray, record_dtype

damper_force_jit = jit_in_place(damper_force)
spring_force_jit = jit_in_place(spring_force)


class ForceElementKind(IntEnum):
    """Kind of a force element.

    Coefficient and free value are: stiffness and free length of a spring, damping of a damper, stiffness and free angle
    of a torsion spring, damping of a torsion damper; none for a torque and a force.
    """

    SPRING = 0
    DAMPER = 1
    TORSION_SPRING = 2
    TORSION_DAMPER = 3
    TORQUE = 4
    FORCE = 5


FORCE_ELEMENT_DTYPE = record_dtype("i8 kind first second", "f8 x1 y1 x2 y2 coefficient free_value", "i8 input_index input_index_y")
"""One force element: kind, bodies, attachment points in body axes (m), coefficient, free value, and inputs.

input_index is the input of a torque or of the x component of a force, input_index_y that of the y component; -1 if none.
"""


_ELEMENT_FIELDS: dict[type[ForceElement], tuple[ForceElementKind, tuple[str, ...], tuple[str, ...]]] = {
    Spring: (ForceElementKind.SPRING, ("stiffness", "free_length"), ()),
    Damper: (ForceElementKind.DAMPER, ("damping",), ()),
    TorsionSpring: (ForceElementKind.TORSION_SPRING, ("stiffness", "free_angle"), ()),
    TorsionDamper: (ForceElementKind.TORSION_DAMPER, ("damping",), ()),
    Torque: (ForceElementKind.TORQUE, (), ("moment",)),
    Force: (ForceElementKind.FORCE, (), ("x", "y")),
}
"""Kind of each type of force elements, and its attributes that are the coefficient and the free value, and the inputs."""


def make_force_element_table(mechanism: Mechanism, origins: Origins, first_input: int) -> tuple[RecordArray, tuple[InputFunction, ...]]:
    """Return the force elements as records, and their inputs, which are numbered from `first_input`.

    `origins` are the body origins in body axes (m), by name of body; the mass centre if left out.
    """
    inputs: list[InputFunction] = []
    table = np.zeros(len(mechanism.force_elements), dtype=FORCE_ELEMENT_DTYPE)
    for i, element in enumerate(mechanism.force_elements):
        if type(element) not in _ELEMENT_FIELDS:
            raise TypeError(f"no force law is defined for force elements of type {type(element).__name__}")
        kind, coefficients, programs = _ELEMENT_FIELDS[type(element)]
        ends = (GROUND, element.point) if isinstance(element, Force) else attrgetter("first", "second")(element)
        first, second = (end if isinstance(end, Point) else Point(body=end) for end in ends)
        values = (*(getattr(element, name) for name in coefficients), 0.0, 0.0)
        input_indices = (*range(first_input + len(inputs), first_input + len(inputs) + len(programs)), -1, -1)
        table[i] = (kind, *attachment_fields(mechanism, first, second, origins), *values[:2], *input_indices[:2])
        inputs += [getattr(element, name) for name in programs]
    return table, tuple(inputs)


@jit_in_place
def _point_kinematics(poses: FloatArray, velocities: FloatArray, body: int, x: float, y: float) -> tuple[float, float, float, float]:
    """Return the arm (m) from the body origin to a point, and the velocity (m/s) of the point."""
    if body < 0:
        return x, y, 0.0, 0.0
    arm_x, arm_y = rotate_vector_jit(poses[body, 2], x, y)
    angular_velocity = velocities[body, 2]
    return arm_x, arm_y, velocities[body, 0] - arm_y * angular_velocity, velocities[body, 1] + arm_x * angular_velocity


@jit_in_place
def _add_force_at_point(result: FloatArray, body: int, arm_x: float, arm_y: float, force_x: float, force_y: float) -> None:
    """Add a force (N) that acts at the end of an arm (m) from the body origin to result (bodies, 3)."""
    if body >= 0:
        result[body, 0] += force_x
        result[body, 1] += force_y
        result[body, 2] += arm_x * force_y - arm_y * force_x


@jit_in_place
def add_element_forces(elements: RecordArray, poses: FloatArray, velocities: FloatArray, inputs: FloatArray, result: FloatArray) -> float:
    """Add the generalised forces of all force elements to result (bodies, 3).

    Returns the power (W) of the elements without a potential.
    """
    power = 0.0
    for i in range(elements.size):
        element = elements[i]
        kind, first, second = element.kind, element.first, element.second
        if kind in (ForceElementKind.SPRING, ForceElementKind.DAMPER, ForceElementKind.FORCE):
            arm1_x, arm1_y, u1, v1 = _point_kinematics(poses, velocities, first, element.x1, element.y1)
            arm2_x, arm2_y, u2, v2 = _point_kinematics(poses, velocities, second, element.x2, element.y2)
            if kind == ForceElementKind.FORCE:
                force_x = inputs[element.input_index]
                force_y = inputs[element.input_index_y]
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
                continue  # coincident points: no line of action
            rate = ((u2 - u1) * dx + (v2 - v1) * dy) / length
            if kind == ForceElementKind.SPRING:
                tension = spring_force_jit(element.coefficient, element.free_value, length)
            else:
                tension = damper_force_jit(element.coefficient, rate)
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
            if kind == ForceElementKind.TORSION_SPRING:
                moment = -spring_force_jit(element.coefficient, element.free_value, relative_angle)
            elif kind == ForceElementKind.TORSION_DAMPER:
                moment = -damper_force_jit(element.coefficient, relative_rate)
                power += moment * relative_rate
            else:
                moment = inputs[element.input_index]
                power += moment * relative_rate
            if second >= 0:
                result[second, 2] += moment
            if first >= 0:
                result[first, 2] -= moment
    return power


def spring_potential_energy(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Return the potential energy of all springs of a mechanism.

    Parameters
    ----------
    mechanism
        Mechanism with its force elements.
    poses
        Poses of the mass centres, m and rad; shape (..., bodies, 3).

    Returns
    -------
    FloatArray
        Energy, J; shape (...).
    """
    total = np.zeros(poses.shape[:-2])
    for element in mechanism.force_elements:
        if isinstance(element, Spring | TorsionSpring):
            displacement = OutputDerivatives(mechanism, element.displacement, poses).value
            total += spring_energy(element.stiffness, element.free_displacement, displacement)
    return total

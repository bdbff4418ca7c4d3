"""Lagrangian coefficients of a mechanism with one degree of freedom, the same for motion tables and statics.

They follow from joints, bodies and force elements of any machine. A prime is a derivative by the leading coordinate, in rad or m.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.dynamics.lowering import BODY_DTYPE, make_body_record
from governor_mechanism.mechanics.dynamics.output_forces import (
    LOAD,
    OUTPUT_FORCE_DTYPE,
    evaluate_force_law,
    evaluate_potential,
    lower_outputs,
    output_force_record,
)
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows, RowColumn
from governor_mechanism.mechanics.kinematics.coordinate_assembly import (
    AssemblyArrays,
    AssemblyWorkspace,
    CoordinateSolver,
    lower_assembly,
    make_assembly_workspace,
)
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.model.joints.drivers import Driver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit, jit_in_place, record_dtype
from governor_mechanism.types import GROUND_INDEX, FloatArray, RecordArray

CANCELLATION_RATIO = 1e-15
"""Derivative of the spindle inertia relative to its terms below which it is rounding and set to zero."""

spindle_inertia_jit = jit_in_place(force_laws.spindle_inertia)
spindle_inertia_rate_jit = jit_in_place(force_laws.spindle_inertia_rate)
spindle_inertia_second_derivative_jit = jit_in_place(force_laws.spindle_inertia_second_derivative)


class Coefficient(IntEnum):
    """Lagrangian coefficients along the coordinate q, with the kinetic energy I q'^2 / 2; a prime is a derivative by q."""

    INERTIA = 0
    """I."""
    INERTIA_DERIVATIVE = 1
    """I'."""
    SPINDLE_INERTIA = 2
    """Moment of inertia J of the bodies about the spindle, kg m2."""
    SPINDLE_INERTIA_DERIVATIVE = 3
    """J'."""
    SPINDLE_INERTIA_SECOND_DERIVATIVE = 4
    """J''."""
    POTENTIAL_DERIVATIVE = 5
    """V' of the potential energy V of weights and springs."""
    POTENTIAL_SECOND_DERIVATIVE = 6
    """V''."""
    DAMPING = 7
    """Force of the linear dampers against q, per unit of its rate."""
    FIRST_LOAD = 8
    """From here on the force along q of each load at unit input, and its derivative."""


OUTPUT_LIMIT_DTYPE = record_dtype(("output_index", "i8"), ("low", "f8"), ("high", "f8"))
"""Limits of an output."""


class ReductionArrays(NamedTuple):
    """A mechanism with one degree of freedom as arrays, from which its Lagrangian coefficients and its motion table follow."""

    assembly: AssemblyArrays  # joints and leading coordinate
    mass: FloatArray  # mass, mass and moment of inertia of each body; shape (3 bodies,)
    bodies: RecordArray  # mass properties, about the mass centres; shape (bodies,)
    has_centrifugal_forces: bool  # whether the plane rotates with the spindle and centrifugal forces act
    output_rows: ConstraintRows  # rows of the outputs of the table, then those along which force elements act
    # forces along the outputs that are tabulated, records of `OUTPUT_FORCE_DTYPE`; the input of a load is its
    # number
    forces: RecordArray
    n_loads: int  # number of inputs of force elements
    output_scales: FloatArray  # scales of the outputs in the table, which come first in the rows of the outputs; shape (outputs,)
    limits: RecordArray  # records of `OUTPUT_LIMIT_DTYPE`, which end the table; shape (limits,)
    steady_speed: float  # magnitude of a constant spindle speed, rad/s; negative if the speed changes
    time_scale: float  # characteristic time, s
    low: float  # lower bound of the coordinate
    high: float  # upper bound of the coordinate
    full_turn: float  # whole turn of a coordinate that is an angle, rad; else 0
    is_conservative: bool  # whether the quadratic and the potential column hold all forces


class ReductionWorkspace(NamedTuple):
    """Buffers of the evaluation; coefficients (n,) are indexed by `Coefficient`."""

    assembly: AssemblyWorkspace
    output_row_values: FloatArray
    output_jacobian: FloatArray
    coefficients: FloatArray


def make_reduction_workspace(arrays: ReductionArrays) -> ReductionWorkspace:
    """Return buffers of the evaluation."""
    n_outputs = len(arrays.output_rows.table)
    return ReductionWorkspace(
        assembly=make_assembly_workspace(arrays.assembly),
        output_row_values=np.zeros((n_outputs, N_ROW_COLUMNS)),
        output_jacobian=np.zeros((n_outputs, 2, 3)),
        coefficients=np.zeros(Coefficient.FIRST_LOAD + 2 * arrays.n_loads),
    )


@jit_in_place
def evaluate_coefficients(arrays: ReductionArrays, workspace: ReductionWorkspace, node: FloatArray) -> None:
    """Fill the coefficients of the workspace from a node (3, 3 bodies): poses, tangent and curvature."""
    poses = node[0].reshape(-1, 3)
    tangents = node[1].reshape(-1, 3)
    curvatures = node[2].reshape(-1, 3)
    coefficients = workspace.coefficients
    coefficients[:] = 0.0
    for k in range(arrays.mass.size):
        coefficients[Coefficient.INERTIA] += arrays.mass[k] * node[1, k] * node[1, k]
        coefficients[Coefficient.INERTIA_DERIVATIVE] += 2.0 * arrays.mass[k] * node[1, k] * node[2, k]
    for k in range(arrays.bodies.size):
        weight = arrays.bodies[k].mass * arrays.bodies[k].gravity
        coefficients[Coefficient.POTENTIAL_DERIVATIVE] += weight * tangents[k, 1]
        coefficients[Coefficient.POTENTIAL_SECOND_DERIVATIVE] += weight * curvatures[k, 1]
    if arrays.has_centrifugal_forces:
        _add_spindle_inertia(arrays, poses, tangents, curvatures, coefficients)
    evaluate_rows(arrays.output_rows, poses, tangents, workspace.output_row_values, workspace.output_jacobian)
    for k in range(arrays.forces.size):
        _add_force(arrays, workspace, k, tangents, curvatures)


@jit_in_place
def _add_spindle_inertia(
    arrays: ReductionArrays, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray, coefficients: FloatArray
) -> None:
    """Add the moment of inertia of all bodies about the spindle, and its derivatives."""
    magnitude, length_scale = 0.0, arrays.assembly.pose_scales[0]
    for k in range(arrays.bodies.size):
        body = arrays.bodies[k]
        x = poses[k, 0]
        angle = poses[k, 2]
        tangent = tangents[k]
        mass, moments = body.mass, (body.xx, body.yy, body.xy)
        coefficients[Coefficient.SPINDLE_INERTIA] += spindle_inertia_jit(mass, body.xx, body.yy, body.xy, body.zz, x, angle)
        coefficients[Coefficient.SPINDLE_INERTIA_DERIVATIVE] += spindle_inertia_rate_jit(
            mass, body.xx, body.yy, body.xy, x, angle, tangent[0], tangent[2]
        )
        coefficients[Coefficient.SPINDLE_INERTIA_SECOND_DERIVATIVE] += spindle_inertia_second_derivative_jit(
            mass, moments, x, angle, (tangent[0], tangent[2]), (curvatures[k, 0], curvatures[k, 2])
        )
        magnitude += 2.0 * mass * length_scale * abs(tangent[0]) + (abs(body.yy - body.xx) + 2.0 * abs(body.xy)) * abs(tangent[2])
    if abs(coefficients[Coefficient.SPINDLE_INERTIA_DERIVATIVE]) < CANCELLATION_RATIO * magnitude:
        coefficients[Coefficient.SPINDLE_INERTIA_DERIVATIVE] = 0.0


@jit_in_place
def _add_force(arrays: ReductionArrays, workspace: ReductionWorkspace, index: int, tangents: FloatArray, curvatures: FloatArray) -> None:
    """Add one force along an output to the coefficients; the output rows were evaluated with the tangents as velocities."""
    force = arrays.forces[index]
    rows = arrays.output_rows
    jacobian = workspace.output_jacobian
    coefficients = workspace.coefficients
    row = force.output_index
    value = workspace.output_row_values[force.output_index, RowColumn.RESIDUAL]
    derivative = output_rate(rows, jacobian, row, tangents)
    second_derivative = output_rate(rows, jacobian, row, curvatures) - workspace.output_row_values[row, RowColumn.GAMMA]
    if rows.table[row].kind == RowKind.DISTANCE and math.isnan(derivative):  # coincident points: no line of action
        return
    if force.law == LOAD:
        column = Coefficient.FIRST_LOAD + 2 * force.input_index
        coefficients[column] += derivative
        coefficients[column + 1] += second_derivative
    elif force.has_power:
        coefficients[Coefficient.DAMPING] -= evaluate_force_law(force.law, force.coefficients, value, derivative) * derivative
    elif value >= force.slack_below:
        _, gradient, stiffness = evaluate_potential(force.law, force.coefficients, value)
        coefficients[Coefficient.POTENTIAL_DERIVATIVE] += gradient * derivative
        coefficients[Coefficient.POTENTIAL_SECOND_DERIVATIVE] += stiffness * derivative * derivative + gradient * second_derivative


@jit
def evaluate_coefficients_at_nodes(arrays: ReductionArrays, workspace: ReductionWorkspace, nodes: FloatArray) -> FloatArray:
    """Return the coefficients (n, coefficients) at nodes (n, 3, 3 bodies)."""
    result = np.empty((nodes.shape[0], workspace.coefficients.size))
    for k in range(nodes.shape[0]):
        evaluate_coefficients(arrays, workspace, nodes[k])
        result[k] = workspace.coefficients
    return result


class TableColumn(IntEnum):
    """Columns of the motion table along the coordinate q.

    With T = I q'^2 / 2 the equation of motion is q'' = QUADRATIC q'^2 + POTENTIAL + CENTRIFUGAL w^2 + DAMPING q' + other forces.
    """

    QUADRATIC = 0
    """-I'/2I."""
    POTENTIAL = 1
    """-V'/I; at constant spindle speed it contains the centrifugal forces."""
    CENTRIFUGAL = 2
    """J'/2I."""
    INVERSE_INERTIA = 3
    """1/I."""
    SPINDLE_INERTIA = 4
    """J."""
    DAMPING = 5
    """Derivative of the dampers' force by q', over I."""
    FIRST_LOAD = 6
    """From here on the loads at unit input over I, then value and derivative of each output."""


@jit_in_place
def evaluate_columns(arrays: ReductionArrays, workspace: ReductionWorkspace, node: FloatArray, columns: FloatArray) -> None:
    """Fill the columns of the table from a node (3, 3 bodies): poses, tangent and curvature."""
    coefficients = workspace.coefficients
    evaluate_coefficients(arrays, workspace, node)
    inverse_inertia = 1.0 / coefficients[Coefficient.INERTIA]
    centrifugal = 0.5 * coefficients[Coefficient.SPINDLE_INERTIA_DERIVATIVE]
    columns[TableColumn.QUADRATIC] = -0.5 * coefficients[Coefficient.INERTIA_DERIVATIVE] * inverse_inertia
    force = -coefficients[Coefficient.POTENTIAL_DERIVATIVE]
    if arrays.steady_speed >= 0.0:
        force, centrifugal = force + centrifugal * arrays.steady_speed**2, 0.0
    columns[TableColumn.POTENTIAL] = force * inverse_inertia
    columns[TableColumn.CENTRIFUGAL] = centrifugal * inverse_inertia
    if columns.size == TableColumn.INVERSE_INERTIA:
        return
    columns[TableColumn.INVERSE_INERTIA] = inverse_inertia
    columns[TableColumn.SPINDLE_INERTIA] = coefficients[Coefficient.SPINDLE_INERTIA]
    columns[TableColumn.DAMPING] = -coefficients[Coefficient.DAMPING] * inverse_inertia
    column: int = TableColumn.FIRST_LOAD
    for k in range(arrays.n_loads):
        columns[column] = coefficients[Coefficient.FIRST_LOAD + 2 * k] * inverse_inertia
        column += 1
    tangents = node[1].reshape(-1, 3)
    for k in range(arrays.output_scales.size):
        columns[column] = workspace.output_row_values[k, RowColumn.RESIDUAL]
        columns[column + 1] = output_rate(arrays.output_rows, workspace.output_jacobian, k, tangents)
        column += 2


def lower_lagrangian(
    scene: Scene,
    prefix: str,
    part: Part,
    # readings of the part that are evaluated with the coefficients, among them those of the effects
    outputs: Sequence[str],
    effects: Sequence[OutputForce],
) -> ReductionArrays:
    """Lower a part to the arrays of its Lagrangian coefficients, without bounds or limits; gas is left out: its force has kinks."""
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    has_centrifugal_forces = plane is not None and plane.is_loaded
    own_elements = [
        element
        for element in scene.mechanism.force_elements
        if not acts_elsewhere(element, prefix, part) and not isinstance(element, CylinderGas)
    ]
    rows, element_forces = lower_outputs(scene.mechanism, outputs, own_elements, {}, 0)
    first_body = scene.mechanism.body_index(prefix + mechanism.bodies[0].name)
    for side in ("first", "second"):
        rows.table[side] -= np.where(rows.table[side] != GROUND_INDEX, first_body, 0)
    effect_records = [output_force_record(effect, outputs.index(effect.reading)) for effect in effects]
    if effect_records:
        element_forces = np.concatenate([np.array(effect_records, dtype=OUTPUT_FORCE_DTYPE), element_forces])
    return ReductionArrays(
        assembly=lower_assembly(mechanism),
        mass=np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).ravel(),
        bodies=np.array([make_body_record(body, part.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        output_rows=rows._replace(row_bodies=bodies_of_rows(rows.table)),
        forces=element_forces,
        n_loads=sum(len(element.loads) for element in own_elements),
        output_scales=np.array([scene.mechanism.output_scale(name) for name in outputs]),
        limits=np.zeros(0, dtype=OUTPUT_LIMIT_DTYPE),
        steady_speed=-1.0,
        time_scale=time_scale(scene),
        low=-math.inf,
        high=math.inf,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=False,
    )


def acts_elsewhere(element: ForceElement, prefix: str, part: Part) -> bool:
    """Return whether a force element acts on no body of a part."""
    return {prefix + body.name for body in part.mechanism.bodies}.isdisjoint(element.bodies)


@dataclass(frozen=True)
class PathCoefficients:
    """The Lagrangian coefficients at n values of the coordinate."""

    coordinate: FloatArray  # leading coordinate q, SI; shape (n,)
    poses: FloatArray  # poses; shape (n, bodies, 3)
    tangents: FloatArray  # first derivative of the poses; shape (n, bodies, 3)
    curvatures: FloatArray  # second derivative of the poses; shape (n, bodies, 3)
    inertia: FloatArray  # i in the kinetic energy I q'^2 / 2; shape (n,)
    inertia_derivative: FloatArray  # i'; shape (n,)
    spindle_inertia: FloatArray  # moment of inertia J of the bodies about the spindle, kg m2; shape (n,)
    spindle_inertia_derivative: FloatArray  # j'; shape (n,)
    spindle_inertia_second_derivative: FloatArray  # j''; shape (n,)
    potential_derivative: FloatArray  # v' of the potential energy V; shape (n,)
    potential_second_derivative: FloatArray  # v''; shape (n,)

    def force_terms(self, speed_squared: FloatArray | float) -> FloatArray:
        """Return V' and -J' w^2 / 2 (2, n), which sum up to the generalised force against the coordinate."""
        return np.array([self.potential_derivative, -0.5 * speed_squared * self.spindle_inertia_derivative])

    def stiffness_terms(self, speed_squared: FloatArray | float) -> FloatArray:
        """Return V'' and -J'' w^2 / 2 (2, n), which sum up to the stiffness."""
        return np.array([self.potential_second_derivative, -0.5 * speed_squared * self.spindle_inertia_second_derivative])

    def concatenate(self, other: PathCoefficients) -> PathCoefficients:
        """Return these values followed by those of another."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__}
        return PathCoefficients(**{name: np.concatenate(pair) for name, pair in pairs.items()})

    def select(self, indices: NDArray[np.integer] | slice) -> PathCoefficients:
        """Return the values at some indices."""
        return PathCoefficients(**{name: getattr(self, name)[indices] for name in self.__dataclass_fields__})


class SingleDofReduction:
    """A scene's mechanism reduced to its leading coordinate, with the loads at t = 0; MechanismError for drives or another mobility."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanism: Mechanism = scene.part.mechanism
        self._solver = CoordinateSolver(self.mechanism)
        mobility = self._solver.mobility
        if drives := [joint.name for joint in self.mechanism.joints if isinstance(joint, Driver)]:
            cause = f"this one is moved by {' and '.join(map(repr, drives))}, so that no load decides its position"
            cure = "leave that out and give a load in its place, or take `kinematics` of it"
            raise MechanismError(f"statics need a mechanism with one degree of freedom and without drives; {cause}: {cure}")
        if mobility != 1:
            cure = "add what holds its bodies until one coordinate is left" if mobility > 1 else "leave out a joint that holds it"
            raise MechanismError(f"statics need a mechanism with one degree of freedom; this one has mobility {mobility}: {cure}")
        if any(isinstance(element, CylinderGas) for element in self.mechanism.force_elements):
            raise MechanismError("statics and linearisation are not for an engine that gas drives, which turns over; run it instead")
        effects = [effect for effect in output_forces_of(scene) if not effect.dissipates]
        outputs = list(dict.fromkeys(effect.reading for effect in effects))
        self._arrays = lower_lagrangian(scene, "", scene.part, outputs, effects)
        self._workspace = make_reduction_workspace(self._arrays)
        loads = [load for element in self.mechanism.force_elements for load in element.loads]
        self._loads = np.array([CubicTimeFunction(load)(np.zeros(1))[0] for load in loads])  # at a discontinuity the right limit
        self.coordinate_scale = self.mechanism.output_scale(self.mechanism.coordinate)
        """SI value of a radian, or of a length scale, of the coordinate."""
        self.free_spindle_inertia = scene.spindle.inertia if isinstance(scene.spindle, FreeSpindle) else 0.0
        """Moment of inertia of a free spindle itself, kg m2; else 0."""

    @cached_property
    def range_of_motion(self) -> RangeOfMotion:
        """Range of motion of the mechanism. Raises MechanismError as `find_range_of_motion` does."""
        return find_range_of_motion(self.mechanism, rotates_with_spindle=self.scene.part.plane == TURNING_PLANE)

    def evaluate(self, values: Sequence[float] | FloatArray, guess: FloatArray | None = None) -> PathCoefficients:
        """Assemble at values (n,), guided by the path or a guess (bodies, 3), and evaluate; MechanismError names an open joint."""
        coordinates = np.asarray(values, dtype=np.float64)
        if guess is None:
            guesses = self.range_of_motion.path.predict_poses(coordinates)
        else:
            guesses = np.repeat(guess[np.newaxis], len(coordinates), axis=0)
        return self.evaluate_near(guesses, coordinates)

    def evaluate_near(self, guesses: FloatArray, values: FloatArray) -> PathCoefficients:
        """Return the coefficients at values (n,), near guesses of the poses (n, bodies, 3). Raises MechanismError as `solve_nodes` does."""
        nodes = self._solver.solve_nodes(guesses, values)
        coefficients = evaluate_coefficients_at_nodes(self._arrays, self._workspace, nodes.reshape(len(values), 3, -1)).T
        unit_forces = coefficients[Coefficient.FIRST_LOAD :].reshape(-1, 2, len(values))
        coefficients[Coefficient.POTENTIAL_DERIVATIVE : Coefficient.POTENTIAL_SECOND_DERIVATIVE + 1] -= np.tensordot(
            self._loads, unit_forces, axes=1
        )
        return PathCoefficients(values, *nodes.swapaxes(0, 1), *coefficients[: Coefficient.DAMPING])

    def output_derivative(self, coefficients: PathCoefficients, name: str) -> FloatArray:
        """Return the derivative (n,) of a reading by the coordinate."""
        return evaluate_output(self.mechanism, name, coefficients.poses).rate(coefficients.tangents)

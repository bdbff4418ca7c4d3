"""Bodies of pymunk that stand for those of a mechanism, and the forces on them by the laws of the multibody model."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.arrays import N_PLANE_COLUMNS, PlaneColumn, System
from governor_mechanism.mechanics.dynamics.body_forces import evaluate_body_forces, inertia_of_plane
from governor_mechanism.mechanics.dynamics.contact_modes import forced_output_names
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, contacts_of, output_forces_of
from governor_mechanism.mechanics.dynamics.lowering import make_system, multibody_input_layout
from governor_mechanism.mechanics.dynamics.output_forces import SLIDING_FRICTION, add_output_forces, evaluate_force_law, lower_outputs
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows, Origins, RowColumn
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import GROUND, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, RecordArray

if TYPE_CHECKING:
    import pymunk


QUASI_INFINITE_MASS = 1e30
"""Mass (kg) whose inverse vanishes next to any other; pymunk accepts no infinite mass for a body that rotates."""

PlanarVector = tuple[float, float]
"""Coordinates x, y (m)."""

Poses = Sequence[Sequence[float]]
"""Poses (x, y, angle) of all bodies and, behind them, the ground, as Python numbers, which are faster one by one than arrays."""


@dataclass(frozen=True)
class BodyProxy:
    """The pymunk body of a mechanism's body, centred at `origin` (m) in its axes; a body pinned to the ground turns about its pin."""

    body: pymunk.Body
    origin: PlanarVector = (0.0, 0.0)
    is_pinned: bool = False


@dataclass(frozen=True)
class AttachedPoint:
    """A point fixed to a pymunk body, in its axes (m); `index` is that of the body, or of the ground."""

    body: pymunk.Body
    index: int
    x: float
    y: float

    def locate(self, poses: Poses) -> tuple[float, float, float]:
        """Return the position x, y (m) and the angle of its body (rad)."""
        x, y, angle = poses[self.index]
        cosine, sine = math.cos(angle), math.sin(angle)
        return x + (cosine * self.x - sine * self.y), y + (sine * self.x + cosine * self.y), angle


def to_body_axes(poses: Poses, index: int, point: PlanarVector) -> PlanarVector:
    """Return a point (m) in the axes of a body."""
    x, y, angle = poses[index]
    dx = point[0] - x
    dy = point[1] - y
    cosine = math.cos(angle)
    sine = math.sin(angle)
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def cannot_rotate_in_pymunk(mechanism: Mechanism, body: Body) -> bool:
    """Return whether a body that must rotate has no inertia for it: a point mass without a pin to the ground."""
    return body.can_rotate and body.planar_inertia <= 0.0 and _find_ground_pin(mechanism, body) is None


def _find_ground_pin(mechanism: Mechanism, body: Body) -> tuple[Point, Point] | None:
    """Return the points of the body and the ground that a pin joins; None without such a pin."""
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            return points[body.name], points[GROUND]
    return None


def make_body_proxy(mechanism: Mechanism, body: Body) -> BodyProxy:
    """Create the pymunk body of a mechanism's body."""
    import pymunk  # slow to import

    if not body.can_rotate:
        return BodyProxy(pymunk.Body(body.mass, math.inf))
    if points := _find_ground_pin(mechanism, body):
        pin, ground = points
        # The mass is so large that the body does not translate: the pin carries every force, only rotation is left.
        pinned_body = pymunk.Body(QUASI_INFINITE_MASS, body.planar_inertia + body.mass * (pin.x**2 + pin.y**2))
        pinned_body.position = (ground.x, ground.y)
        return BodyProxy(pinned_body, (pin.x, pin.y), is_pinned=True)
    return BodyProxy(pymunk.Body(body.mass, body.planar_inertia))


class ForceWorkspace(NamedTuple):
    """Results of an evaluation of forces: those on the bodies, and values and Jacobians of the outputs."""

    poses: FloatArray  # poses at which the forces act, m and rad; shape (bodies, 3)
    forces: FloatArray  # N and N m; shape (bodies, 3)
    plane_motion: FloatArray  # shape (1, columns)
    row_values: FloatArray  # shape (outputs, columns)
    row_jacobian: FloatArray  # with respect to both bodies of a row; shape (outputs, 2, 3)
    jacobian: FloatArray  # shape (outputs, bodies, 3)


def _make_workspace(n_bodies: int, n_outputs: int) -> ForceWorkspace:
    """Return a workspace of zeros."""
    return ForceWorkspace(
        poses=np.zeros((n_bodies, 3)),
        forces=np.zeros((n_bodies, 3)),
        plane_motion=np.zeros((1, N_PLANE_COLUMNS)),
        row_values=np.zeros((n_outputs, N_ROW_COLUMNS)),
        row_jacobian=np.zeros((n_outputs, 2, 3)),
        jacobian=np.zeros((n_outputs, n_bodies, 3)),
    )


@jit_in_place
def _evaluate_forces(
    bodies: RecordArray,
    force_elements: RecordArray,
    output_rows: ConstraintRows,
    output_forces: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    spindle_speed: float,
    inputs: FloatArray,
    workspace: ForceWorkspace,
) -> None:
    """Evaluate forces on the bodies, values of the outputs and their Jacobian."""
    forces, jacobian = workspace.forces, workspace.jacobian
    row_values, row_jacobian = workspace.row_values, workspace.row_jacobian
    workspace.plane_motion[0, PlaneColumn.SPEED] = spindle_speed
    evaluate_body_forces(bodies, workspace.plane_motion, poses, forces)
    row_values[:, : RowColumn.RESIDUAL] = 0.0
    evaluate_rows(output_rows, poses, velocities, row_values, row_jacobian)
    add_output_forces(output_rows, output_forces, velocities, inputs, row_values, row_jacobian, forces)
    add_output_forces(output_rows, force_elements, velocities, inputs, row_values, row_jacobian, forces)
    jacobian[:] = 0.0
    for k in range(output_rows.table.size):
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body != GROUND_INDEX:
                for c in range(3):
                    jacobian[k, body, c] += row_jacobian[k, side, c]


@jit_in_place
def _evaluate_kick(
    bodies: RecordArray,
    force_elements: RecordArray,
    output_rows: ConstraintRows,
    output_forces: RecordArray,
    state: FloatArray,  # poses and velocities; shape (bodies, 2, 3)
    lead: float,  # time by which the forces act after the poses of the state, s
    velocities: FloatArray,  # those on which the forces depend; shape (bodies, 3)
    spindle_speed: float,
    inputs: FloatArray,
    kick_scale: float,
    workspace: ForceWorkspace,
    kick: FloatArray,  # result: forces times the scale; shape (bodies, 3)
) -> None:
    """Evaluate the forces of a kick, at the poses to which the velocities of a state lead, with the outputs there."""
    for body in range(state.shape[0]):
        for c in range(3):
            workspace.poses[body, c] = state[body, 0, c] + lead * state[body, 1, c]
    tables = (bodies, force_elements, output_rows, output_forces)
    _evaluate_forces(*tables, workspace.poses, velocities, spindle_speed, inputs, workspace)
    for body in range(state.shape[0]):
        for c in range(3):
            kick[body, c] = workspace.forces[body, c] * kick_scale


@jit_in_place
def _evaluate_dissipated_power(output_forces: RecordArray, values: FloatArray, rates: FloatArray, inputs: FloatArray) -> float:
    """Return the power (W) that dashpots and sliding friction dissipate at values and rates (outputs,) of the outputs."""
    power = 0.0
    for i in range(output_forces.size):
        force, k = output_forces[i], output_forces[i].output_index
        if force.law == SLIDING_FRICTION:
            power += force.coefficients[0] * inputs[force.input_index] * rates[k]
        elif force.has_power:
            power -= evaluate_force_law(force.law, force.coefficients, values[k], rates[k]) * rates[k]
    return power


@once_per_object
def lower_scene(scene: Scene) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """Return the multibody model of a scene in its initial mode, and its inputs."""
    return make_system(scene)


@dataclass(frozen=True, slots=True)
class StepInputs:
    """Inputs of a step of `h` seconds, where its kick acts; `next_h` (s) is the length of the following step.

    `spindle_speed_squared` is in rad2/s2. `values` (inputs,) are the inputs of the multibody model: loads and friction limits, and the
    prescribed drives at the end of the next step. `kick_scale` lengthens the kick if the next step has another length.
    """

    h: float
    next_h: float
    spindle_speed_squared: float
    values: FloatArray
    kick_scale: float = 1.0


class AppliedForces:
    """Forces at the pose that the next step is about to reach, `kick_poses`, and the energy that dashpots and friction have dissipated.

    `origins` are the centres of the pymunk bodies in body axes (m), to which `system` refers. `output_values` (outputs,) and
    `output_jacobian` (outputs, bodies, 3) belong to the last evaluation, as do the forces that it returns. `output_forces` are
    the records of the present contact mode, at first of the initial one. `evaluation_counts` states how often one step evaluates
    each force law. `dissipated_energy` is in J.
    """

    def __init__(self, scene: Scene, origins: Origins) -> None:
        mechanism = scene.part.mechanism
        system = lower_scene(scene)[0]
        contacts = contacts_of(scene)
        n_bodies = len(mechanism.bodies)
        n_frictions = sum(contact.friction is not None for contact in contacts)
        self.input_layout = multibody_input_layout(scene)
        bodies = system.bodies[:n_bodies].copy()  # without the shaft of a free spindle
        bodies["x"], bodies["y"] = -np.array([origins[body.name] for body in mechanism.bodies]).T
        self._turning_bodies = bodies.copy()
        self._turning_bodies["plane"] = 0
        bodies["plane"][[_is_on_spindle_axis(mechanism, body) for body in mechanism.bodies]] = NO_INDEX
        names, elements = forced_output_names(scene), mechanism.force_elements
        output_rows, force_elements = lower_outputs(mechanism, names, elements, origins, self.input_layout.element_loads.start)
        self.system = system._replace(bodies=bodies, force_elements=force_elements, output_rows=output_rows)
        self.output_forces = system.output_forces
        self._workspace = _make_workspace(n_bodies, len(output_rows.table))
        self.output_jacobian, self.kick_poses = self._workspace.jacobian, self._workspace.poses
        self._has_outputs = len(output_rows.table) > 0
        self.output_values = self.output_gammas = np.zeros(0)
        self.dissipated_energy, self._previous_step = 0.0, (np.zeros(0), np.zeros(0))
        counts = {"gravity": n_bodies * bool(scene.gravity), "centrifugal": int(np.sum(bodies["plane"] != NO_INDEX))}
        counts["springs, dampers, forces"] = len(mechanism.force_elements)
        laws = Counter(effect.law_name for effect in output_forces_of(scene))
        self.evaluation_counts = Counter(counts) + laws + Counter({FRICTION_LAW_NAME: n_frictions})

    def reset(self) -> None:
        """Forget the previous step: the next one is the half step that starts a motion."""
        self._previous_step = np.zeros(0), np.zeros(0)

    def evaluate_kick(
        self,
        state: FloatArray,  # poses and velocities; shape (bodies, 2, 3)
        lead: float,  # time in which its velocities move the poses to where the kick acts, s
        velocities: FloatArray,  # those on which the forces depend; shape (bodies, 3)
        inputs: StepInputs,
        kick: FloatArray,  # result: forces times the scale of the kick; shape (bodies, 3)
    ) -> None:
        """Fill the forces of a kick, and add the energy dissipated in the last step."""
        system, speed = self.system, math.sqrt(inputs.spindle_speed_squared)
        tables = system.bodies, system.force_elements, system.output_rows, self.output_forces
        _evaluate_kick(*tables, state, lead, velocities, speed, inputs.values, inputs.kick_scale, self._workspace, kick)
        self._keep_outputs()
        if self.output_forces.size:
            self._add_dissipation(inputs)

    def evaluate_outputs(self, poses: FloatArray) -> FloatArray:
        """Evaluate the output values and their Jacobian at poses (bodies, 3), and return the values (outputs,)."""
        system = self.system
        tables = system.bodies, system.force_elements, system.output_rows, self.output_forces
        _evaluate_forces(*tables, poses, np.zeros_like(poses), 0.0, np.zeros(system.n_inputs), self._workspace)
        self._keep_outputs()
        return self.output_values

    def _keep_outputs(self) -> None:
        """Keep the outputs of the last evaluation, which the next one overwrites."""
        if self._has_outputs:
            self.output_values = self._workspace.row_values[:, RowColumn.RESIDUAL].copy()
            self.output_gammas = self._workspace.row_values[:, RowColumn.GAMMA].copy()

    def output_rates(self, velocities: FloatArray) -> FloatArray:
        """Return the rates (outputs,) of all output variables for velocities (bodies, 3) of the pymunk bodies."""
        rates: FloatArray = self.output_jacobian.reshape(len(self.output_jacobian), velocities.size) @ velocities.ravel()
        return rates

    def dissipated_power(self, rates: FloatArray, inputs: FloatArray) -> float:
        """Return the power (W) that dashpots and sliding friction dissipate at output rates (outputs,) and inputs (inputs,)."""
        return float(_evaluate_dissipated_power(self.output_forces, self.output_values, rates, inputs))

    def spindle_inertia(self, poses: FloatArray) -> float:
        """Return the moment of inertia about the spindle (kg m2) at poses (bodies, 3)."""
        return float(inertia_of_plane(self._turning_bodies, 0, poses, poses)[0])

    def _add_dissipation(self, inputs: StepInputs) -> None:
        """Add the energy dissipated in the last step, whose displacement and length are known, by the midpoint rule."""
        previous_values, previous_inputs = self._previous_step
        if previous_values.size:
            middle_values = 0.5 * (previous_values + self.output_values)
            rates = (self.output_values - previous_values) / inputs.h
            middle_inputs = 0.5 * (previous_inputs + inputs.values)
            self.dissipated_energy += inputs.h * _evaluate_dissipated_power(self.output_forces, middle_values, rates, middle_inputs)
        self._previous_step = self.output_values, inputs.values


def _is_on_spindle_axis(mechanism: Mechanism, body: Body) -> bool:
    """Return whether a body is guided along the spindle axis with its mass centre on it, so that no centrifugal load acts."""
    return not body.can_rotate and any(
        isinstance(joint, Slider)
        and joint.first.body == GROUND
        and joint.first.x == 0.0
        and math.isclose(abs(joint.angle), math.pi / 2)
        and joint.second == Point(body=body.name, y=joint.second.y)
        for joint in mechanism.joints
    )

"""Arrays of the multibody model in one contact mode, and the work arrays of its evaluation; motions about mass centres and origins."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics import output_forces
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows, rotate_vector
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.numerics.jit import record_dtype
from governor_mechanism.types import BoolArray, FloatArray, IntArray, RecordArray


class PlaneColumn(IntEnum):
    """Column of the motion of a plane: speed (rad/s), acceleration if it is given (rad/s2), inertia (kg m2) and its rate (kg m2/s)."""

    SPEED = 0
    ACCELERATION = 1
    INERTIA = 2
    INERTIA_RATE = 3


N_PLANE_COLUMNS = len(PlaneColumn)
"""Number of columns of the motion of a plane."""


N_ENERGY_STATES = 2
"""Number of energies in a state: the work as in `StateHistory`, and the dissipated part of it, J."""


RUBBING_DTYPE = record_dtype(
    ("output_index", "i8"),  # the output row of the slip
    ("row_index", "i8"),  # the constraint row that holds the gap
    ("coefficient", "f8"),  # coefficient of friction, with the sign of the slip
)
"""Friction of a part that slides on another one: -coefficient * normal force along the slip."""


class StateLayout(NamedTuple):
    """First index of each part of a state after the poses of the body origins."""

    velocities: int  # velocities of the body origins
    work: int  # work as in `StateHistory`, J; up to here reach the velocities
    dissipated_energy: int  # the dissipated part of the work, J
    lags: int  # values of inputs that follow others with a lag


def lay_out_state(n_bodies: int) -> StateLayout:
    """Return the layout of a state of some bodies."""
    work = 6 * n_bodies
    return StateLayout(velocities=3 * n_bodies, work=work, dissipated_energy=work + 1, lags=work + N_ENERGY_STATES)


class System(NamedTuple):
    """Arrays of the multibody model in one contact mode.

    Poses refer to the origin of each body: its mass centre, or the ground pin of a point mass. The last of the joints' rows
    are those of held outputs, before the rows are reordered to a narrow band.
    """

    state_layout: StateLayout  # layout of a state
    constraint_rows: ConstraintRows  # rows of the joints and of held outputs
    force_elements: RecordArray  # forces of the force elements, records of `OUTPUT_FORCE_DTYPE`
    row_pairs: IntArray  # pairs of rows that share a body, see `find_coupled_rows`; shape (pairs, 4)
    bandwidth: int  # half bandwidth of J M^-1 J^T, without the diagonal
    bodies: RecordArray  # records of `BODY_DTYPE`; shape (bodies,)
    # inverse mass (twice) and inverse moment of inertia about the origin, 0 for coordinates that cannot
    # change; shape (bodies, 3). For a shaft it changes with the poses, see `update_inverse_mass`. It includes
    # the stand-in inertia.
    inverse_mass: FloatArray
    # the inverse masses that the bodies would have if all had the same mass, 1; shape (bodies, 3). In this
    # metric the rows of the joints are nearly dependent near a change point alone, not where a light body
    # carries a heavy one.
    equal_mass_metric: FloatArray
    # mass (twice) and moment of inertia in `inverse_mass` that a massless coordinate does not have; shape
    # (bodies, 3)
    stand_in_inertia: FloatArray
    has_stand_in_inertia: bool  # whether any of it is not 0
    planes: RecordArray  # records of `PLANE_DTYPE`
    # rows of the outputs along which effects act or on which loads depend, then of those along which force
    # elements act
    output_rows: ConstraintRows
    output_forces: RecordArray  # records of `OUTPUT_FORCE_DTYPE`
    rubbing: RecordArray  # friction of parts that slide on each other, records of `RUBBING_DTYPE`
    event_functions: RecordArray  # records of `EVENT_FUNCTION_DTYPE`
    n_kinks: int  # number of the last of them that are kinks
    watches_gaps_alone: bool  # whether they are gaps between parts: steps may be longer where those are far
    input_terms: RecordArray  # records of `INPUT_TERM_DTYPE`, in the order of their evaluation
    lags: RecordArray  # records of `LAG_DTYPE`
    n_inputs: int  # number of inputs


class SystemWorkspace(NamedTuple):
    """Work arrays of one evaluation, so that the kernels allocate nothing in their loops."""

    row_values: FloatArray  # prescribed motion, residual and gamma of each row; shape (rows, 5)
    jacobian: FloatArray  # jacobian of each row with respect to the poses of its bodies; shape (rows, sides, 3)
    band: FloatArray  # band of J M^-1 J^T; shape (rows, bandwidth + 1)
    factor: FloatArray  # its Cholesky factor, with the shape of `band`
    eigen: FloatArray  # workspace for the eigenproblem of a singular `band`; shape (2, rows, rows)
    equal_mass_band: FloatArray  # as `band`, in the metric of equal masses
    multipliers: FloatArray  # lagrange multipliers, N; shape (rows,)
    multiplier_corrections: FloatArray  # their corrections by iterative refinement, N; shape (rows,)
    generalised_forces: FloatArray  # applied forces, N and N m; shape (bodies, 3)
    stand_in_forces: FloatArray  # inertia forces of the stand-ins, N and N m; shape (bodies, 3)
    output_row_values: FloatArray  # as `row_values`, for the outputs; shape (outputs, 5)
    output_jacobian: FloatArray  # as `jacobian`, for the outputs; shape (outputs, 2, 3)
    inverse_mass: FloatArray  # as that of the system, at the poses of the last evaluation; shape (bodies, 3)
    # speed (rad/s), acceleration if the speed is given (rad/s2), moment of inertia (kg m2) and its rate (kg
    # m2/s) of each plane; shape (planes, 4)
    plane_motion: FloatArray
    inputs: FloatArray  # values of the inputs; shape (inputs,)
    force_elements: RecordArray  # as those of the system, with the switches of gas at the last evaluation
    is_armed: BoolArray  # whether each event function of a kink is monitored; shape (event functions,)
    # lagrange multipliers without friction of what slides, and those by a unit force along each slip; shape
    # (rubbing + 1, rows)
    rubbing_multipliers: FloatArray
    rubbing_accelerations: FloatArray  # accelerations by these unit forces, m/s2 and rad/s2; shape (rubbing, bodies, 3)
    rubbing_matrix: FloatArray  # buffer of the equations of the normal forces; shape (rubbing, rubbing)
    rubbing_forces: FloatArray  # friction along each slip, N; shape (rubbing,)


def count_output_forces(system: System) -> IntArray:
    """Return how many output forces of each law of `FORCE_LAWS`, and last how many sliding frictions, a system has; shape (laws + 1,)."""
    return np.bincount(system.output_forces["law"], minlength=output_forces.SLIDING_FRICTION + 1)


def make_system_workspace(system: System) -> SystemWorkspace:
    """Return work arrays for the evaluation of a system."""
    rows = len(system.constraint_rows.table)
    bodies = len(system.bodies)
    rubbing = len(system.rubbing)
    band = (rows, system.bandwidth + 1)
    return SystemWorkspace(
        row_values=np.zeros((rows, N_ROW_COLUMNS)),
        jacobian=np.zeros((*system.constraint_rows.row_bodies.shape, 3)),
        band=np.zeros(band),
        factor=np.zeros(band),
        eigen=np.zeros((2, rows, rows)),
        equal_mass_band=np.zeros(band),
        multipliers=np.zeros(rows),
        multiplier_corrections=np.zeros(rows),
        generalised_forces=np.zeros((bodies, 3)),
        stand_in_forces=np.zeros((bodies, 3)),
        output_row_values=np.zeros((len(system.output_rows.table), N_ROW_COLUMNS)),
        output_jacobian=np.zeros((len(system.output_rows.table), 2, 3)),
        inverse_mass=system.inverse_mass.copy(),
        plane_motion=np.zeros((len(system.planes), N_PLANE_COLUMNS)),
        inputs=np.zeros(system.n_inputs),
        force_elements=system.force_elements.copy(),
        is_armed=np.ones(len(system.event_functions), dtype=np.bool_),
        rubbing_multipliers=np.zeros((rubbing + 1, rows)),
        rubbing_accelerations=np.zeros((rubbing, bodies, 3)),
        rubbing_matrix=np.zeros((rubbing, rubbing)),
        rubbing_forces=np.zeros(rubbing),
    )


def to_mass_centres(
    system: System,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (..., bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (..., bodies, 3)
) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities (..., bodies, 3) of the body origins to those of the mass centres."""
    return _shift_reference_points(system, 1.0, poses, velocities)


def from_mass_centres(
    system: System,
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (..., bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (..., bodies, 3)
) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities (..., bodies, 3) of the mass centres to those of the body origins."""
    return _shift_reference_points(system, -1.0, poses, velocities)


def _shift_reference_points(system: System, sign: float, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return poses and velocities of points shifted by the vector from body origin to mass centre (sign 1) or back (-1)."""
    poses, velocities = poses.copy(), velocities.copy()
    if not (system.bodies["x"].any() or system.bodies["y"].any()):
        return poses, velocities
    arm_x, arm_y = rotate_vector(poses[..., 2], sign * system.bodies["x"], sign * system.bodies["y"])
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def body_reference_point(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """Return the origin of a body in body axes (m): the ground pin of a point mass, else the mass centre."""
    pin = ground_pin_of_point_mass(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own_point = pin.first if pin.first.body == body.name else pin.second
    return own_point.x, own_point.y


def ground_pin_of_point_mass(mechanism: Mechanism, body: Body) -> Pin | None:
    """Return the pin about which a body without an inertia of its own, but with a mass, turns on the ground; None if there is none."""
    # About that pin the point mass has a moment of inertia. The pin does not move, so the coupling of
    # rotation and translation in its mass matrix never acts on the motion.
    if not body.can_rotate or body.mass == 0 or body.planar_inertia > 0:
        return None
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            own_point = points[body.name]
            if own_point.x != 0.0 or own_point.y != 0.0:
                return joint
    return None

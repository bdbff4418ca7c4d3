"""Lowering of a scene with one degree of freedom to the arrays of the reduced model."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, make_contact_table, output_dampers_of, output_springs_of
from governor_mechanism.mechanics.dynamics.force_elements import ForceElementKind, make_force_element_table
from governor_mechanism.mechanics.dynamics.lowering import BODY_DTYPE, forced_output_names, make_body_record
from governor_mechanism.mechanics.dynamics.output_forces import OUTPUT_FORCE_DTYPE, OutputForceKind
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.node_evaluation import ReductionArrays
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray, RecordArray

UNBOUNDED_RANGE = 1e9
"""Bound of the coordinate where the scene sets none, in coordinate scales."""


class ReducedForces(NamedTuple):
    """The forces along the output columns of the motion table; few arrays, because each one adds to the cost of a kernel call.

    Attributes
    ----------
    parameters
        Scalars, indexed by `ForceParameter`; shape (11,).
    one_sided_springs
        Springs that go slack instead of pushing: output index, rate, free value, output scale; shape (n, 4).
    output_dampers
        Output index, linear and quadratic coefficient; shape (n, 3).
    contacts
        As made by `make_contact_table`; shape (n, 6).
    """

    parameters: FloatArray
    one_sided_springs: FloatArray
    output_dampers: FloatArray
    contacts: FloatArray


class ForceParameter(IntEnum):
    """Indices of `ReducedForces.parameters`."""

    IS_SPINDLE_LOADED = 0
    """Whether a change of the spindle speed loads the bodies."""
    IS_SPINDLE_FREE = 1
    """Whether the spindle turns freely."""
    FREE_SPINDLE_INERTIA = 2
    """Moment of inertia of a free spindle itself, kg m2."""
    FLUCTUATION_AMPLITUDE = 3
    """Relative amplitude of the fluctuation of a given spindle speed."""
    CYCLES_PER_TURN = 4
    """Cycles of that fluctuation per turn."""
    FORCE_SCALE = 5
    """Scale of generalised forces along the coordinate."""
    IS_CONSERVATIVE = 6
    """Whether the quadratic and the potential column hold all forces."""
    PROGRAM_COUNT = 7
    """Number of inputs of force elements."""
    COORDINATE_SCALE = 8
    """Scale of the coordinate, m or rad."""
    TIME_SCALE = 9
    """Characteristic time, s."""
    ENERGY_SCALE = 10
    """Scale of energies, J."""


def time_functions_of(scene: Scene) -> tuple[CubicTimeFunction, ...]:
    """Return the time functions of a scene: spindle speed or torque, then inputs of force elements, then friction forces."""
    spindle, inputs = scene.spindle, make_force_element_table(scene.part.mechanism, {}, 1)[1]
    spindle_function = spindle.torque if isinstance(spindle, FreeSpindle) else spindle.speed_function
    friction_forces = [contact.friction for contact in contacts_of(scene) if contact.friction is not None]
    return tuple(map(CubicTimeFunction, [spindle_function, *inputs, *friction_forces]))


def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedForces]:
    """Lower a scene of one part to the arrays of its motion table and its forces.

    Parameters
    ----------
    scene
        The scene. Its mechanism has one degree of freedom and no drives.

    Returns
    -------
    tuple[ReductionArrays, ReducedForces]
        What is tabulated along the coordinate, and the forces that act along it.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    forced_outputs = forced_output_names(scene)
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    names = list(dict.fromkeys([*forced_outputs, *(limit.reading for limit in limits)]))
    output_rows = make_output_rows(mechanism, [*names, mechanism.coordinate], {})
    joint_rows = make_constraint_table(mechanism).rows
    rows = np.concatenate([joint_rows.table, output_rows.table[-1:]])
    force_elements, inputs = make_force_element_table(mechanism, {}, 1)
    springs, dampers, programmed_force_elements = _split_force_elements(force_elements)
    low, high = _coordinate_bounds(mechanism)
    scene_time_scale = time_scale(scene)
    has_centrifugal_forces = scene.has_centrifugal and scene.part.plane == TURNING_PLANE
    is_steady = isinstance(spindle, Spindle) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    output_scales = np.array([mechanism.output_scale(name) for name in names])
    arrays = ReductionArrays(
        constraint_rows=ConstraintRows(rows, bodies_of_rows(rows), joint_rows.curve_segments),
        coordinate_wraps=isinstance(mechanism.reading(mechanism.coordinate), LineAngle),
        free_indices=np.array([3 * k + c for k, body in enumerate(mechanism.bodies) for c in range(3 if body.can_rotate else 2)]),
        pose_scales=np.array([mechanism.length_scale, mechanism.length_scale, 1.0] * len(mechanism.bodies)),
        row_scales=np.array([*(1 / mechanism.length_scale,) * len(joint_rows.table), 1 / mechanism.output_scale(mechanism.coordinate)]),
        mass=np.array([m for b in mechanism.bodies for m in (b.mass, b.mass, b.second_moments.xx + b.second_moments.yy)]),
        bodies=np.array([make_body_record(body, scene.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        springs=springs,
        dampers=dampers,
        programmed_force_elements=programmed_force_elements,
        program_indices=np.arange(1, 1 + len(inputs)),
        output_rows=ConstraintRows(output_rows.table[:-1], output_rows.row_bodies[:-1], output_rows.curve_segments),
        output_scales=output_scales,
        output_springs=_two_sided_springs(scene, names),
        limits=np.array([(names.index(limit.reading), limit.low, limit.high) for limit in limits]).reshape(-1, 3),
        steady_speed=abs(spindle.speeds[0]) if is_steady and isinstance(spindle, Spindle) else -1.0,
        coordinate_scale=mechanism.output_scale(mechanism.coordinate),
        time_scale=scene_time_scale,
        length_scale=mechanism.length_scale,
        low=low,
        high=high,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=is_steady and not mechanism.force_elements and not scene.output_effects,
    )
    return arrays, _lower_forces(scene, arrays, names)


def _split_force_elements(force_elements: RecordArray) -> tuple[RecordArray, RecordArray, RecordArray]:
    """Return the force elements with a potential, those that damp, and those with a time function."""
    if not len(force_elements):
        return force_elements, force_elements, force_elements
    has_potential = (force_elements["kind"] == ForceElementKind.SPRING) | (force_elements["kind"] == ForceElementKind.TORSION_SPRING)
    return (
        force_elements[has_potential],
        force_elements[~has_potential & (force_elements["input_index"] < 0)],
        force_elements[force_elements["input_index"] >= 0],
    )


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _two_sided_springs(scene: Scene, names: list[str]) -> FloatArray:
    """Return the springs along outputs that both pull and push."""
    springs = [
        (OutputForceKind.SPRING, names.index(spring.reading), spring.rate, spring.free_value, -1)
        for spring in output_springs_of(scene)
        if not spring.one_sided
    ]
    return np.array(springs, dtype=OUTPUT_FORCE_DTYPE)


def _lower_forces(scene: Scene, arrays: ReductionArrays, names: list[str]) -> ReducedForces:
    mechanism, spindle = scene.part.mechanism, scene.spindle
    one_sided_springs = [
        (names.index(spring.reading), spring.rate, spring.free_value, mechanism.output_scale(spring.reading))
        for spring in output_springs_of(scene)
        if spring.one_sided
    ]
    output_dampers = [(names.index(damper.reading), damper.linear, damper.quadratic) for damper in output_dampers_of(scene)]
    mass = sum(body.mass for body in mechanism.bodies)
    parameters = np.zeros(len(ForceParameter))
    parameters[ForceParameter.IS_SPINDLE_LOADED] = arrays.has_centrifugal_forces
    parameters[ForceParameter.IS_SPINDLE_FREE] = isinstance(spindle, FreeSpindle)
    parameters[ForceParameter.FREE_SPINDLE_INERTIA] = spindle.inertia if isinstance(spindle, FreeSpindle) else 0.0
    parameters[ForceParameter.FLUCTUATION_AMPLITUDE] = 0.5 * spindle.speed_fluctuation if isinstance(spindle, Spindle) else 0.0
    parameters[ForceParameter.CYCLES_PER_TURN] = spindle.cycles_per_turn if isinstance(spindle, Spindle) else 1.0
    parameters[ForceParameter.FORCE_SCALE] = mass * (mechanism.length_scale / arrays.time_scale) ** 2 / arrays.coordinate_scale
    parameters[ForceParameter.IS_CONSERVATIVE], parameters[ForceParameter.PROGRAM_COUNT] = (
        arrays.is_conservative,
        len(arrays.program_indices),
    )
    parameters[ForceParameter.COORDINATE_SCALE], parameters[ForceParameter.TIME_SCALE] = arrays.coordinate_scale, arrays.time_scale
    parameters[ForceParameter.ENERGY_SCALE] = mass * (mechanism.length_scale / arrays.time_scale) ** 2
    return ReducedForces(
        parameters=parameters,
        one_sided_springs=np.array(one_sided_springs).reshape(-1, 4),
        output_dampers=np.array(output_dampers).reshape(-1, 3),
        contacts=make_contact_table(scene, names, 1 + len(arrays.program_indices)),
    )

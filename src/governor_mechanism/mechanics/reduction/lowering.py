"""A scene of mobility one as what is sampled along its coordinate, and what acts on the motion along it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, output_dampers_of, output_springs_of
from governor_mechanism.mechanics.dynamics.force_elements import SPRING_ELEMENT, TORSION_SPRING_ELEMENT, make_force_element_table
from governor_mechanism.mechanics.dynamics.lowering import BODY_DTYPE, forced_output_names, make_body_record
from governor_mechanism.mechanics.dynamics.output_forces import OUTPUT_FORCE_DTYPE, SPRING_FORCE
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.node_evaluation import ReductionArrays
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.scene import TURNING_PLANE, FreeSpindle, Scene, Spindle
from governor_mechanism.types import FloatArray, RecordArray

UNBOUNDED_RANGE = 1e9
"""Of the coordinate's unit: where the description bounds it nowhere."""


class ReducedForces(NamedTuple):
    """What acts on a motion along the columns of a Plan, whose gauges it counts; few arrays, for each costs time.

    numbers: see TURNS and those after it; springs (n, 4) that are slack where they would push: gauge, rate, free value,
    size; brakes (n, 3): gauge, linear, quadratic; keepers (n, 6): gauge, program of friction or -1, low, high,
    restitution, size. A size is what the reading is relative to.
    """

    parameters: FloatArray
    one_sided_springs: FloatArray
    output_dampers: FloatArray
    contacts: FloatArray


(
    IS_SPINDLE_LOADED,
    IS_SPINDLE_FREE,
    FREE_SPINDLE_INERTIA,
    FLUCTUATION_AMPLITUDE,
    CYCLES_PER_TURN,
    FORCE_SCALE,
    IS_CONSERVATIVE,
    PROGRAM_COUNT,
    COORDINATE_SCALE,
    TIME_SCALE,
    ENERGY_SCALE,
) = range(11)
"""Numbers of Acts: whether the spindle's changing speed loads the bodies; whether it is free, and its own inertia; the
part by which a given speed swings, and how often a turn; the size of forces; whether the first two columns are all that
acts; how many programs loads have; what the coordinate, times
and energies are relative to."""


def time_functions_of(scene: Scene) -> tuple[CubicTimeFunction, ...]:
    """The programs of a scene: of the spindle's speed, or the torque on it, of loads, and of frictions."""
    spindle, programs = scene.spindle, make_force_element_table(scene.part.mechanism, {}, 1)[1]
    spindle_program = spindle.torque if isinstance(spindle, FreeSpindle) else spindle.speed_function
    frictions = [contact.friction for contact in contacts_of(scene) if contact.friction is not None]
    return tuple(map(CubicTimeFunction, [spindle_program, *programs, *frictions]))


def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedForces]:
    """What there is to sample of a scene of one part, and what acts on it.

    The mechanism's joints must leave it one freedom and drive nothing.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    forced_outputs = forced_output_names(scene)
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    names = list(dict.fromkeys([*forced_outputs, *(limit.reading for limit in limits)]))
    output_rows = make_output_rows(mechanism, [*names, mechanism.coordinate], {})
    joint_rows = make_constraint_table(mechanism).rows
    rows = np.concatenate([joint_rows.table, output_rows.table[-1:]])
    loads, programs = make_force_element_table(mechanism, {}, 1)
    springs, dampers, programmed_force_elements = _split_force_elements(loads)
    low, high = _coordinate_bounds(mechanism)
    scene_time_scale = time_scale(scene)
    has_centrifugal_forces = scene.has_centrifugal and scene.part.plane == TURNING_PLANE
    is_steady = isinstance(spindle, Spindle) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    output_scales = np.array([_output_scale(mechanism, name) for name in names])
    arrays = ReductionArrays(
        constraint_rows=ConstraintRows(rows, bodies_of_rows(rows), joint_rows.curve_segments),
        coordinate_wraps=isinstance(mechanism.reading(mechanism.coordinate), LineAngle),
        free_indices=np.array([3 * k + c for k, body in enumerate(mechanism.bodies) for c in range(3 if body.can_rotate else 2)]),
        pose_scales=np.array([mechanism.length_scale, mechanism.length_scale, 1.0] * len(mechanism.bodies)),
        row_scales=np.array([*(1 / mechanism.length_scale,) * len(joint_rows.table), 1 / _output_scale(mechanism, mechanism.coordinate)]),
        mass=np.array([m for b in mechanism.bodies for m in (b.mass, b.mass, b.second_moments.xx + b.second_moments.yy)]),
        bodies=np.array([make_body_record(body) for body in mechanism.bodies], dtype=BODY_DTYPE),
        gravity=scene.gravity,
        has_centrifugal_forces=has_centrifugal_forces,
        springs=springs,
        dampers=dampers,
        programmed_force_elements=programmed_force_elements,
        program_indices=np.arange(1, 1 + len(programs)),
        output_rows=ConstraintRows(output_rows.table[:-1], output_rows.row_bodies[:-1], output_rows.curve_segments),
        output_scales=output_scales,
        output_springs=_two_sided_springs(scene, names),
        limits=np.array([(names.index(one.reading), one.low, one.high) for one in limits]).reshape(-1, 3),
        spindle_speed_squared=spindle.speeds[0] ** 2 if is_steady and isinstance(spindle, Spindle) else -1.0,
        coordinate_scale=_output_scale(mechanism, mechanism.coordinate),
        time_scale=scene_time_scale,
        length_scale=mechanism.length_scale,
        low=low,
        high=high,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=is_steady and not mechanism.force_elements and not scene.output_effects,
    )
    return arrays, _lower_forces(scene, arrays, names)


def _split_force_elements(force_elements: RecordArray) -> tuple[RecordArray, RecordArray, RecordArray]:
    """The loads with a potential, those that damp, and those with a program."""
    if not len(force_elements):
        return force_elements, force_elements, force_elements
    has_potential = (force_elements["kind"] == SPRING_ELEMENT) | (force_elements["kind"] == TORSION_SPRING_ELEMENT)
    return (
        force_elements[has_potential],
        force_elements[~has_potential & (force_elements["input_index"] < 0)],
        force_elements[force_elements["input_index"] >= 0],
    )


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = _output_scale(mechanism, mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _output_scale(mechanism: Mechanism, name: str) -> float:
    return 1.0 if mechanism.reading(name).quantity == "angle" else mechanism.length_scale


def _two_sided_springs(scene: Scene, names: list[str]) -> FloatArray:
    """Springs along readings that pull both ways."""
    springs = [
        (SPRING_FORCE, names.index(spring.reading), spring.rate, spring.free_value, -1)
        for spring in output_springs_of(scene)
        if not spring.one_sided
    ]
    return np.array(springs, dtype=OUTPUT_FORCE_DTYPE)


def _lower_forces(scene: Scene, arrays: ReductionArrays, names: list[str]) -> ReducedForces:
    mechanism, spindle, program = scene.part.mechanism, scene.spindle, 1 + len(arrays.program_indices)
    contacts = []
    for contact in contacts_of(scene):
        has_friction = contact.friction is not None
        contacts.append((names.index(contact.output_name), program if has_friction else -1, contact.low, contact.high,
                        contact.restitution, _output_scale(mechanism, contact.output_name)))  # fmt: skip
        program += has_friction
    one_sided_springs = [
        (names.index(spring.reading), spring.rate, spring.free_value, _output_scale(mechanism, spring.reading))
        for spring in output_springs_of(scene)
        if spring.one_sided
    ]
    output_dampers = [(names.index(spring.reading), spring.linear, spring.quadratic) for spring in output_dampers_of(scene)]
    mass = sum(body.mass for body in mechanism.bodies)
    parameters = np.zeros(11)
    parameters[IS_SPINDLE_LOADED] = arrays.has_centrifugal_forces
    parameters[IS_SPINDLE_FREE] = isinstance(spindle, FreeSpindle)
    parameters[FREE_SPINDLE_INERTIA] = spindle.inertia if isinstance(spindle, FreeSpindle) else 0.0
    parameters[FLUCTUATION_AMPLITUDE] = 0.5 * spindle.speed_fluctuation if isinstance(spindle, Spindle) else 0.0
    parameters[CYCLES_PER_TURN] = spindle.cycles_per_turn if isinstance(spindle, Spindle) else 1.0
    parameters[FORCE_SCALE] = mass * (mechanism.length_scale / arrays.time_scale) ** 2 / arrays.coordinate_scale
    parameters[IS_CONSERVATIVE], parameters[PROGRAM_COUNT] = arrays.is_conservative, len(arrays.program_indices)
    parameters[COORDINATE_SCALE], parameters[TIME_SCALE] = arrays.coordinate_scale, arrays.time_scale
    parameters[ENERGY_SCALE] = mass * (mechanism.length_scale / arrays.time_scale) ** 2
    return ReducedForces(
        parameters=parameters,
        one_sided_springs=np.array(one_sided_springs).reshape(-1, 4),
        output_dampers=np.array(output_dampers).reshape(-1, 3),
        contacts=np.array(contacts).reshape(-1, 6),
    )

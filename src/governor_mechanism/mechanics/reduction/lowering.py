"""Lowering of a scene with one degree of freedom to the arrays of the reduced model."""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, loads_of, make_contact_table, one_sided_forces_of, output_forces_of
from governor_mechanism.mechanics.dynamics.force_elements import ForceElementKind, make_force_element_table
from governor_mechanism.mechanics.dynamics.inputs import make_input_terms
from governor_mechanism.mechanics.dynamics.lowering import BODY_DTYPE, forced_output_names, make_body_record
from governor_mechanism.mechanics.dynamics.output_forces import MAX_COEFFICIENTS, OUTPUT_FORCE_DTYPE, output_force_record
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.mechanics.reduction.node_evaluation import ReductionArrays
from governor_mechanism.mechanics.reduction.shaft import ShaftTrain, find_shaft_train, parts_with_coordinate, shaft_readings
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import FloatArray, RecordArray

UNBOUNDED_RANGE = 1e9
"""Bound of the coordinate where the scene sets none, in coordinate scales."""


class ReducedForces(NamedTuple):
    """The forces along the output columns of the motion table; few arrays, because each one adds to the cost of a kernel call.

    Attributes
    ----------
    parameters
        Scalars, indexed by `ForceParameter`.
    one_sided_springs
        Springs that go slack instead of pushing: output index, value below which they are slack, output scale; shape (n, 3).
    output_forces
        Force laws that the table does not contain, by `OutputForceColumn`; shape (n, 8).
    contacts
        Records of `CONTACT_DTYPE`; shape (contacts,).
    shaft_torques
        Input of each torque on the shaft, and its ratio to the shaft; shape (n, 2).
    shaft_outputs
        Ratio to the shaft, and angle (rad) at its zero, of the angles that loads depend on; shape (n, 2).
    input_terms
        Records of `INPUT_TERM_DTYPE`; their sources are the outputs of the table, then `shaft_outputs`.
    inputs
        Values of the inputs at the last evaluation; shape (inputs,).
    """

    parameters: FloatArray
    one_sided_springs: FloatArray
    output_forces: FloatArray
    contacts: RecordArray
    shaft_torques: FloatArray
    shaft_outputs: FloatArray
    input_terms: RecordArray
    inputs: FloatArray


class OutputForceColumn(IntEnum):
    """Columns of `ReducedForces.output_forces`."""

    OUTPUT = 0
    """Index of the output."""
    LAW = 1
    """Index of the force law in `FORCE_LAWS`."""
    DISSIPATES = 2
    """Whether the force dissipates energy."""
    MODE = 3
    """Index in the contact mode of whether a one-sided spring is taut; -1 for a force that always acts."""
    FIRST_COEFFICIENT = 4
    """From here on the coefficients of the law."""


class ForceParameter(IntEnum):
    """Indices of `ReducedForces.parameters`."""

    IS_SPINDLE_LOADED = 0
    """Whether a change of the spindle speed loads the bodies."""
    SPINDLE_RATIO = 1
    """Ratio of the spindle speed to that of the shaft; 0 if the spindle speed is given."""
    SHAFT_INERTIA = 2
    """Moment of inertia of all bodies that only rotate, at the speed of the shaft, kg m2."""
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
    HAS_SHAFT = 11
    """Whether a shaft turns freely, so that its angle and speed are states."""
    HAS_REACTION = 12
    """Whether the bodies in the turning plane act on the shaft."""
    SHAFT_DAMPING = 13
    """Coefficient of the torsion dampers on the shaft, N m s/rad."""
    FIRST_PROGRAM_INPUT = 14
    """Index of the first input of force elements that act along the coordinate."""
    OUTPUT_COUNT = 15
    """Number of outputs in the table."""


def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedForces, tuple[InputFunction, ...]]:
    """Lower a scene to the arrays of its motion table and its forces.

    Parameters
    ----------
    scene
        The scene: one part with one degree of freedom and no drives, and at most one shaft.

    Returns
    -------
    arrays : ReductionArrays
        What is tabulated along the coordinate.
    forces : ReducedForces
        The forces that act along it and on the shaft.
    inputs : tuple[InputFunction, ...]
        Given spindle speed, loads of force elements, friction forces, factors of these.
    """
    (prefix, part), train = parts_with_coordinate(scene)[0], find_shaft_train(scene)
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    spindle = plane.given_speed if plane and plane.given_speed else Spindle()
    shaft_angles = shaft_readings(scene, train)
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    forced_outputs = [name for name in forced_output_names(scene) if name not in shaft_angles]
    names = list(dict.fromkeys([*forced_outputs, *(prefix + limit.reading for limit in limits)]))
    output_rows = make_output_rows(mechanism, [*(name.removeprefix(prefix) for name in names), mechanism.coordinate], {})
    joint_rows = make_constraint_table(mechanism).rows
    rows = np.concatenate([joint_rows.table, output_rows.table[-1:]])
    all_elements, element_inputs = make_force_element_table(scene.mechanism, {}, 1)
    force_elements, shaft_elements = _split_by_part(all_elements, scene, prefix, part, train)
    has_potential = np.isin(force_elements["kind"], (ForceElementKind.SPRING, ForceElementKind.TORSION_SPRING))
    has_program = force_elements["input_index"] >= 0
    programmed = force_elements[has_program]
    program_indices = np.unique([programmed[name] for name in ("input_index", "input_index_y")]).astype(np.int64)
    tabulated = [effect for effect in output_forces_of(scene) if _is_tabulated(effect)]
    tabulated_forces = [output_force_record(effect, names.index(effect.reading)) for effect in tabulated]
    low, high = _coordinate_bounds(mechanism)
    has_centrifugal_forces = plane is not None and plane.is_loaded
    is_steady = not (plane and plane.shaft) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    arrays = ReductionArrays(
        constraint_rows=ConstraintRows(rows, bodies_of_rows(rows), joint_rows.curve_segments),
        coordinate_wraps=isinstance(mechanism.reading(mechanism.coordinate), LineAngle),
        free_indices=np.array([3 * k + c for k, body in enumerate(mechanism.bodies) for c in range(3 if body.can_rotate else 2)]),
        pose_scales=np.array([mechanism.length_scale, mechanism.length_scale, 1.0] * len(mechanism.bodies)),
        row_scales=np.array([*(1 / mechanism.length_scale,) * len(joint_rows.table), 1 / mechanism.output_scale(mechanism.coordinate)]),
        mass=np.array([m for b in mechanism.bodies for m in (b.mass, b.mass, b.second_moments.xx + b.second_moments.yy)]),
        bodies=np.array([make_body_record(body, part.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        springs=force_elements[has_potential],
        dampers=force_elements[~has_potential & ~has_program],
        programmed_force_elements=programmed,
        program_indices=program_indices[program_indices >= 0],
        output_rows=ConstraintRows(output_rows.table[:-1], output_rows.row_bodies[:-1], output_rows.curve_segments),
        output_scales=np.array([scene.mechanism.output_scale(name) for name in names]),
        output_springs=np.array(tabulated_forces, dtype=OUTPUT_FORCE_DTYPE),
        limits=np.array([(names.index(prefix + limit.reading), limit.low, limit.high) for limit in limits]).reshape(-1, 3),
        steady_speed=abs(spindle.speeds[0]) if is_steady else -1.0,
        coordinate_scale=mechanism.output_scale(mechanism.coordinate),
        time_scale=time_scale(scene),
        length_scale=mechanism.length_scale,
        low=low,
        high=high,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=is_steady and not scene.mechanism.force_elements and not scene.output_effects and not train.motion,
    )
    loads = loads_of(scene)
    input_terms, _, n_further_inputs = make_input_terms([*names, *shaft_angles], (), 1, loads, len(loads) - len(element_inputs))
    inputs = (spindle.speed_function, *loads, *(InputFunction(),) * n_further_inputs)
    one_sided_springs = [
        (names.index(one.reading), one.slack_below, scene.mechanism.output_scale(one.reading)) for one in one_sided_forces_of(scene)
    ]
    forces = ReducedForces(
        parameters=_make_parameters(scene, arrays, train, shaft_elements),
        one_sided_springs=np.array(one_sided_springs).reshape(-1, 3),
        output_forces=_output_forces(scene, names),
        contacts=make_contact_table(scene, names, 1 + len(element_inputs)),
        shaft_torques=np.array([(index, ratio) for index, ratio, _ in shaft_elements if index >= 0]).reshape(-1, 2),
        shaft_outputs=np.array(list(shaft_angles.values())).reshape(-1, 2),
        input_terms=input_terms,
        inputs=np.zeros(len(inputs)),
    )
    return arrays, forces, inputs


def _split_by_part(
    elements: RecordArray, scene: Scene, prefix: str, part: Part, train: ShaftTrain
) -> tuple[RecordArray, list[tuple[int, float, float]]]:
    """Return the force elements of the part with the coordinate, and input, relative ratio and damping of those on the shaft."""
    mechanism = scene.mechanism
    first_body = mechanism.body_index(prefix + part.mechanism.bodies[0].name)
    bodies = np.maximum(elements["first"], elements["second"])
    is_own = (bodies >= first_body) & (bodies < first_body + len(part.mechanism.bodies))
    own: RecordArray = elements[is_own]
    for side in ("first", "second"):
        own[side] -= np.where(own[side] >= 0, first_body, 0)
    others = [element for element, is_one in zip(mechanism.force_elements, is_own, strict=True) if not is_one]
    ratios = [train.ratio(element.bodies[1]) - train.ratio(element.bodies[0]) for element in others]
    records = elements[~is_own]
    return own, list(zip(records["input_index"].tolist(), ratios, records["coefficient"].tolist(), strict=True))


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _is_tabulated(effect: OutputForce) -> bool:
    """Return whether the table contains a force along an output: it depends on the coordinate alone, and smoothly."""
    return not effect.dissipates and effect.slack_below == -math.inf


def _output_forces(scene: Scene, names: list[str]) -> FloatArray:
    """Return the force laws that the table does not contain, as in `ReducedForces`."""
    one_sided, n_contacts, rows = one_sided_forces_of(scene), len(contacts_of(scene)), []
    for effect in (effect for effect in output_forces_of(scene) if not _is_tabulated(effect)):
        law, output_index, dissipates, _, coefficients = output_force_record(effect, names.index(effect.reading))
        mode_index = 1 + n_contacts + one_sided.index(effect) if effect in one_sided else -1
        rows.append((output_index, law, dissipates, mode_index, *coefficients))
    return np.array(rows, dtype=float).reshape(-1, OutputForceColumn.FIRST_COEFFICIENT + MAX_COEFFICIENTS)


def _make_parameters(
    scene: Scene, arrays: ReductionArrays, train: ShaftTrain, shaft_elements: list[tuple[int, float, float]]
) -> FloatArray:
    """Return the scalars of a scene, indexed by `ForceParameter`."""
    spindle = next((plane.given_speed for plane in scene.system.planes if plane.given_speed), None) or Spindle()
    energy_scale = sum(body.mass for body in scene.mechanism.bodies) * (scene.mechanism.length_scale / arrays.time_scale) ** 2
    own_energy_scale = float(np.sum(arrays.bodies["mass"])) * (arrays.length_scale / arrays.time_scale) ** 2
    rotors = [body for body in scene.mechanism.bodies if body.name in train.motion]
    values = {
        ForceParameter.IS_SPINDLE_LOADED: arrays.has_centrifugal_forces,
        ForceParameter.SPINDLE_RATIO: train.spindle_ratio,
        ForceParameter.SHAFT_INERTIA: sum(train.ratio(body.name) ** 2 * body.planar_inertia for body in rotors),
        ForceParameter.FLUCTUATION_AMPLITUDE: 0.5 * spindle.speed_fluctuation,
        ForceParameter.CYCLES_PER_TURN: spindle.cycles_per_turn,
        ForceParameter.FORCE_SCALE: own_energy_scale / arrays.coordinate_scale,
        ForceParameter.IS_CONSERVATIVE: arrays.is_conservative,
        ForceParameter.PROGRAM_COUNT: len(arrays.program_indices),
        ForceParameter.COORDINATE_SCALE: arrays.coordinate_scale,
        ForceParameter.TIME_SCALE: arrays.time_scale,
        ForceParameter.ENERGY_SCALE: energy_scale,
        ForceParameter.HAS_SHAFT: bool(train.motion),
        ForceParameter.HAS_REACTION: train.has_reaction,
        ForceParameter.SHAFT_DAMPING: sum(damping * ratio**2 for _, ratio, damping in shaft_elements),
        ForceParameter.FIRST_PROGRAM_INPUT: next(iter(arrays.program_indices), 1),
        ForceParameter.OUTPUT_COUNT: len(arrays.output_scales),
    }
    return np.array([float(values[parameter]) for parameter in ForceParameter])

"""Lowering of a scene with one degree of freedom to the arrays of the reduced model."""

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import (
    contacts_of,
    loads_of,
    make_contact_table,
    one_sided_forces_of,
    output_forces_of,
    reading_tables_of,
)
from governor_mechanism.mechanics.dynamics.force_elements import element_law, lower_outputs
from governor_mechanism.mechanics.dynamics.inputs import make_input_terms, make_table_segments
from governor_mechanism.mechanics.dynamics.lowering import BODY_DTYPE, forced_output_names, make_body_record, make_gas_event_functions
from governor_mechanism.mechanics.dynamics.output_forces import (
    EVENT_FUNCTION_DTYPE,
    MAX_COEFFICIENTS,
    OUTPUT_FORCE_DTYPE,
    OutputForceRecord,
    make_output_force,
    output_force_record,
)
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.coordinate_assembly import lower_assembly
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.node_evaluation import MIN_FIT_TOLERANCE, LagrangianArrays, ReductionArrays
from governor_mechanism.mechanics.reduction.shaft import ShaftTrain, find_shaft_train, parts_with_coordinate, shaft_readings
from governor_mechanism.mechanics.reduction.shaft_outputs import ShaftOutputs, lower_shaft_outputs
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray, RecordArray

UNBOUNDED_RANGE = 1e9
"""Bound of the coordinate where the scene sets none, in coordinate scales."""


COORDINATE = -2
"""Index that stands for the coordinate among those of outputs."""


class ReducedForces(NamedTuple):
    """The forces along the output columns of the motion table; few arrays, because each one adds to the cost of a kernel call.

    Attributes
    ----------
    parameters
        Scalars, indexed by `ForceParameter`.
    one_sided_springs
        Springs that go slack instead of pushing: output index, value below which they are slack, output scale; shape (n, 3).
    output_forces
        Force laws that the table does not contain, by `OutputForceColumn`; shape (n, columns).
    contacts
        Records of `CONTACT_DTYPE`; shape (contacts,).
    shaft_torques
        Input of each torque on the shaft, and its ratio to the shaft; shape (n, 2).
    shaft_forces
        Gas on the shaft, like `output_forces`; shape (n, columns).
    shaft_outputs
        Outputs of bodies on the shaft along which gas acts or on which loads depend. Outputs are counted from those of the table on.
    kinks
        Kinks of gas, records of `EVENT_FUNCTION_DTYPE`; an index of COORDINATE is the coordinate; shape (kinks,).
    table_segments
        Segments of all tables of readings, records of `TABLE_SEGMENT_DTYPE`.
    input_terms
        Records of `INPUT_TERM_DTYPE`; those of tables are set where a segment begins.
    inputs
        Values of the inputs at the last evaluation; shape (inputs,).
    """

    parameters: FloatArray
    one_sided_springs: FloatArray
    output_forces: FloatArray
    contacts: RecordArray
    shaft_torques: FloatArray
    shaft_forces: FloatArray
    shaft_outputs: ShaftOutputs
    kinks: RecordArray
    table_segments: RecordArray
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
    CRANK_ANGLE = 4
    """Output that is the crank angle of a gas, or COORDINATE."""
    PHASE = 5
    """Index in the contact mode of the phase of the cycle that a gas is kept in, or IN_NO_PHASE; -1 for other forces."""
    INPUT = 6
    """Input by which the force is multiplied, or -1."""
    FIRST_COEFFICIENT = 7
    """From here on the coefficients of the law."""


N_OUTPUT_FORCE_COLUMNS = OutputForceColumn.FIRST_COEFFICIENT + MAX_COEFFICIENTS
"""Number of columns of `ReducedForces.output_forces`."""


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
    LOAD_COUNT = 7
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
    FIRST_LOAD_INPUT = 14
    """Index of the first input of force elements that act along the coordinate."""
    OUTPUT_COUNT = 15
    """Number of outputs in the table."""
    MIN_RATE = 16
    """Rate of the coordinate below which the integration ends."""
    STALL_RATIO = 17
    """Ratio to the shaft of a body on it with which the integration ends where it turns back, or 0."""
    TABLE_COUNT = 18
    """Number of tables of readings."""


def lower_lagrangian(scene: Scene, prefix: str, part: Part, outputs: Sequence[str], effects: Sequence[OutputForce]) -> LagrangianArrays:
    """Lower a part with one degree of freedom to the arrays of its Lagrangian coefficients; gas is left out: its force has kinks.

    Parameters
    ----------
    scene
        The scene.
    prefix
        Start of the names of the part.
    part
        The part; its mechanism has no drives.
    outputs
        Readings of the part that are evaluated with the coefficients, among them those of the effects.
    effects
        Effects with a potential.

    Returns
    -------
    LagrangianArrays
        What determines the coefficients.
    """
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    has_centrifugal_forces = plane is not None and plane.is_loaded
    own_elements = [
        element
        for element in scene.mechanism.force_elements
        if not _is_elsewhere(element, prefix, part) and not isinstance(element, CylinderGas)
    ]
    rows, element_forces = lower_outputs(scene.mechanism, outputs, own_elements, {}, 0)
    first_body = scene.mechanism.body_index(prefix + mechanism.bodies[0].name)
    for side in ("first", "second"):
        rows.table[side] -= np.where(rows.table[side] >= 0, first_body, 0)
    effect_records = [output_force_record(effect, outputs.index(effect.reading)) for effect in effects]
    if effect_records:
        element_forces = np.concatenate([np.array(effect_records, dtype=OUTPUT_FORCE_DTYPE), element_forces])
    return LagrangianArrays(
        assembly=lower_assembly(mechanism),
        mass=np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).ravel(),
        bodies=np.array([make_body_record(body, part.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        output_rows=rows._replace(row_bodies=bodies_of_rows(rows.table)),
        forces=element_forces,
        n_loads=sum(len(element.loads) for element in own_elements),
    )


@once_per_object
def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedForces, tuple[CubicTimeFunction, ...]]:
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
    input_functions : tuple[CubicTimeFunction, ...]
        Given spindle speed, loads of force elements, friction forces, factors of these.
    """
    (prefix, part), train = parts_with_coordinate(scene)[0], find_shaft_train(scene)
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    spindle = plane.given_speed if plane and plane.given_speed else Spindle()
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    all_gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    gases = [gas for gas in all_gases if not _is_elsewhere(gas, prefix, part)]
    shaft_gases = [gas for gas in all_gases if _is_elsewhere(gas, prefix, part)]
    names, shaft_names = _output_names(scene, train, [prefix + limit.reading for limit in limits], gases, shaft_gases)
    all_names = [*names, *shaft_names]
    tabulated = [effect for effect in output_forces_of(scene) if _is_tabulated(effect)]
    lagrangian = lower_lagrangian(scene, prefix, part, names, tabulated)
    low, high = _coordinate_bounds(mechanism)
    is_steady = not (plane and plane.shaft) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    arrays = ReductionArrays(
        lagrangian=lagrangian,
        output_scales=np.array([scene.mechanism.output_scale(name) for name in names]),
        limits=np.array([(names.index(prefix + limit.reading), limit.low, limit.high) for limit in limits]).reshape(-1, 3),
        steady_speed=abs(spindle.speeds[0]) if is_steady else -1.0,
        time_scale=time_scale(scene),
        low=low,
        high=high,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=is_steady and not scene.mechanism.force_elements and not scene.output_effects and not train.motion,
        fit_tolerance=MIN_FIT_TOLERANCE,
    )
    loads, contacts = loads_of(scene), contacts_of(scene)
    first_friction_input = 1 + len(loads) - sum(contact.friction is not None for contact in contacts)
    input_terms, _, n_further_inputs = make_input_terms(
        all_names, [0] * len(reading_tables_of(scene)), 1, loads, len(loads) + 1 - first_friction_input
    )
    inputs = (spindle.speed_function, *loads, *(InputFunction(),) * n_further_inputs)
    one_sided_springs = [
        (names.index(one.reading), one.slack_below, scene.mechanism.output_scale(one.reading)) for one in one_sided_forces_of(scene)
    ]
    shaft_elements, first_load_input = _shaft_elements(scene, prefix, part, train)
    gas_records = [_gas_record(scene, all_names, gas, prefix + mechanism.coordinate) for gas in (*gases, *shaft_gases)]
    kinks = make_gas_event_functions(np.array(gas_records, dtype=OUTPUT_FORCE_DTYPE), -1)
    n_tables, scales = len(reading_tables_of(scene)), [scene.mechanism.output_scale(name) for name in all_names]
    first_phase = 1 + len(contacts) + len(one_sided_springs) + n_tables + len(kinks)
    forces = ReducedForces(
        parameters=_make_parameters(scene, part, arrays, train, shaft_elements, first_load_input),
        one_sided_springs=np.array(one_sided_springs).reshape(-1, 3),
        output_forces=np.array([*_effect_rows(scene, names), *_gas_rows(gas_records[: len(gases)], first_phase)], dtype=float).reshape(
            -1, N_OUTPUT_FORCE_COLUMNS
        ),
        contacts=make_contact_table(scene, names, first_friction_input),
        shaft_torques=np.array([(index, ratio) for index, ratio, _ in shaft_elements if index >= 0]).reshape(-1, 2),
        shaft_forces=np.array(_gas_rows(gas_records[len(gases) :], first_phase + len(gases))).reshape(-1, N_OUTPUT_FORCE_COLUMNS),
        shaft_outputs=lower_shaft_outputs(scene, train, shaft_names),
        kinks=np.array(kinks, dtype=EVENT_FUNCTION_DTYPE),
        table_segments=make_table_segments(all_names, scales, arrays.time_scale, loads),
        input_terms=input_terms,
        inputs=np.zeros(len(inputs)),
    )
    return arrays, forces, tuple(map(CubicTimeFunction, inputs))


def _is_elsewhere(element: ForceElement, prefix: str, part: Part) -> bool:
    """Return whether a force element acts on no body of a part."""
    return {prefix + body.name for body in part.mechanism.bodies}.isdisjoint(element.bodies)


def _shaft_elements(scene: Scene, prefix: str, part: Part, train: ShaftTrain) -> tuple[list[tuple[int, float, float]], int]:
    """Return input (-1 for a damper), relative ratio and damping of the force elements on the shaft, and the first input of the others."""
    shaft_elements, next_input, first_own_input = list[tuple[int, float, float]](), 1, 1
    for element in scene.mechanism.force_elements:
        ratio = train.ratio(element.bodies[1]) - train.ratio(element.bodies[0])
        if _is_elsewhere(element, prefix, part):
            if not isinstance(element, CylinderGas):
                shaft_elements.append((next_input, ratio, 0.0) if element.loads else (-1, ratio, element_law(element)[1][0]))
            first_own_input += len(element.inputs) if first_own_input == next_input else 0
        next_input += len(element.inputs)
    return shaft_elements, first_own_input


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _is_tabulated(effect: OutputForce) -> bool:
    """Return whether the table contains a force along an output: it depends on the coordinate alone, and smoothly."""
    return not effect.dissipates and effect.slack_below == -math.inf


def _output_names(
    scene: Scene, train: ShaftTrain, limited: Sequence[str], gases: Sequence[CylinderGas], shaft_gases: Sequence[CylinderGas]
) -> tuple[list[str], list[str]]:
    """Return the readings that the table contains, among them those with limits, and those that the shaft gives."""
    forced, given_by_shaft = forced_output_names(scene), shaft_readings(scene, train)
    own = [*(name for name in forced if name not in given_by_shaft), *limited, *(gas.travel.name for gas in gases)]
    of_gas = [name for gas in shaft_gases for name in (gas.travel.name, gas.crank_angle.name)]
    return list(dict.fromkeys(own)), list(dict.fromkeys([*(name for name in forced if name in given_by_shaft), *of_gas]))


def _effect_rows(scene: Scene, names: Sequence[str]) -> list[tuple[float, ...]]:
    """Return the laws of effects that the table does not contain, as in `ReducedForces.output_forces`."""
    one_sided, n_contacts, rows = one_sided_forces_of(scene), len(contacts_of(scene)), list[tuple[float, ...]]()
    for effect in (effect for effect in output_forces_of(scene) if not _is_tabulated(effect)):
        law, output_index, _, dissipates, *_, coefficients = output_force_record(effect, names.index(effect.reading))
        mode_index = 1 + n_contacts + one_sided.index(effect) if effect in one_sided else -1
        rows.append((output_index, law, dissipates, mode_index, -1, -1, -1, *coefficients))
    return rows


def _gas_record(scene: Scene, names: Sequence[str], gas: CylinderGas, coordinate: str) -> OutputForceRecord:
    """Return the gas in a cylinder as a record of `OUTPUT_FORCE_DTYPE`."""
    law, coefficients = element_law(gas)
    inputs = [load for element in scene.mechanism.force_elements for load in element.inputs]
    return make_output_force(
        FORCE_LAWS.index(law),
        names.index(gas.travel.name),
        coefficients,
        argument_index=COORDINATE if gas.crank_angle.name == coordinate else names.index(gas.crank_angle.name),
        input_index=-1 if gas.factor is None else 1 + next(k for k, load in enumerate(inputs) if load is gas.factor),
    )


def _gas_rows(records: Sequence[OutputForceRecord], first_phase: int) -> list[tuple[float, ...]]:
    """Return records of gas, whose phases begin at an index of the contact mode, as in `ReducedForces.output_forces`."""
    rows = list[tuple[float, ...]]()
    for phase, (law, output_index, crank_angle, _, factor, *_, coefficients) in enumerate(records, start=first_phase):
        rows.append((output_index, law, False, -1, crank_angle, phase, factor, *coefficients))
    return rows


def _make_parameters(
    scene: Scene,
    part: Part,
    arrays: ReductionArrays,
    train: ShaftTrain,
    shaft_elements: list[tuple[int, float, float]],
    first_load_input: int,
) -> FloatArray:
    """Return the scalars of a scene, indexed by `ForceParameter`."""
    spindle = next((plane.given_speed for plane in scene.system.planes if plane.given_speed), None) or Spindle()
    energy_scale = sum(body.mass for body in scene.mechanism.bodies) * (scene.mechanism.length_scale / arrays.time_scale) ** 2
    assembly, mechanism = arrays.lagrangian.assembly, part.mechanism
    own_mass = sum(body.mass for body in mechanism.bodies)
    own_energy_scale = own_mass * (mechanism.length_scale / arrays.time_scale) ** 2
    rotors = [body for body in scene.mechanism.bodies if body.name in train.motion]
    stalling_ratio = next((train.ratio(limit.body) for limit in scene.mechanism.stall_limits if limit.body in train.motion), 0.0)
    values = {
        ForceParameter.IS_SPINDLE_LOADED: arrays.lagrangian.has_centrifugal_forces,
        ForceParameter.SPINDLE_RATIO: train.spindle_ratio,
        ForceParameter.SHAFT_INERTIA: sum(train.ratio(body.name) ** 2 * body.planar_inertia for body in rotors),
        ForceParameter.FLUCTUATION_AMPLITUDE: 0.5 * spindle.speed_fluctuation,
        ForceParameter.CYCLES_PER_TURN: spindle.cycles_per_turn,
        ForceParameter.FORCE_SCALE: own_energy_scale / assembly.coordinate_scale,
        ForceParameter.IS_CONSERVATIVE: arrays.is_conservative,
        ForceParameter.LOAD_COUNT: arrays.lagrangian.n_loads,
        ForceParameter.COORDINATE_SCALE: assembly.coordinate_scale,
        ForceParameter.TIME_SCALE: arrays.time_scale,
        ForceParameter.ENERGY_SCALE: energy_scale,
        ForceParameter.HAS_SHAFT: bool(train.motion),
        ForceParameter.HAS_REACTION: train.has_reaction,
        ForceParameter.SHAFT_DAMPING: sum(damping * ratio**2 for _, ratio, damping in shaft_elements),
        ForceParameter.FIRST_LOAD_INPUT: first_load_input,
        ForceParameter.OUTPUT_COUNT: len(arrays.output_scales),
        ForceParameter.MIN_RATE: -math.inf if stalling_ratio or not scene.mechanism.stall_limits else 0.0,
        ForceParameter.STALL_RATIO: stalling_ratio,
        ForceParameter.TABLE_COUNT: len(reading_tables_of(scene)),
    }
    return np.array([float(values[parameter]) for parameter in ForceParameter])

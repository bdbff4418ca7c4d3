"""Event functions of contacts, of tables of readings and of gas in cylinders: their records in a contact mode, and their values."""

import math
from collections.abc import Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT, GasPressure
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.arrays import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, forced_output_names, rows_of_held_contacts
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, one_sided_forces_of, outline_gaps_of
from governor_mechanism.mechanics.dynamics.inputs import EVENT_ROUNDING_RATIO, output_rate, reading_tables_of
from governor_mechanism.mechanics.dynamics.output_forces import evaluate_travel_in_stroke
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_join, evaluate_other_gap, evaluate_rows_for
from governor_mechanism.mechanics.kinematics.constraint_rows import FOR_EVENTS, RowColumn
from governor_mechanism.model.curves import CornerOutline
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place, record_dtype
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray, IntArray, RecordArray


class EventFunctionKind(IntEnum):
    """Quantity of an event function: value or rate of an output, or force of the constraint row that holds it.

    The force of a row with an argument is that of friction: the threshold times the normal force, that of the argument, is its limit. The
    others are kinks of the gas in a cylinder, at which nothing changes but the law: the dead centres, the sine of the output, and the
    switch of its pressure, the travel since the last dead centre; and the join of two edges of an outline, how far the constraint row that
    holds a gap is beyond the edge that it keeps. OTHER_GAP is the gap of the nearest other one of several rollers while one is held.
    """

    VALUE = 0
    RATE = 1
    FORCE = 2
    DEAD_CENTRE = 3
    SWITCH = 4
    JOIN = 5
    OTHER_GAP = 6


GAS_KINKS = (EventFunctionKind.DEAD_CENTRE, EventFunctionKind.SWITCH)
"""Kinds of event functions of kinks of gas."""

KINKS = (*GAS_KINKS, EventFunctionKind.JOIN)
"""Kinds of event functions of kinks."""

RELEASE_FORCE_RATIO = 100.0
"""Pull at which an outline lets a roller go, relative to the rounding of a force: what touches without a force goes on touching."""

EVENT_FUNCTION_DTYPE = record_dtype(
    ("kind", "i8"),  # an EventFunctionKind
    ("source_index", "i8"),  # the output row, or for a force the constraint row that holds the output
    # SWITCH: the output row of the crank angle; FORCE: the constraint row of the normal force; or NO_INDEX
    ("argument_index", "i8"),
    ("sign", "f8"),  # 1 or -1; SWITCH: 1 / stroke, 1/m
    ("threshold", "f8"),
    ("tolerance", "f8"),  # rounding of the event function
    ("input_index", "i8"),  # the input that is subtracted, or NO_INDEX
    ("contact_index", "i8"),  # the contact or one-sided spring concerned
)
"""One event function g = sign * quantity - threshold - input. An event is an upward zero crossing of g."""

EventFunctionRecord = tuple[EventFunctionKind, int, int, float, float, float, int, int]
"""A record of `EVENT_FUNCTION_DTYPE`."""


class EventTolerances(NamedTuple):
    """Rounding levels of event functions."""

    outputs: Mapping[str, float]  # that of the value of each output, m or rad
    force: float  # that of a constraint force, N
    time: float  # characteristic time of the scene, s; the rounding level of a rate is that of the value divided by it


def make_event_functions(
    scene: Scene,
    mode: ContactMode,
    friction_inputs: Sequence[int],  # input of the friction limit of each contact, see `InputLayout`
    held_rows: IntArray,  # constraint rows of the held outputs; shape (held outputs,)
    force_elements: RecordArray,
) -> RecordArray:
    """Return the event functions of a mode, as records of `EVENT_FUNCTION_DTYPE`."""
    # The contact index counts the contacts, then the one-sided springs, the tables of readings, and
    # last all gases together.
    tolerances = _event_tolerances(scene)
    first_table = len(mode.held_values) + len(mode.taut)
    records = [
        *_contact_event_functions(scene, mode, friction_inputs, held_rows, tolerances),
        *_other_gap_event_functions(scene, mode, held_rows, tolerances),
        *_slack_event_functions(scene, mode, tolerances),
        *_table_event_functions(scene, mode, first_table, tolerances),
        *make_gas_event_functions(force_elements, first_table + len(mode.segments)),
        *_join_event_functions(scene, mode, held_rows, tolerances),
    ]
    return np.array(records, dtype=EVENT_FUNCTION_DTYPE)


OF_CONSTRAINT_ROWS = (EventFunctionKind.FORCE, EventFunctionKind.JOIN, EventFunctionKind.OTHER_GAP)
"""Kinds of event functions of constraint rows rather than of output rows."""


def rows_of_event_functions(event_functions: RecordArray) -> list[int]:
    """Return the output rows from which event functions follow."""
    of_outputs = [function for function in event_functions if function["kind"] not in OF_CONSTRAINT_ROWS]
    rows = {int(function[name]) for function in of_outputs for name in ("source_index", "argument_index")}
    return sorted(rows - {NO_INDEX})


def find_gaps(scene: Scene, event_functions: RecordArray) -> BoolArray:
    """Return which event functions are those of gaps that are open."""
    gaps = {index for index, contact in enumerate(contacts_of(scene)) if contact.is_gap}
    kinds = event_functions["kind"].tolist()
    indices = event_functions["contact_index"].tolist()
    values = EventFunctionKind.VALUE, EventFunctionKind.OTHER_GAP
    return np.array([kind in values and index in gaps for kind, index in zip(kinds, indices, strict=True)], dtype=np.bool_)


def are_gaps(scene: Scene, event_functions: RecordArray) -> bool:
    """Return whether all event functions, and there are some, are those of gaps that are open."""
    are_open = find_gaps(scene, event_functions) & (event_functions["kind"] == EventFunctionKind.VALUE)
    return len(event_functions) > 0 and bool(are_open.all())


def _event_tolerances(scene: Scene) -> EventTolerances:
    """Return the rounding levels of the event functions of a scene."""
    mechanism, time = scene.mechanism, time_scale(scene)
    mass = sum(body.mass for body in mechanism.bodies)
    return EventTolerances(
        outputs={name: EVENT_ROUNDING_RATIO * mechanism.output_scale(name) for name in forced_output_names(scene)},
        force=EVENT_ROUNDING_RATIO * mass * mechanism.length_scale / time**2,
        time=time,
    )


def _contact_event_functions(
    scene: Scene, mode: ContactMode, friction_inputs: Sequence[int], held_rows: IntArray, tolerances: EventTolerances
) -> Iterator[EventFunctionRecord]:
    """Yield the event functions of friction and stops: the force that holds an output, else its rate and its stops."""
    output_names, rows = forced_output_names(scene), iter(held_rows.tolist())
    normal_rows = rows_of_held_contacts(mode, held_rows.tolist())
    names = [contact.output_name for contact in contacts_of(scene)]
    states = zip(contacts_of(scene), mode.held_values, mode.sliding_signs, friction_inputs, strict=True)
    for contact_index, (contact, held, sign, friction_index) in enumerate(states):
        output_index = output_names.index(contact.output_name)
        tolerance = tolerances.outputs[contact.output_name]
        if held is not None and contact.normal is not None:
            row, normal_row = next(rows), normal_rows[names.index(contact.normal)]
            for direction in (1.0, -1.0):
                limit = contact.friction_coefficient
                yield EventFunctionKind.FORCE, row, normal_row, direction, limit, tolerances.force, NO_INDEX, contact_index
            continue
        if held is not None:
            row = next(rows)
            pull = RELEASE_FORCE_RATIO * tolerances.force if contact.is_gap else 0.0
            # A stop pushes with unlimited force in one direction; friction holds in both, up to its limit.
            for direction, is_unlimited in ((1.0, held <= contact.low), (-1.0, held >= contact.high)):
                if not is_unlimited:
                    yield EventFunctionKind.FORCE, row, NO_INDEX, direction, pull, tolerances.force, friction_index, contact_index
            continue
        if mode.is_locked:
            continue
        if sign:
            yield EventFunctionKind.RATE, output_index, NO_INDEX, -float(sign), 0.0, tolerance / tolerances.time, NO_INDEX, contact_index
        for direction, bound in ((1.0, contact.high), (-1.0, -contact.low)):
            if np.isfinite(bound):
                yield EventFunctionKind.VALUE, output_index, NO_INDEX, direction, bound, tolerance, NO_INDEX, contact_index


def _join_event_functions(
    scene: Scene, mode: ContactMode, held_rows: IntArray, tolerances: EventTolerances
) -> Iterator[EventFunctionRecord]:
    """Yield the event functions at joins of edges of outlines that are touched."""
    gaps = {gap.name for gap in outline_gaps_of(scene) if isinstance(gap.outline, CornerOutline)}
    rows = rows_of_held_contacts(mode, held_rows.tolist())
    for contact_index, contact in enumerate(contacts_of(scene)):
        if mode.held_values[contact_index] is not None and contact.output_name in gaps:
            tolerance = tolerances.outputs[contact.output_name]
            yield EventFunctionKind.JOIN, rows[contact_index], NO_INDEX, 1.0, 0.0, tolerance, NO_INDEX, contact_index


def _other_gap_event_functions(
    scene: Scene, mode: ContactMode, held_rows: IntArray, tolerances: EventTolerances
) -> Iterator[EventFunctionRecord]:
    """Yield the event functions at which another one of several rollers touches an outline while one of them does."""
    gaps = {gap.name for gap in outline_gaps_of(scene) if gap.others}
    rows = rows_of_held_contacts(mode, held_rows.tolist())
    for contact_index, contact in enumerate(contacts_of(scene)):
        if mode.held_values[contact_index] is not None and contact.output_name in gaps:
            tolerance = tolerances.outputs[contact.output_name]
            yield EventFunctionKind.OTHER_GAP, rows[contact_index], NO_INDEX, -1.0, 0.0, tolerance, NO_INDEX, contact_index


def _slack_event_functions(scene: Scene, mode: ContactMode, tolerances: EventTolerances) -> Iterator[EventFunctionRecord]:
    """Yield the event functions of one-sided springs: the value at which each goes slack or pulls again."""
    output_names = forced_output_names(scene)
    one_sided = () if mode.is_locked else one_sided_forces_of(scene)
    for contact_index, (effect, taut) in enumerate(zip(one_sided, mode.taut, strict=False), start=len(mode.held_values)):
        direction, name = (-1.0 if taut else 1.0), effect.reading
        threshold, tolerance = direction * effect.slack_below, tolerances.outputs[name]
        yield EventFunctionKind.VALUE, output_names.index(name), NO_INDEX, direction, threshold, tolerance, NO_INDEX, contact_index


def _table_event_functions(scene: Scene, mode: ContactMode, first_index: int, tolerances: EventTolerances) -> Iterator[EventFunctionRecord]:
    """Yield the event functions at the ends of the segment of each table of a reading; `first_index` is the contact index of the first."""
    output_names = forced_output_names(scene)
    for contact_index, (table, segment) in enumerate(zip(reading_tables_of(scene), mode.segments, strict=True), start=first_index):
        output = output_names.index(table.source)
        tolerance = tolerances.outputs[table.source]
        kind = EventFunctionKind.RATE if table.is_rate else EventFunctionKind.VALUE
        tolerance = tolerance / tolerances.time if table.is_rate else tolerance
        if segment > 0:
            yield kind, output, NO_INDEX, -1.0, -table.positions[segment - 1], tolerance, NO_INDEX, contact_index
        if segment < len(table.positions):
            yield kind, output, NO_INDEX, 1.0, table.positions[segment], tolerance, NO_INDEX, contact_index


def make_gas_event_functions(force_elements: RecordArray, contact_index: int) -> list[EventFunctionRecord]:
    """Return the event functions of the kinks of gas: the switch of each gas, then both dead centres of each crank, those shared once."""
    gases = [force for force in force_elements if force["law"] == FORCE_LAWS.index(GasPressure)]
    return list(dict.fromkeys(_gas_event_functions(gases, contact_index)))


def _gas_event_functions(gases: Sequence[Any], contact_index: int) -> Iterator[EventFunctionRecord]:
    """Yield the event functions of gases; the same one for each gas that has it."""
    for gas in gases:
        switch = float(gas["coefficients"][SWITCH_COEFFICIENT])
        stroke = float(gas["coefficients"][7])
        rows = (int(gas["output_index"]), int(gas["argument_index"]))
        switch_input = int(gas["switch_input"])
        if switch_input != NO_INDEX:
            yield EventFunctionKind.SWITCH, *rows, 1.0 / stroke, 0.0, EVENT_ROUNDING_RATIO, switch_input, contact_index
        elif 0.0 < switch < 1.0:
            yield EventFunctionKind.SWITCH, *rows, 1.0 / stroke, switch, EVENT_ROUNDING_RATIO, NO_INDEX, contact_index
    for angle in sorted({int(gas["argument_index"]) for gas in gases}):
        for sign in (1.0, -1.0):
            yield EventFunctionKind.DEAD_CENTRE, angle, NO_INDEX, sign, 0.0, EVENT_ROUNDING_RATIO, NO_INDEX, contact_index


@jit_in_place
def evaluate_event_function(
    event_functions: RecordArray,  # records of `EVENT_FUNCTION_DTYPE`; shape (event functions,)
    i: int,
    # its quantity, SI: value or rate of an output, or force of a constraint row; for a switch the travel, m
    value: float,
    argument: float,  # for a switch the crank angle, rad
    limit: float,
) -> float:
    """Return the value of an event function, positive after its event."""
    event_function = event_functions[i]
    if event_function.kind == EventFunctionKind.SWITCH:
        return float(evaluate_travel_in_stroke(event_function.sign, value, argument) - event_function.threshold - limit)
    if event_function.kind == EventFunctionKind.DEAD_CENTRE:
        value = math.sin(value)
    return float(event_function.sign * value - event_function.threshold - limit)


@jit_in_place
def evaluate_event_functions(
    system: System,
    # work arrays, with the inputs and Lagrange multipliers that `evaluate_accelerations` leaves in them
    workspace: SystemWorkspace,
    # poses and velocities of the body origins, the energy states and the lags; shape (6 * bodies +
    # N_ENERGY_STATES + lags,)
    state: FloatArray,
    # result: values of the event functions, -1 for one that is not armed; shape (event functions,)
    event_values: FloatArray,
    first: int = 0,  # index of the first of the functions that are evaluated
) -> None:
    """Evaluate the event functions at the state whose derivative was evaluated last."""
    layout = system.state_layout
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    evaluate_rows_for(FOR_EVENTS, system.output_rows, poses, velocities, row_values, jacobian)
    for i in range(first, system.event_functions.size):
        event_function = system.event_functions[i]
        if not workspace.is_armed[i]:
            event_values[i] = -1.0
            continue
        limit = workspace.inputs[event_function.input_index] if event_function.input_index != NO_INDEX else 0.0
        is_force, argument = event_function.kind == EventFunctionKind.FORCE, 0.0
        if event_function.argument_index != NO_INDEX and not is_force:
            argument = row_values[event_function.argument_index, RowColumn.RESIDUAL]
        if event_function.kind == EventFunctionKind.RATE:
            value = output_rate(system.output_rows, jacobian, event_function.source_index, velocities)
        elif is_force:
            value = -workspace.multipliers[event_function.source_index]
            if event_function.argument_index != NO_INDEX:
                friction_limit = -event_function.threshold * workspace.multipliers[event_function.argument_index]
                event_values[i] = event_function.sign * value - friction_limit
                continue
        elif event_function.kind == EventFunctionKind.JOIN:
            value = evaluate_join(system.constraint_rows, event_function.source_index, poses, velocities)
        elif event_function.kind == EventFunctionKind.OTHER_GAP:
            value = evaluate_other_gap(system.constraint_rows, event_function.source_index, poses, velocities)
        else:
            value = row_values[event_function.source_index, RowColumn.RESIDUAL]
        event_values[i] = evaluate_event_function(system.event_functions, i, value, argument, limit)

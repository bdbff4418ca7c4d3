"""Loads of a scene and its other inputs: where they stand in the one vector that all kernels read, and those that depend on readings."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np

from governor_mechanism.effects.gas_pressure import travel_in_stroke
from governor_mechanism.mechanics.dynamics.contacts import Contact, contacts_of
from governor_mechanism.mechanics.kinematics.constraint_rows import ConstraintRows, RowColumn
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output, rows_of_readings
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, evaluate_input
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import (
    AngleHarmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    ReadingFunction,
    StrokeHold,
    TableFunction,
)
from governor_mechanism.numerics.jit import jit_in_place, record_dtype
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, RecordArray


@dataclass(frozen=True)
class InputLayout:
    """Slices of the inputs, in their order.

    `further` are the factors of loads and what lags follow: as functions of time they are zero. `friction_inputs` has the
    friction limit of each contact, or NO_INDEX.
    """

    spindle_speeds: slice
    drives: slice
    element_loads: slice
    friction_limits: slice
    further: slice
    friction_inputs: tuple[int, ...]

    @property
    def loads(self) -> slice:
        """Inputs of `loads_of`: the loads of force elements, then the friction limits."""
        return slice(self.element_loads.start, self.friction_limits.stop)

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return int(self.further.stop)


def make_input_layout(loads: Sequence[InputFunction], contacts: Sequence[Contact], n_spindle_speeds: int, n_drives: int) -> InputLayout:
    """Return the layout of given spindle speeds, drives and the loads of a scene, of which the last ones are friction limits."""
    has_friction = [contact.friction is not None for contact in contacts]
    n_frictions = sum(has_friction)
    spindle_speeds = slice(0, n_spindle_speeds)
    drives = _slice_behind(spindle_speeds, n_drives)
    element_loads = _slice_behind(drives, len(loads) - n_frictions)
    friction_limits = _slice_behind(element_loads, n_frictions)
    limits = iter(range(friction_limits.start, friction_limits.stop))
    return InputLayout(
        spindle_speeds=spindle_speeds,
        drives=drives,
        element_loads=element_loads,
        friction_limits=friction_limits,
        further=_slice_behind(friction_limits, sum(map(_count_further, loads))),
        friction_inputs=tuple(next(limits) if has_one else NO_INDEX for has_one in has_friction),
    )


def _slice_behind(before: slice, count: int) -> slice:
    return slice(before.stop, before.stop + count)


def _count_further(load: InputFunction) -> int:
    """Return how many inputs the functions of a load need: each factor has one, and each lag one that it follows."""
    n_lags = sum(bool(function.lag) for function in (*load.functions, *load.factors))
    return len(load.factors) + n_lags


class InputTermKind(IntEnum):
    """Kind of a term of an input, with s the value of an output and r its rate.

    VALUE: a * (s - b) + c. RATE: a * (r - b) + c. HARMONIC: a * cos(c * s) + b * sin(c * s). LAG: the state of a lag. PRODUCT: the input
    is multiplied by another one. NOT_NEGATIVE: the input is 0 where it would be negative. HOLD: the input is the state of its hold, unless
    that is NOT_HELD.
    """

    VALUE = 0
    RATE = 1
    HARMONIC = 2
    LAG = 3
    PRODUCT = 4
    NOT_NEGATIVE = 5
    HOLD = 6


EVENT_ROUNDING_RATIO = 1e-12
"""Rounding level of event functions, relative to a length, rate or force scale."""

NOT_HELD = 2.0
"""State of a hold while it lets its input move; that of an input which is held lies between 0 and 1."""

HOLD_KINDS = (None, StrokeHold.FROM_DEAD_CENTRE, StrokeHold.FROM_CUT_OFF)
"""Kinds of the holds by their number in records; None is a lag."""


INPUT_TERM_DTYPE = record_dtype(
    ("kind", "i8"),  # an InputTermKind
    ("input_index", "i8"),  # the input
    ("source_index", "i8"),  # the output row, lag or input that the term comes from
    ("a", "f8"),  # coefficients
    ("b", "f8"),
    ("c", "f8"),
)
"""One term of an input."""

LAG_DTYPE = record_dtype(
    ("input_index", "i8"),  # the input that is followed
    ("hold", "i8"),  # index of the kind in HOLD_KINDS
    ("time_constant", "f8"),  # of a lag, s; infinite for a hold, whose state only events change
)
"""One first-order lag or hold."""

TABLE_SEGMENT_DTYPE = record_dtype(
    ("term_index", "i8"),  # the term that is set
    ("source_index", "i8"),  # the output row
    ("is_rate", "i8"),  # whether its rate is meant
    ("low", "f8"),  # values between which the segment holds
    ("high", "f8"),
    ("tolerance", "f8"),  # their rounding
    ("a", "f8"),  # coefficients of the term
    ("b", "f8"),
    ("c", "f8"),
)
"""One segment of a table of a reading."""


def make_input_terms(
    output_names: Sequence[str],
    segments: Sequence[int],  # segment of each table of a reading, in the order in which the tables are met
    layout: InputLayout,
    loads: Sequence[InputFunction],
) -> tuple[RecordArray, RecordArray]:
    """Return the terms of loads that depend on readings (`INPUT_TERM_DTYPE`), as they are evaluated, and their lags (`LAG_DTYPE`)."""
    terms, products, last_terms = (list[tuple[int, int, int, float, float, float]]() for _ in range(3))
    lags, table_segments = list[tuple[int, int, float]](), iter(segments)
    further_inputs = iter(range(layout.further.start, layout.further.stop))
    for index, load in enumerate(loads, start=layout.loads.start):
        for position, function in enumerate((*load.functions, *load.factors)):
            is_factor = position >= len(load.functions)
            factor = target = next(further_inputs) if is_factor or function.lag else index
            segment = next(table_segments) if isinstance(function, TableFunction) else 0
            terms += _function_terms(function, target, output_names, segment)
            if function.lag:
                factor = next(further_inputs) if is_factor else index
                terms.append((InputTermKind.LAG, factor, len(lags), 0.0, 0.0, 0.0))
                lags.append((target, 0, function.lag))
            if is_factor:
                products.append((InputTermKind.PRODUCT, index, factor, 0.0, 0.0, 0.0))
        if index >= layout.friction_limits.start and load.depends_on_readings:
            last_terms.append((InputTermKind.NOT_NEGATIVE, index, NO_INDEX, 0.0, 0.0, 0.0))
        if load.hold:
            last_terms.append((InputTermKind.HOLD, index, len(lags), 0.0, 0.0, 0.0))
            lags.append((index, HOLD_KINDS.index(load.hold), math.inf))
    records = np.array(terms + products + last_terms, dtype=INPUT_TERM_DTYPE)
    return records, np.array(lags, dtype=LAG_DTYPE)


def make_table_segments(
    output_names: Sequence[str],
    scales: Sequence[float],  # their scales, m or rad
    time: float,  # characteristic time, s
    loads: Sequence[InputFunction],
) -> RecordArray:
    """Return the segments of all tables of readings (`TABLE_SEGMENT_DTYPE`), by position within a table; its lowest begins at -inf."""
    records, term_index = [], 0
    for function in (one for load in loads for one in (*load.functions, *load.factors)):
        if isinstance(function, TableFunction):
            source = output_names.index(function.source)
            ends = (-math.inf, *function.positions, math.inf)
            tolerance = EVENT_ROUNDING_RATIO * scales[source] / (time if function.is_rate else 1.0)
            for segment, interval in enumerate(pairwise(ends)):
                records.append((term_index, source, function.is_rate, *interval, tolerance, *_table_segment(function, segment)))
        term_index += len(list(_function_terms(function, 0, output_names, 0)))
    return np.array(records, dtype=TABLE_SEGMENT_DTYPE)


def _function_terms(
    function: ReadingFunction, target: int, output_names: Sequence[str], segment: int
) -> Iterator[tuple[int, int, int, float, float, float]]:
    """Yield the terms of a function of a reading, on a segment if it is a table."""
    source = output_names.index(function.source)
    kind = InputTermKind.RATE if function.is_rate else InputTermKind.VALUE
    match function:
        case LinearFunction():
            yield kind, target, source, function.gain, function.about, 0.0
        case TableFunction():
            yield kind, target, source, *_table_segment(function, segment)
        case HarmonicFunction():
            for one in function.harmonics:
                yield InputTermKind.HARMONIC, target, source, *_cosine_and_sine(one), one.order


def _cosine_and_sine(harmonic: AngleHarmonic) -> tuple[float, float]:
    """Return the coefficients of the cosine and the sine of order times angle."""
    return harmonic.amplitude * math.sin(harmonic.phase), harmonic.amplitude * math.cos(harmonic.phase)


def _table_segment(table: TableFunction, segment: int) -> tuple[float, float, float]:
    """Return slope, position and value of a segment of a table; the first and the last segment are constant."""
    positions, values = table.positions, table.values
    if not 0 < segment < len(positions):
        end = min(segment, len(positions) - 1)
        return 0.0, positions[end], values[end]
    low, value = positions[segment - 1], values[segment - 1]
    return (values[segment] - value) / (positions[segment] - low), low, value


def evaluate_reading_function(
    function: ReadingFunction,
    value: float,  # value of the reading, SI
) -> float:
    """Return a function of a reading at a value of it, SI; raise TypeError if its type is unknown."""
    return float(evaluate_reading_function_along(function, np.array([value]))[0])


def evaluate_reading_function_along(
    function: ReadingFunction,
    values: FloatArray,  # values of the reading, SI; shape (n,)
) -> FloatArray:
    """Return a function of a reading at many values (n,) of it, SI; raise TypeError if its type is unknown."""
    match function:
        case LinearFunction():
            return function.gain * (values - function.about)
        case TableFunction():
            return np.interp(values, function.positions, function.values)
        case HarmonicFunction():
            orders, cosines, sines = np.array([(one.order, *_cosine_and_sine(one)) for one in function.harmonics]).T
            angles = np.multiply.outer(values, orders)
            harmonics: FloatArray = np.cos(angles) @ cosines + np.sin(angles) @ sines
            return harmonics
    raise TypeError(f"no function of a reading is defined for {type(function).__name__}")


@jit_in_place
def evaluate_inputs(
    terms: RecordArray,
    output_rows: ConstraintRows,
    row_values: FloatArray,
    jacobian: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    lag_states: FloatArray,
    result: FloatArray,
) -> None:
    """Fill result (inputs,) with the inputs at a state whose output rows were evaluated."""
    for k in range(result.size):
        result[k] = evaluate_input(input_cubics, k, local_time)
    for i in range(terms.size):
        term, source = terms[i], 0.0
        if term.kind == InputTermKind.LAG or term.kind == InputTermKind.HOLD:
            source = lag_states[term.source_index]
        elif term.kind == InputTermKind.RATE:
            source = output_rate(output_rows, jacobian, term.source_index, velocities)
        elif term.kind != InputTermKind.PRODUCT and term.kind != InputTermKind.NOT_NEGATIVE:
            source = row_values[term.source_index, RowColumn.RESIDUAL]
        add_input_term(terms, i, source, result)


@jit_in_place
def add_input_term(terms: RecordArray, i: int, source: float, result: FloatArray) -> None:
    """Add term i to its input in result (inputs,); `source` is the value, rate or lag that it depends on."""
    term = terms[i]
    if term.kind == InputTermKind.PRODUCT:
        result[term.input_index] *= result[term.source_index]
    elif term.kind == InputTermKind.NOT_NEGATIVE:
        result[term.input_index] = max(result[term.input_index], 0.0)
    elif term.kind == InputTermKind.LAG:
        result[term.input_index] += source
    elif term.kind == InputTermKind.HOLD:
        result[term.input_index] = source if source < NOT_HELD else result[term.input_index]
    elif term.kind == InputTermKind.HARMONIC:
        result[term.input_index] += term.a * math.cos(term.c * source) + term.b * math.sin(term.c * source)
    else:
        result[term.input_index] += term.a * (source - term.b) + term.c


@jit_in_place
def output_rate(output_rows: ConstraintRows, jacobian: FloatArray, k: int, velocities: FloatArray) -> float:
    """Return the rate of an output (m/s or rad/s) from its row of the evaluated output Jacobian."""
    rate = 0.0
    for side in range(2):
        body = output_rows.row_bodies[k, side]
        if body != GROUND_INDEX:
            for c in range(3):
                rate += jacobian[k, side, c] * velocities[body, c]
    return rate


@once_per_object
def loads_of(scene: Scene) -> tuple[InputFunction, ...]:
    """Return the loads in the order of the inputs of a system: those of force elements with their factors, then the friction forces."""
    element_loads = [load for element in scene.mechanism.force_elements for load in element.inputs]
    return (*element_loads, *(contact.friction for contact in contacts_of(scene) if contact.friction is not None))


@once_per_object
def reading_functions_of(scene: Scene) -> tuple[ReadingFunction, ...]:
    """Return the functions of readings in the loads of a scene, in the order of the loads."""
    return tuple(function for load in loads_of(scene) for function in (*load.functions, *load.factors))


@once_per_object
def lagged_functions_of(scene: Scene) -> tuple[ReadingFunction | InputFunction, ...]:
    """Return the functions of readings with a lag and the loads that are held, in the order of their states."""
    found = list[ReadingFunction | InputFunction]()
    for load in loads_of(scene):
        found += [function for function in (*load.functions, *load.factors) if function.lag]
        found += [load] if load.hold else []
    return tuple(found)


def reading_tables_of(scene: Scene) -> tuple[TableFunction, ...]:
    """Return the tables of readings in the loads of a scene, in the order of the loads; their kinks are events."""
    return tuple(function for function in reading_functions_of(scene) if isinstance(function, TableFunction))


def has_kinks(scene: Scene) -> bool:
    """Return whether forces have kinks at which steps end though no mode changes: those of gas in cylinders."""
    return any(isinstance(element, CylinderGas) for element in scene.mechanism.force_elements)


def initial_lags(
    scene: Scene,
    poses: FloatArray,  # poses of the mass centres at the start, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
) -> FloatArray:
    """Return the states (lags,) of lags and holds at the start: those of the state from which the scene goes on, if there is one."""
    # Else each begins at the value that it follows, unless its cut-off is still ahead.

    def evaluate(function: ReadingFunction) -> float:
        output = evaluate_output(scene.mechanism, function.source, poses)
        value = np.sum(output.gradient * velocities) if function.is_rate else output.value
        return evaluate_reading_function(function, float(value))

    def evaluate_held(load: InputFunction) -> float:
        total = float(CubicTimeFunction(load)(np.zeros(1))[0]) + sum(evaluate(function) for function in load.functions)
        value = total * math.prod(evaluate(function) for function in load.factors)
        is_ahead = load.hold is StrokeHold.FROM_CUT_OFF and _travel_in_stroke(scene, load, poses) < value
        return NOT_HELD if is_ahead else value

    lagged = lagged_functions_of(scene)
    if scene.state is not None and len(scene.state.lags) == len(lagged):
        return np.array(scene.state.lags)
    return np.array([evaluate(owner) if isinstance(owner, ReadingFunction) else evaluate_held(owner) for owner in lagged])


def _travel_in_stroke(scene: Scene, switch: InputFunction, poses: FloatArray) -> float:
    """Return the travel since the last dead centre, relative to the stroke, of the piston whose gas has a switch."""
    gases = (element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas))
    gas = next(one for one in gases if one.switch is switch)
    rows = (rows_of_readings(scene.mechanism, [reading], {}) for reading in (gas.travel, gas.crank_angle))
    travel, crank_angle = (float(OutputDerivatives(row, poses).value) for row in rows)
    return float(travel_in_stroke(1.0 / gas.stroke, travel, crank_angle))

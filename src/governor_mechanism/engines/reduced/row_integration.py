"""Integration of the rows of a batch, one after the other: start, motion table, steps and readings of each; compiled."""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.certificate import FIRST_TOLERANCE_RATIO
from governor_mechanism.engines.reduced.integration import ReducedEquation, integrate_without_contacts, make_reduced_buffers
from governor_mechanism.engines.reduced.row_arrays import RowArrays, RowScalar
from governor_mechanism.engines.reduced.table_end import TableEndLimits, approach_table_end, find_motion_end, time_at_rate
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.equation import StepBuffers
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.step_record import StepRecord
from governor_mechanism.mechanics.dynamics.forces.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, RowColumn, evaluate_rows
from governor_mechanism.mechanics.kinematics.coordinate_assembly import AssemblyArrays, continue_to_coordinate
from governor_mechanism.mechanics.reduction.motion_table import find_end_coordinate
from governor_mechanism.mechanics.reduction.node_evaluation import (
    Coefficient,
    LagrangianArrays,
    LagrangianWorkspace,
    ReductionArrays,
    make_lagrangian_workspace,
)
from governor_mechanism.mechanics.reduction.reduced_model import N_STATES, ReducedModel
from governor_mechanism.mechanics.reduction.table import (
    EndReason,
    ExtensionStatus,
    PiecewiseTable,
    allocate_table,
    begin_table,
    evaluate_node,
)
from governor_mechanism.mechanics.reduction.table_refinement import extend_table, start_table
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.chebyshev import N_CHEBYSHEV_NODES
from governor_mechanism.numerics.jit import jit_in_place, jit_unlocked
from governor_mechanism.types import FloatArray, IntArray

approach_table_end_jit = jit_in_place(approach_table_end)
time_at_rate_jit, find_motion_end_jit = jit_in_place(time_at_rate), jit_in_place(find_motion_end)
begin_table_jit, find_end_coordinate_jit = jit_in_place(begin_table), jit_in_place(find_end_coordinate)


class RowEnd(IntEnum):
    """Indices of how a row ended."""

    STATUS = 0
    """`IntegrationStatus`, or NOT_STARTED."""
    TIME = 1
    """Time of the end, s."""
    REACHED_COUNT = 2
    """Number of reported times that were reached, with the start."""
    SIDE = 3
    """Side on which the motion left its table last."""
    END_REASON = 4
    """`EndReason` of the table on that side."""
    END_COORDINATE = 5
    """Coordinate at which the table ends there."""
    IS_AT_BOUND = 6
    """Whether that is the bound of the coordinate."""


START_MARGIN = 0.02
"""Distance from the start at which a table begins behind it, in widths of its first piece: more than the error of a motion that returns."""

NOT_STARTED = -1
"""Status of a row that cannot be assembled at its start."""

_TABLE_TOO_SMALL = -2
"""Status of a row whose table needs more pieces than it has room for."""


class RowRequest(NamedTuple):
    """What is the same for all rows.

    Attributes
    ----------
    times
        Reported times, the first of which is the start, s; shape (times,).
    tolerance
        Error of one step.
    max_steps
        Largest number of steps of a row.
    max_step_ratio
        Largest step relative to `RowScalar.MAX_STEP_SCALE`.
    first_step_ratio
        First step relative to the largest one.
    table_end_limits
        What ends an integration at the end of a table.
    no_steps
        Empty record of steps.
    """

    times: FloatArray
    tolerance: float
    max_steps: int
    max_step_ratio: float
    first_step_ratio: float
    table_end_limits: TableEndLimits
    no_steps: StepRecord


class RowBuffers(NamedTuple):
    """Buffers of one thread."""

    workspace: LagrangianWorkspace
    table: PiecewiseTable
    steps: StepBuffers
    state: FloatArray
    step_start: FloatArray
    states: FloatArray
    input_cubics: FloatArray
    mode: IntArray
    piece: IntArray
    poses: FloatArray
    node: FloatArray
    weights: FloatArray
    row_values: FloatArray
    jacobian: FloatArray


def make_row_buffers(arrays: RowArrays, n_times: int, capacity: int) -> RowBuffers:
    """Allocate the buffers of rows.

    Parameters
    ----------
    arrays
        Arrays of a row.
    n_times
        Number of reported times.
    capacity
        Number of pieces of a table.

    Returns
    -------
    RowBuffers
        Buffers of matching sizes.
    """
    n_readings = len(arrays.reading_rows.table)
    return RowBuffers(
        workspace=make_lagrangian_workspace(arrays.reduction.lagrangian),
        table=allocate_table(arrays.reduction, capacity, 0.0, arrays.initial_guess),
        steps=make_reduced_buffers(arrays.forces, np.zeros(len(StepCounter), dtype=np.int64)),
        state=np.zeros(N_STATES),
        step_start=np.zeros(N_STATES + 1),
        states=np.empty((n_times, N_STATES)),
        input_cubics=np.zeros((1, 5)),
        mode=np.zeros(1, dtype=np.int64),
        piece=np.zeros(1, dtype=np.int64),
        poses=np.zeros_like(arrays.initial_guess),
        node=np.zeros((2, arrays.initial_guess.size)),
        weights=np.zeros(N_CHEBYSHEV_NODES),
        row_values=np.zeros((n_readings, N_ROW_COLUMNS)),
        jacobian=np.zeros((n_readings, 2, 3)),
    )


@jit_unlocked
def integrate_rows(
    arrays: RowArrays,
    template: FloatArray,
    places: IntArray,
    numbers: FloatArray,
    first_row: int,
    request: RowRequest,
    buffers: RowBuffers,
    readings: FloatArray,
    ends: FloatArray,
) -> int:
    """Integrate rows from one of them on.

    Parameters
    ----------
    arrays
        Arrays of one row, whose numbers are in the template.
    template
        Buffer of the arrays.
    places
        Where the numbers of a row belong in it; shape (places,).
    numbers
        These numbers; shape (rows, places).
    first_row
        The first row to integrate.
    request
        Times, tolerances and limits.
    buffers
        Buffers.
    readings
        Result: value and rate of the coordinate, then of each reading, at the reported times; shape (rows, 1 + readings, 2, times).
    ends
        Result: how each row ended, indexed by `RowEnd`; shape (rows, RowEnd).

    Returns
    -------
    int
        Number of rows that are done; less than all if a table needs more pieces than it has room for.
    """
    for row in range(first_row, numbers.shape[0]):
        for k in range(places.size):
            template[places[k]] = numbers[row, k]
        if not _integrate_row(arrays, request, buffers, readings[row], ends[row]):
            return row
    return len(numbers)


@jit_in_place
def _integrate_row(arrays: RowArrays, request: RowRequest, buffers: RowBuffers, readings: FloatArray, end: FloatArray) -> bool:
    """Integrate the row whose numbers are in the arrays; return whether its table had room for all pieces."""
    scalars, table, state, q = arrays.scalars, buffers.table, buffers.state, arrays.scalars[RowScalar.START]
    template, lagrangian, assembly = arrays.reduction, arrays.reduction.lagrangian, arrays.reduction.lagrangian.assembly
    assembly = AssemblyArrays(
        assembly.rows,
        assembly.coordinate_wraps,
        assembly.free_indices,
        assembly.pose_scales,
        assembly.row_scales,
        scalars[RowScalar.COORDINATE_SCALE],
    )
    lagrangian = LagrangianArrays(
        assembly,
        lagrangian.mass,
        lagrangian.bodies,
        lagrangian.has_centrifugal_forces,
        lagrangian.output_rows,
        lagrangian.forces,
        lagrangian.n_loads,
    )
    reduction = ReductionArrays(
        lagrangian,
        template.output_scales,
        template.limits,
        scalars[RowScalar.STEADY_SPEED],
        scalars[RowScalar.TIME_SCALE],
        scalars[RowScalar.LOW],
        scalars[RowScalar.HIGH],
        template.full_turn,
        template.is_conservative,
        template.fit_tolerance,
    )
    end[:] = 0.0
    end[RowEnd.STATUS] = NOT_STARTED
    if not reduction.low < q < reduction.high:
        return True
    copy_array(buffers.poses, arrays.initial_guess)
    if not continue_to_coordinate(assembly, buffers.workspace.assembly, q, buffers.poses):
        return True
    begin_table_jit(reduction, table, q, buffers.poses)
    if not start_table(reduction, buffers.workspace, table):
        return True
    first_side = 1 if _find_start_direction(reduction, buffers.workspace.coefficients, scalars[RowScalar.START_RATE]) > 0.0 else 0
    _begin_behind_start(reduction, buffers, q, first_side)
    state[:] = 0.0
    state[0], state[1] = q, scalars[RowScalar.START_RATE]
    copy_array(buffers.states[0], state)
    status, time, n_reached, side = _integrate_along_table(arrays, reduction, request, buffers, first_side)
    if table.n_pieces[0] == 0:
        return True
    if status == _TABLE_TOO_SMALL:
        return False
    edge, bound = table.intervals[table.end_pieces[side], side], reduction.high if side == 1 else reduction.low
    end_coordinate, reason = find_end_coordinate_jit(edge, bound, assembly.coordinate_scale), table.end_reasons[side]
    if status == IntegrationStatus.TABLE_ENDED:
        acceleration = buffers.steps.stages.derivatives[1, 0]
        stops_short, time_left = find_motion_end_jit(edge, end_coordinate, state[0], state[1], acceleration)
        if stops_short:
            end_coordinate, reason = edge, EndReason.AT_SINGULARITY
        time += time_left
    end[RowEnd.STATUS], end[RowEnd.TIME], end[RowEnd.REACHED_COUNT] = status, time, 1 + n_reached
    end[RowEnd.SIDE], end[RowEnd.END_REASON] = side, reason
    end[RowEnd.END_COORDINATE], end[RowEnd.IS_AT_BOUND] = end_coordinate, end_coordinate == bound
    _evaluate_readings(arrays, buffers, buffers.states[: 1 + n_reached], readings)
    return True


@jit_in_place
def _find_start_direction(reduction: ReductionArrays, coefficients: FloatArray, rate: float) -> float:
    """Return a number with the sign of the motion at the start, at a constant spindle speed: its rate, or from rest the force."""
    centrifugal = 0.5 * coefficients[Coefficient.SPINDLE_INERTIA_DERIVATIVE] * reduction.steady_speed**2
    return rate if rate != 0.0 else float(centrifugal - coefficients[Coefficient.POTENTIAL_DERIVATIVE])


@jit_in_place
def _begin_behind_start(reduction: ReductionArrays, buffers: RowBuffers, q: float, side: int) -> None:
    """Begin the table, which was started at a coordinate, a little behind that if it leads to a side, unless it ends there.

    A motion that comes back to its start then needs no further piece.
    """
    table, margin = buffers.table, START_MARGIN * buffers.table.next_widths[side]
    margin = min(margin, 0.5 * (q - reduction.low if side == 1 else reduction.high - q))
    begin_table_jit(reduction, table, q - margin if side == 1 else q + margin, buffers.poses)
    if not start_table(reduction, buffers.workspace, table):
        begin_table_jit(reduction, table, q, buffers.poses)


@jit_in_place
def _integrate_along_table(
    arrays: RowArrays, reduction: ReductionArrays, request: RowRequest, buffers: RowBuffers, first_side: int
) -> tuple[int, float, int, int]:
    """Integrate from the state of the buffers along their table, and extend that where the motion leaves it, as `integrate_passage` does.

    Return the status, the time of the state (s), the number of reported times reached after the start, and the side left last.
    """
    parameters, table, state, counts, forces = (
        arrays.forces.parameters,
        buffers.table,
        buffers.state,
        buffers.steps.stages.counts,
        arrays.forces,
    )
    scale, time_scale, time, end = reduction.lagrangian.assembly.coordinate_scale, reduction.time_scale, 0.0, request.times[-1]
    buffers.steps.error_scale[0], buffers.steps.error_scale[1] = scale, scale / time_scale
    counts[:] = 0
    model = ReducedModel(
        table.coefficients,
        table.intervals,
        table.neighbours,
        table.periodicity,
        parameters,
        forces.one_sided_springs,
        forces.output_forces,
        forces.contacts,
        forces.shaft_torques,
        forces.shaft_forces,
        forces.shaft_outputs,
        forces.kinks,
        forces.table_segments,
        forces.input_terms,
        forces.inputs,
        buffers.input_cubics,
        buffers.mode,
    )
    accuracy = request.tolerance / FIRST_TOLERANCE_RATIO * scale
    equation = ReducedEquation(model, buffers.piece, counts, accuracy, buffers.step_start)
    max_step = request.max_step_ratio * arrays.scalars[RowScalar.MAX_STEP_SCALE]
    step, last_time, n_filled, side = request.first_step_ratio * max_step, -math.inf, 1, first_side
    while time < end:
        # In one place, also for the first piece: the machine code of this function contains that of the table.
        extension = extend_table(reduction, buffers.workspace, table, side)
        if extension == ExtensionStatus.TABLE_FULL:
            return _TABLE_TOO_SMALL, time, n_filled - 1, side
        if extension == ExtensionStatus.TABLE_ENDED:
            travel_left = table.intervals[table.end_pieces[side], side] - state[0]
            time_left, distance_scale = time_at_rate_jit(travel_left, state[1]), max(scale, abs(state[0]))
            step, is_end = approach_table_end_jit(
                travel_left, time_left, step, time > last_time, distance_scale, max(time_scale, end - time), request.table_end_limits
            )
            last_time = time
            if is_end or table.n_pieces[0] == 0:
                return IntegrationStatus.TABLE_ENDED, time, n_filled - 1, side
        buffers.piece[0] = 0
        limits = StepLimits(request.tolerance, step, max_step, request.max_steps, math.inf, request.no_steps, request.no_steps)
        status, step, n_reached, time = integrate_without_contacts(
            equation, buffers.steps, (time, end), request.times[n_filled:], state, limits, buffers.states[n_filled:]
        )
        n_filled += n_reached
        if status != IntegrationStatus.BELOW_TABLE and status != IntegrationStatus.ABOVE_TABLE:
            return status, time, n_filled - 1, side
        side = status - IntegrationStatus.BELOW_TABLE
    return IntegrationStatus.DONE, time, n_filled - 1, side


@jit_in_place
def _evaluate_readings(arrays: RowArrays, buffers: RowBuffers, states: FloatArray, readings: FloatArray) -> None:
    """Fill values and rates of the coordinate and of the readings in states (n, N_STATES)."""
    rows, piece = arrays.reading_rows, 0
    poses, tangents = buffers.node[0].reshape((-1, 3)), buffers.node[1].reshape((-1, 3))
    for k in range(states.shape[0]):
        readings[0, 0, k], readings[0, 1, k] = states[k, 0], states[k, 1]
        if rows.table.size > 0:
            piece = evaluate_node(buffers.table, states[k, 0], piece, buffers.weights, buffers.node)
            evaluate_rows(rows, poses, tangents, buffers.row_values, buffers.jacobian)
        for i in range(rows.table.size):
            readings[1 + i, 0, k] = buffers.row_values[i, RowColumn.RESIDUAL]
            readings[1 + i, 1, k] = output_rate(rows, buffers.jacobian, i, tangents) * states[k, 1]

"""Adaptive construction of the motion table, piece by piece, as far as a motion needs it; compiled.

Each piece is a Chebyshev fit (see `chebyshev`) with a truncation error of at most `FIT_TOLERANCE`; a piece that exceeds it is computed
again with half the width. The table of a closed motion becomes periodic.
"""

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.kinematics.coordinate_assembly import is_on_branch, solve_position
from governor_mechanism.mechanics.reduction.lagrangian import ReductionArrays, ReductionWorkspace, TableColumn, evaluate_columns
from governor_mechanism.mechanics.reduction.table import (
    BOUND_TOLERANCE,
    EndReason,
    ExtensionStatus,
    PeriodIndex,
    PieceColumn,
    PiecewiseTable,
    coordinate_at,
    local_coordinate,
)
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.interpolation import CHEBYSHEV_NODES, N_CHEBYSHEV_NODES, barycentric_weights, evaluate_piece, fit_piece
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray

FIT_TOLERANCE = 1e-13
"""Truncation tolerance of the pieces, relative to the scale of a column."""

MAX_PIECE_WIDTH = 1.0
"""Largest width of a piece, in coordinate scales."""

WIDTH_PER_DISTANCE = 0.25
"""Largest width of a piece relative to its distance from the start, where that is more: a body that flies away needs few pieces."""

MAX_DISTANCE = 1e6
"""Distance from the start, in coordinate scales, at which the table ends: no machine is so large."""

MIN_PIECE_WIDTH = 1e-9
"""Smallest width of a piece, in coordinate scales; where a narrower one is needed, the table ends."""

WIDEN_THRESHOLD = 1e-3
"""Fit residual relative to the tolerance below which the next piece is twice as wide."""

MAX_ROUNDING_ERROR = 1e-7
"""Largest error of a piece whose coefficients have stagnated at rounding level, as near a change point, relative to its column's scale."""

# The last is the number of these widths.
NOISE_LIMIT = 10.0
MIN_RESIZABLE_WIDTH = 1e-3
N_RESIZE_TRIALS = 24
"""Rounding error in units of the fit tolerance, and piece width in coordinate scales, above which other widths are tried."""

CHANGE_POINT_RATIO, CHANGE_POINT_MARGIN = 0.1, 0.1
"""Ratio of the pivots to those at the start below which a piece with that rounding error holds a change point, where the table
ends; not within the margin (in coordinate scales) before the coordinate's bound, which ends the table anyway.
"""

TABLE_CLOSURE_TOLERANCE = 1e-8
"""Distance between the ends of the table, in length scales and rad, below which the motion is closed."""


@jit
def extend_table(arrays: ReductionArrays, workspace: ReductionWorkspace, table: PiecewiseTable, side: int) -> ExtensionStatus:
    """Add the next piece to a table, and before the first one find the node at which it starts; return whether one was added."""
    if table.n_pieces[0] == 0 and not _start_table(arrays, workspace, table):
        return ExtensionStatus.TABLE_ENDED
    return _add_piece(arrays, workspace, table, side)


@jit
def _start_table(arrays: ReductionArrays, workspace: ReductionWorkspace, table: PiecewiseTable) -> bool:
    """Solve the initial node of a table and set the scales from it; return whether that was possible."""
    node, columns = table.initial_node, np.zeros(table.column_scales.size)
    if not solve_position(arrays.assembly, workspace.assembly, table.intervals[0, 0], node):
        table.end_reasons[:] = EndReason.AT_SINGULARITY
        return False
    evaluate_columns(arrays, workspace, node, columns)
    _set_scales(arrays, table, node, columns)
    table.periodicity[PeriodIndex.FIRST_PIVOT] = workspace.assembly.min_pivot[0]
    return True


@jit_in_place
def _set_scales(arrays: ReductionArrays, table: PiecewiseTable, node: FloatArray, columns: FloatArray) -> None:
    """Set the scales of columns and poses from the initial node."""
    column_scales = table.column_scales
    coordinate_scale = arrays.assembly.coordinate_scale
    time_scale = arrays.time_scale
    column_scales[TableColumn.QUADRATIC] = 1.0 / coordinate_scale
    column_scales[TableColumn.POTENTIAL] = coordinate_scale / time_scale**2
    column_scales[TableColumn.CENTRIFUGAL] = coordinate_scale
    largest_tangent = 0.0
    for c in range(table.node_scales.shape[1]):
        pose_scale = arrays.assembly.pose_scales[c]
        table.node_scales[0, c] = pose_scale
        table.node_scales[1, c] = pose_scale / coordinate_scale
        largest_tangent = max(largest_tangent, abs(node[1, c]))
    if columns.size == TableColumn.INVERSE_INERTIA:
        return
    column_scales[TableColumn.INVERSE_INERTIA] = columns[TableColumn.INVERSE_INERTIA]
    column_scales[TableColumn.SPINDLE_INERTIA] = columns[TableColumn.SPINDLE_INERTIA]
    column_scales[TableColumn.DAMPING] = 1.0 / time_scale
    first_output = TableColumn.FIRST_LOAD + arrays.n_loads
    for column in range(TableColumn.FIRST_LOAD, first_output):
        column_scales[column] = largest_tangent * columns[TableColumn.INVERSE_INERTIA]
    for k in range(arrays.output_scales.size):
        column_scales[first_output + 2 * k] = arrays.output_scales[k]
        column_scales[first_output + 2 * k + 1] = arrays.output_scales[k] / coordinate_scale


class Extension(NamedTuple):
    """What is known of the next piece: its index, its side of the table, its start, and how far it may lead."""

    piece: int
    neighbour: int  # the piece that it continues, or NO_INDEX for the first one
    side: int
    start: float
    bound: float  # bound of the coordinate on its side
    period_end: float  # where the table may become periodic; infinite if it cannot
    noise_limit: float  # rounding error, in units of the fit tolerance, above which other widths are tried
    acceptable_noise: float  # rounding error with which the search for another width ends


@jit_in_place
def _plan_piece(arrays: ReductionArrays, table: PiecewiseTable, side: int) -> Extension:
    piece = table.n_pieces[0]
    edge_piece = table.end_pieces[side]
    direction = 2 * side - 1
    start = table.intervals[edge_piece, side]
    bound = arrays.high if side == 1 else arrays.low
    scale = arrays.assembly.coordinate_scale
    period_end = direction * math.inf
    if arrays.full_turn > 0.0:
        turns = direction * table.periodicity[PeriodIndex.N_TURNS] * arrays.full_turn
        period_end = table.intervals[table.end_pieces[1 - side], 1 - side] + turns
    noise_limit, acceptable_noise = NOISE_LIMIT, 0.0
    distance_left = max(abs(bound - start), MIN_PIECE_WIDTH * scale)
    if distance_left < CHANGE_POINT_MARGIN * scale:
        # An error of the acceleration there moves the motion by at most its product with the distance that is left.
        noise_limit = acceptable_noise = NOISE_LIMIT * scale / distance_left
    return Extension(piece, edge_piece if piece > 0 else NO_INDEX, side, start, bound, period_end, noise_limit, acceptable_noise)


@jit_in_place
def _add_piece(arrays: ReductionArrays, workspace: ReductionWorkspace, table: PiecewiseTable, side: int) -> ExtensionStatus:
    if table.end_reasons[side] != EndReason.NOT_ENDED or table.periodicity[PeriodIndex.PERIOD] > 0.0:
        return ExtensionStatus.TABLE_ENDED
    if table.n_pieces[0] >= table.intervals.shape[0]:
        return ExtensionStatus.TABLE_FULL
    extension = _plan_piece(arrays, table, side)
    scale = arrays.assembly.coordinate_scale
    start = extension.start
    distance = abs(extension.start - table.periodicity[PeriodIndex.START])
    if distance > MAX_DISTANCE * scale:
        table.end_reasons[side] = EndReason.TOO_FAR
        return ExtensionStatus.TABLE_ENDED
    width = min(table.next_widths[side], max(MAX_PIECE_WIDTH * scale, WIDTH_PER_DISTANCE * distance))
    has_too_much_rounding = False
    while True:
        end, at_bound = _choose_end(extension, width)
        if abs(end - start) < MIN_PIECE_WIDTH * scale:
            table.end_reasons[side] = EndReason.AT_BOUND if at_bound else EndReason.AT_SINGULARITY
            return ExtensionStatus.TABLE_ENDED
        residual, rounding = _fill_piece(arrays, workspace, table, extension, end)
        if residual <= 1.0 and rounding * FIT_TOLERANCE < MAX_ROUNDING_ERROR:
            break
        has_too_much_rounding = has_too_much_rounding or residual <= 1.0
        width = 0.5 * abs(end - start)
    if rounding > extension.noise_limit and abs(end - start) > MIN_RESIZABLE_WIDTH * scale and not at_bound:
        end = _reduce_rounding_by_resizing(arrays, workspace, table, extension, end, rounding)
        residual, rounding = _fill_piece(arrays, workspace, table, extension, end)
        # No step control corrects the error of the table at a change point, and the error estimate would not show it.
        near_change_point = workspace.assembly.min_pivot[0] < CHANGE_POINT_RATIO * table.periodicity[PeriodIndex.FIRST_PIVOT]
        if rounding > extension.noise_limit and near_change_point and abs(extension.bound - end) > CHANGE_POINT_MARGIN * scale:
            table.end_reasons[side] = EndReason.AT_SINGULARITY
            return ExtensionStatus.TABLE_ENDED
    limit_value, reason = _locate_limit_in_piece(arrays, table, extension.piece, side)
    if reason != EndReason.NOT_ENDED:
        table.end_reasons[side], end = reason, limit_value  # the last piece ends where a reading reaches its limit
        if abs(end - start) < MIN_PIECE_WIDTH * scale:
            return ExtensionStatus.TABLE_ENDED
        residual, rounding = _fill_piece(arrays, workspace, table, extension, end)
    table.periodicity[PeriodIndex.ROUNDING] = max(table.periodicity[PeriodIndex.ROUNDING], rounding)
    table.next_widths[side] = abs(end - start) * (2.0 if residual < WIDEN_THRESHOLD else 1.0)
    if has_too_much_rounding and extension.acceptable_noise > 0.0:
        table.next_widths[side] = 0.5 * abs(end - start)  # rounding grows with a power of the distance that is left
    is_near_bound = abs(extension.bound - end) < BOUND_TOLERANCE * scale
    if has_too_much_rounding and is_near_bound and table.end_reasons[side] == EndReason.NOT_ENDED:
        table.end_reasons[side] = EndReason.AT_BOUND  # at a change point there, narrower pieces would lead little nearer
    _link_piece(table, extension)
    if table.end_reasons[side] == EndReason.NOT_ENDED and end == extension.period_end:
        _close_period(arrays, table)
    return ExtensionStatus.PIECE_ADDED


@jit_in_place
def _choose_end(extension: Extension, width: float) -> tuple[float, bool]:
    """Return the end of a piece of a width, and whether that is the bound of the coordinate."""
    direction = 2 * extension.side - 1
    end, at_bound = extension.start + direction * width, False
    if direction * (end - extension.bound) >= 0.0:
        end, at_bound = extension.bound, True
    if direction * (end - extension.period_end) >= 0.0:
        end, at_bound = extension.period_end, False
    return end, at_bound


@jit_in_place
def _link_piece(table: PiecewiseTable, extension: Extension) -> None:
    """Make the piece that was filled the last one on its side."""
    piece = extension.piece
    neighbour = extension.neighbour
    side = extension.side
    table.neighbours[piece, 1 - side] = neighbour
    table.neighbours[piece, side] = NO_INDEX
    if neighbour != NO_INDEX:
        table.neighbours[neighbour, side] = piece
    table.n_pieces[0] = piece + 1
    table.end_pieces[side] = piece


@jit_in_place
def _reduce_rounding_by_resizing(
    arrays: ReductionArrays, workspace: ReductionWorkspace, table: PiecewiseTable, extension: Extension, end: float, least: float
) -> float:
    """Return the end of the first trial piece whose rounding error is acceptable, or of that with the least one."""
    # Near a change point the rounding error depends on the positions of the nodes. Narrower pieces are
    # tried before wider ones.
    best, start = end, extension.start
    for k in range(N_RESIZE_TRIALS):
        if least <= extension.acceptable_noise:
            break
        j = N_RESIZE_TRIALS // 2 - 1 - k if k < N_RESIZE_TRIALS // 2 else k
        trial_end = start + (end - start) * (0.3 + 1.4 * (j + 0.5) / N_RESIZE_TRIALS)
        if (trial_end - extension.bound) * (end - start) >= 0.0:
            break
        residual, rounding = _fill_piece(arrays, workspace, table, extension, trial_end)
        if residual <= 1.0 and rounding < least:
            best, least = trial_end, rounding
    return best


@jit
def _fill_piece(
    arrays: ReductionArrays, workspace: ReductionWorkspace, table: PiecewiseTable, extension: Extension, end: float
) -> tuple[float, float]:
    """Fill a piece, node by node from the side of its neighbour, set workspace.assembly.min_pivot; return truncation and rounding error."""
    piece = extension.piece
    neighbour = extension.neighbour
    direction = 2 * extension.side - 1
    low, high = min(extension.start, end), max(extension.start, end)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    columns = np.empty(table.column_scales.size)
    values = np.empty((table.column_scales.size, N_CHEBYSHEV_NODES))
    first, last = (0, N_CHEBYSHEV_NODES - 1) if direction > 0 else (N_CHEBYSHEV_NODES - 1, 0)
    guess = np.empty(table.pose_increment.size)
    node = table.initial_node
    node_before = table.initial_node
    q = q_before = table.periodicity[PeriodIndex.START]
    if neighbour != NO_INDEX:  # its two nearest nodes
        node = table.nodes[neighbour, last]
        node_before = table.nodes[neighbour, last - direction]
        q = coordinate_at(table.intervals, neighbour, CHEBYSHEV_NODES[last])
        q_before = coordinate_at(table.intervals, neighbour, CHEBYSHEV_NODES[last - direction])
    min_pivot = math.inf
    for step in range(N_CHEBYSHEV_NODES):
        k = first + direction * step
        q_node = middle + half * CHEBYSHEV_NODES[k]
        _extrapolate_poses(arrays, node, node_before, q, q_before, q_node, table.nodes[piece, k])
        copy_array(guess, table.nodes[piece, k, 0])
        is_solved = solve_position(arrays.assembly, workspace.assembly, q_node, table.nodes[piece, k])
        if not (is_solved and is_on_branch(arrays.assembly, table.nodes[piece, k, 0], guess)):
            return math.inf, 0.0
        min_pivot = min(min_pivot, workspace.assembly.min_pivot[0])
        evaluate_columns(arrays, workspace, table.nodes[piece, k], columns)
        copy_array(values[:, k], columns)
        node_before, q_before = node, q
        node, q = table.nodes[piece, k], q_node
    workspace.assembly.min_pivot[0] = min_pivot
    _unwrap_line_angles(arrays, table, neighbour, values, first, direction)
    interval = table.intervals[piece]
    interval[PieceColumn.LOW] = low
    interval[PieceColumn.HIGH] = high
    interval[PieceColumn.MIDDLE] = middle
    interval[PieceColumn.INVERSE_HALF_WIDTH] = 1.0 / half
    return _fit_residual(arrays, table, piece, values)


@jit_in_place
def _extrapolate_poses(
    arrays: ReductionArrays, node: FloatArray, node_before: FloatArray, q: float, q_before: float, q_node: float, guess: FloatArray
) -> None:
    """Extrapolate the poses by a Taylor polynomial from the last two nodes."""
    displacement, previous_displacement = q_node - q, q - q_before
    for c in range(arrays.assembly.pose_scales.size):
        third_derivative = (node[2, c] - node_before[2, c]) / previous_displacement if previous_displacement != 0.0 else 0.0
        guess[0, c] = node[0, c] + displacement * (node[1, c] + displacement * (0.5 * node[2, c] + displacement / 6.0 * third_derivative))


@jit_in_place
def _unwrap_line_angles(
    arrays: ReductionArrays, table: PiecewiseTable, neighbour: int, values: FloatArray, first: int, direction: int
) -> None:
    """Remove whole turns from outputs that are angles of lines, continuing the neighbouring piece."""
    for output_index in range(arrays.output_scales.size):
        if arrays.output_rows.table[output_index].kind == RowKind.LINE_ANGLE:
            column = TableColumn.FIRST_LOAD + arrays.n_loads + 2 * output_index
            last = values[column, first]
            if neighbour != NO_INDEX:
                last = evaluate_piece(table.coefficients, neighbour, column, float(direction))
            for step in range(N_CHEBYSHEV_NODES):
                k = first + direction * step
                values[column, k] -= 2.0 * math.pi * math.floor((values[column, k] - last) / (2.0 * math.pi) + 0.5)
                last = values[column, k]


@jit
def _fit_residual(arrays: ReductionArrays, table: PiecewiseTable, piece: int, values: FloatArray) -> tuple[float, float]:
    """Fit a piece; return its truncation error and its rounding error in units of the fit tolerance."""
    truncation = 0.0
    rounding = 0.0
    unused_coefficients = np.empty(N_CHEBYSHEV_NODES)
    column = np.empty(N_CHEBYSHEV_NODES)
    for c in range(values.shape[0]):
        error, has_stagnated = fit_piece(values[c], table.coefficients[piece, c])
        error /= max(table.column_scales[c], _largest_magnitude(values[c]))
        truncation, rounding = (truncation, max(rounding, error)) if has_stagnated else (max(truncation, error), rounding)
    for order in range(2):
        for c in range(arrays.assembly.pose_scales.size):
            copy_array(column, table.nodes[piece, :, order, c])
            error, has_stagnated = fit_piece(column, unused_coefficients)
            error /= max(table.node_scales[order, c], _largest_magnitude(column))
            truncation, rounding = (truncation, max(rounding, error)) if has_stagnated else (max(truncation, error), rounding)
    return truncation / FIT_TOLERANCE, rounding / FIT_TOLERANCE


@jit_in_place
def _largest_magnitude(values: FloatArray) -> float:
    """Return the largest magnitude of values (n,)."""
    largest = 0.0
    for k in range(values.size):
        largest = max(largest, abs(values[k]))
    return largest


@jit_in_place
def _locate_limit_in_piece(arrays: ReductionArrays, table: PiecewiseTable, piece: int, side: int) -> tuple[float, int]:
    """Return the first value on a piece at which a reading reaches its limit, and the reason code; else its far end."""
    near_edge = table.intervals[piece, 1 - side]
    far_edge = table.intervals[piece, side]
    n_samples = 4 * N_CHEBYSHEV_NODES
    reason: int = EndReason.NOT_ENDED
    for limit in range(arrays.limits.size):
        for side_index in range(2):
            inside, outside = near_edge, far_edge
            for k in range(1, n_samples + 1):
                outside = near_edge + (far_edge - near_edge) * k / n_samples
                if _limit_violation(arrays, table, piece, limit, side_index, outside) >= 0.0:
                    for _ in range(60):
                        middle = 0.5 * (inside + outside)
                        if _limit_violation(arrays, table, piece, limit, side_index, middle) >= 0.0:
                            outside = middle
                        else:
                            inside = middle
                    far_edge, reason = inside, EndReason.AT_LIMIT + 2 * limit + side_index
                    break
                inside = outside
    return far_edge, reason


@jit_in_place
def _limit_violation(arrays: ReductionArrays, table: PiecewiseTable, piece: int, limit: int, side_index: int, q: float) -> float:
    """Return how far a reading is beyond its low (0) or high (1) limit."""
    column = TableColumn.FIRST_LOAD + arrays.n_loads + 2 * arrays.limits[limit].output_index
    value = evaluate_piece(table.coefficients, piece, column, local_coordinate(table.intervals, piece, q))
    return float(value - arrays.limits[limit].high if side_index == 1 else arrays.limits[limit].low - value)


@jit
def _close_period(arrays: ReductionArrays, table: PiecewiseTable) -> None:
    """Make a table periodic whose ends meet; else let it continue for another turn."""
    low, high = table.end_pieces[0], table.end_pieces[1]
    weights = np.empty(N_CHEBYSHEV_NODES)
    first = np.zeros(arrays.assembly.pose_scales.size)
    last = np.zeros(arrays.assembly.pose_scales.size)
    for end in range(2):
        piece, poses = (low, first) if end == 0 else (high, last)
        barycentric_weights(local_coordinate(table.intervals, piece, table.intervals[piece, end]), weights)
        for k in range(N_CHEBYSHEV_NODES):
            for c in range(poses.size):
                poses[c] += weights[k] * table.nodes[piece, k, 0, c]
    for c in range(arrays.assembly.pose_scales.size):
        pose_change = last[c] - first[c]
        whole_turns = 2.0 * math.pi * math.floor(pose_change / (2.0 * math.pi) + 0.5) if c % 3 == 2 else 0.0
        if abs(pose_change - whole_turns) > TABLE_CLOSURE_TOLERANCE * arrays.assembly.pose_scales[c]:
            table.periodicity[PeriodIndex.N_TURNS] += 1.0
            return
        table.pose_increment[c] = whole_turns
    if not _is_periodic(arrays, table, low, high):  # for example a spring that is wound up
        table.periodicity[PeriodIndex.N_TURNS] += 1.0
        return
    start = table.intervals[low, PieceColumn.LOW]
    end = table.intervals[high, PieceColumn.HIGH]
    table.periodicity[PeriodIndex.START] = start
    table.periodicity[PeriodIndex.PERIOD] = end - start


@jit_in_place
def _is_periodic(arrays: ReductionArrays, table: PiecewiseTable, low: int, high: int) -> bool:
    """Return whether all columns have the same values at both ends; angles of lines are exempt, because whole turns do not matter."""
    first_output_column, is_same = TableColumn.FIRST_LOAD + arrays.n_loads, True
    for c in range(table.column_scales.size):
        output_index = (c - first_output_column) // 2
        is_derivative = (c - first_output_column) % 2 == 1
        if c >= first_output_column and not is_derivative and arrays.output_rows.table[output_index].kind == RowKind.LINE_ANGLE:
            continue
        first = evaluate_piece(table.coefficients, low, c, -1.0)
        last = evaluate_piece(table.coefficients, high, c, 1.0)
        is_same = is_same and abs(last - first) <= TABLE_CLOSURE_TOLERANCE * max(table.column_scales[c], abs(first), abs(last))
    return is_same

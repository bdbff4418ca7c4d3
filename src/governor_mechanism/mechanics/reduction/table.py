"""Piecewise Chebyshev table of a motion along its coordinate: storage, lookup and evaluation of poses; compiled."""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.reduction.lagrangian import ReductionArrays, TableColumn
from governor_mechanism.numerics.interpolation import N_CHEBYSHEV_NODES, barycentric_weights
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray, IntArray

INITIAL_PIECE_WIDTH = 0.1
"""Width of the first piece, in coordinate scales."""

BOUND_TOLERANCE = 1e-3
"""Distance from the coordinate's bound, in coordinate scales, within which a table that cannot be extended counts as ending there."""


ON_TABLE = -1
"""What stands for a side where a coordinate is on the table."""


class ExtensionStatus(IntEnum):
    """Result of `extend_table`."""

    PIECE_ADDED = 0
    TABLE_FULL = 1
    """The capacity is used up."""
    TABLE_ENDED = 2


class EndReason(IntEnum):
    """Why a table ends on a side."""

    NOT_ENDED = 0
    AT_BOUND = 1
    """At a bound of the coordinate."""
    AT_SINGULARITY = 2
    """Where the coordinate does not determine the poses."""
    TOO_FAR = 3
    """So far from the start that a body flies away."""
    AT_LIMIT = 4
    """At a limit of a reading: this plus twice the index of the limit, plus 1 at a high one."""


class PieceColumn(IntEnum):
    """Columns of the intervals of the pieces; the first two are also the sides of a table, below and above."""

    LOW = 0
    HIGH = 1
    MIDDLE = 2
    INVERSE_HALF_WIDTH = 3


class PeriodIndex(IntEnum):
    """Indices in the periodicity of a table."""

    PERIOD = 0
    """0 if the table is not periodic."""
    START = 1
    """Its beginning; the start of the table before it is periodic."""
    N_TURNS = 2
    """Number of whole turns to try next."""
    ROUNDING = 3
    """Largest rounding error in units of the fit tolerance."""
    FIRST_PIVOT = 4
    """Pivot ratio of the joints at the start."""


class PiecewiseTable(NamedTuple):
    """Pieces of the table in the order in which they were added, and the state of its construction."""

    intervals: FloatArray  # ends, midpoint and 1 / half width of each piece, see `PieceColumn`; shape (pieces, 4)
    neighbours: IntArray  # index of the piece below and above, or NO_INDEX; shape (pieces, 2)
    coefficients: FloatArray  # power-series coefficients of the columns; shape (pieces, columns, 12)
    nodes: FloatArray  # poses and their first two derivatives at the Chebyshev nodes; shape (pieces, 12, 3, 3 bodies)
    n_pieces: IntArray  # number of pieces; shape (1,)
    end_pieces: IntArray  # index of the lowest and the highest piece; shape (2,)
    end_reasons: IntArray  # why the table ends below and above; shape (2,)
    next_widths: FloatArray  # width of the next piece below and above; shape (2,)
    periodicity: FloatArray  # the period, and how far the construction is, see `PeriodIndex`; shape (5,)
    pose_increment: FloatArray  # change of the poses over a period; shape (3 bodies,)
    column_scales: FloatArray  # scales of the fit errors of the columns; shape (columns,)
    node_scales: FloatArray  # scales of the fit errors of poses and tangents; shape (2, 3 bodies)
    initial_node: FloatArray  # poses at the start and their first two derivatives; shape (3, 3 bodies)


def allocate_table(
    arrays: ReductionArrays,
    capacity: int,
    q: float,  # leading coordinate at which the table starts, SI
    poses: FloatArray,  # poses near that start; shape (bodies, 3)
) -> PiecewiseTable:
    """Allocate an empty table."""
    n_columns, n_bodies = count_columns(arrays), len(arrays.bodies)
    width = INITIAL_PIECE_WIDTH * arrays.assembly.coordinate_scale
    table = PiecewiseTable(
        intervals=np.zeros((capacity, len(PieceColumn))),
        neighbours=np.full((capacity, 2), NO_INDEX, dtype=np.int64),
        coefficients=np.zeros((capacity, n_columns, N_CHEBYSHEV_NODES)),
        nodes=np.zeros((capacity, N_CHEBYSHEV_NODES, 3, 3 * n_bodies)),
        n_pieces=np.zeros(1, dtype=np.int64),
        end_pieces=np.zeros(2, dtype=np.int64),
        end_reasons=np.zeros(2, dtype=np.int64),
        next_widths=np.full(2, width),
        periodicity=np.array([0.0, q, 1.0, 0.0, 0.0]),
        pose_increment=np.zeros(3 * n_bodies),
        column_scales=np.zeros(n_columns),
        node_scales=np.zeros((2, 3 * n_bodies)),
        initial_node=np.zeros((3, 3 * n_bodies)),
    )
    table.intervals[0, :2] = q
    table.initial_node[0] = poses.ravel()
    return table


def grow_table(table: PiecewiseTable) -> PiecewiseTable:
    """Return the table with twice the capacity; pieces that are added overwrite the copies."""
    names = ("intervals", "neighbours", "coefficients", "nodes")
    return table._replace(**{name: np.concatenate([getattr(table, name)] * 2) for name in names})


def count_columns(arrays: ReductionArrays) -> int:
    """Return the number of columns of the table."""
    n_outputs = len(arrays.output_scales)
    if arrays.is_conservative and not n_outputs:
        return TableColumn.INVERSE_INERTIA
    return TableColumn.FIRST_LOAD + arrays.n_loads + 2 * n_outputs


@jit_in_place
def local_coordinate(intervals: FloatArray, piece: int, q: float) -> float:
    """Return the local coordinate in a piece, from -1 to 1 within it."""
    return float((q - intervals[piece, PieceColumn.MIDDLE]) * intervals[piece, PieceColumn.INVERSE_HALF_WIDTH])


@jit_in_place
def coordinate_at(intervals: FloatArray, piece: int, t: float) -> float:
    """Return the coordinate at a local coordinate in a piece."""
    return float(intervals[piece, PieceColumn.MIDDLE] + t / intervals[piece, PieceColumn.INVERSE_HALF_WIDTH])


@jit_in_place
def find_piece(
    intervals: FloatArray,
    neighbours: IntArray,
    periodicity: FloatArray,
    q: float,  # leading coordinate, SI
    piece_guess: int,
) -> tuple[int, float, int]:
    """Return the piece of a value, or the nearest, the local coordinate (-1 to 1), and ON_TABLE or the side it lacks: 0 low, 1 high."""
    low = PieceColumn.LOW
    high = PieceColumn.HIGH
    period = periodicity[PeriodIndex.PERIOD]
    piece = piece_guess
    wrapped = q
    side = ON_TABLE
    if period > 0.0:
        wrapped = q - period * math.floor((q - periodicity[PeriodIndex.START]) / period)
    t = local_coordinate(intervals, piece, wrapped)
    if abs(t) > 1.0:
        while wrapped > intervals[piece, high] and neighbours[piece, high] != NO_INDEX:
            piece = neighbours[piece, high]
        while wrapped < intervals[piece, low] and neighbours[piece, low] != NO_INDEX:
            piece = neighbours[piece, low]
        t = local_coordinate(intervals, piece, wrapped)
        if period == 0.0:  # in a periodic table only rounding leads beyond an end
            side = 1 if wrapped > intervals[piece, high] else 0 if wrapped < intervals[piece, low] else ON_TABLE
    return piece, t, side


@jit
def evaluate_poses(
    table: PiecewiseTable,
    values: FloatArray,  # leading coordinate, SI; shape (n,)
) -> FloatArray:
    """Return poses, then their derivatives by the coordinate, (2, n, bodies, 3), by barycentric interpolation."""
    weights = np.empty(N_CHEBYSHEV_NODES)
    piece = 0
    result = np.empty((2, values.size, table.pose_increment.size))
    for i in range(values.size):
        piece = evaluate_node(table, values[i], piece, weights, result[:, i])
    return result.reshape((2, values.size, table.pose_increment.size // 3, 3))


@jit_in_place
def evaluate_node(
    table: PiecewiseTable,
    q: float,  # leading coordinate, SI
    piece_guess: int,
    weights: FloatArray,  # buffer; shape (N_CHEBYSHEV_NODES,)
    node: FloatArray,  # result; shape (2, 3 bodies)
) -> int:
    """Fill poses and their derivative by the coordinate into a node (2, 3 bodies); return the index of the piece."""
    piece, t, _ = find_piece(table.intervals, table.neighbours, table.periodicity, q, piece_guess)
    barycentric_weights(t, weights)
    period = table.periodicity[PeriodIndex.PERIOD]
    n_periods = math.floor((q - table.periodicity[PeriodIndex.START]) / period) if period > 0.0 else 0.0
    for c in range(table.pose_increment.size):
        pose = tangent = 0.0
        for k in range(N_CHEBYSHEV_NODES):
            pose += weights[k] * table.nodes[piece, k, 0, c]
            tangent += weights[k] * table.nodes[piece, k, 1, c]
        node[0, c], node[1, c] = pose + n_periods * table.pose_increment[c], tangent
    return piece

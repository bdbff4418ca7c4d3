"""What has been laid of a mechanism's way: pieces along its coordinate, looked up and read off; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.reduction.node_evaluation import FIRST_PROGRAM_COLUMN, INVERSE_INERTIA_COLUMN, ReductionArrays
from governor_mechanism.numerics.chebyshev import N_CHEBYSHEV_NODES, barycentric_weights
from governor_mechanism.numerics.jit import jit, jit_internal
from governor_mechanism.types import FloatArray, IntArray

INITIAL_PIECE_WIDTH = 0.1
"""Of the coordinate's unit: the first piece tried."""


class PiecewiseTable(NamedTuple):
    """Pieces, in the order in which they were laid: edges (pieces, 4), their low and high end, middle and 1 / half
    width; beside (pieces, 2), the ones below and above, -1 where none is; table (pieces, columns, COUNT);
    places (pieces, COUNT, 3, 3 bodies), poses and their two derivatives at the nodes.

    number (1,): how many there are. ends, why (2,): the lowest and highest piece, and why the way ends there; width
    (2,) of the next piece; ring (5,): period, beginning, whole turns to try next, most rounding in units of TIGHT, how
    independent the joints were at first; turned (3 bodies,): what a turn adds to poses; natural (columns,) and
    natural_places (2, 3 bodies): what fits are relative to; first (3, 3 bodies): the place that all begins at.
    """

    intervals: FloatArray
    neighbours: IntArray
    coefficients: FloatArray
    nodes: FloatArray
    n_pieces: IntArray
    end_pieces: IntArray
    end_reasons: IntArray
    next_widths: FloatArray
    periodicity: FloatArray
    pose_increment: FloatArray
    column_scales: FloatArray
    node_scales: FloatArray
    initial_node: FloatArray


def allocate_table(arrays: ReductionArrays, capacity: int) -> PiecewiseTable:
    """Room for so many pieces, none laid."""
    n_columns, n_bodies = count_columns(arrays), len(arrays.bodies)
    return PiecewiseTable(
        intervals=np.zeros((capacity, 4)),
        neighbours=np.full((capacity, 2), -1, dtype=np.int64),
        coefficients=np.zeros((capacity, n_columns, N_CHEBYSHEV_NODES)),
        nodes=np.zeros((capacity, N_CHEBYSHEV_NODES, 3, 3 * n_bodies)),
        n_pieces=np.zeros(1, dtype=np.int64),
        end_pieces=np.zeros(2, dtype=np.int64),
        end_reasons=np.zeros(2, dtype=np.int64),
        next_widths=np.full(2, INITIAL_PIECE_WIDTH * arrays.coordinate_scale),
        periodicity=np.array([0.0, 0.0, 1.0, 0.0, 0.0]),
        pose_increment=np.zeros(3 * n_bodies),
        column_scales=np.zeros(n_columns),
        node_scales=np.zeros((2, 3 * n_bodies)),
        initial_node=np.zeros((3, 3 * n_bodies)),
    )


def grow_table(table: PiecewiseTable) -> PiecewiseTable:
    """The same with room for twice as many pieces."""
    grown = {}
    for name in ("intervals", "neighbours", "coefficients", "nodes"):
        old = getattr(table, name)
        grown[name] = np.concatenate([old, np.full_like(old, -1 if name == "neighbours" else 0)])
    return table._replace(**grown)


def count_columns(arrays: ReductionArrays) -> int:
    """How many columns there are."""
    return (
        INVERSE_INERTIA_COLUMN
        if arrays.is_conservative and not len(arrays.output_rows.table)
        else FIRST_PROGRAM_COLUMN + len(arrays.program_indices) + 2 * len(arrays.output_rows.table)
    )


@jit_internal
def find_piece(intervals: FloatArray, neighbours: IntArray, periodicity: FloatArray, q: float, piece_guess: int) -> tuple[int, float, int]:
    """The piece that holds a value, looked for from one near by, where in it the value is (-1 to 1), and -1.

    Where none does, the side (0 below, 1 above) to lay one on stands in place of that.
    """
    piece, wrapped, side = piece_guess, q, -1
    if periodicity[0] > 0.0:
        wrapped = q - periodicity[0] * math.floor((q - periodicity[1]) / periodicity[0])
    t = (wrapped - intervals[piece, 2]) * intervals[piece, 3]
    if abs(t) > 1.0:
        while wrapped > intervals[piece, 1] and neighbours[piece, 1] >= 0:
            piece = neighbours[piece, 1]
        while wrapped < intervals[piece, 0] and neighbours[piece, 0] >= 0:
            piece = neighbours[piece, 0]
        t = (wrapped - intervals[piece, 2]) * intervals[piece, 3]
        if periodicity[0] == 0.0:  # on a ring it would be rounding
            side = 1 if wrapped > intervals[piece, 1] else 0 if wrapped < intervals[piece, 0] else -1
    return piece, t, side


@jit
def evaluate_poses(table: PiecewiseTable, values: FloatArray, poses: FloatArray, tangents: FloatArray) -> None:
    """Fill poses and their derivative (n, 3 bodies) at values (n,) of the coordinate that have been laid."""
    weights, piece = np.empty(N_CHEBYSHEV_NODES), 0
    for i in range(values.size):
        piece, t, _ = find_piece(table.intervals, table.neighbours, table.periodicity, values[i], piece)
        barycentric_weights(t, weights)
        n_periods = math.floor((values[i] - table.periodicity[1]) / table.periodicity[0]) if table.periodicity[0] > 0.0 else 0.0
        for c in range(table.pose_increment.size):
            pose = tangent = 0.0
            for k in range(N_CHEBYSHEV_NODES):
                pose += weights[k] * table.nodes[piece, k, 0, c]
                tangent += weights[k] * table.nodes[piece, k, 1, c]
            poses[i, c], tangents[i, c] = pose + n_periods * table.pose_increment[c], tangent

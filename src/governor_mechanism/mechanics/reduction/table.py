"""What has been laid of a mechanism's way: pieces along its coordinate, looked up and read off; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.reduction.node_evaluation import EASE, FIRST, Plan
from governor_mechanism.numerics.chebyshev import COUNT, weighed
from governor_mechanism.numerics.jit import compiled, kernel
from governor_mechanism.types import FloatArray, IntArray

FIRST_WIDTH = 0.1
"""Of the coordinate's unit: the first piece tried."""


class Laid(NamedTuple):
    """Pieces, in the order in which they were laid: edges (pieces, 4), their low and high end, middle and 1 / half
    width; beside (pieces, 2), the ones below and above, -1 where none is; table (pieces, columns, COUNT);
    places (pieces, COUNT, 3, 3 bodies), poses and their two derivatives at the nodes.

    number (1,): how many there are. ends, why (2,): the lowest and highest piece, and why the way ends there; width
    (2,) of the next piece; ring (5,): period, beginning, whole turns to try next, most rounding in units of TIGHT, how
    independent the joints were at first; turned (3 bodies,): what a turn adds to poses; natural (columns,) and
    natural_places (2, 3 bodies): what fits are relative to; first (3, 3 bodies): the place that all begins at.
    """

    edges: FloatArray
    beside: IntArray
    table: FloatArray
    places: FloatArray
    number: IntArray
    ends: IntArray
    why: IntArray
    width: FloatArray
    ring: FloatArray
    turned: FloatArray
    natural: FloatArray
    natural_places: FloatArray
    first: FloatArray


def make_laid(plan: Plan, room: int) -> Laid:
    """Room for so many pieces, none laid."""
    columns, bodies = columns_of(plan), len(plan.bodies)
    return Laid(
        edges=np.zeros((room, 4)),
        beside=np.full((room, 2), -1, dtype=np.int64),
        table=np.zeros((room, columns, COUNT)),
        places=np.zeros((room, COUNT, 3, 3 * bodies)),
        number=np.zeros(1, dtype=np.int64),
        ends=np.zeros(2, dtype=np.int64),
        why=np.zeros(2, dtype=np.int64),
        width=np.full(2, FIRST_WIDTH * plan.unit),
        ring=np.array([0.0, 0.0, 1.0, 0.0, 0.0]),
        turned=np.zeros(3 * bodies),
        natural=np.zeros(columns),
        natural_places=np.zeros((2, 3 * bodies)),
        first=np.zeros((3, 3 * bodies)),
    )


def more_room(laid: Laid) -> Laid:
    """The same with room for twice as many pieces."""
    double = {}
    for name in ("edges", "beside", "table", "places"):
        old = getattr(laid, name)
        double[name] = np.concatenate([old, np.full_like(old, -1 if name == "beside" else 0)])
    return laid._replace(**double)


def columns_of(plan: Plan) -> int:
    """How many columns there are."""
    return (
        EASE if plan.plain and not len(plan.gauges.table) else FIRST + len(plan.programs) + 2 * len(plan.gauges.table)
    )


@kernel
def piece_of(edges: FloatArray, beside: IntArray, ring: FloatArray, q: float, near: int) -> tuple[int, float, int]:
    """The piece that holds a value, looked for from one near by, where in it the value is (-1 to 1), and -1.

    Where none does, the side (0 below, 1 above) to lay one on stands in place of that.
    """
    k, local, side = near, q, -1
    if ring[0] > 0.0:
        local = q - ring[0] * math.floor((q - ring[1]) / ring[0])
    t = (local - edges[k, 2]) * edges[k, 3]
    if abs(t) > 1.0:
        while local > edges[k, 1] and beside[k, 1] >= 0:
            k = beside[k, 1]
        while local < edges[k, 0] and beside[k, 0] >= 0:
            k = beside[k, 0]
        t = (local - edges[k, 2]) * edges[k, 3]
        if ring[0] == 0.0:  # on a ring it would be rounding
            side = 1 if local > edges[k, 1] else 0 if local < edges[k, 0] else -1
    return k, t, side


@compiled
def places_at(laid: Laid, values: FloatArray, poses: FloatArray, ahead: FloatArray) -> None:
    """Fill poses and their derivative (n, 3 bodies) at values (n,) of the coordinate that have been laid."""
    weights, near = np.empty(COUNT), 0
    for i in range(values.size):
        near, t, _ = piece_of(laid.edges, laid.beside, laid.ring, values[i], near)
        weighed(t, weights)
        turns = math.floor((values[i] - laid.ring[1]) / laid.ring[0]) if laid.ring[0] > 0.0 else 0.0
        for c in range(laid.turned.size):
            place = moving = 0.0
            for k in range(COUNT):
                place += weights[k] * laid.places[near, k, 0, c]
                moving += weights[k] * laid.places[near, k, 1, c]
            poses[i, c], ahead[i, c] = place + turns * laid.turned[c], moving

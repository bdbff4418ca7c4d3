"""A mechanism's way laid out piece by piece, as far as a motion goes: poses and columns along the coordinate; compiled.

Each piece is a fit (see `pieces`) that leaves out no more than TIGHT; where it does, it is laid anew, half as wide. A
way that comes all the way round is closed to a ring.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_kernels import LEAN
from governor_mechanism.mechanics.reduction.node_evaluation import (
    BRANCH,
    DRAG,
    EASE,
    FIRST,
    GRIP,
    OWN,
    PULL,
    SPINDLE,
    Bench,
    Plan,
    placed,
    sampled,
)
from governor_mechanism.mechanics.reduction.table import Laid
from governor_mechanism.numerics.chebyshev import COUNT, NODES, fitted, powers, weighed
from governor_mechanism.numerics.jit import compiled, kernel
from governor_mechanism.types import FloatArray

TIGHT = 1e-13
"""What a fit may leave out, of what its column is natural in."""

WIDEST = 1.0
"""Of the coordinate's unit: no piece is wider."""

SHORTEST = 1e-9
"""Of the coordinate's unit: where a piece must be narrower, the way ends."""

AT_EASE = 1e-3
"""A piece that leaves out less than this part of what it may lets the next one be wider."""

ROUNDING = 1e6
"""So many times more than TIGHT may be left out where it is rounding: near a change point, where the way soon ends."""

NOTABLE, NARROW, TRIED = 10.0, 1e-3, 24
"""More rounding than that, in units of TIGHT, on a piece wider than this part of the coordinate's unit: so many other
widths are tried."""

WEAK, LAST = 0.1, 0.1
"""A piece with that much rounding, and with joints that much less independent than at the start, holds a change point,
where the way ends; but for the last part (of the coordinate's unit) before its bound, which ends it anyhow."""

RECURS = 1e-8
"""Machine sizes, and rad: a way that comes so near its beginning is closed."""

BEGIN = 2
"""What `lay` is asked for first; else 0 is below, and 1 above."""

LAID, FULL, ENDED = 0, 1, 2
"""What became of it: a piece was laid; there is no room; the way ends."""

OPEN, BOUND, CENTRE, BEYOND = 0, 1, 2, 3
"""Why a way ends: it does not; at the coordinate's bound; where it cannot be followed; from BEYOND on at a limit."""


@compiled
def lay(plan: Plan, bench: Bench, laid: Laid, what: int, q: float, poses: FloatArray) -> int:
    """Lay the next piece below (what = 0) or above (1) all others; or first (BEGIN) find the place from which pieces
    are laid, at a value of the coordinate near poses (bodies, 3), which nothing else asks for. What became of it.

    One way in from Python for both: each is compiled with all that it calls.
    """
    if what == BEGIN:
        return LAID if _begun(plan, bench, laid, q, poses) else ENDED
    return int(_extended(plan, bench, laid, what))


@kernel
def _begun(plan: Plan, bench: Bench, laid: Laid, q: float, poses: FloatArray) -> bool:
    place, columns = np.zeros((3, plan.units.size)), np.zeros(laid.natural.size)
    place[0] = poses.ravel()
    laid.edges[0, 0] = laid.edges[0, 1] = laid.ring[1] = q
    if not placed(plan, bench, q, place):
        laid.why[:] = CENTRE
        return False
    sampled(plan, bench, place, columns)
    _naturals(plan, laid, place, columns)
    laid.first[:] = place
    laid.ring[4] = bench.pivot[0]
    return True


@kernel
def _naturals(plan: Plan, laid: Laid, place: FloatArray, columns: FloatArray) -> None:
    """What columns and places are relative to, from the first place."""
    natural, unit, second = laid.natural, plan.unit, plan.second
    natural[OWN], natural[PULL], natural[GRIP] = 1.0 / unit, unit / second**2, unit
    moving = 0.0
    for k in range(plan.units.size):
        moving = max(moving, abs(place[1, k]))
        laid.natural_places[0, k] = plan.units[k]
        laid.natural_places[1, k] = plan.units[k] / unit
    if columns.size == EASE:
        return
    natural[EASE], natural[SPINDLE], natural[DRAG] = columns[EASE], columns[SPINDLE], 1.0 / second
    at = FIRST
    for _ in range(plan.programs.size):
        natural[at] = moving * columns[EASE]
        at += 1
    for k in range(plan.gauges.table.size):
        natural[at], natural[at + 1] = plan.sizes[k], plan.sizes[k] / unit
        at += 2


@kernel
def _extended(plan: Plan, bench: Bench, laid: Laid, side: int) -> int:
    if laid.why[side] != OPEN or laid.ring[0] > 0.0:
        return ENDED
    at, edge = laid.number[0], laid.ends[side]
    if at >= laid.edges.shape[0]:
        return FULL
    start, sign = laid.edges[edge, side], 1.0 if side == 1 else -1.0
    bound = plan.high if side == 1 else plan.low
    width = min(laid.width[side], WIDEST * plan.unit)
    while True:
        end, bounded = start + sign * width, False
        if sign * (end - bound) >= 0.0:
            end, bounded = bound, True
        whole = laid.edges[laid.ends[1 - side], 1 - side] + sign * laid.ring[2] * plan.turn
        if plan.turn > 0.0 and sign * (end - whole) >= 0.0:
            end, bounded = whole, False
        if abs(end - start) < SHORTEST * plan.unit:
            laid.why[side] = BOUND if bounded else CENTRE
            return ENDED
        left_out, rounding = _lay(plan, bench, laid, at, edge, min(start, end), max(start, end), side)
        if left_out <= 1.0 and rounding < ROUNDING:
            if rounding > NOTABLE and abs(end - start) > NARROW * plan.unit and not bounded:
                end = _quieter(plan, bench, laid, at, edge, start, end, side, rounding)
                left_out, rounding = _lay(plan, bench, laid, at, edge, min(start, end), max(start, end), side)
                # What a change point does to the tables no run can make good, and what is passed there would not show.
                weak = bench.pivot[0] < WEAK * laid.ring[4]
                if rounding > NOTABLE and weak and abs(bound - end) > LAST * plan.unit:
                    laid.why[side] = CENTRE
                    return ENDED
            met, reason = _limit(plan, laid, at, side)
            if reason == OPEN:
                break
            laid.why[side] = reason  # the last piece ends where a reading meets its limit
            if abs(met - start) < SHORTEST * plan.unit:
                return ENDED
            left_out, rounding = _lay(plan, bench, laid, at, edge, min(start, met), max(start, met), side)
            end = met
            break
        width = 0.5 * abs(end - start)
    laid.ring[3] = max(laid.ring[3], rounding)
    laid.width[side] = abs(end - start) * (2.0 if left_out < AT_EASE else 1.0)
    laid.beside[at, 1 - side] = edge if at > 0 else -1
    laid.beside[at, side] = -1
    if at > 0:
        laid.beside[edge, side] = at
    laid.number[0] = at + 1
    laid.ends[side] = at
    if laid.why[side] == OPEN and plan.turn > 0.0 and end == whole:
        _close_ring(plan, laid)
    return LAID


@kernel
def _quieter(
    plan: Plan, bench: Bench, laid: Laid, at: int, edge: int, start: float, end: float, side: int, least: float
) -> float:
    """Where else a piece may end so that less is rounding: near a change point it matters where its nodes stand."""
    best, bound = end, plan.high if side == 1 else plan.low
    for k in range(TRIED):
        there = start + (end - start) * (0.3 + 1.4 * (k + 0.5) / TRIED)
        if (there - bound) * (end - start) >= 0.0:
            break
        left_out, rounding = _lay(plan, bench, laid, at, edge, min(start, there), max(start, there), side)
        if left_out <= 1.0 and rounding < least:
            best, least = there, rounding
    return best


@kernel
def _lay(
    plan: Plan, bench: Bench, laid: Laid, at: int, near: int, low: float, high: float, side: int
) -> tuple[float, float]:
    """Fill a piece, its nodes from the side of the piece near by; what its fits leave out, and how much is rounding.

    bench.pivot becomes the least of all its nodes.
    """
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    columns, values = np.empty(laid.natural.size), np.empty((laid.natural.size, COUNT))
    first, last, onward = (0, COUNT - 1, 1) if side == 1 else (COUNT - 1, 0, -1)
    place, before = np.empty((3, plan.units.size)), np.empty((3, plan.units.size))
    place[:], before[:] = laid.first, laid.first
    q = q_before = laid.edges[0, 0]
    if at > 0:  # the two nodes of its neighbour nearest to this piece
        place[:], before[:] = laid.places[near, last], laid.places[near, last - onward]
        q = laid.edges[near, 2] + NODES[last] / laid.edges[near, 3]
        q_before = laid.edges[near, 2] + NODES[last - onward] / laid.edges[near, 3]
    least = math.inf
    for step in range(COUNT):
        k = first + onward * step
        there = middle + half * NODES[k]
        _expect(plan, place, before, q, q_before, there, laid.places[at, k])
        guess = laid.places[at, k, 0].copy()
        if not placed(plan, bench, there, laid.places[at, k]):
            return math.inf, 0.0
        least = min(least, bench.pivot[0])
        for c in range(plan.units.size):
            if not abs(laid.places[at, k, 0, c] - guess[c]) < BRANCH * plan.units[c]:
                return math.inf, 0.0
        sampled(plan, bench, laid.places[at, k], columns)
        for c in range(columns.size):
            values[c, k] = columns[c]
        before[:], q_before = place, q
        place[:], q = laid.places[at, k], there
    bench.pivot[0] = least
    _unwrap(plan, laid, near if at > 0 else -1, values, first, onward)
    laid.edges[at, 0], laid.edges[at, 1], laid.edges[at, 2], laid.edges[at, 3] = low, high, middle, 1.0 / half
    return _left_out(plan, laid, at, values)


@kernel
def _expect(
    plan: Plan, place: FloatArray, before: FloatArray, q: float, q_before: float, there: float, guess: FloatArray
) -> None:
    """Poses at a value, by their derivatives at the place before it, and the one before that."""
    way, past = there - q, q - q_before
    for c in range(plan.units.size):
        third = (place[2, c] - before[2, c]) / past if past != 0.0 else 0.0
        guess[0, c] = place[0, c] + way * (place[1, c] + way * (0.5 * place[2, c] + way / 6.0 * third))


@kernel
def _unwrap(plan: Plan, laid: Laid, near: int, values: FloatArray, first: int, onward: int) -> None:
    """Take whole turns out of gauges that tell the angle of a line, on from the neighbour's."""
    for gauge in range(plan.gauges.table.size):
        if plan.gauges.table[gauge].kind == LEAN:
            column = FIRST + plan.programs.size + 2 * gauge
            last = powers(laid.table, near, column, float(onward)) if near >= 0 else values[column, first]
            for step in range(COUNT):
                k = first + onward * step
                values[column, k] -= 2.0 * math.pi * math.floor((values[column, k] - last) / (2.0 * math.pi) + 0.5)
                last = values[column, k]


@kernel
def _left_out(plan: Plan, laid: Laid, at: int, values: FloatArray) -> tuple[float, float]:
    worst, noise, spare, column = 0.0, 0.0, np.empty(COUNT), np.empty(COUNT)
    for c in range(values.shape[0]):
        rest, level = fitted(values[c], laid.table[at, c])
        rest /= TIGHT * max(laid.natural[c], np.max(np.abs(values[c])))
        worst, noise = (worst, max(noise, rest)) if level else (max(worst, rest), noise)
    for order in range(2):
        for c in range(plan.units.size):
            column[:] = laid.places[at, :, order, c]
            rest, level = fitted(column, spare)
            rest /= TIGHT * max(laid.natural_places[order, c], np.max(np.abs(column)))
            worst, noise = (worst, max(noise, rest)) if level else (max(worst, rest), noise)
    return worst, noise


@kernel
def _limit(plan: Plan, laid: Laid, at: int, side: int) -> tuple[float, int]:
    """Where on a piece a reading first meets its limit, and which; at its far end none does."""
    near, far, reason, looks = laid.edges[at, 1 - side], laid.edges[at, side], OPEN, 4 * COUNT
    for i in range(plan.limits.shape[0]):
        for way in range(2):
            inside, outside = near, far
            for k in range(1, looks + 1):
                outside = near + (far - near) * k / looks
                if _excess(plan, laid, at, i, way, outside) >= 0.0:
                    for _ in range(60):
                        middle = 0.5 * (inside + outside)
                        if _excess(plan, laid, at, i, way, middle) >= 0.0:
                            outside = middle
                        else:
                            inside = middle
                    far, reason = inside, BEYOND + 2 * i + way
                    break
                inside = outside
    return far, reason


@kernel
def _excess(plan: Plan, laid: Laid, at: int, limit: int, way: int, q: float) -> float:
    """How far a reading is beyond its low (way 0) or high (1) limit."""
    column = FIRST + plan.programs.size + 2 * int(plan.limits[limit, 0])
    value = powers(laid.table, at, column, (q - laid.edges[at, 2]) * laid.edges[at, 3])
    return float(value - plan.limits[limit, 2] if way == 1 else plan.limits[limit, 1] - value)


@kernel
def _close_ring(plan: Plan, laid: Laid) -> None:
    """Join the ends of a way that has come round to where it began; else let it go on for another turn."""
    low, high = laid.ends[0], laid.ends[1]
    weights = np.empty(COUNT)
    first, last = np.zeros(plan.units.size), np.zeros(plan.units.size)
    for end in range(2):
        piece, poses = (low, first) if end == 0 else (high, last)
        weighed((laid.edges[piece, end] - laid.edges[piece, 2]) * laid.edges[piece, 3], weights)
        for k in range(COUNT):
            for c in range(plan.units.size):
                poses[c] += weights[k] * laid.places[piece, k, 0, c]
    for c in range(plan.units.size):
        turned = last[c] - first[c]
        whole = 2.0 * math.pi * math.floor(turned / (2.0 * math.pi) + 0.5) if c % 3 == 2 else 0.0
        if abs(turned - whole) > RECURS * plan.units[c]:
            laid.ring[2] += 1.0
            return
        laid.turned[c] = whole
    if not _same_again(plan, laid, low, high):  # as where a spring is wound up
        laid.ring[2] += 1.0
        return
    laid.ring[1] = laid.edges[low, 0]
    laid.ring[0] = laid.edges[high, 1] - laid.edges[low, 0]


@kernel
def _same_again(plan: Plan, laid: Laid, low: int, high: int) -> bool:
    """Whether all columns are after a turn what they were, but for angles of lines, which no turn changes."""
    gauges, same = FIRST + plan.programs.size, True
    for c in range(laid.natural.size):
        gauge = (c - gauges) // 2
        if c >= gauges and (c - gauges) % 2 == 0 and plan.gauges.table[gauge].kind == LEAN:
            continue
        first, last = powers(laid.table, low, c, -1.0), powers(laid.table, high, c, 1.0)
        same = same and abs(last - first) <= RECURS * max(laid.natural[c], abs(first), abs(last))
    return same

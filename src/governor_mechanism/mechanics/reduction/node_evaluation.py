"""One place on the way of a mechanism of mobility one: poses, how they move, what follows; compiled.

Dense elimination that picks independent rows: where joints are redundant, those left over say the same.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.equations_of_motion import body_forces, inertia_of
from governor_mechanism.mechanics.dynamics.force_elements import add_loads
from governor_mechanism.mechanics.dynamics.output_forces import add_acts, gauge_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import ASKED, ASKED_BEND, BEND, OPENING, Rows, evaluate
from governor_mechanism.numerics.jit import compiled, kernel
from governor_mechanism.types import FloatArray, IntArray, RecordArray

STEPS = 16
"""So many Newton steps are made."""

LOST = 0.3
"""Machine sizes, and rad: after a Newton step of this size nothing is near by."""

FINE, SMALL = 2e-15, 1e-8
"""Machine sizes, and rad: a Newton step this small is the last; one that is no smaller than half the one before it is
rounding, if it is at least that small."""

NEAR = 0.1
"""Of the coordinate's unit: steps by which a start is reached."""

BRANCH = 0.05
"""Machine sizes, and rad: poses that close farther from where they were expected may be on another branch."""

SINGULAR = 1e-11
"""A pivot below this fraction of its row has vanished."""

OWN, PULL, GRIP, EASE, SPINDLE, DRAG, FIRST = range(7)
"""Columns along a coordinate q: -I'/2I, -V'/I, J'/2I, 1/I, J, the slope of dampers' force by q' over I; from FIRST on
those of programmed loads over I, then value and slope of each gauge.

T = I q'^2 / 2, so q'' is OWN q'^2 + PULL + GRIP w^2 + DRAG q' and more. PULL has the spindle's turning in it where that
never changes."""


class Plan(NamedTuple):
    """What there is to sample. rows: the joints', and last the coordinate's; free: coordinates (of poses.ravel()) that
    may change; units and mass (3 bodies,) of all of them; scales (rows,): what makes openings relative; loads apart by
    kind; sizes (gauges,): what they are relative to; limits (n, 3): gauge, low, high.

    squared (rad2/s2) is the spindle's speed where it never changes, else below nought; unit, second and size are what
    the coordinate, times and lengths are relative to; low and high bound the coordinate. plain: OWN and PULL are all
    that acts.
    """

    rows: Rows
    wraps: bool
    free: IntArray
    units: FloatArray
    scales: FloatArray
    mass: FloatArray
    bodies: RecordArray
    gravity: float
    centrifugal: bool
    springs: RecordArray
    dampers: RecordArray
    driven: RecordArray
    programs: IntArray
    gauges: Rows
    sizes: FloatArray
    pulls: RecordArray
    limits: FloatArray
    squared: float
    unit: float
    second: float
    size: float
    low: float
    high: float
    turn: float
    plain: bool


class Bench(NamedTuple):
    """Room to work in; pivot (1,): how independent the rows were at the place last closed."""

    line: FloatArray
    gradient: FloatArray
    seen: FloatArray
    leaning: FloatArray
    matrix: FloatArray
    order: IntArray
    right: FloatArray
    found: FloatArray
    answer: FloatArray
    every: FloatArray
    pivot: FloatArray
    load: FloatArray
    still: FloatArray
    cubics: FloatArray


def make_bench(plan: Plan) -> Bench:
    """Room for samples of this plan."""
    rows, bodies, gauges = len(plan.rows.table), len(plan.bodies), len(plan.gauges.table)
    return Bench(
        line=np.zeros((rows, 5)),
        gradient=np.zeros((rows, 2, 3)),
        seen=np.zeros((gauges, 5)),
        leaning=np.zeros((gauges, 2, 3)),
        matrix=np.zeros((rows, len(plan.free))),
        order=np.zeros(rows, dtype=np.int64),
        right=np.zeros(rows),
        found=np.zeros(3 * bodies),
        answer=np.zeros(len(plan.free)),
        every=np.zeros(3 * bodies),
        pivot=np.zeros(1),
        load=np.zeros((bodies, 3)),
        still=np.zeros((bodies, 3)),
        cubics=np.zeros((int(np.max(plan.programs, initial=0)) + 1, 5)),
    )


@kernel
def _eliminate(matrix: FloatArray, order: IntArray) -> float:
    """Factors in place, rows in an order of their own; the least pivot, which is nought where rows are too few."""
    rows, columns = matrix.shape
    least = math.inf
    for i in range(rows):
        order[i] = i
    for c in range(columns):
        best = c
        for i in range(c + 1, rows):
            if abs(matrix[i, c]) > abs(matrix[best, c]):
                best = i
        if best != c:
            order[c], order[best] = order[best], order[c]
            for k in range(columns):
                matrix[c, k], matrix[best, k] = matrix[best, k], matrix[c, k]
        pivot = matrix[c, c]
        least = min(least, abs(pivot))
        if not least > SINGULAR:
            return 0.0
        for i in range(c + 1, rows):
            factor = matrix[i, c]
            if factor != 0.0:
                factor /= pivot
                matrix[i, c] = factor
                for k in range(c + 1, columns):
                    matrix[i, k] -= factor * matrix[c, k]
    return least


@kernel
def _solved(
    matrix: FloatArray,
    order: IntArray,
    right: FloatArray,
    free: IntArray,
    units: FloatArray,
    answer: FloatArray,
    found: FloatArray,
) -> float:
    """Fill found (3 bodies,) with what makes the factorised rows equal to right; its size, in units."""
    columns, size = free.size, 0.0
    for i in range(columns):
        total = right[order[i]]
        for k in range(i):
            total -= matrix[i, k] * answer[k]
        answer[i] = total
    for i in range(columns - 1, -1, -1):
        total = answer[i]
        for k in range(i + 1, columns):
            total -= matrix[i, k] * answer[k]
        answer[i] = total / matrix[i, i]
        found[free[i]] = units[free[i]] * answer[i]
        size = max(size, abs(answer[i]))
    return size


@kernel
def _fill(
    ends: IntArray,
    gradient: FloatArray,
    scales: FloatArray,
    free: IntArray,
    units: FloatArray,
    every: FloatArray,
    matrix: FloatArray,
) -> None:
    """Fill the matrix (rows, free) with gradients in units of rows and coordinates; every (3 bodies,) is room, and
    nought before and after."""
    for i in range(ends.shape[0]):
        for side in range(2):
            body = ends[i, side]
            if body >= 0:
                for c in range(3):
                    every[3 * body + c] += scales[i] * gradient[i, side, c] * units[3 * body + c]
        for k in range(free.size):
            matrix[i, k] = every[free[k]]
        for side in range(2):
            body = ends[i, side]
            if body >= 0:
                for c in range(3):
                    every[3 * body + c] = 0.0


@kernel
def placed(plan: Plan, bench: Bench, q: float, place: FloatArray) -> bool:
    """Close place[0] (poses) at a value of the coordinate, from a guess; fill in its two derivatives."""
    rows, free, units, scales, line, gradient = (
        plan.rows,
        plan.free,
        plan.units,
        plan.scales,
        bench.line,
        bench.gradient,
    )
    matrix, order, right, found, answer = bench.matrix, bench.order, bench.right, bench.found, bench.answer
    poses, moving, every, ends = place[0].reshape(-1, 3), place[1].reshape(-1, 3), bench.every, rows.ends
    last, before = right.size - 1, math.inf
    for _ in range(STEPS):
        line[:, ASKED] = 0.0
        evaluate(rows, poses, bench.still, line, gradient)
        for i in range(last):
            right[i] = -line[i, OPENING] * scales[i]
        off = line[last, OPENING] - q
        if plan.wraps:
            off -= 2.0 * math.pi * math.floor(off / (2.0 * math.pi) + 0.5)
        right[last] = -off * scales[last]
        _fill(ends, gradient, scales, free, units, every, matrix)
        bench.pivot[0] = _eliminate(matrix, order)
        if bench.pivot[0] == 0.0:
            return False
        step = _solved(matrix, order, right, free, units, answer, found)
        if not step < LOST:
            return False
        for k in range(units.size):
            place[0, k] += found[k]
        if step <= FINE or (step < SMALL and step >= 0.5 * before):
            break
        before = step
    else:
        return False
    right[:] = 0.0
    right[last] = scales[last]
    _solved(matrix, order, right, free, units, answer, place[1])
    line[:, ASKED_BEND] = 0.0
    evaluate(rows, poses, moving, line, gradient)
    for i in range(last + 1):
        right[i] = line[i, BEND] * scales[i]
    _solved(matrix, order, right, free, units, answer, place[2])
    return True


@compiled
def reach(plan: Plan, bench: Bench, q: float, poses: FloatArray) -> bool:
    """Bring poses (bodies, 3) that all but close the joints to a value of the coordinate, by steps of NEAR."""
    place, moved = np.zeros((3, plan.units.size)), np.zeros(plan.units.size)
    place[0] = poses.ravel()
    bench.line[:] = 0.0
    evaluate(plan.rows, poses, bench.still, bench.line, bench.gradient)
    start = bench.line[plan.rows.table.size - 1, OPENING]
    steps = max(1, math.ceil(abs(q - start) / (NEAR * plan.unit)))
    here = start
    for k in range(steps + 1):
        there = start + (q - start) * k / steps
        for c in range(plan.units.size):
            place[0, c] += (there - here) * place[1, c]
        moved[:] = place[0]
        if not placed(plan, bench, there, place):
            return False
        for c in range(plan.units.size):
            if not abs(place[0, c] - moved[c]) < BRANCH * plan.units[c]:
                return False
        here = there
    poses[:] = place[0].reshape(-1, 3)
    return True


@kernel
def sampled(plan: Plan, bench: Bench, place: FloatArray, columns: FloatArray) -> None:
    """Fill columns with what follows from a place (3, 3 bodies)."""
    poses, ahead = place[0].reshape(-1, 3), place[1].reshape(-1, 3)
    inertia = growth = 0.0
    for k in range(plan.mass.size):
        inertia += plan.mass[k] * place[1, k] * place[1, k]
        growth += 2.0 * plan.mass[k] * place[1, k] * place[2, k]
    steady = plan.centrifugal and plan.squared >= 0.0
    body_forces(plan.bodies, plan.gravity, steady, poses, plan.squared, bench.load)
    add_loads(plan.springs, poses, bench.still, bench.cubics, 0.0, bench.load)
    add_acts(plan.gauges, plan.pulls, poses, bench.still, bench.cubics, 0.0, bench.seen, bench.leaning, bench.load)
    columns[OWN] = -0.5 * growth / inertia
    columns[PULL] = _along(bench.load, place[1]) / inertia
    if columns.size == EASE:
        return
    columns[GRIP] = 0.0
    if plan.centrifugal and not steady:
        body_forces(plan.bodies, 0.0, True, poses, 1.0, bench.load)
        columns[GRIP] = _along(bench.load, place[1]) / inertia
    columns[EASE], columns[SPINDLE] = 1.0 / inertia, inertia_of(plan.bodies, poses)
    bench.load[:] = 0.0
    add_loads(plan.dampers, poses, ahead, bench.cubics, 0.0, bench.load)
    columns[DRAG] = _along(bench.load, place[1]) / inertia
    at = FIRST
    for program in plan.programs:
        bench.load[:] = 0.0
        bench.cubics[program, 3] = 1.0
        add_loads(plan.driven, poses, bench.still, bench.cubics, 0.0, bench.load)
        bench.cubics[program, 3] = 0.0
        columns[at] = _along(bench.load, place[1]) / inertia
        at += 1
    evaluate(plan.gauges, poses, ahead, bench.seen, bench.leaning)
    for k in range(plan.gauges.table.size):
        columns[at] = bench.seen[k, OPENING]
        columns[at + 1] = gauge_rate(plan.gauges, bench.leaning, k, ahead)
        at += 2


@kernel
def _along(load: FloatArray, ahead: FloatArray) -> float:
    total, flat = 0.0, load.ravel()
    for k in range(ahead.size):
        total += flat[k] * ahead[k]
    return total

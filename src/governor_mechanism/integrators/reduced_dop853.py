"""One step of DOP853 for one coordinate and its rate, its error, and what lies within it; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.tableau import (
    DENSE_NODES,
    DENSE_STAGES,
    DENSE_WEIGHTS,
    ERROR_3,
    ERROR_5,
    NODES,
    STAGES,
    WEIGHTS,
)
from governor_mechanism.mechanics.reduction.equation_of_motion import FLOWS, Line, accelerated
from governor_mechanism.mechanics.reduction.lowering import PLAIN
from governor_mechanism.mechanics.reduction.node_evaluation import OWN, PULL
from governor_mechanism.mechanics.reduction.table import piece_of
from governor_mechanism.numerics.chebyshev import powers, powers_inlined
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, IntArray

FROM = np.array([1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3, 5])
"""The first stage after stage 0 that counts in each, and in the step itself: those between have no weight."""


class Stages(NamedTuple):
    """Rates (16,) and accelerations (16,) at the stages of a step, and what flows (16, FLOWS); room for the inside of
    a step (2 + FLOWS, 7); last (1,), the coordinate at the stage before its end."""

    rates: FloatArray
    bends: FloatArray
    flows: FloatArray
    dense: FloatArray
    last: FloatArray


def make_stages() -> Stages:
    """Room for a step."""
    return Stages(np.zeros(16), np.zeros(16), np.zeros((16, FLOWS)), np.zeros((2 + FLOWS, 7)), np.zeros(1))


@kernel
def stepped(
    line: Line, since: float, h: float, q: float, v: float, near: int, stages: Stages
) -> tuple[float, float, int, int]:
    """Coordinate and rate a step h later, from stages[0]; the piece they are on, and -1.

    Where none is laid, the side to lay one on stands in place of that.
    """
    if line.numbers[PLAIN] != 0.0:
        return _plainly(line.table, line.edges, line.beside, line.ring, h, q, v, near, stages.rates, stages.bends)
    ahead, rate, side = q, v, -1
    for stage in range(1, 13):
        way, gain, node = _summed(stage, stages.rates, stages.bends)
        ahead, rate = q + h * way, v + h * gain
        near, t, side = piece_of(line.edges, line.beside, line.ring, ahead, near)
        if side >= 0:
            break
        if stage == 11:
            stages.last[0] = ahead
        stages.rates[stage] = rate
        stages.bends[stage] = accelerated(line, near, t, rate, since + node * h, stages.flows, stage)
    return ahead, rate, near, side


@kernel
def _plainly(
    table: FloatArray,
    edges: FloatArray,
    beside: IntArray,
    ring: FloatArray,
    h: float,
    q: float,
    v: float,
    near: int,
    rates: FloatArray,
    bends: FloatArray,
) -> tuple[float, float, int, int]:
    """The same where the first two columns are all that acts, in one loop without calls: five times as fast."""
    ahead, rate, side, round_again = q, v, -1, ring[0] > 0.0
    for stage in range(1, 13):
        if stage < 12:
            way, gain = STAGES[stage, 0] * rates[0], STAGES[stage, 0] * bends[0]
            for k in range(FROM[stage], stage):
                way += STAGES[stage, k] * rates[k]
                gain += STAGES[stage, k] * bends[k]
        else:
            way, gain = WEIGHTS[0] * rates[0], WEIGHTS[0] * bends[0]
            for k in range(5, 12):
                way += WEIGHTS[k] * rates[k]
                gain += WEIGHTS[k] * bends[k]
        ahead, rate = q + h * way, v + h * gain
        t = (ahead - edges[near, 2]) * edges[near, 3]
        if round_again or abs(t) > 1.0:
            near, t, side = piece_of(edges, beside, ring, ahead, near)
            if side >= 0:
                break
        rates[stage] = rate
        bends[stage] = powers_inlined(table, near, OWN, t) * rate * rate + powers_inlined(table, near, PULL, t)
    return ahead, rate, near, side


@kernel
def _summed(stage: int, rates: FloatArray, bends: FloatArray) -> tuple[float, float, float]:
    """The weighed means of rates and accelerations up to a stage, and its part of the step; stage 12 is its end."""
    if stage < 12:
        node, way, gain = NODES[stage], STAGES[stage, 0] * rates[0], STAGES[stage, 0] * bends[0]
        for k in range(FROM[stage], stage):
            way += STAGES[stage, k] * rates[k]
            gain += STAGES[stage, k] * bends[k]
    else:
        node, way, gain = 1.0, WEIGHTS[0] * rates[0], WEIGHTS[0] * bends[0]
        for k in range(5, 12):
            way += WEIGHTS[k] * rates[k]
            gain += WEIGHTS[k] * bends[k]
    return way, gain, node


@kernel
def error_of(
    flows: FloatArray, rates: FloatArray, bends: FloatArray, unit: float, second: float, energy: float, h: float
) -> float:
    """The error of a step, each number relative to its scale, as Hairer combines those of order 5 and 3."""
    fifth, third = _errors(rates, bends, 1.0 / unit, second / unit)
    for c in range(FLOWS):
        column, scale = flows[:, c], 1.0 if c == FLOWS - 1 else 1.0 / energy
        five, three = _errors(column, column, scale, 0.0)
        fifth, third = fifth + five, third + three
    return _combined(fifth, third, h, 2.0 + FLOWS)


@kernel
def plain_error(rates: FloatArray, bends: FloatArray, unit: float, second: float, h: float) -> float:
    """The same where nothing flows."""
    fifth, third = _errors(rates, bends, 1.0 / unit, second / unit)
    return _combined(fifth, third, h, 2.0)


@kernel
def _errors(one: FloatArray, other: FloatArray, scale: float, other_scale: float) -> tuple[float, float]:
    """The squares of the errors of order 5 and 3 of two numbers, per second, summed."""
    five = three = other_five = other_three = 0.0
    for k in range(12):
        five += ERROR_5[k] * one[k]
        three += ERROR_3[k] * one[k]
        other_five += ERROR_5[k] * other[k]
        other_three += ERROR_3[k] * other[k]
    fifth = (five * scale) ** 2 + (other_five * other_scale) ** 2
    return fifth, (three * scale) ** 2 + (other_three * other_scale) ** 2


@kernel
def _combined(fifth: float, third: float, h: float, count: float) -> float:
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * count)


@kernel
def decay_of(rates: FloatArray, bends: FloatArray, last: FloatArray, ahead: float, rate: float) -> float:
    """The fastest rate (1/s) at which neighbouring motions come together, as the last two stages tell it."""
    slope = (rates[12] - rates[11]) ** 2 + (bends[12] - bends[11]) ** 2
    apart = (ahead - last[0]) ** 2 + (rate - rates[11]) ** 2
    return math.sqrt(slope / apart) if apart > 0.0 else 0.0


@kernel
def opened(
    line: Line, since: float, h: float, q: float, v: float, ahead: float, rate: float, near: int, stages: Stages
) -> int:
    """Prepare stages.dense for what lies within a step, of three more evaluations; -1, or the side to lay on."""
    rates, bends, flows, dense = stages.rates, stages.bends, stages.flows, stages.dense
    table, edges, beside, ring, plain = line.table, line.edges, line.beside, line.ring, line.numbers[PLAIN] != 0.0
    for extra in range(3):
        way = gain = 0.0
        for k in range(13 + extra):
            way += DENSE_STAGES[extra, k] * rates[k]
            gain += DENSE_STAGES[extra, k] * bends[k]
        near, t, side = piece_of(edges, beside, ring, q + h * way, near)
        if side >= 0:
            return side
        moving = v + h * gain
        rates[13 + extra] = moving
        if plain:
            bends[13 + extra] = powers(table, near, OWN, t) * moving * moving + powers(table, near, PULL, t)
        else:
            later = since + DENSE_NODES[extra] * h
            bends[13 + extra] = accelerated(line, near, t, moving, later, flows, 13 + extra)
    _prepared(rates, ahead - q, h, dense, 0)
    _prepared(bends, rate - v, h, dense, 1)
    for c in range(0 if plain else FLOWS):
        column = flows[:, c]
        _prepared(column, h * gained(column), h, dense, 2 + c)
    return -1


@kernel
def gained(slopes: FloatArray) -> float:
    """The step's mean of something whose slopes are known at its stages."""
    total = WEIGHTS[0] * slopes[0]
    for k in range(5, 12):
        total += WEIGHTS[k] * slopes[k]
    return float(total)


@kernel
def _prepared(slopes: FloatArray, change: float, h: float, dense: FloatArray, at: int) -> None:
    dense[at, 0] = change
    dense[at, 1] = h * slopes[0] - change
    dense[at, 2] = 2.0 * change - h * (slopes[12] + slopes[0])
    for r in range(4):
        total = 0.0
        for k in range(16):
            total += DENSE_WEIGHTS[r, k] * slopes[k]
        dense[at, 3 + r] = h * total


@kernel
def within(dense: FloatArray, at: int, part: float) -> float:
    """The change from the step's beginning to a part of it."""
    p, rest = part, 1.0 - part
    total = (dense[at, 6] * p + dense[at, 5]) * rest + dense[at, 4]
    return float(((((total * p + dense[at, 3]) * rest + dense[at, 2]) * p + dense[at, 1]) * rest + dense[at, 0]) * p)

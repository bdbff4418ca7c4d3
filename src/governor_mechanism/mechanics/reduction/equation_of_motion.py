"""The second derivative of one coordinate at a value, a rate and a moment, and what flows meanwhile; compiled."""

from __future__ import annotations

from typing import NamedTuple

from governor_mechanism.mechanics.dynamics.equations_of_motion import free_spindle_speed, uneven_speed
from governor_mechanism.mechanics.dynamics.output_forces import brake_force, spring_force
from governor_mechanism.mechanics.reduction.lowering import (
    FREE,
    PLAIN,
    PROGRAMS,
    SPINDLE_INERTIA,
    TURNS,
    UNEVEN,
    WAVES,
    Acts,
)
from governor_mechanism.mechanics.reduction.node_evaluation import DRAG, EASE, FIRST, GRIP, OWN, PULL, SPINDLE
from governor_mechanism.mechanics.reduction.table import Laid
from governor_mechanism.numerics.chebyshev import powers
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, IntArray

FLOWS = 3
"""Numbers beside coordinate and rate: work (J) as in `State`, what brakes and friction took of it (J), and the angle
(rad) of the spindle. Nothing depends on them."""

HELD = 0
"""Where a mode (1 + keepers + springs,) tells whether all stands still; after it stand the sign of each keeper's
sliding, and whether each one-sided spring pulls."""


class Line(NamedTuple):
    """Laid pieces and what acts along them, in few arrays; see `Laid`, `Acts`. cubics (programs, 5) of the time since
    a beginning; mode as HELD tells."""

    table: FloatArray
    edges: FloatArray
    beside: IntArray
    ring: FloatArray
    numbers: FloatArray
    springs: FloatArray
    brakes: FloatArray
    keepers: FloatArray
    cubics: FloatArray
    mode: IntArray


def make_line(laid: Laid, acts: Acts, cubics: FloatArray, mode: IntArray) -> Line:
    """What is stepped along, from the time at which the cubics begin."""
    return Line(laid.table, laid.edges, laid.beside, laid.ring, *acts, cubics, mode)


@kernel
def now(cubics: FloatArray, program: int, since: float) -> float:
    """A program's value."""
    a, b, c, d = cubics[program, 0], cubics[program, 1], cubics[program, 2], cubics[program, 3]
    return float(((a * since + b) * since + c) * since + d)


@kernel
def spindle_at(numbers: FloatArray, cubics: FloatArray, since: float, inertia: float) -> tuple[float, float, float]:
    """Speed (rad/s) of the spindle, its given slope (rad/s2), and the torque (N m) on a free one.

    cubics[0] are of the given speed, or of that torque; its integral from 0 s, with the momentum at the start, is the
    momentum.
    """
    a, b, c, d = cubics[0, 0], cubics[0, 1], cubics[0, 2], cubics[0, 3]
    value = ((a * since + b) * since + c) * since + d
    whole = cubics[0, 4] + (((0.25 * a * since + b / 3.0) * since + 0.5 * c) * since + d) * since
    if numbers[FREE] != 0.0:
        return free_spindle_speed(whole, numbers[SPINDLE_INERTIA] + inertia), 0.0, value
    growth = (3.0 * a * since + 2.0 * b) * since + c
    if numbers[UNEVEN] == 0.0:
        return value, growth, 0.0
    speed, slope = uneven_speed(numbers[UNEVEN], numbers[WAVES], whole, value, growth)
    return speed, slope, 0.0


@kernel
def pulled(
    line: Line, piece: int, t: float, v: float, since: float, rubbing: bool, flows: FloatArray, at: int
) -> float:
    """The acceleration of everything that acts, friction among it or left out; fills flows[at] (FLOWS,) per second."""
    table, numbers, mode = line.table, line.numbers, line.mode
    ease, spindle = powers(table, piece, EASE, t), powers(table, piece, SPINDLE, t)
    drag = powers(table, piece, DRAG, t)
    omega, growth, torque = spindle_at(numbers, line.cubics, since, spindle)
    found = powers(table, piece, OWN, t) * v * v + powers(table, piece, PULL, t) + drag * v
    found += powers(table, piece, GRIP, t) * omega * omega
    power, lost, column = drag * v * v / ease, 0.0, FIRST
    for program in range(1, 1 + int(numbers[PROGRAMS])):
        push = now(line.cubics, program, since) * powers(table, piece, column, t)
        found += push
        power += push * v / ease
        column += 1
    for i in range(line.springs.shape[0]):
        if mode[1 + line.keepers.shape[0] + i] != 0:
            gauge = column + 2 * int(line.springs[i, 0])
            pull = spring_force(line.springs[i, 1], line.springs[i, 2], powers(table, piece, gauge, t))
            found -= pull * powers(table, piece, gauge + 1, t) * ease
    for i in range(line.brakes.shape[0]):
        slope = powers(table, piece, column + 2 * int(line.brakes[i, 0]) + 1, t)
        pull = brake_force(line.brakes[i, 1], line.brakes[i, 2], slope * v)
        found -= pull * slope * ease
        lost += pull * slope * v
    for i in range(line.keepers.shape[0] if rubbing else 0):
        if mode[1 + i] != 0:
            slope = powers(table, piece, column + 2 * int(line.keepers[i, 0]) + 1, t)
            pull = mode[1 + i] * now(line.cubics, int(line.keepers[i, 1]), since)
            found -= pull * slope * ease
            lost += pull * slope * v
    flows[at, 0] = lost - power - torque * omega
    if growth != 0.0 and numbers[TURNS] != 0.0:
        flows[at, 0] += spindle * omega * growth
    flows[at, 1], flows[at, 2] = lost, omega
    return float(found)


@kernel
def accelerated(line: Line, piece: int, t: float, v: float, since: float, flows: FloatArray, at: int) -> float:
    """The acceleration on a piece; nought where all is held."""
    if line.numbers[PLAIN] != 0.0:
        return powers(line.table, piece, OWN, t) * v * v + powers(line.table, piece, PULL, t)
    found = pulled(line, piece, t, v, since, True, flows, at)
    return 0.0 if line.mode[HELD] != 0 else found


@kernel
def gauge_at(line: Line, piece: int, t: float, gauge: float) -> tuple[float, float]:
    """Value of a gauge and its slope along the coordinate."""
    column = FIRST + int(line.numbers[PROGRAMS]) + 2 * int(gauge)
    return powers(line.table, piece, column, t), powers(line.table, piece, column + 1, t)


@kernel
def resisting(line: Line, piece: int, t: float, since: float) -> float:
    """The generalised force up to which friction holds."""
    total = 0.0
    for i in range(line.keepers.shape[0]):
        if line.keepers[i, 1] >= 0:
            slope = gauge_at(line, piece, t, line.keepers[i, 0])[1]
            total += now(line.cubics, int(line.keepers[i, 1]), since) * abs(slope)
    return float(total)


@kernel
def drawn(line: Line, piece: int, t: float, since: float, flows: FloatArray) -> float:
    """The generalised force at rest, less friction; flows (1, FLOWS) is room."""
    return float(pulled(line, piece, t, 0.0, since, False, flows, 0) / powers(line.table, piece, EASE, t))

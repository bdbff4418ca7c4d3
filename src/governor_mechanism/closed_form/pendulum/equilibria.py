"""Where weight and centrifugal pull balance, V' = w^2 J' / 2: the speed for an arm angle, the angles for a speed.

The angles: the travel is scanned, cut where the moment turns, and every piece, monotone by then, is bisected to machine
precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.closed_form.arguments import Number, checked, refuse_where
from governor_mechanism.closed_form.pendulum.kinematics import (
    PendulumGovernor,
    Position,
    position,
    potential_slopes,
    spindle_slopes,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray


def balanced_squared(governor: PendulumGovernor, at: Position, moment: FloatArray) -> FloatArray:
    """The square of the spindle speed whose centrifugal pull holds `moment` (N m) on the arms."""
    shown = ("arm_angle", np.degrees(at.angle), "deg")
    clear = math.degrees(math.asin(max(-1.0, -governor.offset / governor.arm))) + 0.0  # no -0
    sentence = "the ball stands on the spindle axis or beyond it: no speed balances it"
    refuse_where(at.ball <= 0, sentence, shown, cure=f"keep arm_angle above {clear:g} deg")
    lever = spindle_slopes(governor, at)[0]
    sentence = "the centrifugal pull on balls and rods does not raise the arms: no speed balances them"
    refuse_where(lever <= 0, sentence, shown, cure="open the arms further")
    sentence = "no real equilibrium speed: weight and centrifugal pull turn the arms the same way"
    refuse_where(moment < 0, sentence, shown, cure="open the arms further")
    return 2 * moment / lever


def squared_speed(governor: PendulumGovernor, at: Position, spindle_speed: Number | None) -> FloatArray:
    """The square of the speed given, or of the equilibrium speed when none is given."""
    if spindle_speed is None:
        return balanced_squared(governor, at, potential_slopes(governor, at)[0])
    return checked(spindle_speed, "spindle_speed", "rad/s") ** 2


def equilibrium_angles(
    governor: PendulumGovernor, *, spindle_speed: float, lowest: float = -math.pi / 2, highest: float = math.pi / 2
) -> FloatArray:
    """All arm angles (rad, ascending) at which the governor rests at one spindle speed (rad/s), to machine precision.

    Searches the travel from lowest to highest, as far as the link reaches and the balls stay on their own side of the
    axis, so the rest of an open governor without offset hanging on the axis is not listed. Ends of the travel count.
    The array is empty when no angle balances. Raises MechanismError unless lowest < highest.
    Limit: an equilibrium whose speed curve turns twice within 1/500 of the travel may be overlooked.
    """
    speed = checked(spindle_speed, "spindle_speed", "rad/s")
    low, high = checked(lowest, "lowest", "rad"), checked(highest, "highest", "rad")
    if speed.ndim or low.ndim or high.ndim:
        raise MechanismError("spindle_speed, lowest and highest must each be one number")
    ends = (("lowest", np.degrees(low), "deg"), ("highest", np.degrees(high), "deg"))
    refuse_where(low >= high, "lowest must lie below highest", *ends)
    grid = _travel_grid(governor, float(low), float(high))
    if grid.size == 0:
        return grid
    turns = _roots_between(lambda angle: _balance(governor, speed, angle)[1], grid)
    knots = np.unique(np.concatenate([grid, turns]))
    moment, _, noise = _balance(governor, speed, knots)
    touching = np.abs(moment) <= noise
    crossing = _roots_between(lambda angle: _balance(governor, speed, angle)[0], knots, skip=touching)
    runs = np.split(np.flatnonzero(touching), np.flatnonzero(np.diff(np.flatnonzero(touching)) > 1) + 1)
    closest = [run[np.argmin(np.abs(moment[run]))] for run in runs if run.size]
    found: FloatArray = np.sort(np.concatenate([knots[np.array(closest, dtype=np.intp)], crossing]))
    return found[spindle_slopes(governor, position(governor, found))[0] > 0] if found.size else found


def _balance(
    governor: PendulumGovernor, speed: FloatArray, angle: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The moment that closes the arms, its slope and the moment that rounding can feign."""
    at = position(governor, angle)
    (weight, stiff), (lever, bend) = potential_slopes(governor, at), spindle_slopes(governor, at)
    pull, slope = speed**2 * lever / 2, stiff - speed**2 * bend / 2
    size, rounding = np.abs(weight) + np.abs(pull), 8 * np.finfo(np.float64).eps
    # of the moments and of the angle; the slope grows without bound where the link comes to the end of its reach
    noise = rounding * size + np.minimum(rounding * np.abs(slope * angle), 1e-6 * size)
    return weight - pull, slope, noise


def _travel_grid(governor: PendulumGovernor, lowest: float, highest: float) -> FloatArray:
    """Angles to scan: even over the travel and crowded at its ends, where the speed may grow without bound."""
    apart, l1, l2 = governor.offset - governor.lug_radius, governor.joint_length, governor.link_length
    low = math.asin(min(1.0, max(-1.0, -governor.offset / governor.arm, (-l2 - apart) / l1)))
    high = math.asin(max(-1.0, min(1.0, (l2 - apart) / l1)))
    low, high = max(low, lowest), min(high, highest)
    near = (high - low) * 10.0 ** np.arange(-16, -2.5, 0.25)
    upright = [0.0] if low <= 0.0 <= high else []
    grid = np.unique(np.concatenate([low + near, np.linspace(low, high, 513), upright, high - near]))
    reached = governor.is_rhombus | (np.abs((apart + l1 * np.sin(grid)) / l2) < 1.0)
    outside_axis = governor.offset + governor.arm * np.sin(grid) > 0
    kept: FloatArray = grid[reached & outside_axis & (np.abs(grid) < math.pi / 2)]
    return kept if low < high else kept[:0]


def _roots_between(
    function: Callable[[FloatArray], FloatArray], knots: FloatArray, skip: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Roots of a function monotone between knots, by bisection; knots that are roots are skipped or returned."""
    sign = np.sign(function(knots))
    on_knot = sign == 0 if skip is None else skip
    crossed = (sign[:-1] * sign[1:] < 0) & ~on_knot[:-1] & ~on_knot[1:]
    low, high, low_sign = knots[:-1][crossed], knots[1:][crossed], sign[:-1][crossed]
    for _ in range(100 if low.size else 0):
        middle = (low + high) / 2
        before = np.sign(function(middle)) == low_sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    roots = (low + high) / 2
    return roots if skip is not None else np.concatenate([knots[on_knot], roots])

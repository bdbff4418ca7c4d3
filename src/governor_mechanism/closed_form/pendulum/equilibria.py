"""Equilibria of the arms, V' = w^2 J' / 2: the speed at an arm angle, and the angles at a speed.

The angles are found by a scan of the travel. It is split where the moment has an extremum, and each monotone piece is bisected to
machine precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.closed_form.arguments import FloatOrArray, raise_where, validate_argument
from governor_mechanism.closed_form.pendulum.kinematics import (
    LinkageGeometry,
    PendulumGovernor,
    evaluate_geometry,
    potential_derivatives,
    spindle_inertia_derivatives,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray


def squared_balance_speed(governor: PendulumGovernor, geometry: LinkageGeometry, moment: FloatArray) -> FloatArray:
    """Return the square of the spindle speed (rad^2/s^2) at which the centrifugal load balances `moment` (N m) on the arms."""
    shown = ("arm_angle", np.degrees(geometry.angle), "deg")
    min_arm_angle_deg = math.degrees(math.asin(max(-1.0, -governor.offset / governor.arm))) + 0.0  # no -0
    message = "the ball is on or beyond the spindle axis: no speed balances it"
    raise_where(geometry.ball_radius <= 0, message, shown, hint=f"keep arm_angle above {min_arm_angle_deg:g} deg")
    inertia_derivative = spindle_inertia_derivatives(governor, geometry)[0]
    message = "the centrifugal load does not raise the arms: no speed balances them"
    raise_where(inertia_derivative <= 0, message, shown, hint="open the arms further")
    message = "no real equilibrium speed: weight and centrifugal load turn the arms in the same direction"
    raise_where(moment < 0, message, shown, hint="open the arms further")
    return 2 * moment / inertia_derivative


def squared_given_or_equilibrium_speed(
    governor: PendulumGovernor, geometry: LinkageGeometry, spindle_speed: FloatOrArray | None
) -> FloatArray:
    """Return the square of the given spindle speed, or of the equilibrium speed if none is given (rad^2/s^2)."""
    if spindle_speed is None:
        return squared_balance_speed(governor, geometry, potential_derivatives(governor, geometry)[0])
    return validate_argument(spindle_speed, "spindle_speed", "rad/s") ** 2


def equilibrium_angles(
    governor: PendulumGovernor, *, spindle_speed: float, lowest: float = -math.pi / 2, highest: float = math.pi / 2
) -> FloatArray:
    """Return all arm angles at which the governor is in equilibrium at one spindle speed.

    The search covers the part of the range that the link reaches and in which the balls are on their own side of the axis. The equilibrium
    of an open governor without offset whose balls hang on the axis is therefore not included. The ends of the range are included. An
    equilibrium may be missed where the speed curve has two extrema within 1/500 of the range.

    Parameters
    ----------
    governor
        Dimensions and masses.
    spindle_speed
        Spindle speed, rad/s.
    lowest
        Lower end of the search range, rad.
    highest
        Upper end of the search range, rad.

    Returns
    -------
    FloatArray
        Arm angles, rad, ascending, to machine precision; empty if there is no equilibrium.

    Raises
    ------
    MechanismError
        If an argument is not one finite number, or lowest is not below highest.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    low, high = validate_argument(lowest, "lowest", "rad"), validate_argument(highest, "highest", "rad")
    if speed.ndim or low.ndim or high.ndim:
        raise MechanismError("spindle_speed, lowest and highest must each be one number")
    ends = (("lowest", np.degrees(low), "deg"), ("highest", np.degrees(high), "deg"))
    raise_where(low >= high, "lowest must be below highest", *ends)
    grid = _travel_grid(governor, float(low), float(high))
    if grid.size == 0:
        return grid
    turning_points = _bisect_between(lambda angle: _moment_balance(governor, speed, angle)[1], grid)
    knots = np.unique(np.concatenate([grid, turning_points]))
    moment, _, noise = _moment_balance(governor, speed, knots)
    is_root = np.abs(moment) <= noise
    bracketed_roots = _bisect_between(lambda angle: _moment_balance(governor, speed, angle)[0], knots, skip_knots=is_root)
    root_groups = np.split(np.flatnonzero(is_root), np.flatnonzero(np.diff(np.flatnonzero(is_root)) > 1) + 1)
    root_indices = [group[np.argmin(np.abs(moment[group]))] for group in root_groups if group.size]
    angles: FloatArray = np.sort(np.concatenate([knots[np.array(root_indices, dtype=np.intp)], bracketed_roots]))
    return angles[spindle_inertia_derivatives(governor, evaluate_geometry(governor, angles))[0] > 0] if angles.size else angles


def _moment_balance(governor: PendulumGovernor, speed: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the closing moment on the arms (N m), its derivative (N m/rad) and the bound of its rounding error (N m)."""
    geometry = evaluate_geometry(governor, angle)
    potential_derivative, potential_second_derivative = potential_derivatives(governor, geometry)
    inertia_derivative, inertia_second_derivative = spindle_inertia_derivatives(governor, geometry)
    centrifugal_moment = speed**2 * inertia_derivative / 2
    stiffness = potential_second_derivative - speed**2 * inertia_second_derivative / 2
    moment_scale, rounding = np.abs(potential_derivative) + np.abs(centrifugal_moment), 8 * np.finfo(np.float64).eps
    # Rounding of the moments and of the angle; the stiffness is unbounded where the link is at the end of its reach.
    noise = rounding * moment_scale + np.minimum(rounding * np.abs(stiffness * angle), 1e-6 * moment_scale)
    return potential_derivative - centrifugal_moment, stiffness, noise


def _travel_grid(governor: PendulumGovernor, lowest: float, highest: float) -> FloatArray:
    """Return the scan angles (rad): uniform over the travel, graded at its ends, where the speed may grow without bound."""
    radius_offset, l1, l2 = governor.offset - governor.lug_radius, governor.joint_length, governor.link_length
    low = math.asin(min(1.0, max(-1.0, -governor.offset / governor.arm, (-l2 - radius_offset) / l1)))
    high = math.asin(max(-1.0, min(1.0, (l2 - radius_offset) / l1)))
    low, high = max(low, lowest), min(high, highest)
    end_spacing = (high - low) * 10.0 ** np.arange(-16, -2.5, 0.25)
    vertical_angle = [0.0] if low <= 0.0 <= high else []
    grid = np.unique(np.concatenate([low + end_spacing, np.linspace(low, high, 513), vertical_angle, high - end_spacing]))
    is_reachable = governor.is_rhombus | (np.abs((radius_offset + l1 * np.sin(grid)) / l2) < 1.0)
    is_outside_axis = governor.offset + governor.arm * np.sin(grid) > 0
    valid_angles: FloatArray = grid[is_reachable & is_outside_axis & (np.abs(grid) < math.pi / 2)]
    return valid_angles if low < high else valid_angles[:0]


def _bisect_between(
    function: Callable[[FloatArray], FloatArray], knots: FloatArray, skip_knots: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the roots of a function that is monotone between knots, by bisection; roots at knots are returned or, if given, skipped."""
    sign = np.sign(function(knots))
    on_knot = sign == 0 if skip_knots is None else skip_knots
    has_sign_change = (sign[:-1] * sign[1:] < 0) & ~on_knot[:-1] & ~on_knot[1:]
    low, high, low_sign = knots[:-1][has_sign_change], knots[1:][has_sign_change], sign[:-1][has_sign_change]
    for _ in range(100 if low.size else 0):
        middle = (low + high) / 2
        root_above_middle = np.sign(function(middle)) == low_sign
        low, high = np.where(root_above_middle, middle, low), np.where(root_above_middle, high, middle)
    roots = (low + high) / 2
    return roots if skip_knots is not None else np.concatenate([knots[on_knot], roots])

"""Effort, lift and power of a governor for a relative change of speed.

In equilibrium at w the load V' is balanced by J' w^2 / 2 (coordinate q, potential V, moment of inertia J about the spindle). If the speed
rises to (1 + p) w and the sleeve is held, the force ((1 + p)^2 - 1) V' / s' along its reading s holds it. Were the sleeve let go, it would
rise to the position whose equilibrium speed is (1 + p) w, and the force would fall to zero on the way. The *effort* is the mean of both,
(p + p^2 / 2) V' / s'; the *power* is the effort times that rise of the sleeve (Th. Bevan, The Theory of Machines, chapter on governors; he
neglects p^2 beside 2 p).
"""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.numerics.roots import find_roots
from governor_mechanism.statics.adaptive_grid import sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import REMOVABLE_SINGULARITY_TOLERANCE, equilibrium_speed_squared
from governor_mechanism.types import FloatArray
from governor_mechanism.units.text_table import short_repr

POSITION_TOLERANCE = 1e-12
"""Last Newton step of the risen position, in scales of the coordinate: rounding of the assembly, with room."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorEffort:
    """Effort, lift and power for a relative change of speed, at positions of equilibrium; arrays of shape (n,)."""

    speed_change: float  # relative increase p of the speed
    against: str  # name of the reading of the sleeve
    # mean force at the sleeve while it yields to the change of speed, N or N m; 0 where there is no
    # equilibrium speed
    effort: FloatArray
    lift: FloatArray  # travel of the sleeve to the equilibrium at the increased speed, m or rad; 0 where `has_lift` is false
    power: FloatArray  # effort times lift, J; 0 where `has_lift` is false
    # whether the position is stable and the equilibrium at the increased speed lies within the travel, before
    # any fold
    has_lift: NDArray[np.bool_]

    __repr__ = short_repr


def evaluate_effort(
    reduction: SingleDofReduction,
    coefficients: PathCoefficients,  # Lagrangian coefficients at the positions; shape (n,)
    # whether a position is one of stable equilibrium at its equilibrium speed; shape (n,)
    stable: NDArray[np.bool_],
    speed_change: float,
    against: str,
) -> GovernorEffort:
    """Return effort, lift and power at positions."""
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    sleeve_load = np.where(speed_squared > 0.0, np.abs(_force_along(reduction, coefficients, against)), 0.0)
    effort = speed_change * (1.0 + 0.5 * speed_change) * sleeve_load
    risen, has_lift = _find_risen_positions(reduction, coefficients, np.where(stable, speed_squared, 0.0), (1.0 + speed_change) ** 2)
    lift = np.zeros_like(effort)
    if has_lift.any():
        before, after = (
            evaluate_output_value(reduction.mechanism, against, along.poses)
            for along in (coefficients.select(np.flatnonzero(has_lift)), reduction.evaluate(risen[has_lift]))
        )
        lift[has_lift] = np.abs(after - before)
    return GovernorEffort(speed_change=speed_change, against=against, effort=effort, lift=lift, power=effort * lift, has_lift=has_lift)


def _force_along(reduction: SingleDofReduction, coefficients: PathCoefficients, name: str) -> FloatArray:
    """Return the load V' / s' along a reading s, N or N m; 0 at a turning point of the reading."""
    # Where V' and s' vanish together (arms that hang in line with the links), it is the limit V'' /
    # s''.
    output = evaluate_output(reduction.mechanism, name, coefficients.poses, coefficients.tangents)
    slope = output.rate(coefficients.tangents)
    curvature = output.acceleration(coefficients.curvatures)
    values = np.array([coefficients.potential_derivative, slope])
    derivatives = np.array([coefficients.potential_second_derivative, curvature])
    tolerance = REMOVABLE_SINGULARITY_TOLERANCE * reduction.coordinate_scale
    is_removable = np.all(np.abs(values) <= tolerance * np.abs(derivatives), axis=0)
    load, way = np.where(is_removable, derivatives, values)
    force: FloatArray = np.divide(load, way, out=np.zeros_like(way), where=way != 0.0)
    return force


def _find_risen_positions(
    reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: FloatArray, ratio: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return where the squared equilibrium speed (n,) has risen by a ratio on the same stable part of the curve, and whether it has."""
    # A position with speed_squared = 0 is left out.
    grid = sample_range_of_motion(reduction).sorted_coefficients
    nodes = grid.coordinate.tolist()
    node_speeds = equilibrium_speed_squared(grid, reduction.coordinate_scale).tolist()
    has_position, brackets = speed_squared > 0.0, np.zeros((len(speed_squared), 2))
    for index in np.flatnonzero(has_position):
        start = float(coefficients.coordinate[index]), float(speed_squared[index])
        # At a stable position the speed rises toward larger J, since the stiffness is J' d(w^2)/dq / 2.
        way = 1 if coefficients.spindle_inertia_derivative[index] > 0.0 else -1
        bracket = _bracket_speed(nodes, node_speeds, start, way, ratio * start[1])
        has_position[index] = bracket is not None
        brackets[index] = bracket or 0.0
    risen = np.zeros_like(speed_squared)
    if has_position.any():
        targets = ratio * speed_squared[has_position]

        def speed_excess(values: FloatArray) -> tuple[FloatArray, FloatArray]:
            along = reduction.evaluate(values)
            squares = equilibrium_speed_squared(along, reduction.coordinate_scale)
            stiffness = along.stiffness_terms(squares).sum(axis=0)
            slope = np.divide(2 * stiffness, along.spindle_inertia_derivative, out=np.zeros_like(squares), where=squares > 0.0)
            return squares - targets, slope

        low, high = brackets[has_position].T
        risen[has_position] = find_roots(speed_excess, low, high, POSITION_TOLERANCE * reduction.coordinate_scale)
    return risen, has_position


def _bracket_speed(
    nodes: list[float], node_speeds: list[float], start: tuple[float, float], way: int, target: float
) -> tuple[float, float] | None:
    """Return neighbouring coordinates between which the squared speed passes a target, from a start in a direction, or None."""
    position, speed = start
    index = bisect_right(nodes, position) if way > 0 else bisect_left(nodes, position) - 1
    while 0 <= index < len(nodes) and node_speeds[index] > speed:
        if node_speeds[index] >= target:
            low, high = sorted((position, nodes[index]))
            return low, high
        position, speed = nodes[index], node_speeds[index]
        index += way
    return None

"""Equations of a path of a coupler's point, and their solution from many starts at once.

A dyad is a fixed pivot, a link, and an arm from the moving pivot to the point. At each point of the path the arms of both dyads have
turned by one angle, and the moving pivots have the lengths of the links from the fixed ones. With nine points there are as many
equations as unknowns.

C. W. Wampler, A. P. Morgan, A. J. Sommese, Complete solution of the nine-point path synthesis problem for four-bar linkages, Journal of
Mechanical Design 114 (1992), pp. 153-159.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

import numpy as np

from governor_mechanism.types import ComplexArray, FloatArray, IntArray

FIRST_DAMPING: Final = 1e-2
MAX_DAMPING: Final = 1e8
"""Damping of Levenberg and Marquardt at the start, and beyond which a search has stalled; points are scaled to an extent of one."""

SOLVED_COST: Final = 1e-28
"""Sum of squared residuals at which a search ends."""

N_STEPS_BETWEEN: Final = 20
"""Number of steps after which searches that have ended are left out."""


class Linearised(NamedTuple):
    """Residuals, shape (starts, rows, points), and derivatives by the unknowns of a linkage (last axis) and by the angle at their point."""

    residual: FloatArray
    by_unknowns: FloatArray
    by_angles: FloatArray


class Equations(Protocol):
    """Equations in unknowns (starts, unknowns) and one angle for each point (starts, points)."""

    def __call__(self, unknowns: FloatArray, angles: FloatArray) -> Linearised:
        """Return residuals and derivatives."""
        ...


class DyadEquations:
    """Equations in pivots and arms (A, B, z1, z2 as x and y), lengths of links, and angles by which the arms have turned.

    With a timing, angles of the input from its first position, the angle at which the input starts is the last unknown.
    """

    PIVOTS: Final = slice(0, 4)
    LENGTHS: Final = slice(8, 10)

    def __init__(self, points: ComplexArray, timing: FloatArray | None = None) -> None:
        self.points, self.timing = points, timing

    def __call__(self, unknowns: FloatArray, angles: FloatArray) -> Linearised:
        """Return half the squared lengths of the links at all points less those asked for, or with a timing the gaps of the first."""
        fixed, arms = as_complex(unknowns[:, :8]).reshape(-1, 2, 2, 1).swapaxes(0, 1)
        turn = np.exp(1j * angles)
        rows = list[tuple[FloatArray, FloatArray, FloatArray]]()
        for dyad, length in enumerate(unknowns[:, self.LENGTHS].T[:, :, None]):
            arm = arms[:, dyad] * turn
            vector = self.points + arm - fixed[:, dyad]
            if dyad == 0 and self.timing is not None:
                link = np.exp(1j * (unknowns[:, 10:] + self.timing))
                cases = [(unit, np.real(unit * (vector - length * link)), -np.real(unit * link)) for unit in (1.0 + 0j, -1j)]
            else:
                cases = [(np.conj(vector), 0.5 * (np.abs(vector) ** 2 - length**2), -length)]
            for unit, residual, by_length in cases:
                slope = np.zeros((*angles.shape, unknowns.shape[1]))
                slope[:, :, 2 * dyad], slope[:, :, 2 * dyad + 1] = -np.real(unit), np.imag(unit)
                slope[:, :, 4 + 2 * dyad], slope[:, :, 5 + 2 * dyad] = np.real(unit * turn), -np.imag(unit * turn)
                slope[:, :, 8 + dyad] = by_length
                if len(cases) > 1:
                    slope[:, :, 10] = -np.real(unit * 1j * length * link)
                rows.append((residual, slope, np.real(unit * 1j * arm)))
        residual, by_unknowns, by_angles = (np.stack(parts, axis=1) for parts in zip(*rows, strict=True))
        by_angles[:, :, 0] = 0.0  # arms are given at the first point
        return Linearised(residual, by_unknowns, by_angles)


def as_complex(pairs: FloatArray) -> ComplexArray:
    """Return x and y, beside each other on the last axis, as complex numbers."""
    return pairs[..., ::2] + 1j * pairs[..., 1::2]


def minimise(
    equations: Equations,
    unknowns: FloatArray,
    angles: FloatArray,
    free: IntArray,  # numbers of the unknowns that may change
    n_steps: int,
    bound: float,  # largest absolute value of a free unknown
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return unknowns, angles and sums of squared residuals at the ends of searches by Levenberg and Marquardt."""
    unknowns, angles = unknowns.copy(), angles.copy()
    cost, damping = np.full(len(unknowns), np.inf), np.full(len(unknowns), FIRST_DAMPING)
    running = np.arange(len(unknowns))
    for _ in range(0, n_steps, N_STEPS_BETWEEN):
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # links in a line
            ends = _run_steps(equations, unknowns[running], angles[running], damping[running], free, bound)
        unknowns[running], angles[running], cost[running], damping[running] = ends
        running = running[(cost[running] > SOLVED_COST) & (damping[running] < MAX_DAMPING)]
        if not len(running):
            break
    return unknowns, angles, cost


def _run_steps(
    equations: Equations, unknowns: FloatArray, angles: FloatArray, damping: FloatArray, free: IntArray, bound: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return unknowns, angles, costs and damping some steps later; a step that does not lower the cost is not made."""
    state = equations(unknowns, angles)
    cost = _cost(state)
    for _ in range(N_STEPS_BETWEEN):
        step, turn = _find_step(state, damping, free)
        moved = unknowns.copy()
        moved[:, free] = np.clip(moved[:, free] + step, -bound, bound)
        turned = angles + turn
        new = equations(moved, turned)
        new_cost = _cost(new)
        is_better = new_cost < cost
        unknowns, angles, cost = (
            np.where(is_better.reshape(-1, *[1] * (old.ndim - 1)), changed, old)
            for changed, old in ((moved, unknowns), (turned, angles), (new_cost, cost))
        )
        state = Linearised(
            *(np.where(is_better.reshape(-1, *[1] * (old.ndim - 1)), changed, old) for changed, old in zip(new, state, strict=True))
        )
        damping = np.clip(np.where(is_better, 0.2 * damping, 4.0 * damping), 1e-13, 2.0 * MAX_DAMPING)
    return unknowns, angles, cost, damping


def _cost(state: Linearised) -> FloatArray:
    """Return sums of squared residuals; infinite where a linkage cannot be assembled."""
    cost: FloatArray = (state.residual**2).sum(axis=(1, 2))
    return np.where(np.isnan(cost), np.inf, cost)


def _find_step(state: Linearised, damping: FloatArray, free: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the steps of free unknowns and of angles: each angle occurs at its own point alone, and is eliminated first."""
    residual, by_unknowns, by_angles = state.residual, state.by_unknowns[..., free], state.by_angles
    angle_weight = (by_angles**2).sum(axis=1) + damping[:, None]
    mixed = np.einsum("srp,srpu->spu", by_angles, by_unknowns)
    angle_slope = (by_angles * residual).sum(axis=1)
    flat = by_unknowns.reshape(len(damping), -1, len(free))
    matrix = flat.swapaxes(1, 2) @ flat - (mixed / angle_weight[..., None]).swapaxes(1, 2) @ mixed
    matrix += damping[:, None, None] * np.eye(len(free))
    slope = (flat * residual.reshape(len(damping), -1, 1)).sum(axis=1) - (mixed * (angle_slope / angle_weight)[..., None]).sum(axis=1)
    step = -np.linalg.solve(matrix, slope[..., None])[..., 0]
    turn = -(angle_slope + (mixed @ step[..., None])[..., 0]) / angle_weight
    return step, turn

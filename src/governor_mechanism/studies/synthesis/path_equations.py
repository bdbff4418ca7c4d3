"""Equations of a path of a coupler's point, and their solution from many starts at once; and linkages along curves of many points.

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
    cost = np.full(len(unknowns), np.inf)
    damping = np.full(len(unknowns), FIRST_DAMPING)
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
    residual = state.residual
    by_unknowns = state.by_unknowns[..., free]
    by_angles = state.by_angles
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


N_INPUTS: Final = 121
"""Number of inputs at which random linkages are computed."""

N_SAMPLES: Final = 64
"""Number of places along a path, at equal distances on it, at which two paths are compared."""

N_FITTED: Final = 48
"""Number of the nearest of the random linkages that are fitted."""


class CurveEquations:
    """Distances, as x and y, of a coupler's curve from points.

    Unknowns are fixed pivots and the place of the point on the coupler (A, B, k as x and y), the lengths of input, coupler and output,
    and the sense of assembly, 1 or -1, which is kept; angles are those of the input.
    """

    def __init__(self, points: ComplexArray) -> None:
        self.points = points

    @staticmethod
    def places(unknowns: FloatArray, angles: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return both moving pivots, and the direction of the coupler; NaN where the linkage cannot be assembled."""
        first, second = as_complex(unknowns[:, :4]).T[:, :, None]
        a, b, c, sense = unknowns[:, 6:].T[:, :, None]
        start = first + a * np.exp(1j * angles)
        towards = second - start
        distance = np.abs(towards)
        cosine = (b**2 + distance**2 - c**2) / (2.0 * b * distance)
        with np.errstate(invalid="ignore"):
            direction = towards / distance * (cosine + 1j * sense * np.sqrt(1.0 - cosine**2))
        return start, start + b * direction, direction

    def __call__(self, unknowns: FloatArray, angles: FloatArray) -> Linearised:
        """Return the distances with their derivatives; the output's length holds the turn of the coupler."""
        start, end, direction = self.places(unknowns, angles)
        point, second = as_complex(unknowns[:, 4:6]), as_complex(unknowns[:, 2:4])
        b, c = unknowns[:, 7:8], unknowns[:, 8:9]
        away = np.conj(end - second) / c
        lever = np.real(away * 1j * direction) * b
        crank = np.exp(1j * angles)
        a_turn = 1j * unknowns[:, 6:7] * crank
        zero, one = np.zeros_like(crank), np.ones_like(crank)
        # shifts of the first moving pivot, of the coupler's point in it, of its length, of the second pivot, and of the output's length
        moved = [(one, zero, 0, 0, 0), (1j * one, zero, 0, 0, 0), (zero, zero, 0, one, 0), (zero, zero, 0, 1j * one, 0)]
        moved += [(zero, direction, 0, 0, 0), (zero, 1j * direction, 0, 0, 0), (crank, zero, 0, 0, 0), (zero, zero, 1, 0, 0)]
        moved += [(zero, zero, 0, 0, 1), (a_turn, zero, 0, 0, 0)]
        slopes = []
        for shift, inner, longer, ground, output in moved:
            turn = (output - np.real(away * (shift + longer * direction - ground))) / lever
            slopes.append(shift + inner + 1j * point * direction * turn)
        *by_unknowns, by_angles = slopes
        gap = start + point * direction - self.points
        stacked = np.stack(by_unknowns, axis=-1)
        return Linearised(*(np.stack([one.real, one.imag], axis=1) for one in (gap, stacked, by_angles)))


def curve_starts(
    points: ComplexArray, *, is_closed: bool, pivots: tuple[complex, complex] | None, n_starts: int, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Return random linkages, as unknowns, whose paths have the shape nearest to points, and their inputs at these points."""
    # Each is turned, scaled and shifted onto the points, unless pivots are chosen. Along a closed path
    # they turn fully, else they pass a random part of a turn.
    unknowns, inputs = _random_linkages(n_starts, seed, pivots, is_closed)
    samples = np.linspace(0.0, 1.0, N_SAMPLES + 1)
    inputs = _at_equal_distances(unknowns, inputs, samples)
    last = -1 if is_closed else None  # the end of a closed path is its start
    paths = _path(unknowns, inputs)[:, :last]
    can_move = np.isfinite(paths).all(axis=1)
    unknowns = unknowns[can_move]
    inputs = inputs[can_move]
    paths = paths[can_move]
    ends = np.append(points, points[0]) if is_closed else points
    along = np.append(0.0, np.cumsum(np.abs(np.diff(ends))))
    along /= along[-1]
    wanted: ComplexArray = (np.interp(samples, along, ends.real) + 1j * np.interp(samples, along, ends.imag))[:last]
    centre, middles = (0.0, np.zeros((len(paths), 1))) if pivots else (wanted.mean(), paths.mean(axis=1, keepdims=True))
    backwards = np.roll(wanted[::-1], 1) if is_closed else wanted[::-1]
    products = np.stack([_correlate(one, paths - middles, is_closed) for one in (wanted - centre, backwards - centre)], axis=1)
    size = (np.abs(paths - middles) ** 2).sum(axis=1)
    measure = (np.real(products) if pivots else np.abs(products)).reshape(len(paths), 2 * products.shape[2])  # senses, shifts
    gap = size - 2.0 * measure.max(axis=1) if pivots else -(measure.max(axis=1) ** 2) / size
    nearest = np.argsort(gap)[:N_FITTED]
    sense, shift = np.divmod(measure[nearest].argmax(axis=1), products.shape[2])
    factor: ComplexArray = (
        np.ones(len(nearest), dtype=np.complex128) if pivots else np.conj(products[nearest, sense, shift]) / size[nearest]
    )
    fractions = np.where(sense[:, None] == 1, -1.0, 1.0) * along[: len(points)]
    places = (fractions + (shift / N_SAMPLES)[:, None]) % 1.0 if is_closed else np.where(sense[:, None] == 1, 1.0 + fractions, fractions)
    angles = [np.interp(place, samples, inputs[k]) for place, k in zip(places, nearest, strict=True)]
    moved = _similar(unknowns[nearest], factor, centre - factor * middles[nearest, 0])
    return moved, np.array(angles).reshape(len(nearest), len(points)) + np.angle(factor)[:, None]


def _random_linkages(n_starts: int, seed: int, pivots: tuple[complex, complex] | None, is_closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return random linkages that can be assembled at all inputs of a random range, or of a whole turn, and these inputs."""
    generator = np.random.default_rng(seed)
    first, second = pivots or (0j, 1.0 + 0j)
    lengths = abs(second - first) * np.exp(generator.normal(0.0, 0.7, (n_starts, 3)))
    place = lengths[:, 1] * (0.5 + generator.normal(0.0, 1.0, (2, n_starts)).T @ np.array([1.0, 1j]))
    sense = generator.choice([-1.0, 1.0], n_starts)
    fixed = np.broadcast_to([first.real, first.imag, second.real, second.imag], (n_starts, 4))
    unknowns = np.column_stack([fixed, place.real, place.imag, lengths, sense])
    low = generator.uniform(-np.pi, np.pi, (n_starts, 1))
    width = 2.0 * np.pi if is_closed else generator.uniform(0.1 * np.pi, 2.0 * np.pi, (n_starts, 1))
    inputs = low + width * np.linspace(0.0, 1.0, N_INPUTS)
    can_move = np.isfinite(_path(unknowns, inputs)).all(axis=1)
    return unknowns[can_move], inputs[can_move]


def _path(unknowns: FloatArray, inputs: FloatArray) -> ComplexArray:
    start, _, direction = CurveEquations.places(unknowns, inputs)
    return start + as_complex(unknowns[:, 4:6]) * direction


def _at_equal_distances(unknowns: FloatArray, inputs: FloatArray, samples: FloatArray) -> FloatArray:
    """Return inputs at fractions of the length of each path."""
    passed = np.cumsum(np.abs(np.diff(_path(unknowns, inputs), axis=1)), axis=1)
    passed = np.column_stack([np.zeros(len(passed)), passed]) / passed[:, -1:]
    return np.array([np.interp(samples, *pair) for pair in zip(passed, inputs, strict=True)]).reshape(-1, len(samples))


def _correlate(wanted: ComplexArray, paths: ComplexArray, is_closed: bool) -> ComplexArray:
    """Return scalar products of paths with one that is wanted, shape (paths, shifts): of a closed path with all shifts along it."""
    if not is_closed:
        return (paths @ np.conj(wanted))[:, None]
    return np.fft.ifft(np.fft.fft(paths, axis=1) * np.conj(np.fft.fft(wanted)), axis=1)


def _similar(unknowns: FloatArray, factor: ComplexArray, shift: ComplexArray) -> FloatArray:
    """Return linkages turned and scaled by complex factors, and shifted."""
    fixed = as_complex(unknowns[:, :4]) * factor[:, None] + shift[:, None]
    parts = [part for pivot in fixed.T for part in (pivot.real, pivot.imag)]
    return np.column_stack([*parts, unknowns[:, 4:9] * np.abs(factor)[:, None], unknowns[:, 9]])

"""Positions of a body: four-bars whose coupler passes three, four or five of them, from dyads of a fixed and a moving pivot.

A displacement from the first position turns the body by alpha and moves its point by delta. In complex numbers a dyad of the link W,
from the fixed to the moving pivot, and Z, from there to the point, closes at each position: W (exp(i beta) - 1) + Z (exp(i alpha) - 1) =
delta. The link has the same length at all of them: the equation of the circle is linear in the fixed pivot G, in the moving pivot w, and
in their product.

G. N. Sandor, A. G. Erdman, Advanced mechanism design 2 (1984), chapter 3; J. M. McCarthy, G. S. Soh, Geometric design of linkages (2011),
chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.synthesis.linkage import Candidate, FourBarLinkage, Synthesis, check_all
from governor_mechanism.studies.synthesis.tables import parse_pivots, read_points, require_count
from governor_mechanism.types import ComplexArray, FloatArray
from governor_mechanism.units.text_table import short_repr

COLUMNS: Final = {"x": "length", "y": "length", "angle": "angle"}
KEYS: Final = ("fixed_pivots", "moving_pivots")

N_CURVE_SAMPLES: Final = 180
"""Number of turns of the link at which Burmester's curves are sampled; each has two dyads at most."""

MAX_SIZE_RATIO: Final = 10.0
"""Largest distance of a pivot from the positions, relative to their extent, for linkages from Burmester's curves."""

N_CHECKED: Final = 8
"""Number of pairs of dyads on Burmester's curves that are run, those of the best transmission angles at the positions."""

MIN_SEPARATION: Final = 0.3
"""Distance of all pivots, relative to the extent of the positions, between linkages that count as different."""

FAR_PIVOT: Final = 1e6
"""Distance of a pivot, relative to the extent of the positions, beyond which it is at infinity: a slider."""


class Dyad(NamedTuple):
    """A fixed pivot, and a moving pivot in the first position; m."""

    fixed: complex
    moving: complex


@dataclass(frozen=True, kw_only=True, eq=False)
class PositionSynthesis(Synthesis):
    """Four-bars whose coupler passes positions of a body.

    Attributes
    ----------
    positions
        The positions: x and y, m, and the angle, rad; shape (n, 3).
    dyads
        All dyads of five positions, or those of the chosen pivots of three.
    centre_curve
        Fixed pivots on Burmester's curve of four positions, m; shape (m, 2).
    circle_curve
        Moving pivots in the first position on the other curve, each for the fixed pivot of the same row.
    """

    positions: FloatArray
    dyads: tuple[Dyad, ...]
    centre_curve: FloatArray
    circle_curve: FloatArray

    __repr__ = short_repr
    figure = "render.figures.synthesis.position_figure"


class Displacements:
    """Displacements of a body from its first position: turns alpha, rad, and shifts delta of its point, m; shape (n,), the first zero."""

    def __init__(self, positions: FloatArray) -> None:
        points = positions[:, 0] + 1j * positions[:, 1]
        self.point: complex = complex(points[0])
        self.delta: ComplexArray = points - points[0]
        self.turn: ComplexArray = np.exp(1j * (positions[:, 2] - positions[0, 2]))
        self.extent = float(np.abs(self.delta).max()) or 1.0

    def moved(self, pivot: complex | ComplexArray) -> ComplexArray:
        """Return a point of the body, given in the first position, at all positions; a new axis is last."""
        return self.point + self.delta + np.multiply.outer(np.asarray(pivot) - self.point, self.turn)


def read_position_task(source: object, given: Mapping[str, Any]) -> tuple[FloatArray, dict[str, tuple[complex, complex]]]:
    """Return the positions and the chosen pivots of a file, or of arguments."""
    positions, keys = read_points(source, COLUMNS, KEYS)
    keys |= {name: value for name, value in given.items() if value is not None}
    if positions is None:
        raise MechanismError("the file has no positions; write points = [[x, y, angle], ...]")
    require_count(positions, (3, 4, 5), "the number of positions")
    chosen = {name: parse_pivots(name, value) for name, value in keys.items()}
    if len(positions) == 3 and len(chosen) != 1:
        raise MechanismError("three positions leave two pivots free: give fixed_pivots or moving_pivots, one of both, as two points [x, y]")
    if len(positions) > 3 and chosen:
        raise MechanismError(f"{' and '.join(chosen)} can be chosen for three positions alone; {len(positions)} determine all pivots")
    if np.abs(np.exp(1j * (positions[:, 2] - positions[0, 2])) - 1.0).max() < 1e-9:
        raise MechanismError("the angles of all positions are the same: any parallelogram with links of equal length moves a body so")
    return positions, chosen


def synthesise_positions(positions: FloatArray, chosen: Mapping[str, tuple[complex, complex]]) -> PositionSynthesis:
    """Return the four-bars through three to five positions of a body."""
    body = Displacements(positions)
    curves = np.zeros((0, 2), dtype=np.complex128)
    if len(positions) == 3:
        dyads = [_dyad_of_three(body, pivot, name) for name, pivots in chosen.items() for pivot in pivots]
        candidates = [_four_bar(body, *dyads)]
        notes = "three positions with chosen pivots have one four-bar"
    elif len(positions) == 4:
        curves = burmester_curves(body)
        dyads, candidates = [], _pairs_on_curves(body, curves)
        notes = f"four positions: {len(candidates)} of the pairs of {len(curves)} dyads on Burmester's curves were run"
    else:
        dyads = find_dyads(body)
        candidates = [_four_bar(body, *pair) for pair in combinations(dyads, 2)]
        notes = f"five positions: real dyads found: {len(dyads)}, four-bars of two of them: {len(candidates)}"
    if len(positions) != 4:  # those of four were chosen for the order in which their input passes
        candidates = [one for linkage in candidates for one in (linkage, _from_the_other_side(linkage))]
        notes += ", each with either link as input"
    rows = check_all(candidates)
    good = sum(not row.check.defects for row in rows)
    return PositionSynthesis(
        rows=rows,
        notes=(notes, f"{good} of {len(rows)} linkages pass all positions in their order"),
        positions=positions,
        dyads=tuple(dyads),
        centre_curve=_as_points(curves[:, 0]),
        circle_curve=_as_points(curves[:, 1]),
    )


def _as_points(values: ComplexArray) -> FloatArray:
    return np.column_stack([values.real, values.imag])


def _four_bar(body: Displacements, first: Dyad, second: Dyad) -> Candidate:
    linkage = FourBarLinkage(fixed=(first.fixed, second.fixed), moving=(first.moving, second.moving), point=body.point)
    return linkage, np.column_stack([body.moved(first.moving), body.moved(second.moving), body.moved(body.point)])


def _from_the_other_side(candidate: Candidate) -> Candidate:
    """Return a linkage with input and output exchanged: another link drives, with its own branches and order."""
    linkage, positions = candidate
    other = FourBarLinkage(fixed=linkage.fixed[::-1], moving=linkage.moving[::-1], point=linkage.point)
    return other, positions[:, [1, 0, 2]]


def circle_equations(body: Displacements) -> FloatArray:
    """Return the equations of a circle, shape (n - 1, 7), in u, v, X, Y, Re and Im of w conj(G), and 1."""
    # w = u + iv is the moving pivot and G = X + iY the fixed one, both from the point of the body in
    # the first position.
    delta, turn = body.delta[1:], body.turn[1:]
    linear, product = np.conj(delta) * turn, 1.0 - turn
    columns = [linear.real, -linear.imag, -delta.real, -delta.imag, product.real, -product.imag, 0.5 * np.abs(delta) ** 2]
    return np.column_stack(columns)


def _dyad_of_three(body: Displacements, pivot: complex, name: str) -> Dyad:
    """Return the dyad of three positions with a chosen pivot."""
    other = complex(other_pivots(body, np.array(pivot), name))
    if np.isnan(other):
        raise MechanismError(
            f"the point {pivot.real:g}, {pivot.imag:g} m of {name} has its three places on a line, so that its link would be a slider; "
            "choose another point"
        )
    return Dyad(other, pivot) if name == "moving_pivots" else Dyad(pivot, other)


def other_pivots(body: Displacements, pivots: ComplexArray, name: str) -> ComplexArray:
    """Return the other pivots of dyads of three positions with chosen ones; the equations are linear in them. NaN for a slider."""
    u, v, x, y, p, q, rest = circle_equations(body).T
    chosen = (pivots - body.point)[..., None]
    first, second = chosen.real, chosen.imag
    if name == "moving_pivots":  # in X and Y: p = uX + vY, q = vX - uY
        by_x = x + first * p + second * q
        by_y = y + second * p - first * q
        constant = rest + first * u + second * v
    else:  # in u and v: p = Xu + Yv, q = -Yu + Xv
        by_x = u + first * p - second * q
        by_y = v + second * p + first * q
        constant = rest + first * x + second * y
    determinant = _cross(by_x, by_y)
    is_slider = np.abs(determinant) < 1e-12 * np.maximum(np.abs(by_x), np.abs(by_y)).max(axis=-1) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        found = (_cross(by_y, constant) + 1j * _cross(constant, by_x)) / determinant
    return np.where(is_slider, np.nan, body.point + found)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def burmester_curves(body: Displacements) -> ComplexArray:
    """Return fixed and moving pivots, shape (n, 2), on the curves of centre points and of circle points of four positions."""
    # The determinant of three dyad equations is a linkage of four vectors that are turned by the betas:
    # one beta gives two of the others.
    alpha, delta = body.turn[1:] - 1.0, body.delta[1:]
    minors = np.cross(alpha, delta)
    turn_2 = np.exp(1j * math.tau * (np.arange(N_CURVE_SAMPLES) + 0.5) / N_CURVE_SAMPLES)
    closing = -(-minors.sum() + minors[0] * turn_2)
    first, second = abs(minors[1]), abs(minors[2])
    length = np.abs(closing)
    cosine = (length**2 + first**2 - second**2) / (2.0 * length * first)
    is_real = np.abs(cosine) <= 1.0
    found = []
    for sense in (1.0, -1.0):
        inner = sense * np.arccos(cosine[is_real])
        turn_3 = np.exp(1j * (np.angle(closing[is_real] / minors[1]) + inner))
        turn_4 = (closing[is_real] - minors[1] * turn_3) / minors[2]
        for betas in zip(turn_2[is_real], turn_3, turn_4, strict=True):
            matrix = np.column_stack([np.array(betas) - 1.0, alpha])
            (link, arm), _, matrix_rank, _ = np.linalg.lstsq(matrix, delta, rcond=1e-9)
            if matrix_rank == 2:
                found.append((body.point - arm - link, body.point - arm))
    return np.array(found, dtype=np.complex128).reshape(-1, 2)


def find_dyads(body: Displacements) -> list[Dyad]:
    """Return all real dyads of five positions, four at most."""
    # The equations leave three of the seven products free; that two of them are products of the others
    # makes two conics, which intersect in four points.
    scaled = circle_equations(body) * np.array([body.extent] * 4 + [body.extent**2] * 2 + [1.0]) / body.extent**2
    null = np.linalg.svd(scaled)[2][4:]
    u, v, x, y, p, q, one = null.T
    conics = [_symmetric(p, one) - _symmetric(u, x) - _symmetric(v, y), _symmetric(q, one) - _symmetric(v, x) + _symmetric(u, y)]
    dyads = list[Dyad]()
    for weights in intersect_conics(*conics):
        values = null.T @ weights
        if abs(values[6]) * FAR_PIVOT < np.abs(values).max():
            continue  # a pivot at infinity
        moving, fixed = (body.point + body.extent * complex(values[k], values[k + 1]) / values[6] for k in (0, 2))
        refined = _refine(body, Dyad(fixed, moving))
        if not any(abs(refined.fixed - other.fixed) + abs(refined.moving - other.moving) < 1e-6 * body.extent for other in dyads):
            dyads.append(refined)
    return dyads


def _symmetric(first: FloatArray, second: FloatArray) -> FloatArray:
    return 0.5 * (np.outer(first, second) + np.outer(second, first))


def intersect_conics(first: FloatArray, second: FloatArray) -> list[FloatArray]:
    """Return the real points, homogeneous, shape (3,), in which two conics, symmetric matrices, intersect."""
    # In turned axes the third coordinate of no point is zero; the resultant of both as quadratics in
    # the first coordinate is a polynomial of the fourth degree in the second one.
    axes = np.linalg.qr(np.array([[0.7, 0.3, -0.2], [0.1, 0.9, 0.5], [-0.6, 0.2, 0.8]]))[0]
    turned = [axes.T @ conic @ axes / np.linalg.norm(conic) for conic in (first, second)]

    def quadratic(conic: FloatArray, y: complex) -> tuple[complex, complex, complex]:
        return conic[0, 0], 2.0 * (conic[0, 1] * y + conic[0, 2]), conic[1, 1] * y * y + 2.0 * conic[1, 2] * y + conic[2, 2]

    def resultant(y: complex) -> complex:
        (a, b, c), (d, e, f) = (quadratic(conic, y) for conic in turned)
        return (a * f - c * d) ** 2 - (a * e - b * d) * (b * f - c * e)

    samples = np.exp(1j * math.tau * np.arange(5) / 5)
    coefficients = (np.fft.fft([resultant(y) for y in samples]) / 5).real
    points = []
    for root in np.roots(coefficients[::-1]):
        if abs(root.imag) < 1e-6 * (1.0 + abs(root)):
            (a, b, c), (d, e, f) = (quadratic(conic, root.real) for conic in turned)
            x = np.real((c * d - a * f) / (a * e - b * d))
            points.append(axes @ np.array([x, root.real, 1.0]))
    return points


def _refine(body: Displacements, dyad: Dyad) -> Dyad:
    """Return a dyad corrected by Newton's iteration on the equations of the circle."""
    equations = circle_equations(body)
    w, g = dyad.moving - body.point, dyad.fixed - body.point
    values = np.array([w.real, w.imag, g.real, g.imag])
    for _ in range(8):
        u, v, x, y = values
        residual = equations @ [u, v, x, y, u * x + v * y, v * x - u * y, 1.0]
        slope = equations[:, :4] + np.outer(equations[:, 4], [x, y, u, v]) + np.outer(equations[:, 5], [-y, x, v, -u])
        values = values - np.linalg.lstsq(slope, residual, rcond=None)[0]
    return Dyad(body.point + complex(values[2], values[3]), body.point + complex(values[0], values[1]))


def _pairs_on_curves(body: Displacements, curves: ComplexArray) -> list[Candidate]:
    """Return the pairs of dyads that keep their branch and order and have the best transmission angles at the positions, all different."""
    near = curves[(np.abs(curves - body.point) < MAX_SIZE_RATIO * body.extent).all(axis=1)]
    if len(near) < 2:
        return []
    fixed, moving = near[:, :1], body.moved(near[:, 1])  # (n, 1) and (n, positions)
    steps = np.diff(np.unwrap(np.angle(moving - fixed), axis=1), axis=1)
    in_order = (np.abs(np.sign(steps).sum(axis=1)) == steps.shape[1]) & (np.abs(steps.sum(axis=1)) < math.tau)
    first, second = (one.ravel() for one in np.meshgrid(np.flatnonzero(in_order), np.arange(len(near)), indexing="ij"))
    coupler, link = moving[second] - moving[first], moving[second] - fixed[second]
    with np.errstate(divide="ignore", invalid="ignore"):
        sines = np.imag(coupler * np.conj(link)) / np.abs(coupler * link)
    keeps_branch = np.abs(np.sign(sines).sum(axis=1)) == sines.shape[1]
    score = np.where(keeps_branch, np.abs(sines).min(axis=1), -1.0)
    chosen = list[tuple[int, int]]()
    for k in np.argsort(-score):
        if score[k] <= 0.0 or len(chosen) == N_CHECKED:
            break
        pair = near[[first[k], second[k]]]
        if not any(np.abs(pair - near[list(other)]).max() < MIN_SEPARATION * body.extent for other in chosen):
            chosen.append((int(first[k]), int(second[k])))
    return [_four_bar(body, *(Dyad(*map(complex, near[k])) for k in pair)) for pair in chosen]

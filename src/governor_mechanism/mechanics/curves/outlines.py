"""Outlines as pieces for the kernels: lines, arcs and curves; what is wrong with them; and points along them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.mechanics.curves.outline_kernels import N_CURVE_SAMPLES, ON_FEATURE, least_depth
from governor_mechanism.mechanics.curves.segments import evaluate_polar_curve, make_curve_segments
from governor_mechanism.model.curves import CornerOutline, CurveOutline, Outline, PolarHarmonics
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray, Vector2

SMOOTH_TURN = 1e-9
"""Sine of the angle between two edges below which the outline is smooth there."""

MIN_CURVATURE = 1e-3
"""Curvature of a curve, relative to that of its circle, below which an edge touches it along a line rather than at a point."""

CHORDS_PER_EDGE = 24
"""Chords in place of an arc where outlines are drawn, and where edges are searched for crossings."""

SAME_CENTRE = 1e-7
"""Distance of the centres of arcs of one circle, relative to its radius: a half circle has its direction to the root of rounding."""

CURVATURE_SAMPLES = 360
"""Angles at which the curvature of a closed curve is looked at, twice, from both sides."""


@dataclass(frozen=True)
class Edge:
    """An edge of an outline in the anticlockwise sense: start (m), direction there (rad), length (m), curvature (1/m, left is positive)."""

    start: Vector2
    direction: float
    length: float
    curvature: float

    @property
    def end_direction(self) -> float:
        """Direction at its end, rad."""
        return self.direction + self.curvature * self.length

    def point(self, share: float) -> Vector2:
        """Return the point at a share of its length, m."""
        turn = self.curvature * self.length * share
        # sin(x) / x keeps its digits for small angles
        chord = share * self.length * float(np.sinc(turn / (2 * math.pi)))
        angle = self.direction + turn / 2
        return self.start[0] + chord * math.cos(angle), self.start[1] + chord * math.sin(angle)

    def values(self) -> list[float]:
        """Return the values of the piece of the kernels."""
        return [*self.start, math.cos(self.direction), math.sin(self.direction), self.length, self.curvature]


def edges_of(outline: CornerOutline) -> list[Edge]:
    """Return the edges of an outline, anticlockwise."""
    corners = outline.corners
    ends = [((one.x, one.y), (other.x, other.y), one.radius) for one, other in pairwise((*corners, corners[0]))]
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1), _ in ends)
    if area < 0.0:
        ends = [(end, start, radius) for start, end, radius in reversed(ends)]
    return [_edge(*one) for one in ends]


def _edge(start: Vector2, end: Vector2, radius: float) -> Edge:
    """Return an edge; one with a positive radius bulges to the right."""
    chord = math.dist(start, end)
    direction = math.atan2(end[1] - start[1], end[0] - start[0])
    if radius == 0.0:
        return Edge(start, direction, chord, 0.0)
    half_turn = math.asin(min(chord / (2 * abs(radius)), 1.0))
    return Edge(start, direction - math.copysign(half_turn, radius), 2 * half_turn * abs(radius), 1 / radius)


def _turn(edge: Edge, following: Edge) -> float:
    """Return the angle (rad) by which the outline turns left between two edges, -pi to pi."""
    return math.remainder(following.direction - edge.end_direction, math.tau)


def _turns(edges: Sequence[Edge]) -> list[float]:
    """Return the angles (rad) by which a closed outline turns left behind each edge."""
    return [_turn(one, other) for one, other in pairwise((*edges, edges[0]))]


def chains_of(outline: CornerOutline) -> list[list[Edge]]:
    """Return the edges between hollow corners, where a roller touches both sides at once."""
    # Along such a chain the distance of a point changes smoothly: around corners that stand out it
    # rolls.
    edges = edges_of(outline)
    hollow = [k + 1 for k, turn in enumerate(_turns(edges)) if turn < -SMOOTH_TURN]
    if not hollow:
        return [edges]
    doubled = edges + edges
    return [doubled[start:end] for start, end in pairwise((*hollow, hollow[0] + len(edges)))]


def make_pieces(outline: CornerOutline, chain: int) -> FloatArray:
    """Return the pieces of a chain for the kernels, each behind the directions of the edges before and behind it.

    At a hollow corner there is no such edge. The first column is the depth up to which the left side is inside. Shape (edges, 11).
    """
    pieces = _pieces_without_depth(outline, chain)
    pieces[:, 0] = _depths(outline)[chain]
    return pieces


def _is_without_hollow_corners(outline: CornerOutline) -> bool:
    return all(turn >= -SMOOTH_TURN for turn in _turns(edges_of(outline)))


def _pieces_without_depth(outline: CornerOutline, chain: int) -> FloatArray:
    """Return the pieces of a chain with 0 in the first column."""
    edges = chains_of(outline)[chain]
    closing = [edges[-1], edges[0]] if _is_without_hollow_corners(outline) else [None, None]
    rows = []
    for before, edge, behind in zip([closing[0], *edges[:-1]], edges, [*edges[1:], closing[1]], strict=True):
        start = [0.0, 0.0] if before is None else [math.cos(before.end_direction), math.sin(before.end_direction)]
        end = [0.0, 0.0] if behind is None else [math.cos(behind.direction), math.sin(behind.direction)]
        rows.append([0.0, *start, *end, *edge.values()])
    return np.array(rows)


DEPTH_SAMPLES = tuple(12 * 4**k for k in range(4))
"""Numbers of points along each edge with which the depth behind a chain is looked for, until they stand close enough."""


@once_per_object
def _depths(outline: CornerOutline) -> list[float]:
    """Return for each chain the depth (m) up to which what is to its left is inside the outline: half of that to the other chains.

    A way from the chain straight to a point outside leads through another chain. Points of those that are no farther from each other than
    half of the least distance find it but for half of it.
    """
    chains = chains_of(outline)
    if _is_without_hollow_corners(outline):
        return [math.inf]
    depths = [0.0] * len(chains)
    longest = max(edge.length for edge in edges_of(outline))
    for n in DEPTH_SAMPLES:
        points = [np.array([edge.point(k / n) for edge in chain for k in range(n + 1)]) for chain in chains]
        for k, chain in enumerate(chains):
            others = np.concatenate([points[i] for i in range(len(chains)) if i != k] or [np.empty((0, 2))])
            ends = [np.hypot(*(others - end).T) for end in (chain[0].start, chain[-1].point(1.0))]
            others = others[np.minimum(*ends) > ON_FEATURE * longest]  # but for the corners that it shares with them
            least = least_depth(_pieces_without_depth(outline, k), others)
            depths[k] = least / 2 if longest / n <= least / 2 else 0.0
        if all(depths):
            break
    return depths


def bounding_circle(chain: Sequence[Edge]) -> tuple[float, float, float]:
    """Return a circle (centre and radius, m) around a chain."""
    points = np.array([edge.point(share) for edge in chain for share in (0.0, 0.5, 1.0)])
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    # An arc is no farther from one of these three points than a quarter of its length.
    return *centre.tolist(), max(np.hypot(*(points - centre).T)) + max(edge.length for edge in chain) / 4


def make_curve_pieces(outline: CurveOutline) -> FloatArray:
    """Return the segments of a closed curve, and then its points at equal angles, for the kernels."""
    segments = make_curve_segments(outline.curve)
    samples = np.zeros((N_CURVE_SAMPLES, segments.shape[1]))
    samples[:, -2:] = [_polar_point(segments, angle)[0] for angle in math.tau * np.arange(N_CURVE_SAMPLES) / N_CURVE_SAMPLES]
    return np.concatenate([segments, samples])


def _polar_point(segments: FloatArray, angle: float) -> tuple[Vector2, Vector2, float]:
    """Return a point of a closed curve (m), the unit normal outward, and the curvature (1/m)."""
    radius, slope, second_derivative = evaluate_polar_curve(segments, 0, len(segments), angle)
    cosine = math.cos(angle)
    sine = math.sin(angle)
    speed = math.hypot(radius, slope)
    normal = (radius * cosine + slope * sine) / speed, (radius * sine - slope * cosine) / speed
    return (radius * cosine, radius * sine), normal, (radius * (radius - second_derivative) + 2 * slope**2) / speed**3


def outline_points(outline: Outline) -> list[Vector2]:
    """Return points along an outline, anticlockwise, in its axes, m."""
    if isinstance(outline, CornerOutline):
        return [edge.point(k / n) for edge in edges_of(outline) for n in [_n_chords(edge)] for k in range(n)]
    if not isinstance(outline, CurveOutline):
        raise TypeError(f"no points are defined along outlines of type {type(outline).__name__}")
    segments, points = make_curve_segments(outline.curve), []
    for angle in math.tau * np.arange(4 * N_CURVE_SAMPLES) / (4 * N_CURVE_SAMPLES):
        (x, y), (nx, ny), _ = _polar_point(segments, angle)
        points.append((x - outline.inset * nx, y - outline.inset * ny))
    return points


def _n_chords(edge: Edge) -> int:
    return CHORDS_PER_EDGE if edge.curvature else 1


def find_outline_problems(outline: CornerOutline) -> Iterator[str]:
    """Yield a sentence for each place where an outline turns back on itself or crosses itself."""
    edges = edges_of(outline)
    for edge, following in pairwise((*edges, edges[0])):
        if abs(_turn(edge, following)) > math.pi - SMOOTH_TURN:
            yield f"the outline turns back on itself at {_place(following.start)}; leave the corner out, or move it"
    points = np.array(outline_points(outline))
    for i, j in _crossing_chords(points):
        yield f"the outline crosses itself between {_place(points[i])} and {_place(points[j])}; move its corners"
        return


def _place(point: Sequence[float]) -> str:
    return f"({point[0]:.6g} m, {point[1]:.6g} m)"


def _crossing_chords(points: FloatArray) -> Iterator[tuple[int, int]]:
    """Yield the pairs of chords of a closed polygon that touch or cross, but for neighbours."""
    starts, n = points, len(points)
    ends = np.roll(points, -1, axis=0)
    for i in range(n - 2):
        others = np.arange(i + 2, n if i else n - 1)
        first, second = starts[others], ends[others]
        sides = _cross(ends[i] - starts[i], first - starts[i]) * _cross(ends[i] - starts[i], second - starts[i])
        other_sides = _cross(second - first, starts[i] - first) * _cross(second - first, ends[i] - first)
        for j in others[(sides <= 0.0) & (other_sides <= 0.0) & ((sides < 0.0) | (other_sides < 0.0))]:
            yield i, int(j)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    result: FloatArray = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return result


def find_roller_problem(outline: Outline, radius: float) -> str:
    """Return why a roller of a radius (m) cannot follow an outline; empty if it can."""
    if isinstance(outline, CornerOutline):
        return _find_problem_at_edges(outline, radius)
    return _find_problem_along_curve(outline, radius) if isinstance(outline, CurveOutline) else ""


def _find_problem_at_edges(outline: CornerOutline, radius: float) -> str:
    edges = edges_of(outline)
    if radius <= 0.0:
        return "the roller needs a radius where the outline has corners or arcs: give even an edge or a tip the radius that it has"
    tightest = min((abs(1 / edge.curvature) for edge in edges if edge.curvature < 0.0), default=math.inf)
    if tightest <= radius:
        return (
            f"the outline has a hollow arc of radius {tightest:g} m, which a roller of {radius:g} m cannot enter, or would touch everywhere"
        )
    return _single_hollow_corner(edges)


def _single_hollow_corner(edges: Sequence[Edge]) -> str:
    if sum(turn < -SMOOTH_TURN for turn in _turns(edges)) == 1:
        return "the outline has a single hollow corner; round it with a hollow arc, of a radius larger than that of what touches it"
    return ""


def _find_problem_along_curve(outline: CurveOutline, radius: float) -> str:
    curvatures = _curvatures(make_curve_segments(outline.curve))
    if max(curvatures) * outline.inset >= 1.0:
        return _undercut(outline, max(curvatures))
    if -min(curvatures) * (radius - outline.inset) >= 1.0:
        hollow = -1 / min(curvatures) + outline.inset
        return f"the outline is hollow with a radius of {hollow:g} m, in which a roller of {radius:g} m touches two sides at once"
    return ""


def _curvatures(segments: FloatArray) -> list[float]:
    """Return curvatures round a closed curve, 1/m, at both sides of where it may jump."""
    around = math.tau * np.arange(CURVATURE_SAMPLES) / CURVATURE_SAMPLES
    return [_polar_point(segments, angle + side)[2] for angle in (*around, *segments[:, 0]) for side in (-1e-9, 1e-9)]


def _undercut(outline: CurveOutline, largest: float) -> str:
    return f"the curve bends with a radius of {1 / largest:g} m, less than the inset {outline.inset:g} m: the cam is undercut"


def find_profile_problem(outline: CornerOutline, profile: CurveOutline) -> str:
    """Return why a closed curve cannot touch lines and arcs with a single point at a time; empty if it can."""
    segments = make_curve_segments(profile.curve)
    curvatures = _curvatures(segments)
    if max(curvatures) * profile.inset >= 1.0:
        return _undercut(profile, max(curvatures))
    flattest = 1 / min(curvatures) - profile.inset if min(curvatures) > 0.0 else math.inf
    if min(curvatures) < MIN_CURVATURE / profile.curve.typical_radius:
        return "the curve is hollow or flat somewhere, where it would touch an edge at two points at once; let a roller touch it there"
    hollow = [-1 / edge.curvature for edge in edges_of(outline) if edge.curvature < 0.0]
    if hollow and min(hollow) <= flattest:
        return (
            f"the outline has a hollow arc of radius {min(hollow):g} m, and the curve bends with radii up to {flattest:g} m: "
            "it cannot enter, or would touch everywhere"
        )
    return _single_hollow_corner(edges_of(outline))


def find_circle(outline: Outline) -> tuple[float, float, float] | None:
    """Return centre and radius (m) of an outline that is a circle, of arcs or as a curve, or None."""
    if isinstance(outline, CurveOutline):
        curve = outline.curve
        is_circle = isinstance(curve, PolarHarmonics) and not any(one.amplitude for one in curve.harmonics)
        return (0.0, 0.0, curve.typical_radius - outline.inset) if is_circle else None
    edges = edges_of(outline) if isinstance(outline, CornerOutline) else []
    if not edges or edges[0].curvature <= 0.0:
        return None
    radius = 1 / edges[0].curvature
    centres = [(edge.start[0] - radius * math.sin(edge.direction), edge.start[1] + radius * math.cos(edge.direction)) for edge in edges]
    is_one = all(math.isclose(edge.curvature * radius, 1.0, rel_tol=SMOOTH_TURN) for edge in edges)
    is_round = is_one and all(math.dist(centre, centres[0]) <= SAME_CENTRE * radius for centre in centres)
    return (*centres[0], radius) if is_round else None


def is_inside(points: Sequence[Vector2], x: float, y: float) -> bool:
    """Return whether a point is inside a closed polygon."""
    inside = False
    for (x0, y0), (x1, y1) in pairwise((*points, points[0])):
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside

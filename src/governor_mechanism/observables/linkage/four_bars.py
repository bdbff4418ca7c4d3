"""Four-bar loops of a mechanism, and what turns fully in each by Grashof's rule."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import permutations

from governor_mechanism.model.joints import Distance, Point
from governor_mechanism.model.links import GROUND_LINK, Hinge, Link, LinkGraph
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.results.result import Recorded

CHANGE_POINT_TOLERANCE = 1e-9
"""Difference of the sums of two lengths, relative to the sum of all, below which they are equal; that of given lengths is rounding."""


class GrashofClass(StrEnum):
    """Classes of four-bars; s and l are the shortest and the longest length, p and q the others."""

    CRANK_ROCKER = "crank-rocker"
    DOUBLE_CRANK = "double crank"
    DOUBLE_ROCKER = "double rocker"
    TRIPLE_ROCKER = "triple rocker"
    CHANGE_POINT = "change point"


_REASONS = {
    GrashofClass.CRANK_ROCKER: "s + l < p + q, and {shortest}, the shortest, turns fully beside the ground",
    GrashofClass.DOUBLE_CRANK: "s + l < p + q, and the ground is the shortest: both links on it turn fully",
    GrashofClass.DOUBLE_ROCKER: "s + l < p + q, and {shortest}, the coupler, is the shortest: it alone turns fully",
    GrashofClass.TRIPLE_ROCKER: "s + l > p + q: no link turns fully",
    GrashofClass.CHANGE_POINT: "s + l = p + q: all links can lie on one line, where the motion branches",
}


@dataclass(frozen=True, kw_only=True)
class FourBar(Recorded):
    """A four-bar loop on the ground.

    Attributes
    ----------
    links
        Names of the input, the coupler and the output.
    lengths
        Lengths of ground, input, coupler and output, m.
    """

    links: tuple[str, str, str]
    lengths: tuple[float, float, float, float]

    derived = ("grashof",)

    @property
    def grashof(self) -> GrashofClass:
        """Class by Grashof's rule."""
        shortest, *_, longest = sorted(self.lengths)
        excess = 2 * (shortest + longest) - sum(self.lengths)
        if abs(excess) <= CHANGE_POINT_TOLERANCE * sum(self.lengths):
            return GrashofClass.CHANGE_POINT
        if excess > 0:
            return GrashofClass.TRIPLE_ROCKER
        classes = (GrashofClass.DOUBLE_CRANK, GrashofClass.CRANK_ROCKER, GrashofClass.DOUBLE_ROCKER, GrashofClass.CRANK_ROCKER)
        return classes[self.lengths.index(shortest)]

    def __str__(self) -> str:
        """Return links, lengths and class in a sentence."""
        names = ("ground", *self.links)
        lengths = ", ".join(f"{name} {1e3 * length:.6g}" for name, length in zip(names, self.lengths, strict=True))
        reason = _REASONS[self.grashof].format(shortest=names[self.lengths.index(min(self.lengths))])
        return f"four-bar {lengths} mm: {self.grashof}; {reason}"


def find_four_bars(mechanism: Mechanism, drive: str = "") -> tuple[FourBar, ...]:
    """Return all loops of four links with the ground; the input is the one that a reading, or else a driver, moves."""
    graph = LinkGraph(mechanism)
    distances = graph.distances_from(graph.inputs(drive))
    pivots = [(hinge, link) for hinge in graph.hinges_of(GROUND_LINK) for link in hinge.links if link != GROUND_LINK]
    found: dict[frozenset[Link], FourBar] = {}
    for (start, first), (end, last) in permutations(pivots, 2):
        if start is end or first == last or distances.get(first, math.inf) > distances.get(last, math.inf):
            continue
        for left, coupler, right in _couplers_between(graph, (start, first), (end, last)):
            loop = ((GROUND_LINK, start, end), (first, start, left), (coupler, left, right), (last, right, end))
            lengths = tuple(_length(mechanism, link, one, other) for link, one, other in loop)
            if all(lengths):
                four_bar = FourBar(links=(first.name, coupler.name, last.name), lengths=lengths)  # type: ignore[arg-type]  # four
                found.setdefault(frozenset((first, coupler, last)), four_bar)
    return tuple(found.values())


def _couplers_between(graph: LinkGraph, start: tuple[Hinge, Link], end: tuple[Hinge, Link]) -> Iterator[tuple[Hinge, Link, Hinge]]:
    """Yield each link that joins two links on pivots, with its hinges on both."""
    (start_pivot, first), (end_pivot, last) = start, end
    for left in graph.hinges_of(first):
        for right in graph.hinges_of(last):
            if left is not start_pivot and right is not end_pivot and left is not right:
                shared = set(left.links).intersection(right.links) - {first, last, GROUND_LINK}
                yield from ((left, coupler, right) for coupler in sorted(shared, key=lambda link: link.name))


def _length(mechanism: Mechanism, link: Link, first: Hinge, second: Hinge) -> float:
    """Return the distance of two hinges on a link, m."""
    if link.is_bar:
        return next(joint.length for joint in mechanism.joints if isinstance(joint, Distance) and joint.name == link.name)
    points: list[Point] = [hinge.points[link.name] for hinge in (first, second)]
    return math.dist(*((point.x, point.y) for point in points))

"""What holds of a whole linkage: the travel of its drive with dead centres, toggles and time ratios, its four-bars, and its mobility."""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import permutations

import numpy as np
from numpy.polynomial import Polynomial

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.kinematic_analysis import release_drivers
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_reading_motions
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.model.joints import Distance, Joint, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import GROUND_LINK, Hinge, Link, LinkGraph, Mechanism
from governor_mechanism.model.motion_readings import find_transmissions
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.numerics.roots import find_roots
from governor_mechanism.observables.motion_readings import Motion, transmission_sine
from governor_mechanism.types import FloatArray
from governor_mechanism.units.fields import class_words

N_SAMPLES = 721
"""Number of positions between which dead centres are sought: half a degree of a turn."""

SAMPLE_SHIFT = 0.37
"""Part of a step by which the first sample lies beside the start, so that no dead centre falls on both ends of a turn."""

ROOT_TOLERANCE = 1e-13
"""Newton step, in coordinate scales, below which a dead centre is located."""

MIN_SPREAD_RATIO = 1e-9
"""Spread of a reading, relative to its scale, below which it stands still; rounding leaves 1e-15."""

DEFAULT_MARGIN = 1e-3
"""Part of the travel that a study leaves out at each end, where velocities grow without bound."""

N_EXTRAPOLATION_NODES, EXTRAPOLATED_PART = 8, 1e-3
"""Number of positions from which a toggle is extrapolated, and the part of the travel in which they lie."""

MAX_EXTRAPOLATED_SINE = 0.05
"""Sine of a transmission angle at the nearest of these positions up to which coupler and link are aligned at the toggle."""


@dataclass(frozen=True, kw_only=True)
class DeadCentre(Recorded):
    """A position at which a reading turns back while the drive goes on."""

    reading: str  # name of the reading
    drive: float  # value of the driving reading, SI
    value: float  # value of the reading, SI
    is_highest: bool  # whether the reading has a maximum there


@dataclass(frozen=True, kw_only=True)
class Toggle(Recorded):
    """A position beyond which the drive cannot go."""

    drive: float  # value of the driving reading, SI
    couplers: tuple[str, ...]  # couplers whose transmission angle is 0 or 180 degrees there
    reason: str  # what happens there, in words


class DriveTravel:
    """The travel of a mechanism over a driving reading.

    Parameters
    ----------
    mechanism
        The mechanism with its drivers.
    over
        Name of the driving reading.
    poses
        A position on the branch of the motion; shape (bodies, 3).

    Attributes
    ----------
    mechanism
        The mechanism without the drivers that move the reading, which leads it.

    Raises
    ------
    MechanismError
        If the reading does not determine the motion, or stands still there.
    """

    def __init__(self, mechanism: Mechanism, over: str, poses: FloatArray) -> None:
        at = replace(mechanism, initial_guess=tuple((x, y, angle) for x, y, angle in poses.tolist()))
        released = release_drivers(at, over, {})
        self.mechanism = replace(released, initial_guess=at.initial_guess, coordinate=over, limits=(), stall_limits=())
        self._solver = CoordinateSolver(self.mechanism)

    @cached_property
    def range(self) -> RangeOfMotion:
        """The range of the driving reading."""
        return find_range_of_motion(self.mechanism, rotates_with_spindle=False)

    @property
    def words(self) -> str:
        """How far the drive goes, as "full turns" or "-165.5 to 188.7 deg"."""
        if self.turns_fully:
            return "full turns"
        low, high = (float(np.degrees(end).round(1)) + 0.0 for end in self.range.ends)
        return f"{low:g} to {high:g} deg"

    @property
    def turns_fully(self) -> bool:
        """Whether the drive turns on without end, one turn like the next."""
        return math.isclose(self.range.period, math.tau)

    def default_values(self, count: int) -> FloatArray:
        """Return values (count,) over a whole period from 0 on, or over the travel up to a thousandth of it from both ends."""
        if self.range.period:
            return np.linspace(0.0, self.range.period, count)
        low, high = self.range.ends
        margin = DEFAULT_MARGIN * (high - low)
        return np.linspace(low + margin, high - margin, count)

    @cached_property
    def dead_centres(self) -> tuple[DeadCentre, ...]:
        """The dead centres of all readings, by reading and in the order of the drive; those of a turn within 0 to its end."""
        low, high = self.range.low, self.range.high
        shift = SAMPLE_SHIFT * (high - low) / (N_SAMPLES - 1) if self.range.period else 0.0
        samples = np.linspace(low, high, N_SAMPLES) + shift
        motions = self._evaluate(samples)
        found = list[DeadCentre]()
        for name, (values, slopes, _) in motions.items():
            if name != self.mechanism.coordinate and np.ptp(values) > MIN_SPREAD_RATIO * self.mechanism.output_scale(name):
                found += self._locate(name, samples, slopes)
        return tuple(sorted(found, key=lambda one: (list(motions).index(one.reading), one.drive)))

    def _evaluate(self, values: FloatArray) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
        """Return each reading and its two derivatives by the drive at values (n,) of it."""
        nodes = self._solver.solve_nodes(self.range.path.predict_poses(values), values)
        return evaluate_reading_motions(self.mechanism, *(np.ascontiguousarray(nodes[:, k]) for k in range(3)))

    def _locate(self, name: str, samples: FloatArray, slopes: FloatArray) -> list[DeadCentre]:
        """Return the dead centres of a reading between samples (n,), from its derivatives there."""
        is_rising = slopes >= 0.0
        starts = np.flatnonzero(is_rising[:-1] != is_rising[1:])
        if not starts.size:
            return []
        tolerance = ROOT_TOLERANCE * self.mechanism.output_scale(self.mechanism.coordinate)
        places = find_roots(lambda drive: self._evaluate(drive)[name][1:], samples[starts], samples[starts + 1], tolerance)
        values = self._evaluate(places)[name][0]
        wrapped = np.mod(places, self.range.period) if self.range.period else places
        return [
            DeadCentre(reading=name, drive=float(drive), value=float(value), is_highest=bool(is_rising[start]))
            for drive, value, start in zip(wrapped, values, starts, strict=True)
        ]

    @cached_property
    def toggles(self) -> tuple[Toggle, ...]:
        """The ends of the travel; none where it is closed."""
        if self.range.period:
            return ()
        ends = zip(self.range.ends, (self.range.low_message, self.range.high_message), strict=True)
        return tuple(self._make_toggle(end, reason) for end, reason in ends)

    def _make_toggle(self, end: float, reason: str) -> Toggle:
        """Return the toggle at an end of the travel, with the couplers that are aligned with the links that they move."""
        # There the sine of the transmission angle vanishes, and the drive is a smooth function of
        # it, which is extrapolated: beside the end positions are exact, and at it the drive does
        # not determine them.
        inward = 1.0 if end == self.range.ends[0] else -1.0
        steps = np.arange(1, N_EXTRAPOLATION_NODES + 1) / N_EXTRAPOLATION_NODES
        is_turning_point = reason.startswith("turning point")  # there the sine is as the root of the distance
        distances = EXTRAPOLATED_PART * float(np.diff(self.range.ends)[0]) * (steps**2 if is_turning_point else steps)
        sines = self._sines(end + inward * distances)
        aligned = tuple(name for name, values in sines.items() if abs(values[0]) < MAX_EXTRAPOLATED_SINE)
        places = [
            inward * float(Polynomial.fit(sines[name], distances, N_EXTRAPOLATION_NODES - 1)(0.0))
            for name in aligned[:1]
            if np.all(np.diff(np.abs(sines[name])) > 0.0)
        ]
        return Toggle(drive=end + sum(places), couplers=aligned, reason=reason)

    def _sines(self, values: FloatArray) -> dict[str, FloatArray]:
        """Return the sine of each transmission angle with the sign of the turn from coupler to link, at values (n,) of the drive."""
        nodes = self._solver.solve_nodes(self.range.path.predict_poses(values), values)
        motion = Motion(mechanism=self.mechanism, poses=nodes[:, 0], velocities=nodes[:, 1], accelerations=nodes[:, 2], rates={})
        return {name: transmission_sine(motion, angle) for name, angle in find_transmissions(self.mechanism).items()}

    @cached_property
    def time_ratios(self) -> dict[str, float]:
        """Time ratio of each reading with one stroke each way in a turn of the drive: the slower stroke over the faster one."""
        ratios = dict[str, float]()
        for name in dict.fromkeys(one.reading for one in self.dead_centres) if self.turns_fully else ():
            drives = [one.drive for one in self.dead_centres if one.reading == name]
            if len(drives) == 2:
                stroke = abs(drives[1] - drives[0])
                ratios[name] = max(stroke, math.tau - stroke) / min(stroke, math.tau - stroke)
        return ratios


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
    """A four-bar loop on the ground."""

    links: tuple[str, str, str]  # names of the input, the coupler and the output
    lengths: tuple[float, float, float, float]  # lengths of ground, input, coupler and output, m

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


MAX_EXAMINED_POSES = 7
"""Number of poses at which the rank is examined: at single ones, as in a change point, it is smaller than in general."""


@dataclass(frozen=True)
class CountedJoints(Recorded):
    """Joints of one kind."""

    kind: str  # word for the joint, as "pin"
    count: int  # number of them
    constraints: int  # number of constraints of each

    def __str__(self) -> str:
        """Return the term of the count, as "2 x 4 pins"."""
        return f"{self.constraints} x {self.count} {self.kind}{'s' if self.count > 1 else ''}"


@dataclass(frozen=True, kw_only=True)
class Mobility(Recorded):
    """Mobility of a mechanism without its drives."""

    bodies: int  # number of moving bodies
    guided: int  # number of coordinates that are given because bodies are described as ones that do not turn, or only turn
    joints: tuple[CountedJoints, ...]  # joints by their kind
    true: int  # degrees of freedom: coordinates minus the rank of the joint equations, where it is largest in the motion

    derived = ("gruebler", "redundant")

    @property
    def gruebler(self) -> int:
        """Grübler's count: 3 for each moving body, less the constraints."""
        return 3 * self.bodies - self.guided - sum(one.count * one.constraints for one in self.joints)

    @property
    def redundant(self) -> int:
        """Number of constraints that follow from the others."""
        return self.true - self.gruebler

    def __str__(self) -> str:
        """Return both numbers, with the count behind Grübler's."""
        terms = [f"3 x {self.bodies} {'bodies' if self.bodies > 1 else 'body'}"]
        terms += [f"{self.guided} for bodies that do not turn"] if self.guided else []
        count = f"{' - '.join([*terms, *map(str, self.joints)])} = {self.gruebler}"
        if not self.redundant:
            return f"mobility {self.true}: by Grübler's count {count}"
        noun = "constraint is" if self.redundant == 1 else "constraints are"
        return f"mobility {self.true}; Grübler's count is {count}, but {self.redundant} {noun} redundant"


def find_mobility(
    mechanism: Mechanism,
    poses: FloatArray,  # poses of its motion, in which the joints close; shape (n, bodies, 3)
) -> Mobility:
    """Return the mobility of a mechanism without its drives."""
    undriven = tuple(joint for joint in mechanism.joints if not isinstance(joint, RotationalDriver | TranslationalDriver))
    solver = PositionSolver(replace(mechanism, joints=undriven))
    examined = np.unique(np.linspace(0, len(poses) - 1, MAX_EXAMINED_POSES).astype(int))
    kinds = Counter((joint.noun or class_words(joint), _count_constraints(joint)) for joint in undriven)
    return Mobility(
        bodies=len(mechanism.bodies),
        guided=sum(3 - sum(body.moves) for body in mechanism.bodies),
        joints=tuple(CountedJoints(kind, count, constraints) for (kind, constraints), count in kinds.items()),
        true=min(solver.count_degrees_of_freedom(poses[k]) for k in examined),
    )


def _count_constraints(joint: Joint) -> int:
    return len(joint.constraint_rows(1.0))

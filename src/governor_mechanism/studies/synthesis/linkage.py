"""A four-bar linkage as an answer: its scene, and the check by running it through what was asked.

The joints at the ends of the shortest link of a Grashof linkage turn fully; the angles at the other two never pass a straight line, so
that their signs tell its two circuits apart.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.linkage import DriveTravel, FourBar, GrashofClass
from governor_mechanism.scenes.changed_document import make_scene
from governor_mechanism.studies.kinematics import study_kinematics
from governor_mechanism.types import BoolArray, ComplexArray, FloatArray, IntArray
from governor_mechanism.units.text_table import short_repr

DEFECTS: Final = ("none", "order", "branch", "circuit")
"""Defects, by their codes."""


class Judgement(NamedTuple):
    """What holds of linkages; shape (n,)."""

    defect: IntArray  # code of the gravest defect
    turns_fully: BoolArray  # whether the input does
    transmission: FloatArray  # least absolute sine of the transmission angle at the positions


def judge(fixed: ComplexArray, moving: ComplexArray) -> Judgement:
    """Return the defects of linkages, whose first link drives, with fixed pivots (n, 2) and moving ones (n, positions, 2)."""
    ground = (fixed[:, 1] - fixed[:, 0])[:, None]
    crank = (moving[:, :, 0] - fixed[:, :1]) / ground  # in the axes of the ground
    link = moving[:, :, 1] - fixed[:, 1:]
    coupler = moving[:, :, 1] - moving[:, :, 0]
    lengths = np.abs(np.stack([ground, moving[:, :1, 0] - fixed[:, :1], coupler[:, :1], link[:, :1]]))[:, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = np.imag(coupler * np.conj(link)) / np.abs(coupler * link)
    is_grashof = 2.0 * (lengths.min(axis=0) + lengths.max(axis=0)) < lengths.sum(axis=0)
    turns_fully = is_grashof & (lengths[:2].min(axis=0) < lengths[2:].min(axis=0))
    side = np.sign(crank.imag)
    changes_circuit = is_grashof & ~_is_constant(np.where(turns_fully[:, None], np.sign(sine), side))
    d, a, b, c = lengths
    has_zero = (np.abs(b - c) < np.abs(d - a)) & (np.abs(d - a) < b + c)  # whether the input of a triple rocker passes the ground
    middle = np.where(is_grashof, 0.5 * math.pi * side[:, 0], np.where(has_zero, 0.0, math.pi))[:, None]
    steps = np.diff(np.where(turns_fully[:, None], np.angle(crank), np.angle(crank * np.exp(-1j * middle))), axis=1)
    cyclic = np.minimum((steps % math.tau).sum(axis=1), (-steps % math.tau).sum(axis=1)) < math.tau
    in_order = np.where(turns_fully, cyclic, _is_constant(np.sign(steps)))
    defect = np.select([changes_circuit, ~_is_constant(np.sign(sine)), ~in_order], [3, 2, 1], 0)
    return Judgement(defect, turns_fully, np.abs(sine).min(axis=1))


def _is_constant(signs: FloatArray) -> BoolArray:
    constant: BoolArray = np.abs(signs.sum(axis=1)) == signs.shape[1]
    return constant


LINKS: Final = ("crank", "coupler", "rocker")
"""Names of input, coupler and output in the scene."""

DRIVE: Final = "input_angle"
"""Name of the reading that drives the linkage."""

SAME_POSITION: Final = 1e-3
"""Distance of the pivots, relative to the longest link, within which a position counts as one that was asked for: another branch is
farther away, and an approximate answer nearer."""

MIN_LENGTH_RATIO: Final = 1e-3
"""Length of a link relative to the longest below which there is no linkage to build."""

RATE: Final = math.tau / 6.0
"""Speed of the input in the scene, rad/s: 10 rpm."""

N_SAMPLES: Final = 181
"""Number of input angles at which a linkage is run."""

N_BETWEEN: Final = 61
"""Number of angles through which it is run from the first position to the lowest, and to the highest."""


@dataclass(frozen=True, kw_only=True)
class FourBarLinkage:
    """A four-bar linkage at the first of its positions; points are complex numbers x + iy, m.

    Attributes
    ----------
    fixed
        Fixed pivots of input and output.
    moving
        Moving pivots of input and output.
    point
        Point of the coupler.
    """

    fixed: tuple[complex, complex]
    moving: tuple[complex, complex]
    point: complex

    @property
    def lengths(self) -> tuple[float, float, float, float]:
        """Lengths of ground, input, coupler and output, m."""
        (first, second), (start, end) = self.fixed, self.moving
        return abs(second - first), abs(start - first), abs(end - start), abs(end - second)

    @property
    def can_be_built(self) -> bool:
        """Whether no link is a point beside the others."""
        return min(self.lengths) > MIN_LENGTH_RATIO * max(self.lengths)

    @property
    def type(self) -> GrashofClass:
        """Class by Grashof's rule."""
        return FourBar(links=LINKS, lengths=self.lengths).grashof


def linkage_document(linkage: FourBarLinkage, title: str, rate: float = RATE, duration: float = math.tau / RATE) -> dict[str, Any]:
    """Return the document of a scene in which a motor turns the input, rad/s, for a time, s."""
    (ground_a, ground_b), (start, end) = linkage.fixed, linkage.moving
    ends = ((ground_a, start), (start, end), (ground_b, end))
    bodies: list[dict[str, Any]] = [_rod(name, *pair) for name, pair in zip(LINKS, ends, strict=True)]
    bodies[1]["points"] = {"P": _pair((linkage.point - start) / cmath.exp(1j * cmath.phase(end - start)))}
    pins = (("ground.A", "crank.start"), ("crank.end", "coupler.start"), ("coupler.end", "rocker.end"), ("ground.B", "rocker.start"))
    joints: list[dict[str, Any]] = [{"type": "pin", "first": first, "second": second} for first, second in pins]
    joints.append({"type": "driven_turn", "name": "motor", "first": "ground", "second": "crank", "rate": rate})
    return {
        "title": title,
        "machine": "custom",
        "ground": {"A": _pair(ground_a), "B": _pair(ground_b)},
        "body": bodies,
        "joint": joints,
        "readings": {DRIVE: {"angle": "crank"}, "coupler_angle": {"angle": "coupler"}, "output_angle": {"angle": "rocker"}},
        "run": {"duration": duration, "paths": ["P"]},
    }


def _pair(point: complex) -> list[float]:
    return [float(point.real), float(point.imag)]


def _rod(name: str, start: complex, end: complex) -> dict[str, Any]:
    vector = end - start
    return {"name": name, "mass": 1.0, "rod": {"length": abs(vector)}, "at": _pair(start), "angle": cmath.phase(vector)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Check:
    """What running a linkage through the positions showed.

    Attributes
    ----------
    distance
        Largest distance of a point from where it was asked, m; infinite if a position is not reached.
    transmission
        Transmission angle farthest from 90 degrees, rad: over the turn of an input that turns fully, else between the positions.
    defects
        What keeps the linkage from passing all positions in their order, in words.
    turns_fully
        Whether the input does.
    sense
        Sense of the input in which it passes them: 1 anticlockwise, -1 clockwise.
    sweep
        Angle of the input from the first position to the last that it reaches, or a whole turn, rad.
    inputs
        Input angles at which it was run, rad; shape (n,).
    path
        Path of the coupler's point, m; shape (n, 2).
    """

    distance: float
    transmission: float
    defects: tuple[str, ...]
    turns_fully: bool
    sense: int
    sweep: float
    inputs: FloatArray
    path: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class SynthesisedLinkage(Recorded):
    """One answer: a linkage with its dimensions, checked by running it.

    Attributes
    ----------
    number
        Its number in the result.
    linkage
        Pivots and point at the first position.
    positions
        Moving pivots, and point of the coupler, at the positions for which it was made, m; shape (n, 3).
    check
        What running it showed.
    error
        Largest structural error of a function, rad; zero for positions and paths.
    cognates
        Both cognates, which draw the same path.
    """

    number: int
    linkage: FourBarLinkage
    positions: ComplexArray
    check: Check
    error: float = 0.0
    cognates: tuple[FourBarLinkage, ...] = ()

    __repr__ = short_repr
    record = (
        "number",
        *(f"{name}=linkage.{name}" for name in ("lengths", "type", "fixed", "moving", "point")),
        *("transmission_angle=check.transmission", "distance=check.distance", "defects=check.defects", "error", "cognates"),
    )

    @cached_property
    def scene(self) -> Scene:
        """The linkage as a scene, whose motor turns the input through the positions."""
        title = f"Synthesised {self.linkage.type}"
        return make_scene(linkage_document(self.linkage, title, self.check.sense * RATE, self.check.sweep / RATE))

    @property
    def defects(self) -> str:
        """The defects in words; "none" without any."""
        return "; ".join(self.check.defects) or "none"


def _length_column(key: str, index: int) -> Column:
    return Column(key, f"{key}, mm", ".6g/mm", "m", value=lambda row: row.linkage.lengths[index])


_PLACES: Final[Mapping[str, Callable[[FourBarLinkage], complex]]] = {
    "input_pivot": lambda linkage: linkage.fixed[0],
    "output_pivot": lambda linkage: linkage.fixed[1],
    "input_joint": lambda linkage: linkage.moving[0],
    "output_joint": lambda linkage: linkage.moving[1],
    "point": lambda linkage: linkage.point,
}
"""Fixed pivots, moving pivots and point at the first position, by the names of their columns."""


def _coordinate_columns(key: str) -> Iterator[Column]:
    """Yield the columns of the coordinates of a point in tables."""
    place = _PLACES[key]
    yield Column(f"{key}_x", unit="m", value=lambda row: place(row.linkage).real, in_json=False)
    yield Column(f"{key}_y", unit="m", value=lambda row: place(row.linkage).imag, in_json=False)


def _format_point(point: complex) -> str:
    return f"({1e3 * point.real:.5g}, {1e3 * point.imag:.5g})"


DIMENSION_COLUMNS: Final = (
    Column("number", "no.", "{number}", side="r"),
    *(_length_column(key, index) for index, key in enumerate(("ground", "input", "coupler", "output"))),
    Column("type", "type", value="linkage.type"),
)
CHECK_COLUMNS: Final = (
    Column("transmission_angle", "transmission, deg", ".2f/deg", "rad", value="check.transmission"),
    Column("defects", "defects", value="defects"),
    *(Column(key, unit="m", value=f"linkage.{key}", in_table=False) for key in ("fixed", "moving", "point")),
    *(column for key in _PLACES for column in _coordinate_columns(key)),
)
"""Columns of all answers: before and after those of a kind of synthesis. JSON has pivots and point as pairs, tables as coordinates."""
PIVOT_COLUMN: Final = Column(heading="fixed pivots, mm", cell=lambda row: "  ".join(map(_format_point, row.linkage.fixed)))
"""Fixed pivots of input and output, in the text."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Synthesis(Result):
    """Four-bars found for what was asked.

    Attributes
    ----------
    rows
        The linkages, the best first.
    notes
        What holds of the answer, in sentences.
    """

    rows: tuple[SynthesisedLinkage, ...]
    notes: tuple[str, ...]

    __repr__ = short_repr
    index = "number"
    data_files = ("csv", "json")
    columns = (*DIMENSION_COLUMNS, PIVOT_COLUMN, Column("distance", "distance, mm", ".2g/mm", "m", value="check.distance"), *CHECK_COLUMNS)

    def __str__(self) -> str:
        """Return the linkages as a table, and the notes."""
        return "\n".join([*([format_columns(self.columns, self.rows)] if self.rows else []), *self.notes])


def check_linkage(linkage: FourBarLinkage, positions: ComplexArray, points: ComplexArray | None = None) -> Check:
    """Run a linkage through positions (n, 3) by its input; MechanismError if that cannot lead at the first one."""
    # The positions are the moving pivots and the point of the coupler, in the order in which they are
    # asked for; distances are those of the given points, shape (n,), or else of all three.
    moving = positions[:, :2]
    scene = make_scene(linkage_document(linkage, "a linkage that is checked"))
    mechanism = scene.part.mechanism
    travel = DriveTravel(mechanism, DRIVE, PositionSolver(mechanism).solve({}))
    motion = travel.range
    middle = 0.5 * (motion.low + motion.high)
    angles = middle + np.angle((moving[:, 0] - linkage.fixed[0]) * cmath.exp(-1j * middle))
    is_inside = motion.contains(angles)
    reached = np.full((len(angles), 3), np.inf + 0j)
    if is_inside.any():
        reached[is_inside] = _run_through(scene, angles[0], angles[is_inside])
    gaps = np.abs(reached[:, :2] - moving).max(axis=1)
    is_reached = gaps < SAME_POSITION * max(linkage.lengths)
    if not is_reached.any():
        raise MechanismError("the linkage cannot be followed from its first position, near which it changes its branch")
    defects = [*_position_defects(linkage, travel, is_inside, is_reached), *_order_defects(angles[is_reached], bool(motion.period))]
    distances = np.abs(reached - positions).max(axis=1) if points is None else np.abs(reached[:, 2] - points)
    sense, sweep = _plan_run(angles[is_reached], bool(motion.period))
    inputs = travel.default_values(N_SAMPLES) if motion.period else np.linspace(*_between(angles[is_reached], motion.ends), N_SAMPLES)
    study = study_kinematics(scene, DRIVE, inputs, readings=["transmission_angle.coupler"])
    transmission = study.readings["transmission_angle.coupler"]
    return Check(
        distance=float(distances.max()),
        transmission=float(transmission[np.argmax(np.abs(transmission - 0.5 * math.pi))]),
        defects=tuple(defects),
        turns_fully=travel.turns_fully,
        sense=sense,
        sweep=sweep,
        inputs=inputs,
        path=study.paths["P"],
    )


def _run_through(scene: Scene, first: float, angles: FloatArray) -> ComplexArray:
    """Return moving pivots and point (n, 3) at input angles: from the first position to the lowest, and to the highest of them."""
    # Angles between keep the kinematics on one branch where another is near.
    reached = np.zeros((len(angles), 3), dtype=np.complex128)
    for end, is_here in ((angles.min(), angles <= first), (angles.max(), angles >= first)):
        grid = np.unique(np.concatenate([angles[is_here], np.linspace(first, end, N_BETWEEN)]))
        paths = study_kinematics(scene, DRIVE, grid if end > first else grid[::-1]).paths
        places = np.searchsorted(grid, angles[is_here])
        places = places if end > first else len(grid) - 1 - places
        reached[is_here] = np.column_stack([_as_complex(paths[name])[places] for name in ("crank.end", "coupler.end", "P")])
    return reached


def _as_complex(path: FloatArray) -> ComplexArray:
    return path[:, 0] + 1j * path[:, 1]


def _between(angles: FloatArray, ends: tuple[float, float]) -> tuple[float, float]:
    """Return the ends of the positions, or those of the travel, a thousandth of it inside, for a single one."""
    low, high = float(angles.min()), float(angles.max())
    margin = 1e-3 * (ends[1] - ends[0])
    return (low, high) if high - low > margin else (ends[0] + margin, ends[1] - margin)


def _position_defects(linkage: FourBarLinkage, travel: DriveTravel, is_inside: BoolArray, is_reached: BoolArray) -> list[str]:
    """Name the positions on another circuit, in which the links are assembled otherwise, and those behind a toggle of the input."""
    has_one_circuit = linkage.type is GrashofClass.TRIPLE_ROCKER
    found: dict[str, list[str]] = {"circuit": [], "branch": []}
    for number, (inside, reached) in enumerate(zip(is_inside, is_reached, strict=True), start=1):
        if not reached:
            is_branch = has_one_circuit or (inside and not travel.turns_fully)
            found["branch" if is_branch else "circuit"].append(str(number))
    return [f"{kind} ({', '.join(numbers)})" for kind, numbers in found.items() if numbers]


def _order_defects(angles: FloatArray, is_cyclic: bool) -> list[str]:
    """Return whether the input passes its angles in another order than asked for."""
    steps = np.diff(angles)
    ways = ([np.sum(steps % math.tau), np.sum(-steps % math.tau)] if is_cyclic else []) if len(steps) else [0.0]
    in_order = any(way < math.tau for way in ways) or bool(np.all(steps > 0.0) or np.all(steps < 0.0))
    return [] if in_order else ["order"]


def _plan_run(angles: FloatArray, is_cyclic: bool) -> tuple[int, float]:
    """Return the sense in which the input passes its angles, and how far it turns."""
    steps = np.diff(angles)
    if is_cyclic:
        return (1 if np.sum(steps % math.tau) <= np.sum(-steps % math.tau) else -1), math.tau
    farthest = float(angles[np.argmax(np.abs(angles - angles[0]))] - angles[0])
    return (1 if farthest >= 0.0 else -1), abs(farthest) or 0.1


def output_changes(linkage: FourBarLinkage, inputs: FloatArray) -> FloatArray:
    """Return how far the output turns from the first position to input angles, rad; infinite if the input cannot go through them."""
    scene = make_scene(linkage_document(linkage, "a linkage that generates a function"))
    first = cmath.phase(linkage.moving[1] - linkage.fixed[1])
    try:
        outputs = study_kinematics(scene, DRIVE, inputs).readings["output_angle"]
    except MechanismError:
        return np.full(len(inputs), np.inf)
    unwrapped: FloatArray = np.unwrap(outputs)
    nearest = int(np.argmin(np.abs(inputs - cmath.phase(linkage.moving[0] - linkage.fixed[0]))))
    changes: FloatArray = unwrapped - first - math.tau * round((unwrapped[nearest] - first) / math.tau)
    return changes


Candidate = tuple[FourBarLinkage, ComplexArray]
"""A linkage with its positions, shape (n, 3)."""


def check_all(candidates: Sequence[Candidate], points: ComplexArray | None = None) -> tuple[SynthesisedLinkage, ...]:
    """Return the linkages that can be built, checked by running them: first those without defects, with the best transmission angles."""
    # A linkage at a change point, from which two motions lead on, or whose input is at a dead position
    # first, is not among them.
    checked = list[tuple[FourBarLinkage, ComplexArray, Check]]()
    for linkage, positions in candidates:
        if linkage.can_be_built and linkage.type is not GrashofClass.CHANGE_POINT:
            with suppress(MechanismError):
                checked.append((linkage, positions, check_linkage(linkage, positions, points)))
    checked.sort(key=lambda one: (len(one[2].defects), round(abs(one[2].transmission - 0.5 * math.pi), 6), max(one[0].lengths)))
    return tuple(
        SynthesisedLinkage(number=number, linkage=linkage, positions=positions, check=check)
        for number, (linkage, positions, check) in enumerate(checked, start=1)
    )

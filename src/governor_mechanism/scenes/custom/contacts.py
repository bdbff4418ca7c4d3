"""Outlines of bodies as scene files write them, and [[contact]]: a roller or an outline of a body that touches that of another one."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

from governor_mechanism.machines.base import rotate_point
from governor_mechanism.machines.custom import SketchedBody
from governor_mechanism.mechanics.curves.outlines import (
    chains_of,
    find_circle,
    find_outline_problems,
    find_profile_problem,
    find_roller_problem,
)
from governor_mechanism.model.curves import Corner, CornerOutline, Curve, CurveOutline, Outline, PolarCurve
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.custom.field_types import CUSTOM_TYPES, PointRegistry
from governor_mechanism.scenes.quantities import Table
from governor_mechanism.units.fields import declare, entry, quantity
from governor_mechanism.units.problems import KEY, ProblemCode, mistake, parse_each, wrong_value
from governor_mechanism.units.quantities import format_value

MAX_TEETH: Final = 500
"""Largest number of teeth or slots of a wheel."""

MAX_GAPS: Final = 100
"""Largest number of gaps of a contact: each costs time in every step."""


def _make_curve_outline(*, curve: Curve, inset: float = 0.0) -> CurveOutline:
    if not isinstance(curve, PolarCurve):
        raise mistake(ProblemCode.WRONG_TYPE, f"{KEY}.curve must be closed, with closed, polar, lifts or harmonics")
    return CurveOutline(curve=curve, inset=inset)


CURVE_OUTLINE: Final = Table(
    make=_make_curve_outline,
    fields={
        "curve": declare("curve", meaning="a closed curve about the origin of the body, as that of a curve slot"),
        "inset": declare(
            "quantity",
            "length",
            sign="not negative",
            built=True,
            default=0.0,
            meaning="the distance of the outline inside of the curve: for a cam the radius of the roller whose centre follows the curve",
        ),
    },
    types=CUSTOM_TYPES,
    example='{ curve = { radius = "40 mm", harmonics = [{ amplitude = "5 mm", order = 1 }] } }',
)
"""An outline along a closed curve."""


def _make_count_type(least: int) -> quantities.ValueType:
    """Return the type of numbers of teeth, slots or rollers round a wheel."""

    def parse(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= MAX_TEETH:
            raise wrong_value(value, f"must be a whole number from {least} to {MAX_TEETH}", code=ProblemCode.OUT_OF_RANGE)
        return value

    return quantities.without_context(parse, {"type": "integer", "minimum": least, "maximum": MAX_TEETH})


def _parse_corner(value: object) -> Corner:
    """Return a corner [x, y], or [x, y, radius] with the radius of the edge that begins there."""
    if not isinstance(value, list | tuple) or len(value) not in (2, 3):
        raise wrong_value(value, "must be [x, y], or [x, y, radius] where an arc begins")
    names = ("x", "y", "radius")
    numbers = [quantities.parse_si(item, "length", f"{KEY} {name}") for name, item in zip(names, value, strict=False)]
    return Corner(**dict(zip(names, numbers, strict=False)))


def _parse_corners(value: object) -> list[Corner]:
    """Return corners [x, y] or [x, y, radius]."""
    if not isinstance(value, list | tuple):
        raise wrong_value(value, f"must be a list of corners [x, y] or [x, y, radius], or {CURVE_OUTLINE.example}")
    return parse_each(_parse_corner, value, paths=[f"{KEY}, corner {number}:" for number in range(1, len(value) + 1)])


def _repeat_corners(*, corners: Sequence[Corner], repeat: int) -> list[Corner]:
    """Return corners that stand as often round the origin, turned from one to the next by as much of a turn."""
    places = [(rotate_point(one.x, one.y, math.tau * k / repeat), one.radius) for k in range(repeat) for one in corners]
    return [Corner(x=x, y=y, radius=radius) for (x, y), radius in places]


REPEATED_CORNERS: Final = Table(
    make=_repeat_corners,
    fields={
        "corners": declare("corners", meaning="the corners of one tooth or slot, anticlockwise, as a list [x, y] or [x, y, radius]"),
        "repeat": declare("count", meaning="how often it stands round the origin of the body"),
    },
    types={**CUSTOM_TYPES, "corners": quantities.without_context(_parse_corners, {"type": "array"}), "count": _make_count_type(2)},
    example="{ corners = [[x, y], ...], repeat = 12 }",
)
"""An outline of equal teeth or slots round the origin."""


def parse_outline(value: object) -> Outline:
    """Return an outline: a list of corners, a table of corners that repeat, or the table of a closed curve."""
    if isinstance(value, Mapping) and not {"corners", "repeat"} & set(value):
        curve_outline: CurveOutline = CURVE_OUTLINE.build(value)
        return curve_outline
    corners = REPEATED_CORNERS.build(value) if isinstance(value, Mapping) else _parse_corners(value)
    outline = CornerOutline(corners=tuple(corners))
    if problems := list(find_outline_problems(outline)):
        raise mistake(ProblemCode.OUT_OF_RANGE, *(f"{KEY}: {problem}" for problem in problems))
    return outline


OUTLINE_TYPE: Final = quantities.without_context(
    parse_outline,
    {"type": ["array", "object"], "description": "corners [x, y] or [x, y, radius], { corners, repeat }, or { curve, inset }"},
)
"""An outline of a body."""


@dataclass(frozen=True, kw_only=True)
class Touching:
    """What touches, a roller or a closed curve about a point, and what it touches, an outline about its origin."""

    roller: Point
    origin: Point
    outline: Outline
    radius: float = 0.0
    profile: CurveOutline | None = None

    def find_problem(self) -> str:
        """Return why it cannot touch the outline; empty if it can."""
        if self.profile is not None and isinstance(self.outline, CornerOutline):
            return find_profile_problem(self.outline, self.profile)
        return find_roller_problem(self.outline, self.radius)


def _find_outline(registry: PointRegistry, name: str, key: str) -> tuple[SketchedBody, Outline]:
    """Return a body with its outline."""
    body = registry.bodies.get(name)
    if body is None or body.outline is None:
        cure = 'write outline = [["0 mm", "0 mm"], ...] in its [[body]]' + (
            f', or first = "{name}.origin" for a point' if key == "first" else ""
        )
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY}.{key} names {format_value(name)}, which has no outline; {cure}")
    return body, body.outline


def _pair_outlines(first: tuple[SketchedBody, Outline], second: tuple[SketchedBody, Outline]) -> Touching:
    """Return which of two outlines touches the other, so that they have one point in common: a circle, as a roller, or a curve."""
    orders = ((first, second), (second, first))
    for (body, outline), (touched, other) in orders:
        circle = find_circle(outline)
        if circle is not None and circle[2] > 0.0:
            return Touching(roller=body.point(circle[:2]), origin=touched.point((0.0, 0.0)), outline=other, radius=circle[2])
    for (body, outline), (touched, other) in orders:
        if isinstance(outline, CurveOutline) and isinstance(other, CornerOutline):
            return Touching(roller=body.point((0.0, 0.0)), origin=touched.point((0.0, 0.0)), outline=other, profile=outline)
    both = "are curves" if isinstance(first[1], CurveOutline) else "have corners"
    raise mistake(
        ProblemCode.CONFLICT,
        f"{KEY}: the outlines of {format_value(first[0].name)} and {format_value(second[0].name)} both {both}; of two that touch one is "
        "a circle, or one a closed curve and the other one of edges and arcs; else give each corner or tip that touches a contact of its "
        "own, with its radius",
    )


def _deal_rollers(rollers: Sequence[Point], at_once: int) -> list[tuple[Point, ...]]:
    """Return groups of rollers round a wheel, none of which has two of as many that follow one another."""
    # They are dealt in rounds that are equal but for one roller, so that also across the last and the first one each group has a roller in
    # turn.
    n_rounds = len(rollers) // at_once
    starts = [number * len(rollers) // n_rounds for number in range(n_rounds + 1)]
    rounds = [rollers[start:end] for start, end in pairwise(starts)]
    return [tuple(one[place] for one in rounds if place < len(one)) for place in range(max(map(len, rounds)))]


@dataclass(frozen=True, kw_only=True)
class WrittenContact:
    """A contact as [[contact]] describes it."""

    name: str = entry("label", default="", meaning="the name; the gap is the reading NAME_gap. By default that of both bodies")
    first: Point | str = entry(
        "point or outline",
        meaning='the centre of the roller, or the point, that touches the outline, as "follower.roller"; or a body whose own outline does',
    )
    radius: float = quantity(
        "length",
        sign="not negative",
        built=True,
        default=0.0,
        meaning="the radius of the roller; 0 for a point, which needs an outline along a curve, and for a body with its own outline",
    )
    second: str = entry("body", meaning='the body with the outline, as "cam"')
    restitution: float = entry("restitution", default=0.0, meaning="the coefficient of restitution, 0 to 1")
    friction: float = quantity(
        "number", sign="not negative", built=True, default=0.0, meaning="the coefficient of Coulomb friction, sticking and sliding"
    )

    repeat: int = entry("count", default=1, meaning="how often the roller stands round the origin of its body, as the tips of a wheel")
    at_once: int = entry(
        "count",
        default=1,
        meaning="how many rollers that follow one another may touch a part of the outline at once; each costs time in every step",
    )

    def gaps(self, registry: PointRegistry) -> list[OutlineGap]:
        """Return the gaps of the contact, one for each part of the outline between hollow corners, and for each roller at once."""
        touching = self._find_touching(registry)
        where = f"{KEY} of {format_value(self._first_body)} and {format_value(self.second)}"
        if problem := touching.find_problem():
            raise mistake(ProblemCode.OUT_OF_RANGE, f"{where}: {problem}")
        n_chains = len(chains_of(touching.outline)) if isinstance(touching.outline, CornerOutline) else 1
        rollers = self._rollers(registry, touching)
        if self.at_once > len(rollers):
            text = f"{KEY}.at_once is at most the number of the rollers, {len(rollers)}; found {self.at_once}"
            raise mistake(ProblemCode.OUT_OF_RANGE, f"{text}; raise repeat, or leave at_once out")
        dealt = _deal_rollers(rollers, self.at_once)
        n_gaps = n_chains * len(dealt)
        if n_gaps > MAX_GAPS:
            each = f" for each of {len(dealt)} groups of rollers" if len(dealt) > 1 else ""
            problem = f"the outline has {n_chains} hollow corners{each}, and at most {MAX_GAPS} parts between them are looked at"
            raise mistake(ProblemCode.OUT_OF_RANGE, f"{where}: {problem}; round them with hollow arcs")
        pairs = [(chain, group) for chain in range(n_chains) for group in dealt]
        return [
            self._gap(replace(touching, roller=group[0]), chain, f"_{number}" if n_gaps > 1 else "", group[1:])
            for number, (chain, group) in enumerate(pairs, start=1)
        ]

    def _rollers(self, registry: PointRegistry, touching: Touching) -> tuple[Point, ...]:
        """Return the centres of all rollers."""
        if self.repeat == 1:
            return (touching.roller,)
        body = registry.bodies.get(self._first_body)
        if body is None or not (isinstance(self.first, Point) and isinstance(touching.outline, CornerOutline)):
            text = f"{KEY}.repeat is for rollers of a body that touch an outline of corners"
            raise mistake(ProblemCode.CONFLICT, f"{text}; leave it out, or write a [[contact]] for each roller")
        origin = body.point((0.0, 0.0))
        x, y = self.first.x - origin.x, self.first.y - origin.y
        places = [rotate_point(x, y, math.tau * k / self.repeat) for k in range(1, self.repeat)]
        return (self.first, *(body.point(place) for place in places))

    @property
    def _first_body(self) -> str:
        """Name of the body that touches."""
        return self.first if isinstance(self.first, str) else self.first.body

    def _find_touching(self, registry: PointRegistry) -> Touching:
        """Return what touches, and what it touches."""
        second = _find_outline(registry, self.second, "second")
        if self._first_body == self.second:
            raise mistake(ProblemCode.CONFLICT, f"both sides are of {format_value(self.second)}; a body cannot touch itself")
        if isinstance(self.first, Point):
            return Touching(roller=self.first, origin=second[0].point((0.0, 0.0)), outline=second[1], radius=self.radius)
        first = _find_outline(registry, self.first, "first")
        if self.radius:
            text = f"{KEY}.first is {format_value(self.first)}, which touches with its own outline; leave radius out, or name a point of it"
            raise mistake(ProblemCode.CONFLICT, text)
        return _pair_outlines(first, second)

    def _gap(self, touching: Touching, chain: int, suffix: str, others: tuple[Point, ...]) -> OutlineGap:
        """Return the gap to a part of the outline, of a roller or of the nearest one of several."""
        name = self.name or "_".join(re.sub(r"\W+", "_", body) for body in (self._first_body, self.second))
        return OutlineGap(
            name=f"{name}_gap{suffix}",
            quantity="length",
            contact=name,
            origin=touching.origin,
            roller=touching.roller,
            outline=touching.outline,
            chain=chain,
            radius=touching.radius,
            restitution=self.restitution,
            profile=touching.profile,
            friction=self.friction,
            others=others,
        )


@dataclass(frozen=True, kw_only=True)
class ContactTable(Table):
    """The table of a contact."""

    def build(self, values: object, context: Any = None, **arguments: Any) -> list[OutlineGap]:
        """Return the gaps of the contact."""
        contact = WrittenContact(**self.read(values, context))
        if contact.name and not contact.name.isidentifier():
            raise mistake(
                ProblemCode.WRONG_TYPE, f"{KEY}.name consists of letters, digits and _, as cam_roller; found {format_value(contact.name)}"
            )
        return contact.gaps(context)


CONTACT: Final = ContactTable.of(WrittenContact, types={**CUSTOM_TYPES, "count": _make_count_type(1)})
"""[[contact]]; its context is the `PointRegistry`."""


def find_name_conflicts(gaps: Sequence[OutlineGap], readings: Sequence[str]) -> list[str]:
    """Return a sentence for each gap whose name another gap or reading has."""
    names = [*readings, *(gap.name for gap in gaps)]
    return [
        f"contact {gap.contact!r}: there already is a reading {gap.name!r}; give the contact another name"
        for number, gap in enumerate(gaps, start=len(readings))
        if gap.name in names[:number]
    ]

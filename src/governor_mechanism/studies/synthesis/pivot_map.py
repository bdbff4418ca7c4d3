"""A map for three positions of a body: what four-bar each place of the second pivot makes, with the first one chosen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.studies.synthesis.linkage import DEFECTS, MIN_LENGTH_RATIO, judge
from governor_mechanism.studies.synthesis.positions import COLUMNS, KEYS, Displacements, other_pivots
from governor_mechanism.studies.synthesis.tables import parse_pair, read_points, require_count
from governor_mechanism.types import BoolArray, ComplexArray, FloatArray
from governor_mechanism.units.problems import check_arguments, whole_number
from governor_mechanism.units.quantities import parse_quantity
from governor_mechanism.units.text_table import short_repr

SPAN_RATIO: Final = 4.0
"""Width of a map relative to the extent of the positions, unless it is given."""

REGIONS: Final = ("input turns fully", "input rocks", *DEFECTS[1:], "no linkage")
"""What the places of a map are: without defects by the class of the linkage, else by the gravest defect."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PivotRegion:
    """Places of the second pivot of one kind: their share of the map, and the one with the best transmission angle, m and rad."""

    name: str
    share: float
    x: float
    y: float
    transmission: float

    __repr__ = short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class PivotMap(Result):
    """Four-bars through three positions of a body by the place of their second pivot; arrays have one value for each place.

    Attributes
    ----------
    positions
        The positions: x and y, m, and the angle, rad; shape (3, 3).
    varied
        Which pivots the places are: "moving_pivots", in the first position, or "fixed_pivots".
    first
        The first pivot, that of the input link, and the pivot that follows from it, m; shape (2, 2).
    x
        Places of the second pivot, m; shape (n,).
    y
        The same.
    other_x
        The pivot that follows from each, m; shape (n,).
    other_y
        The same.
    link
        Length of the output link, m; shape (n,).
    region
        What each place is, one of the names of `regions`; shape (n,).
    transmission
        Transmission angle at the positions, from a straight line, rad: the least; shape (n,).
    regions
        Their shares of the map and their best places.
    """

    positions: FloatArray
    varied: str
    first: FloatArray
    x: FloatArray
    y: FloatArray
    other_x: FloatArray
    other_y: FloatArray
    link: FloatArray
    region: tuple[str, ...]
    transmission: FloatArray
    regions: tuple[PivotRegion, ...]

    __repr__ = short_repr
    figure = "render.figures.synthesis.pivot_map_figure"
    data_files = ("csv", "json")
    columns = (
        *(Column(key, unit="m") for key in ("x", "y", "other_x", "other_y", "link")),
        Column("region"),
        Column("transmission", unit="rad"),
    )

    @property
    def is_possible(self) -> bool:
        """Whether a place makes a linkage without defects."""
        return any(region.name in REGIONS[:2] for region in self.regions)

    def __str__(self) -> str:
        """Return the regions as a table."""
        columns = (
            Column("name", "region"),
            Column("share", "of the map, %", lambda region: f"{100.0 * region.share:.1f}", side="r"),
            Column("x", "best x, mm", ".6g/mm", "m"),
            Column("y", "best y, mm", ".6g/mm", "m"),
            Column("transmission", "transmission, deg", ".2f/deg", "rad"),
        )
        return format_columns(columns, self.regions)


def read_map_task(source: object, given: Mapping[str, Any]) -> tuple[FloatArray, str, complex, float, int]:
    """Return positions, the kind of the pivots, the first of them, the width of the map, m, and the number of places on a side."""
    positions, keys = read_points(source, COLUMNS, (*KEYS, "span", "count"))
    keys |= {name: value for name, value in given.items() if value is not None}
    if positions is None:
        raise MechanismError("the file has no positions; write points = [[x, y, angle], ...]")
    require_count(positions, (3,), "the number of positions of a map")
    if np.abs(np.exp(1j * (positions[:, 2] - positions[0, 2])) - 1.0).max() < 1e-9:
        raise MechanismError("the angles of all positions are the same: any parallelogram with links of equal length moves a body so")
    if all(name in keys for name in KEYS):
        raise MechanismError("give fixed_pivots or moving_pivots, one of both")
    extent = Displacements(positions).extent
    span = parse_quantity(keys.pop("span", SPAN_RATIO * extent), "length", "span, the width of the map")
    if not span > 0.0:
        raise MechanismError(f"span, the width of the map, must be positive; found {span:g} m")
    count = _check_count(keys.pop("count", 101))
    name, value = next(iter(keys.items()), ("moving_pivots", [positions[0, :2].tolist()]))
    if not isinstance(value, list | tuple) or len(value) not in (1, 2):
        raise MechanismError(f"{name} of a map must be one point, as [[0, 0]]; the second one is varied")
    return positions, name, complex(*parse_pair(value[0], "length", f"point 1 of {name}")), span, count


@check_arguments(count=whole_number(2))
def _check_count(count: int) -> int:
    return count


def map_pivots(positions: FloatArray, name: str, first: complex, span: float, count: int) -> PivotMap:
    """Return the map of the second pivot around the middle of the positions."""
    body = Displacements(positions)
    follows = complex(other_pivots(body, np.array(first), name))
    if np.isnan(follows):
        raise MechanismError(
            f"the first of {name} has its three places on a line, so that its link would be a slider; choose another point"
        )
    middle = positions[:, :2].mean(axis=0)
    side = span * np.linspace(-0.5, 0.5, count)
    places = ((middle[0] + side)[None, :] + 1j * (middle[1] + side)[:, None]).ravel()
    others = other_pivots(body, places, name)
    is_moving = name == "moving_pivots"
    starts, ends = (first, places) if is_moving else (follows, others)
    fixed = np.stack(np.broadcast_arrays(*((follows, others) if is_moving else (first, places))), axis=1)
    moving = np.stack(np.broadcast_arrays(body.moved(starts), body.moved(ends)), axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        judgement = judge(fixed, moving)
    region = np.where(judgement.defect > 0, judgement.defect + 1, np.where(judgement.turns_fully, 0, 1))
    region[~_can_be_built(fixed, moving)] = len(REGIONS) - 1
    transmission = np.arcsin(np.clip(judgement.transmission, 0.0, 1.0))
    regions = []
    for code, text in enumerate(REGIONS):
        inside = region == code
        if inside.any():
            has_angle = code < len(REGIONS) - 1
            best = int(np.argmax(np.where(inside, transmission, -1.0))) if has_angle else int(np.argmax(inside))
            angle = float(transmission[best]) if has_angle else math.nan
            place = complex(places[best])
            regions.append(PivotRegion(name=text, share=float(inside.mean()), x=place.real, y=place.imag, transmission=angle))
    return PivotMap(
        positions=positions,
        varied=name,
        first=np.array([[first.real, first.imag], [follows.real, follows.imag]]),
        x=places.real,
        y=places.imag,
        other_x=others.real,
        other_y=others.imag,
        link=np.abs(others - places),
        region=tuple(REGIONS[code] for code in region.tolist()),
        transmission=transmission,
        regions=tuple(regions),
    )


def _can_be_built(fixed: ComplexArray, moving: ComplexArray) -> BoolArray:
    """Return whether all links are finite and none is a point beside the others."""
    ends = moving[:, 0]
    lengths = np.abs(np.stack([fixed[:, 1] - fixed[:, 0], *(ends - fixed).T, ends[:, 1] - ends[:, 0]]))
    can_be_built: BoolArray = np.isfinite(lengths).all(axis=0) & (lengths.min(axis=0) > MIN_LENGTH_RATIO * lengths.max(axis=0))
    return can_be_built

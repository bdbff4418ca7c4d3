"""Points of the ground that a person drags on the page."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.live.quantities import split_quantity
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.render.page.views import PageView
from governor_mechanism.units.quantities import parse_quantity

START_STEP: Final = 1e-4
"""Step of the leading coordinate, rad or length scales, that tells where a body moves."""

ON_AXIS: Final = 1e-6
"""Distance from the axis, length scales, up to which a mass centre lies on it."""

PLAIN_EXPRESSION: Final = re.compile(r"\s*=\s*(-?)\s*([A-Za-z_]\w*)\s*")
"""An expression that is a dimension or its negative."""


@dataclass(frozen=True, kw_only=True)
class Coordinate:
    """A coordinate that follows a quantity of the scene: its key, its value, m, and the change of the quantity by a metre."""

    key: str
    value: float
    per_metre: float


@dataclass(frozen=True, kw_only=True)
class Grip:
    """A point of the drawing that a person drags.

    Attributes
    ----------
    name
        What it is.
    place
        Its place in the picture, units.
    effects
        For each quantity that follows it, its key and the changes by a unit of the picture to the right and down.
    starts_motion
        Whether it moves where the motion starts, and not the mechanism.
    """

    name: str
    place: tuple[float, float]
    effects: tuple[tuple[str, float, float], ...]
    starts_motion: bool = False


def find_grips(scene: Scene, view: PageView) -> Iterator[Grip]:
    """Yield the points that can be dragged in the first view of a scene of one part."""
    if view.has_plane and view.shows_bodies and len(scene.parts) == 1:
        yield from _find_pivots(scene.document, scene.part, view)
        yield from _find_start(scene, view)


def _find_pivots(document: Mapping[str, Any], part: Part, view: PageView) -> Iterator[Grip]:
    """Yield the points of the ground of a custom machine whose coordinates are quantities of its file."""
    ground = document.get("ground")
    for name, position in ground.items() if isinstance(ground, Mapping) else ():
        if not isinstance(position, list | tuple) or len(position) != 2:
            continue
        x, y = (_coordinate(f"ground.{name}.{k}", one, document, part) for k, one in enumerate(position, start=1))
        if x is not None and y is not None and x.key != y.key:
            scale = view.picture.scale
            effects = ((x.key, x.per_metre / scale, 0.0), (y.key, 0.0, -y.per_metre / scale))
            yield Grip(name=f"pivot {name}", place=_place(view, x.value, y.value), effects=effects)


def _place(view: PageView, x: float, y: float) -> tuple[float, float]:
    """Return the place of a point, m, in the picture."""
    place = view.picture.place(view.place_poses(np.array([x, y, 0.0]))[:2])
    return float(place[0]), float(place[1])


def _find_start(scene: Scene, view: PageView) -> Iterator[Grip]:
    """Yield the body that moves farthest with the leading coordinate, where its start is a quantity of the file."""
    coordinate = scene.mechanism.coordinate
    written = split_quantity(scene.document.get("start", {}).get(coordinate))
    if written is None or scene.mechanism.count_drivers():
        return
    number, unit = written
    quantity = scene.mechanism.reading(coordinate).quantity
    factor = parse_quantity(f"1 {unit}", quantity, coordinate) if unit else 1.0
    value = factor * number
    step = START_STEP * (1.0 if quantity == "angle" else scene.mechanism.length_scale)
    try:
        poses = analyse_kinematics(scene, coordinate, [value, value + step]).poses
    except MechanismError:  # at a turning point of the coordinate
        return
    moves = np.linalg.norm(np.diff(poses[..., :2], axis=0)[0], axis=1)
    is_beside_axis = np.abs(poses[0, :, 0]) > ON_AXIS * scene.mechanism.length_scale  # a hand pulls a ball, not the sleeve
    body = int(np.argmax(np.where(is_beside_axis, moves, 0.0) if np.any(moves[is_beside_axis] > 0.0) else moves))
    here, there = (np.array(_place(view, *pose[:2])) for pose in poses[:, body])
    tangent = (there - here) * factor / step
    length = float(tangent @ tangent)
    if length > 0.0:
        dx, dy = (tangent / length).tolist()
        name = scene.mechanism.bodies[body].name.replace("_", " ")
        yield Grip(name=name, place=(float(here[0]), float(here[1])), effects=((f"start.{coordinate}", dx, dy),), starts_motion=True)


def _coordinate(key: str, written: object, document: Mapping[str, Any], part: Part) -> Coordinate | None:
    """Return a coordinate; None if it does not follow a single quantity."""
    sign = 1.0
    match = PLAIN_EXPRESSION.fullmatch(written) if isinstance(written, str) else None
    if match and match[2] in part.dimensions:
        sign = -1.0 if match[1] else 1.0
        key, written = f"dimensions.{match[2]}", document["dimensions"].get(match[2])
    quantity = split_quantity(written)
    if quantity is None:
        return None
    number, unit = quantity
    factor = parse_quantity(f"1 {unit}", "length", key) if unit else 1.0
    return Coordinate(key=key, value=sign * factor * number, per_metre=sign / factor)

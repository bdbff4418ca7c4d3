"""What a person drags on the page: points of the ground, and what moves, to where the motion is to start."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.effects.holding import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.live.quantities import Quantity, split_quantity
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.render.geometry.primitives import BoundingBox
from governor_mechanism.render.page.page_data import collect_tracks
from governor_mechanism.render.page.views import PageView, show_run
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import display_unit, format_quantity, format_reading_name, parse_quantity

START_STEP: Final = 1e-4
"""Step of the leading coordinate, rad or length scales, that tells where a body moves."""

ON_AXIS: Final = 1e-6
"""Distance from the axis, length scales, up to which a mass centre lies on it."""

TRAVEL_SAMPLES: Final = 121
"""Number of positions of a travel: a cubic between them is drawn to a tenth of a pixel."""

STOP_MARGIN: Final = 0.02
"""Share of the distance of two samples by which a travel ends before a stop, which is located between them."""

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
    """A point of the drawing that a person drags."""

    name: str  # what it is
    place: tuple[float, float]  # its place in the picture, units
    # for each quantity that follows it, its key and the changes by a unit of the picture to the right and
    # down
    effects: tuple[tuple[str, float, float], ...]
    # value of its quantity where the motion starts, of what moves that start and not the mechanism; None for
    # others
    start: float | None = None


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Where what is drawn goes while the leading coordinate takes other values at the start."""

    key: str  # key of the quantity that says where the motion starts
    values: tuple[float, float]  # its first and its last value, in its unit; the samples between them are equally far apart
    is_closed: bool  # whether the last sample is the first one again
    ends: tuple[str, str]  # why it ends at either end, as sentences
    tracks: Sequence[Mapping[str, Any]]  # tracks of what moves, as a page has them
    # role of each shape of the drawing, and the number of its track; None for a shape without one
    shapes: Sequence[tuple[str, int | None]]


class TravelEnd(NamedTuple):
    """An end of the travel: the value of the coordinate (SI), and what is there."""

    value: float
    sentence: str


def find_grips(run: Trajectory, view: PageView) -> Iterator[Grip]:
    """Yield the points that can be dragged in the first view of a run of one part."""
    scene = run.scene
    if view.has_plane and view.shows_bodies and len(scene.parts) == 1:
        yield from _find_pivots(scene.document, scene.part, view)
        yield from _find_starts(run, view)


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


def find_start(run: Trajectory) -> tuple[Quantity, float] | None:
    """Return where the leading coordinate starts, as its file writes it or in its usual unit, and that unit in SI; None if driven."""
    # None too if the mechanism has several parts.
    scene = run.scene
    name = scene.mechanism.coordinate
    if len(scene.parts) != 1 or scene.mechanism.count_drivers() or name not in run.readings:
        return None
    written = split_quantity(scene.document.get("start", {}).get(name))
    quantity = scene.mechanism.reading(name).quantity
    unit = written[1] if written else display_unit(READING_UNITS[quantity])[1]
    factor = parse_quantity(f"1 {unit}", quantity, name) if unit else 1.0
    value = float(run.readings[name][0]) / factor
    words = format_reading_name(name)
    return Quantity(key=f"start.{name}", group="start", words=words, value=value, unit=unit, low=value, high=value), factor


def _find_starts(run: Trajectory, view: PageView) -> Iterator[Grip]:
    """Yield a ball, and what slides along the axis, where the motion starts."""
    found, scene = find_start(run), run.scene
    if found is None:
        return
    (start, factor), mechanism = found, scene.mechanism
    value = start.value * factor
    step = START_STEP * (1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.length_scale)
    try:
        poses = analyse_kinematics(scene, mechanism.coordinate, [value, value + step]).poses
    except MechanismError:  # at a turning point of the coordinate
        return
    moves = np.linalg.norm(np.diff(poses[..., :2], axis=0)[0], axis=1)
    is_beside_axis = np.abs(poses[0, :, 0]) > ON_AXIS * mechanism.length_scale
    for group in (is_beside_axis, ~is_beside_axis):
        body = int(np.argmax(np.where(group, moves, 0.0)))
        here, there = (np.array(_place(view, *pose[:2])) for pose in poses[:, body])
        tangent = (there - here) * factor / step
        length = float(tangent @ tangent)
        if group[body] and length > 0.0:
            dx, dy = (tangent / length).tolist()
            name = mechanism.bodies[body].name.replace("_", " ")
            yield Grip(name=name, place=(float(here[0]), float(here[1])), effects=((start.key, dx, dy),), start=start.value)


def find_travel(run: Trajectory, boxes: Sequence[BoundingBox]) -> Travel | None:
    """Return where a run of one part may start, as drawn in the boxes of its views; None where no coordinate says where that is."""
    found, scene = find_start(run), run.scene
    if found is None:
        return None
    start, factor = found
    times = np.arange(float(TRAVEL_SAMPLES))
    try:
        travel = find_range_of_motion(scene.part.mechanism, rotates_with_spindle=scene.part.turns)
        value = travel.unwrap_values(np.array([start.value * factor]))[0]
        ends = _ends_of(scene, travel, float(np.clip(value, travel.low, travel.high)))
        motion = analyse_kinematics(scene, scene.mechanism.coordinate, np.linspace(ends[0].value, ends[1].value, len(times)))
    except MechanismError:
        return None
    view = show_run(_drawn_along(run, motion, times), None, (times[0], times[-1]), times, 1.0, boxes=boxes).views[0]
    length = ends[1].value - ends[0].value
    if not view.has_plane or length <= 0.0:
        return None
    return Travel(
        key=start.key,
        values=(ends[0].value / factor, ends[1].value / factor),
        is_closed=0.0 < travel.period < length * (1.0 + STOP_MARGIN),
        ends=(ends[0].sentence, ends[1].sentence),
        **collect_tracks(view, len(times)),
    )


def _ends_of(scene: Scene, travel: RangeOfMotion, value: float) -> tuple[TravelEnd, TravelEnd]:
    """Return the ends between which the coordinate of a scene may start, around a value (SI): those of its range, or stops before them."""
    name = scene.mechanism.coordinate
    unit = READING_UNITS[scene.mechanism.reading(name).quantity]
    values = np.linspace(travel.low, travel.high, TRAVEL_SAMPLES)
    low = TravelEnd(travel.low, _end_sentence(name, travel.ends[0], unit, travel.low_message))
    high = TravelEnd(travel.high, _end_sentence(name, travel.ends[1], unit, travel.high_message))
    readings = analyse_kinematics(scene, name, values).readings
    for stops in (one for one in scene.output_effects if isinstance(one, Stops)):
        reached = readings[stops.reading]
        excess = np.maximum(reached - stops.high, stops.low - reached)
        below, above = (np.flatnonzero((excess > 0.0) & side) for side in (values < value, values > value))
        if len(below):
            low = max(low, _end_at(scene, stops, values, reached, (below[-1], below[-1] + 1)), key=lambda end: end.value)
        if len(above):
            high = min(high, _end_at(scene, stops, values, reached, (above[0], above[0] - 1)), key=lambda end: end.value)
    return low, high


def _end_at(scene: Scene, stops: Stops, values: FloatArray, reached: FloatArray, samples: tuple[int, int]) -> TravelEnd:
    """Return the end of a travel just before a stop: between a sample beyond it and the one before it, where its reading is (n,)."""
    beyond, before = samples
    limit = stops.high if reached[beyond] > stops.high else stops.low
    share = (limit - reached[beyond]) / (reached[before] - reached[beyond])
    value = values[beyond] + min(share + STOP_MARGIN, 1.0) * (values[before] - values[beyond])
    unit = READING_UNITS[scene.mechanism.reading(stops.reading).quantity]
    return TravelEnd(float(value), _end_sentence(stops.reading, limit, unit, "a stop"))


def _end_sentence(reading: str, value: float, unit: str, message: str) -> str:
    """Return why a travel ends at a value (SI) of a reading."""
    name = format_reading_name(reading)
    return f"{name[:1].upper()}{name[1:]} {format_quantity(round(value, 9), unit, '.4g')}: {message}."


def _drawn_along(run: Trajectory, motion: Kinematics, times: FloatArray) -> Trajectory:
    """Return a run that goes through a motion (n positions), one position at each of n times, as a drawing of it needs it."""
    names = [body.name for body in run.scene.part.mechanism.bodies]
    poses = run.poses[:1].repeat(len(times), axis=0)
    poses[:, [run.scene.mechanism.body_index(name) for name in names]] = motion.poses
    readings = {name: motion.readings.get(name, np.full(len(times), values[0])) for name, values in run.readings.items()}
    rates = {name: np.zeros(len(times)) for name in run.rates}
    return replace(
        run,
        times=times,
        poses=poses,
        velocities=np.zeros_like(poses),
        readings=readings,
        rates=rates,
        joint_gap=np.zeros(len(times)),
        deferred_results=None,
    )


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

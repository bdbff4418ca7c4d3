"""Generic drawing of any mechanism from its bodies, joints, force elements and poses, with marks of its readings as in a textbook."""

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import GROUND, Glyph, Joint, Point
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Moment, axes_along, fixed, shapes_of
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    PoseTuple,
    Vec2,
    arc_points,
    axes_to_plane,
    bounding_box,
)
from governor_mechanism.render.machines.generic import bodies, force_elements, joints
from governor_mechanism.render.machines.generic.bodies import RIM_ROLES, WEB_ROLE
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents, PlacedMechanism
from governor_mechanism.render.machines.governor_parts import hatched_pair_shapes
from governor_mechanism.types import FloatArray

Stroke = tuple[Vec2, ...]


def _arc(centre: Vec2, radii: Vec2, first: float, last: float) -> Stroke:
    """Return an arc of an ellipse from one angle to another (degrees)."""
    angles = [math.radians(first + (last - first) * k / 16) for k in range(17)]
    return tuple((centre[0] + radii[0] * math.cos(angle), centre[1] + radii[1] * math.sin(angle)) for angle in angles)


_STROKES: Mapping[str, Sequence[Stroke]] = {
    "alpha": [((0.52, 0.62), (0.42, 0.28), (0.30, 0.04), (0.16, 0.0), (0.03, 0.16), (0.03, 0.44), (0.18, 0.62), (0.32, 0.5), (0.54, 0.0))],
    "beta": [((0.05, -0.3), *_arc((0.25, 0.75), (0.20, 0.20), 180, -90)), (*_arc((0.24, 0.27), (0.24, 0.28), 90, -140),)],
    "gamma": [
        ((0.0, 0.52), (0.10, 0.62), (0.20, 0.48), (0.28, 0.08), (0.28, -0.2), (0.22, -0.3), (0.18, -0.16), (0.28, 0.12), (0.50, 0.62))
    ],
    "delta": [_arc((0.24, 0.27), (0.23, 0.27), 0, 360), ((0.40, 0.46), (0.16, 0.74), (0.16, 0.88), (0.28, 0.95), (0.42, 0.88))],
    "epsilon": [_arc((0.26, 0.47), (0.22, 0.15), 40, 270), _arc((0.26, 0.16), (0.25, 0.16), 90, 320)],
    "theta": [_arc((0.22, 0.47), (0.20, 0.47), 0, 360), ((0.02, 0.47), (0.42, 0.47))],
    "phi": [_arc((0.27, 0.3), (0.27, 0.28), 0, 360), ((0.27, 0.9), (0.27, -0.3))],
    "psi": [((0.3, 0.9), (0.3, -0.3)), ((0.0, 0.6), (0.04, 0.25), (0.3, 0.06), (0.56, 0.25), (0.6, 0.6))],
    "omega": [((0.12, 0.6), *_arc((0.16, 0.26), (0.15, 0.26), 160, 350), *_arc((0.46, 0.26), (0.15, 0.26), 190, 380), (0.5, 0.6))],
    "Theta": [_arc((0.33, 0.475), (0.33, 0.475), 0, 360), ((0.18, 0.475), (0.48, 0.475))],
    "Phi": [_arc((0.33, 0.475), (0.33, 0.28), 0, 360), ((0.33, 0.0), (0.33, 0.95))],
    "Omega": [((0.0, 0.0), (0.22, 0.0), *_arc((0.36, 0.54), (0.32, 0.41), 242, -62), (0.5, 0.0), (0.72, 0.0))],
    "x": [((0.0, 0.6), (0.45, 0.0)), ((0.0, 0.0), (0.45, 0.6))],
    "y": [((0.0, 0.6), (0.24, 0.02)), ((0.48, 0.6), (0.1, -0.3))],
}

_SIGNS: Mapping[str, Sequence[Stroke]] = {
    "P": [((0.0, 0.0), (0.0, 0.95), (0.28, 0.95), *_arc((0.28, 0.7), (0.25, 0.25), 90, -90), (0.0, 0.45))],
    "(": [_arc((0.34, 0.35), (0.28, 0.62), 120, 240)],
    ")": [_arc((0.0, 0.35), (0.28, 0.62), 60, -60)],
    ",": [((0.06, 0.04), (0.0, -0.16))],
}
"""What stands beside the letters of coordinates; no name of a reading."""


def is_drawn_letter(name: str) -> bool:
    """Return whether there are strokes for a letter."""
    return name in _STROKES


def make_letters(names: Sequence[str], middle: Vec2, height: float) -> Lines:
    """Return letters beside one another around a position (m), with capitals of a height (m)."""
    strokes: list[Stroke] = []
    left = 0.0
    for name in names:
        drawn = _STROKES.get(name) or _SIGNS[name]
        width = max(x for stroke in drawn for x, _ in stroke)
        strokes += [tuple((left + x, y) for x, y in stroke) for stroke in drawn]
        left += width + 0.28
    offset = (0.5 * (left - 0.28), 0.38)
    x0, y0 = middle
    return Lines("letter", tuple(tuple((x0 + height * (x - offset[0]), y0 + height * (y - offset[1])) for x, y in one) for one in strokes))


_ARC_RADIUS = 0.085
_RADIUS_STEP = 0.075
_RAY_EXTENSION = 0.03
_LETTER_DISTANCE = 0.042
_LETTER_HEIGHT = 0.055
"""Radius of the first arc at a hinge and its increase to the next, lengths beyond it, and height of a letter, as fractions of the scale."""
_LETTER_TURNS = tuple(math.radians(5.0 * k) for k in range(-18, 19))
_LETTER_RISES = (0.0, 0.02, 0.04)
"""Places that a letter may take: directions against the middle of its arc, and further distances from it, as fractions of the scale."""
_LETTER_CLEARANCE, _N_LETTER_MOMENTS = 0.048, 24
"""Distance of the middle of a letter from the middle of a bar, as a fraction of the scale, below which they overlap, and the number of
moments at which this is tried."""
_ARC_CLEARANCE = 0.03
"""The same from an arc."""
_OVERLAP_COST = 10.0
"""Cost of a letter whose middle always lies on a bar or an arc, where a letter turned by 1 rad costs 1."""
_LETTERS_ASIDE = 0.12
_LETTERS_ABOVE = 0.075
_COORDINATE_HEIGHT = 0.04
"""Distance of the middle of the letters of coordinates from their point, beside it and above it, as fractions of the length scale."""
_NEAR = 0.12
"""Distance between hinges below which their arcs get different radii, as a fraction of the length scale."""


class _Arc(NamedTuple):
    """Arc of an angle: the hinge (m), the radius (m), and the directions of both axes (rad)."""

    hinge: Vec2
    radius: float
    start: float
    end: float


def reading_mark_parts(extents: MechanismExtents) -> Iterator[DrawnPart]:
    """Yield an arc with its letter between the axes of two bodies at their hinge, and the letters of the coordinates of a point."""
    for number, reading in enumerate(_marked_angles(extents)):
        yield extents.flex(partial(_angle_shapes, number), section_only=True)
        letter = make_letters((reading.name,), (0.0, 0.0), _LETTER_HEIGHT * extents.length_scale)
        yield Attached(frame=partial(_letter_axes, extents, number), shapes=(letter,), section_only=True)
    yield from _coordinate_parts(extents)


def _marked_angles(extents: MechanismExtents) -> list[BodyAngle]:
    """Return the angles that are named by a letter."""
    readings = extents.part.mechanism.readings
    return [reading for reading in readings if isinstance(reading, BodyAngle) and is_drawn_letter(reading.name)]


@once_per_object
def _marked_arcs(placed: PlacedMechanism) -> Sequence[_Arc]:
    """Return the arcs of all marked angles. An angle of several turns shows as the rest of the last one."""
    u, arcs = placed.unit, list[_Arc]()
    # Clear of the arrows of torques.
    torques = (load for load in placed.mechanism.force_elements if isinstance(load, Torque))
    earlier: list[Vec2] = [placed.hinge_position(load.first, load.second) for load in torques]
    for reading in _marked_angles(placed.extents):
        hinge = placed.hinge_position(reading.reference_body, reading.body)
        n_near = sum(math.dist(hinge, other) < _NEAR * u for other in earlier)
        earlier.append(hinge)
        start = placed.pose(reading.reference_body)[2]
        end = placed.pose(reading.body)[2]
        arcs.append(_Arc(hinge, (_ARC_RADIUS + n_near * _RADIUS_STEP) * u, start, end))
    return arcs


def _angle_shapes(number: int, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return the two axes of an angle, and its arc."""
    hinge, radius, start, end = _marked_arcs(placed)[number]
    rays = (axes_to_plane((*hinge, one), radius + _RAY_EXTENSION * placed.unit, 0.0) for one in (start, end))
    arc = arc_points(hinge, start, math.remainder(end - start, 2 * math.pi), radius, 24)
    return [Lines("angle ray", tuple((hinge, ray) for ray in rays)), Lines("angle arc", (arc,))]


def _letter_axes(extents: MechanismExtents, number: int, moment: Moment) -> PoseTuple:
    """Return the axes of the letter of an angle, beside its arc."""
    return *_letter_place(extents.placed_at(moment), number, *_letter_choices(extents)[number]), 0.0


def _letter_place(placed: PlacedMechanism, number: int, turn: float, rise: float) -> Vec2:
    """Return the middle of a letter in a direction against the middle of its arc (rad), at a further distance from it."""
    hinge, radius, start, end = _marked_arcs(placed)[number]
    heading = start + 0.5 * math.remainder(end - start, 2 * math.pi) + turn
    return axes_to_plane((*hinge, heading), radius + (_LETTER_DISTANCE + rise) * placed.unit, 0.0)


@once_per_object
def _letter_choices(extents: MechanismExtents) -> Sequence[tuple[float, float]]:
    """Return the direction and distance of each letter with which it lies least on bars, arcs and letters before it over the run."""
    rows = np.unique(np.linspace(0, len(extents.poses) - 1, _N_LETTER_MOMENTS).astype(int))
    moments = [extents.placed_at(Moment(extents.poses[row], 0.0)) for row in rows]
    # By moments and bars, or letters.
    starts, ends = np.moveaxis(np.array([_bar_lines(placed) for placed in moments]), 2, 0)
    arcs = np.array([[(*arc.hinge, arc.radius) for arc in _marked_arcs(placed)] for placed in moments])
    candidates = list(product(_LETTER_TURNS, _LETTER_RISES))
    choices = list[tuple[float, float]]()
    for number in range(arcs.shape[1]):
        places = np.array([[_letter_place(placed, number, *choice) for placed in moments] for choice in candidates])[:, :, None]
        from_bars = _distances(places, starts, ends).min(axis=2) / _LETTER_CLEARANCE
        from_arcs = np.abs(np.linalg.norm(places - arcs[..., :2], axis=-1) - arcs[..., 2]).min(axis=2) / _ARC_CLEARANCE
        overlaps = np.maximum(1.0 - np.minimum(from_bars, from_arcs) / extents.length_scale, 0.0).mean(axis=1)
        best = int(np.argmin(_OVERLAP_COST * overlaps + np.abs(candidates).sum(axis=1)))
        choices.append(candidates[best])
        starts, ends = (np.concatenate([one, places[best]], axis=1) for one in (starts, ends))
    return choices


def _bar_lines(placed: PlacedMechanism) -> list[tuple[Vec2, Vec2]]:
    """Return the lines between the joints of each body that moves."""
    points = {point for joint in placed.mechanism.joints for point in (joint.first, joint.second) if point.body != GROUND}
    ordered = sorted(points, key=lambda point: (point.body, point.x, point.y))
    return [(placed.position(one), placed.position(other)) for one, other in combinations(ordered, 2) if one.body == other.body]


def _distances(points: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the distances of points (..., 2) from the lines between starts and ends (..., 2), m."""
    steps = ends - starts
    lengths = np.maximum(np.sum((ends - starts) ** 2, axis=-1), 1e-300)
    shares = np.clip(np.sum((points - starts) * steps, axis=-1) / lengths, 0.0, 1.0)
    distances: FloatArray = np.linalg.norm(points - starts - shares[..., None] * steps, axis=-1)
    return distances


def _coordinate_parts(extents: MechanismExtents) -> Iterator[Attached]:
    """Yield a dot and P (x, y), or the coordinate it has, at each point with a coordinate, on the side away from its body's mass centre."""
    # That of a mass centre is on the side away from the origin. A body with a shape of its own has the dot alone.
    u = extents.length_scale
    letters: defaultdict[Point, list[str]] = defaultdict(list)
    shaped = bodies.shaped_bodies(extents)
    for reading in extents.part.mechanism.readings:
        if isinstance(reading, PointCoordinate) and is_drawn_letter(reading.name) and reading.point.body != GROUND:
            letters[reading.point].append(reading.name)
    for point, names in letters.items():
        dot = Circle("tracer", point.x, point.y, 0.013 * u)
        yield Attached(frame=extents.body_axes(point.body), shapes=(dot,), section_only=True)
        listed = [one for name in names for one in (",", name)][1:]
        if point.body in shaped:
            continue
        letter = make_letters(["P", "(", *listed, ")"], (0.0, 0.0), _COORDINATE_HEIGHT * u)
        yield Attached(frame=partial(_coordinate_axes, extents, point), shapes=(letter,), section_only=True)


def _coordinate_axes(extents: MechanismExtents, point: Point, moment: Moment) -> PoseTuple:
    """Return the axes of the letters of coordinates, in their middle."""
    placed, u = extents.placed_at(moment), extents.length_scale
    x, y = placed.position(point)
    across, up = _direction_away((x, y), (placed.pose(point.body)[:2], (0.0, 0.0)), 0.01 * u)
    return x + _LETTERS_ASIDE * u * across, y + _LETTERS_ABOVE * u * up, 0.0


def _direction_away(point: Vec2, centres: Iterable[Vec2], near: float) -> Vec2:
    """Return the direction to a point from the first of some centres that is not near it (m), or up."""
    for x, y in centres:
        distance = math.dist(point, (x, y))
        if distance > near:
            return (point[0] - x) / distance, (point[1] - y) / distance
    return 0.0, 1.0


_LINK_WIDTH, _PIN_RADIUS = 0.030, 0.016
"""Width of a massless link and radius of a pin, as fractions of the length scale."""
_BEARING_GAP, _BEARING_HEIGHT = 0.12, 0.05
"""Distance of the bearings of a spindle beyond what stands on it, and their height, as fractions of the length scale."""
_SYMMETRY_RATIO = 0.04
"""Difference of the extents to both sides of the axis, relative to their sum, below which a part is round."""


class GenericDrawing(MechanismExtents):
    """Drawing of any mechanism."""

    shows_bodies = True

    @property
    def points_without_pins(self) -> Collection[Point]:
        """Points of joints that are drawn without a pin."""
        return ()

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the axis of a rotating plane, discs and circles of cranks, the guides on the ground, feet, walls and captions."""
        placed = self.placed_at(Moment(self.poses[len(self.poses) // 2], 0.0))
        yield fixed(self._axis_shapes())
        yield from joints.wheel_parts(placed, fixed=True)
        yield fixed(bodies.crank_shapes(self))
        yield from joints.guide_parts(placed, fixed=True)
        yield fixed(joints.rack_bed_shapes(placed))
        yield from joints.foot_parts(placed)
        yield fixed(bodies.weld_wall_shapes(placed))
        yield fixed(force_elements.wall_shapes(placed))
        yield fixed(force_elements.drag_caption_shapes(self))

    def _axis_shapes(self) -> Iterator[DrawnShape]:
        """Yield the axis of a plane that turns, and the spindle in its bearings."""
        if self.part.turns:
            ground_points = [point for joint in self.part.mechanism.joints for point in (joint.first, joint.second) if point.body == GROUND]
            on_axis = [self.part.mechanism.body_index(point.body) for point in joints.points_on_axis(self)]
            heights = [*self.poses[:, on_axis, 1].ravel().tolist(), *(point.y for point in ground_points)]
            u = self.length_scale
            bottom = min(heights)
            top = max(heights)
            margins = (_BEARING_GAP * u, (_BEARING_GAP + _BEARING_HEIGHT) * u, (_BEARING_GAP + 2 * _BEARING_HEIGHT) * u)
            half = 0.5 * joints.SPINDLE_WIDTH * u
            yield Lines("axis", (((0.0, bottom - 1.2 * margins[-1]), (0.0, top + 1.2 * margins[-1])),))
            yield make_rectangle("spindle", -half, half, bottom - margins[-1], top + margins[-1])
            for near, far in ((bottom - margins[0], bottom - margins[1]), (top + margins[0], top + margins[1])):
                box = (half, 3.5 * half, min(near, far), max(near, far))
                yield from hatched_pair_shapes("bearing", box[:2], box[2:], 0.02 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield torques, wheels, bodies, links, blocks, force elements and pins.

        Slotted bodies are behind what slides in them; masses and balls are in front of plates and links.
        """
        parts = self._parts_in_order()
        yield from parts if not self.part.turns else (_settle_turning(part, self.first_moment) for part in parts)

    def _parts_in_order(self) -> Iterator[DrawnPart]:
        """Yield what moves, back to front."""
        placed = self.placed_at(self.first_moment)
        slotted, bodies_without = (list(bodies.body_parts(placed, slotted=is_slotted)) for is_slotted in (True, False))
        yield from force_elements.torque_arrow_parts(self)
        yield from (part for part in (*slotted, *bodies_without) if part.shapes[0].role == WEB_ROLE)
        yield from joints.rack_parts(placed)
        yield from joints.wheel_parts(placed, fixed=False)
        yield from (part for part in slotted if part.shapes[0].role not in (WEB_ROLE, "ball"))
        yield from joints.guide_parts(placed, fixed=False)
        others = [part for part in bodies_without if part.shapes[0].role not in (WEB_ROLE, "block", "ball")]
        yield from joints.block_parts(placed, behind=True)
        yield from sorted(others, key=lambda part: part.shapes[0].role not in RIM_ROLES)  # bars are in front of frames
        yield from (self._link_part(joint) for joint in self.part.mechanism.joints if Glyph.BAR in joint.glyphs)
        yield from force_elements.translational_element_parts(placed)
        yield from joints.block_parts(placed, behind=False)
        yield from (part for part in (*slotted, *bodies_without) if part.shapes[0].role in ("block", "ball"))
        yield from bodies.roller_parts(placed)
        yield from force_elements.torsional_element_parts(placed)
        yield from force_elements.drive_parts(placed)
        pins = list(joints.pin_points(placed, self.points_without_pins))
        yield from (force_elements.eye_part(self, "pivot", point, _PIN_RADIUS * self.length_scale) for point in pins)
        yield from force_elements.output_effect_parts(self)
        yield from bodies.tracer_parts(placed)
        yield from force_elements.force_arrow_parts(self)
        yield self.flex(force_elements.drag_arrow_shapes, section_only=True)
        yield from reading_mark_parts(self)

    def _link_part(self, joint: Joint) -> Attached:
        """Return a massless link between its points."""

        def ends_at(moment: Moment) -> tuple[Vec2, Vec2]:
            placed = self.placed_at(moment)
            return placed.position(joint.first), placed.position(joint.second)

        bar = make_bar("link", *ends_at(self.first_moment), _LINK_WIDTH * self.length_scale)
        return self.attach(axes_along(ends_at), [bar])

    def named_places(self, poses: FloatArray) -> dict[str, FloatArray]:
        """Return the places (n, 2) m of the parts that have names, at poses (n, bodies, 3)."""
        return {body.name: poses[:, k, :2] for k, body in enumerate(self.part.mechanism.bodies)}


def _settle_turning(part: DrawnPart, moment: Moment) -> DrawnPart:
    """Return a part that turns with the spindle only if it stands beside the axis, or is a bar across it; others are round."""
    shapes = list(shapes_of([part], moment))
    is_bar = any(shape.role in ("plate", "link") for shape in shapes)
    left, right, _, _ = bounding_box(shapes)
    is_round = not is_bar and abs(right + left) <= _SYMMETRY_RATIO * (right - left)
    return replace(part, turns=False) if is_round else part

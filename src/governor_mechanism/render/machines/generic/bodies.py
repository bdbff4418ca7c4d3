"""Generic drawing of bodies: plates and bars through their joint points, discs, masses and balls; cranks with the circles of their pins."""

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.curves.outlines import find_circle, is_inside, outline_points
from governor_mechanism.model.curves import CurveOutline, Outline
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring
from governor_mechanism.model.joints import GROUND, Glyph, Joint, Pin, Point, Weld
from governor_mechanism.model.mechanism import Body, BodyOutline, Mechanism, NamedPoint
from governor_mechanism.model.output_variables import LineAngle, OutlineGap, PointCoordinate, PointDistance, Reading
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.attached import Attached
from governor_mechanism.render.geometry.outlines import make_bar, make_plate_outline, make_rectangle, make_wall, shrink_convex
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    Vec2,
    arc_points,
    convex_hull,
    distinct_points,
    drawn_ball_radius,
    place_points,
)
from governor_mechanism.render.machines.generic.joints import STRIP_WIDTH, guide_centreline, spoked_wheel, toothed_bodies
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents, PlacedMechanism

WEB_ROLE, RIM_ROLES = "plate web", ("plate rim", "plate edge")
"""Role of what fills a frame, and roles of its bars and their edges."""
_MIN_OPENING = 0.4
"""Least distance of the middle of an opening from the bars around it, relative to their width: a smaller one would be a slit."""


def body_outline_shapes(points: Sequence[Vec2], width: float) -> Iterator[DrawnShape]:
    """Yield the shapes of a body through points (m) with bars of a width (m): a bar or narrow plate, or a frame with its web."""
    corners = convex_hull(points)
    if len(corners) < 3 or not shrink_convex(corners, (0.5 + _MIN_OPENING) * width):
        yield make_plate_outline("plate", points, width)
        return
    outer = make_plate_outline(WEB_ROLE, corners, width).points
    inner = tuple(shrink_convex(corners, width / 2))
    yield Polygon(WEB_ROLE, outer)
    yield from (make_bar("plate", *ends, width) for ends in _ribs(points, corners, width))
    # One outline around the rim: out along the outer edge and back along the inner one. Its seam has no stroke of its own.
    yield Polygon("plate rim", (*outer, outer[0], inner[0], *inner[::-1]))
    yield Lines("plate edge", tuple((*edge, edge[0]) for edge in (outer, inner)))


def _ribs(points: Sequence[Vec2], corners: Sequence[Vec2], width: float) -> Iterator[tuple[Vec2, Vec2]]:
    """Yield the ends of bars that join each point inside the rim to the nearest point that is joined already."""
    joined = list(corners)
    for point in sorted(points, key=lambda one: min(math.dist(one, corner) for corner in corners)):
        edges = zip(corners, (*corners[1:], corners[0]), strict=True)
        if min(_distance_to_segment(point, *edge) for edge in edges) > width / 2:
            yield point, min(joined, key=partial(math.dist, point))
            joined.append(point)


def _distance_to_segment(point: Vec2, start: Vec2, end: Vec2) -> float:
    """Return the distance of a point from a segment (m)."""
    x, y = point
    x0, y0 = start
    x1, y1 = end
    share = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / math.dist(start, end) ** 2
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, (x0 + share * (x1 - x0), y0 + share * (y1 - y0)))


_MIN_TURN = 1.9 * math.pi
"""Angle (rad) from which on a body counts as turning round: nearly a turn."""
_MAX_DISC_RADIUS = 0.35
"""Largest radius of a drawn disc, as a fraction of the length scale."""
_MIN_CIRCLE_RADIUS = 0.03
"""Radius below which the circle of a pin is left out, as a fraction of the length scale."""


class _Crank(NamedTuple):
    """A body that goes round a fixed pin: the centre (m), the radii of its other joints (m), and that of its disc (m; 0 without)."""

    centre: Vec2
    radii: Sequence[float]
    disc_radius: float


@once_per_object
def _find_cranks(extents: MechanismExtents) -> Sequence[_Crank]:
    """Return the bodies that go round a pin on the ground during the run."""
    mechanism = extents.part.mechanism
    u = extents.length_scale
    cranks = []
    for pin in mechanism.joints:
        if not isinstance(pin, Pin) or GROUND not in (pin.first.body, pin.second.body):
            continue
        ground, own = (pin.first, pin.second) if pin.first.body == GROUND else (pin.second, pin.first)
        index = mechanism.body_index(own.body)
        if index < 0 or float(np.ptp(extents.poses[:, index, 2])) < _MIN_TURN:
            continue
        if own.body in _bodies_with_outlines(mechanism):
            continue
        joined = [point for joint in mechanism.joints for point in (joint.first, joint.second) if point.body == own.body]
        points = distinct_points([(own.x, own.y), *((point.x, point.y) for point in joined)], 0.01 * u)[1:]
        radii = sorted({round(math.dist((own.x, own.y), point), 12) for point in points})
        has_disc = bool(radii) and math.hypot(own.x, own.y) < 1e-9 * u
        cranks.append(_Crank((ground.x, ground.y), radii, _disc_radius(mechanism.bodies[index]) if has_disc else 0.0))
    return cranks


def _disc_radius(body: Body) -> float:
    """Return the radius of a uniform disc with the moments of inertia of a body (m), or 0 if they are not those of a disc."""
    xx, yy, xy = body.second_moments.in_plane
    is_round = xx > 0.0 and abs(xx - yy) <= 1e-9 * xx and abs(xy) <= 1e-9 * xx
    return 2 * math.sqrt(xx / body.mass) if is_round and body.mass else 0.0


def crank_shapes(extents: MechanismExtents) -> Iterator[DrawnShape]:
    """Yield the discs of cranks, which look alike at every angle, and the circles on which their pins move."""
    u = extents.length_scale
    for crank in _find_cranks(extents):
        if crank.disc_radius:
            yield Circle("crank web", *crank.centre, min(crank.disc_radius, _MAX_DISC_RADIUS * u))
        circles = (arc_points(crank.centre, 0.0, 2 * math.pi, radius, 72) for radius in crank.radii if radius > _MIN_CIRCLE_RADIUS * u)
        yield Lines("crank circle", tuple(circles))


_BAR_WIDTH = 0.040
"""Width of a bar, as a fraction of the length scale."""
_COINCIDENCE_DISTANCE = 0.02
"""Distance below which two points are drawn as one, as a fraction of the length scale."""
_MASS_SIDES = (0.22, 0.16)
"""Sides of a mass that hangs on springs, as fractions of the length scale."""


class _BodyOutline(NamedTuple):
    """What of the drawing of a body is the same at every pose."""

    # points that its plate or bar contains, in body axes, m; fewer than two for a body without one
    points: Sequence[Vec2]
    width: float  # width of the plate, m
    has_ball: bool  # whether a ball stands at a corner of the plate
    has_single_shape: bool  # whether a body without plate is drawn at its mass centre
    tracers: Sequence[Vec2]  # points with a name or a reading that no joint holds, in body axes, m
    is_slotted: bool  # whether other bodies slide in it


@once_per_object
def _find_outlines(extents: MechanismExtents) -> Sequence[_BodyOutline]:
    """Return the outlines of all bodies."""
    toothed = toothed_bodies(extents)
    rolling = _rolling_bodies(extents)
    outlines = []
    for body in extents.part.mechanism.bodies:
        points = _outline_points(extents, body)
        is_slotted = bool(_guides_on(extents, body))
        width = (STRIP_WIDTH if is_slotted else _BAR_WIDTH) * extents.length_scale
        has_ball = len(points) > 1 and _has_end_mass(extents, body, points)
        has_own_shape = body.name in toothed or body.name in rolling or _is_sliding_block(extents, body)
        has_single_shape = len(points) < 2 and not has_own_shape
        outlines.append(_BodyOutline(points, width, has_ball, has_single_shape, _tracer_points(extents, body), is_slotted))
    return outlines


def body_parts(placed: PlacedMechanism, *, slotted: bool) -> Iterator[Attached]:
    """Yield plates, bars, discs, masses and balls one by one: those of the bodies with a slot or a guide, or those of the others."""
    for body, outline in zip(placed.mechanism.bodies, _find_outlines(placed.extents), strict=True):
        if outline.is_slotted == slotted:
            frame = placed.extents.body_axes(body.name)
            yield from (Attached(frame=frame, shapes=(shape,)) for shape in _body_shapes(placed, body, outline))


def _body_shapes(placed: PlacedMechanism, body: Body, outline: _BodyOutline) -> Iterator[DrawnShape]:
    """Yield the shapes of a body in its axes: its own outline if it has one."""
    if own_outlines := _bodies_with_outlines(placed.mechanism).get(body.name):
        for one in own_outlines:
            corners = tuple((x + one.origin.x, y + one.origin.y) for x, y in outline_points(one.outline))
            is_welded = body.name in _welded_points(placed.mechanism)
            can_turn = body.can_rotate and not is_welded
            hangs = can_turn and body.mass > 0.0 and not is_inside(corners, 0.0, 0.0)
            points = [*_joint_and_force_points(placed.extents, body), (0.0, 0.0)] if hangs else outline.points
            beyond = [point for point in points if not is_welded and not is_inside(corners, *point)]
            yield from (_bar_from((one.origin.x, one.origin.y), point, outline.width) for point in beyond)
            yield Polygon("plate", corners)
            if can_turn and (disc := _marked_disc(one.outline)):
                x, y, radius = disc
                yield _radius_mark((x + one.origin.x, y + one.origin.y), radius)
            if hangs:
                yield _ball_shape(placed, body)
        return
    if len(outline.points) > 1:
        yield from body_outline_shapes(outline.points, outline.width)
    if outline.has_ball:
        yield _ball_shape(placed, body)
    if outline.has_single_shape:
        yield from _single_point_shapes(placed, body)


def _bar_from(origin: Vec2, point: Vec2, width: float) -> Polygon:
    """Return a bar from the origin of an outline, beyond which its round end does not stand out, to a point."""
    distance = math.dist(origin, point)
    share = min(0.5 * width / distance, 0.5) if distance > 0.0 else 0.0
    (x0, y0), (x1, y1) = origin, point
    return make_bar("plate", (x0 + share * (x1 - x0), y0 + share * (y1 - y0)), point, width)


def _marked_disc(outline: Outline) -> tuple[float, float, float] | None:
    """Return centre and radius (m) of a round outline, or of the largest disc about the shaft in a cam, whose turning is hard to see."""
    if isinstance(outline, CurveOutline):
        return find_circle(outline) or (0.0, 0.0, min(math.hypot(x, y) for x, y in outline_points(outline)))
    return find_circle(outline)


def _radius_mark(centre: Vec2, radius: float) -> Lines:
    """Return a marked radius, which shows how a disc turns."""
    x, y = centre
    return Lines("marked spoke", (((x, y), (x + radius, y)),))


def _welded_points(mechanism: Mechanism) -> dict[str, Point]:
    """Return the points of the ground to which bodies are welded, by the name of the body."""
    welds = [joint for joint in mechanism.joints if isinstance(joint, Weld)]
    ends = (ends for weld in welds for ends in ((weld.first, weld.second), (weld.second, weld.first)))
    return {body.body: ground for ground, body in ends if ground.body == GROUND}


_WALL_HALF, _WALL_DEPTH = 0.09, 0.035
"""Half the length of a wall at a weld, and the depth of its hatching, as fractions of the length scale."""


def weld_wall_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield what holds the bodies that are welded to the ground: a floor along their flat underside, or a wall at the weld.

    A body that stands above the others hangs from a ceiling. A body with an outline and without a flat side has nothing.
    """
    u = placed.unit
    for name, ground in _welded_points(placed.mechanism).items() if not placed.extents.part.turns else ():
        pose, corners = placed.pose(name), list[Vec2]()
        for one in _bodies_with_outlines(placed.mechanism).get(name, ()):
            corners += place_points(pose, [(x + one.origin.x, y + one.origin.y) for x, y in outline_points(one.outline)])
        if not corners:
            toward = math.atan2(pose[1] - ground.y, pose[0] - ground.x)
            yield make_wall((ground.x, ground.y), toward, _WALL_HALF * u, _WALL_DEPTH * u)
            continue
        heights = [y for _, y in corners]
        hangs = (min(heights) + max(heights)) / 2 > placed.extents.mean_height + _WALL_HALF * u
        level = max(heights) if hangs else min(heights)
        flat = [x for x, y in corners if abs(y - level) < 1e-3 * u]
        if (half := (max(flat) - min(flat)) / 2) > _WALL_DEPTH * u:
            yield make_wall((min(flat) + half, level), -math.pi / 2 if hangs else math.pi / 2, half, _WALL_DEPTH * u)


def shaped_bodies(extents: MechanismExtents) -> set[str]:
    """Return the names of bodies with an outline, a roller or a disc, on which a letter would cover what touches."""
    mechanism = extents.part.mechanism
    rollers = {one.roller.body for one in mechanism.readings if isinstance(one, OutlineGap)}
    outlines = zip(mechanism.bodies, _find_outlines(extents), strict=True)
    discs = {body.name for body, outline in outlines if outline.has_single_shape and body.can_rotate}
    return {*rollers, *discs, *_bodies_with_outlines(mechanism)}


def _bodies_with_outlines(mechanism: Mechanism) -> dict[str, list[BodyOutline]]:
    """Return the outlines by the name of their body."""
    names = dict.fromkeys(one.origin.body for one in mechanism.outlines)
    return {name: [one for one in mechanism.outlines if one.origin.body == name] for name in names}


def _rolling_bodies(extents: MechanismExtents) -> set[str]:
    """Return the names of bodies that are a roller about their mass centre."""
    gaps = (one for one in extents.part.mechanism.readings if isinstance(one, OutlineGap) and one.radius > 0.0)
    return {gap.roller.body for gap in gaps if math.hypot(gap.roller.x, gap.roller.y) < 1e-9 * extents.length_scale}


def roller_parts(placed: PlacedMechanism) -> Iterator[Attached]:
    """Yield the rollers that touch outlines, each once."""
    gaps = (reading for reading in placed.mechanism.readings if isinstance(reading, OutlineGap) and reading.radius > 0.0)
    for point, radius in dict.fromkeys((gap.roller, gap.radius) for gap in gaps):
        shapes: list[DrawnShape] = [Circle("wheel", point.x, point.y, radius)]
        body = placed.mechanism.bodies[placed.mechanism.body_index(point.body)]
        if body.can_rotate and body.name in _rolling_bodies(placed.extents):
            shapes.append(_radius_mark((point.x, point.y), radius))
        yield Attached(frame=placed.extents.body_axes(point.body), shapes=tuple(shapes))


def tracer_parts(placed: PlacedMechanism) -> Iterator[Attached]:
    """Yield the points that have a name or that readings follow, and that no joint holds."""
    for body, outline in zip(placed.mechanism.bodies, _find_outlines(placed.extents), strict=True):
        shapes = tuple(Circle("tracer", *point, 0.012 * placed.unit) for point in outline.tracers)
        yield Attached(frame=placed.extents.body_axes(body.name), shapes=shapes, section_only=True)


def _tracer_points(extents: MechanismExtents, body: Body) -> list[Vec2]:
    """Return the points of a body that have a name or that readings follow, and that no joint holds, in body axes."""
    tolerance = _COINCIDENCE_DISTANCE * extents.length_scale
    held = _joint_and_force_points(extents, body)
    followed = distinct_points([*_reading_points(extents, body), *_named_points(extents, body, extents.part.mechanism.points)], tolerance)
    return [point for point in followed if all(math.dist(point, other) > tolerance for other in held)]


def _outline_points(extents: MechanismExtents, body: Body) -> list[Vec2]:
    """Return the points that the body outline contains, in body axes: joint points, named ones, ends, slots, and a point mass."""
    tolerance = _COINCIDENCE_DISTANCE * extents.length_scale
    mechanism = extents.part.mechanism
    named = _named_points(extents, body, (*mechanism.points, *mechanism.ends))
    points = distinct_points(
        [*_joint_and_force_points(extents, body), *_reading_points(extents, body), *named, *_slot_points(extents, body)], tolerance
    )
    is_wheel = body.name in toothed_bodies(extents)
    if not points or (is_wheel and all(math.hypot(*point) <= tolerance for point in points)):
        return points  # a wheel about its own centre; an eccentric wheel is drawn as a rod with a wheel
    if len(points) == 1 and not _is_sliding_block(extents, body):
        distance = math.hypot(*points[0])
        if distance > tolerance:
            # A rod with this radius of gyration extends by this ratio beyond its mass centre.
            extension_ratio = min(math.sqrt(3) * _gyration_radius(body) / distance, 1.0)
            return [points[0], (-extension_ratio * points[0][0], -extension_ratio * points[0][1])]
    elif _may_have_ball(extents, body) and not _is_inside_hull((0.0, 0.0), points, tolerance):
        return distinct_points([*points, (0.0, 0.0)], tolerance)
    return points


def _held_points(element: Joint | ForceElement | Reading) -> tuple[Point, ...]:
    """Return the points at which a joint or a force element holds a body, or which a reading follows."""
    match element:
        case Joint() if Glyph.FEET in element.glyphs:
            return element.first, element.second
        case Joint() if element.glyphs & {Glyph.FOOT, Glyph.PATH}:
            return (element.second,)
        case Spring() | Damper() | PointDistance():
            return element.first, element.second
        case Force() | PointCoordinate():
            return (element.point,)
        case LineAngle():
            return element.start, element.end
        case OutlineGap():
            return (element.roller,)
    return ()


def _points_on(body: Body, elements: Iterable[Joint | ForceElement | Reading]) -> list[Vec2]:
    return [(point.x, point.y) for element in elements for point in _held_points(element) if point.body == body.name]


def _joint_and_force_points(extents: MechanismExtents, body: Body) -> list[Vec2]:
    mechanism = extents.part.mechanism
    gaps = [reading for reading in mechanism.readings if isinstance(reading, OutlineGap)]
    return _points_on(body, (*mechanism.joints, *mechanism.force_elements, *gaps))


def _reading_points(extents: MechanismExtents, body: Body) -> list[Vec2]:
    """Return the points of readings on the body, except the mass centre, which is the default of a reading without a point."""
    return [point for point in _points_on(body, extents.part.mechanism.readings) if any(point)]


def _named_points(extents: MechanismExtents, body: Body, points: Iterable[NamedPoint]) -> list[Vec2]:
    """Return those of some points that lie on the body, if a fixed plane shows it drawn through its points."""
    # A wheel, a block, a slotted link and an outline have a shape of their own; a governor has balls.
    name, mechanism = body.name, extents.part.mechanism
    has_own_shape = name in toothed_bodies(extents) or name in _rolling_bodies(extents) or name in _bodies_with_outlines(mechanism)
    if extents.part.turns or has_own_shape or _is_sliding_block(extents, body) or _guides_on(extents, body):
        return []
    return [(one.point.x, one.point.y) for one in points if one.point.body == name]


def _slot_points(extents: MechanismExtents, body: Body) -> list[Vec2]:
    """Return points of the guides on the body, which its plate must contain."""
    points: list[Vec2] = []
    for joint in _guides_on(extents, body):
        axes = (joint.first.x, joint.first.y, getattr(joint, "angle", 0.0))
        chain = guide_centreline(joint, extents)
        points += place_points(axes, chain[:: max(len(chain) // 12, 1)])
    return points


def _guides_on(extents: MechanismExtents, body: Body) -> list[Joint]:
    return [joint for joint in extents.part.mechanism.joints if joint.glyphs & {Glyph.GUIDE, Glyph.SLOT} and joint.first.body == body.name]


def _is_sliding_block(extents: MechanismExtents, body: Body) -> bool:
    """Return whether a sliding block represents the body."""
    return any(Glyph.GUIDE in joint.glyphs and joint.second.body == body.name for joint in extents.part.mechanism.joints)


def _may_have_ball(extents: MechanismExtents, body: Body) -> bool:
    """Return whether a mass centre beyond the joints is a ball: of a pendulum, or of any arm of a governor."""
    return body.can_rotate and (extents.part.turns or not any(body.second_moments.in_plane))


def _is_inside_hull(point: Vec2, points: Sequence[Vec2], tolerance: float) -> bool:
    corners = convex_hull([*points, point])
    start = points[0]
    end = points[-1]
    is_between_ends = math.dist(start, point) + math.dist(point, end) < math.dist(start, end) + tolerance
    return point not in corners or (len(corners) < 3 and is_between_ends)


def _has_end_mass(extents: MechanismExtents, body: Body, outline: Sequence[Vec2]) -> bool:
    """Return whether the whole mass is at a corner of the outline, as in a pendulum bob."""
    tolerance = _COINCIDENCE_DISTANCE * extents.length_scale
    return _may_have_ball(extents, body) and any(math.hypot(*corner) < tolerance for corner in convex_hull(outline))


def _single_point_shapes(placed: PlacedMechanism, body: Body) -> list[DrawnShape]:
    """Return the shapes of a body with at most one point, around its mass centre: disc, hanging mass or ball."""
    u = placed.unit
    if body.mass == 0.0 and not body.can_rotate:
        return [make_wall((0.0, 0.0), math.pi / 2, 0.10 * u, 0.035 * u)]  # a moving point of the ground
    holding_joints = [joint for joint in placed.mechanism.joints if joint.glyphs & {Glyph.PIN, Glyph.PINS, Glyph.PIN_IN_SLOT}]
    is_held_by_joint = any(body.name in (joint.first.body, joint.second.body) for joint in holding_joints)
    if placed.hangs_on_springs(body.name) and not is_held_by_joint:
        half_width, half_height = (side / 2 * u for side in _MASS_SIDES)
        return [make_rectangle("block", -half_width, half_width, -half_height, half_height)]
    if (radius := placed.extents.flywheel_radius) > 0.0:
        return spoked_wheel(radius, 0.84 * radius, 0.1 * radius)
    if body.can_rotate and body.planar_inertia > 0.0:
        # A disc with this moment of inertia.
        radius = min(max(math.sqrt(2) * _gyration_radius(body), 0.06 * u), 0.25 * u)
        return [Circle("wheel", 0.0, 0.0, radius), Lines("marked spoke", (((0.0, 0.0), (radius, 0.0)),))]
    return [_ball_shape(placed, body)]


def _gyration_radius(body: Body) -> float:
    """Return the radius of gyration about the mass centre, m; 0 without mass."""
    return math.sqrt(max(body.planar_inertia, 0.0) / body.mass) if body.mass else 0.0


def _ball_shape(placed: PlacedMechanism, body: Body) -> Circle:
    return Circle("ball", 0.0, 0.0, min(0.7 * drawn_ball_radius(body.mass, placed.unit), 0.09 * placed.unit))

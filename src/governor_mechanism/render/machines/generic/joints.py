"""Generic drawing of joints: guides, slots, sliding blocks, the feet of ground pins, meshing toothed wheels, and racks on their pinions.

A body that only slides moves alike in every parallel guide, so that its guide may be drawn beside the line of its pin.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from governor_mechanism.mechanics.curves.outlines import outline_points
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path, rotate_vector
from governor_mechanism.model import joints
from governor_mechanism.model.curves import Curve, PolarCurve, PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Damper, ForceElement, Spring
from governor_mechanism.model.joints import GROUND, Glyph, Point, Slider
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry import attached
from governor_mechanism.render.geometry.attached import Attached, Frame, Moment
from governor_mechanism.render.geometry.outlines import (
    make_band,
    make_bar,
    make_box,
    make_hatching,
    make_parallel_outline,
    make_rectangle,
    make_wall,
)
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    arc_points,
    axes_to_plane,
    bounding_box,
    closed_curve_points,
    convex_hull,
    distinct_points,
    place_points,
    wheel_centres,
    wheel_radii,
)
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents, PlacedMechanism
from governor_mechanism.types import FloatArray

RAM_LENGTH, BLOCK_WIDTH = 0.30, 0.08
"""Length of a ram, and width of a guide, as fractions of the length scale."""
_CLEARANCE = 0.16
"""Distance of the guide's middle from the points that pass along it, relative to the length scale: half a bar, half a block, a wall."""
_MAX_OFFSET = 0.35


@once_per_object
def ram_offsets(extents: MechanismExtents) -> Mapping[str, float]:
    """Return the distance of the drawn guide from the line of the pin (m, to the left of the guide's direction), by slider that has one."""
    offsets = {}
    for joint in extents.part.mechanism.joints:
        if isinstance(joint, Slider) and joint.first.body == GROUND and not extents.part.turns:
            offset = _offset_of(extents, joint)
            if 0.0 < abs(offset) <= _MAX_OFFSET * extents.length_scale:
                offsets[joint.name] = offset
    return offsets


def _offset_of(extents: MechanismExtents, slider: Slider) -> float:
    """Return how far the guide of a slider stands aside (m); 0 if nothing passes along it, or if something passes on both sides."""
    mechanism, u = extents.part.mechanism, extents.length_scale
    if mechanism.bodies[mechanism.body_index(slider.second.body)].can_rotate:
        return 0.0
    own = point_path(mechanism, extents.poses, slider.second)
    low, high = extents.joint_travels[slider.name]
    others = {point for joint in mechanism.joints for point in (joint.first, joint.second)}
    passing = []
    for point in sorted((one for one in others if one.body not in (GROUND, slider.second.body)), key=repr):
        path = point_path(mechanism, extents.poses, point)
        if np.hypot(*(path - own).T).max() > 0.02 * u:
            along, across = rotate_vector(-slider.angle, *(path - (slider.first.x, slider.first.y)).T)
            is_near = (along > low - RAM_LENGTH / 2 * u) & (along < high + RAM_LENGTH / 2 * u) & (np.abs(across) < BLOCK_WIDTH * u)
            passing.append(across[is_near])
    heights = np.concatenate(passing) if passing else np.zeros(0)
    if not heights.size or (heights.min() < 0.0 < heights.max()):
        return 0.0
    return float(heights.max() + _CLEARANCE * u if heights.max() <= 0.0 else heights.min() - _CLEARANCE * u)


_SLOT_WIDTH, STRIP_WIDTH = 0.046, 0.100
"""Widths of a slot and of the strip around it, as fractions of the length scale."""
_BLOCK_SIDES, _SPRUNG_BLOCK_SIDES = (0.15, BLOCK_WIDTH), (0.16, 0.22)
"""Sides, along and across the guide, of a sliding block and of a mass held by springs in its guide, as fractions of the length scale."""
_GUIDE_EXTENSION = 0.12
"""Length of a guide beyond the travel at each end, as a fraction of the length scale."""
SPINDLE_WIDTH, _HUB_WIDTH = 0.024, 0.05
"""Widths of a spindle and of the hub on it that carries pins, as fractions of the length scale."""
_N_SLOT_SEGMENTS = 48
"""Number of straight segments of a drawn slot."""
_RACK_THICKNESS = 0.09
_RACK_MARGIN = 0.18
_BED_MARGIN = 0.06
"""Thickness of a rack, its length beyond its travel, and that of a bed beyond this at each end, as fractions of the length scale."""
_CONCENTRIC_WHEEL_RADIUS = 0.16
"""Radius of the larger of two wheels with a common centre, as a fraction of the length scale."""


def guide_centreline(joint: joints.Joint, extents: MechanismExtents) -> Sequence[Vec2]:
    """Return the centre line of the guide of the joint's second point (m, in the axes of the joint's first point)."""
    low, high = extents.joint_travels[joint.name]
    extension = _GUIDE_EXTENSION * extents.length_scale
    match joint:
        case joints.ArcSlot(radius=radius):
            extension = min(0.6 * extension / radius, 0.2)
            return arc_points((0.0, 0.0), low - extension, high - low + 2 * extension, radius, _N_SLOT_SEGMENTS)
        case joints.CurveSlot(curve=PolarCurve() as curve):
            return closed_curve_points(curve, 2 * _N_SLOT_SEGMENTS)
        case joints.CurveSlot(curve=curve):
            first, last = low - 0.6 * extension, high + 0.6 * extension
            if isinstance(curve, SplineCurve):
                # A table curve ends at its first and last point; it is drawn whole unless the run uses a small part of it.
                max_extension = 0.5 * (high - low) + extension
                first = max(low - max_extension, min(curve.x[0], low))
                last = min(high + max_extension, max(curve.x[-1], high))
            xs = np.linspace(first, last, _N_SLOT_SEGMENTS + 1)
            return list(zip(xs.tolist(), _curve_ordinates(curve, xs).tolist(), strict=True))
        case _:
            return [(low - extension, 0.0), (high + extension, 0.0)]


def _curve_ordinates(curve: Curve, xs: FloatArray) -> FloatArray:
    match curve:
        case PolynomialCurve(coefficients=coefficients):
            return np.asarray(np.polynomial.polynomial.polyval(xs, coefficients), dtype=np.float64)
        case SplineCurve(x=x, y=y):
            from scipy.interpolate import CubicSpline  # slow to import

            return np.asarray(CubicSpline(x, y)(xs))
    raise NotImplementedError(f"curves of type {type(curve).__name__} cannot be drawn")


def guide_parts(placed: PlacedMechanism, *, fixed: bool) -> Iterator[Attached]:
    """Yield the guides on the ground (`fixed`) or on bodies; the plate of a body is drawn elsewhere."""
    for joint in placed.mechanism.joints:
        if joint.name not in placed.extents.joint_travels or (joint.first.body == joints.GROUND) != fixed:
            continue
        # The guide in the axes of the body that carries it.
        axes = (joint.first.x, joint.first.y, getattr(joint, "angle", 0.0))
        shapes: list[DrawnShape] = []
        if Glyph.GUIDE in joint.glyphs and not (fixed and _is_drawn_elsewhere(placed, joint)):
            shapes = _straight_guide_shapes(placed, joint, axes, fixed=fixed)
        elif Glyph.SLOT in joint.glyphs:
            shapes = _slot_shapes(joint, placed.extents, axes, fixed=fixed)
        elif Glyph.PATH in joint.glyphs and fixed and not _is_guided_by_slider(placed, joint):
            shapes = [Lines("guide", (place_points(axes, guide_centreline(joint, placed.extents)),))]
        frame = placed.extents.body_axes(joint.first.body)
        yield Attached(frame=frame, shapes=tuple(shapes), turns=not fixed or Glyph.SLOT in joint.glyphs)


def _guide_axes(placed: PlacedMechanism, joint: joints.Joint) -> PoseTuple:
    """Return the axes of a guide: origin in the joint's first point, x along a straight guide."""
    angle = getattr(joint, "angle", 0.0)
    return *placed.position(joint.first), placed.pose(joint.first.body)[2] + angle


def _is_drawn_elsewhere(placed: PlacedMechanism, joint: joints.Joint) -> bool:
    """Return whether the block of a slider is a rack, or drawn by the drawing of a machine."""
    return joint.second.body in rack_bodies(placed.mechanism) or joint.name in placed.extents.replaced_guides


def _block_sides(placed: PlacedMechanism, joint: joints.Joint) -> Vec2:
    """Return the sides of the block of a slider; a mass on springs is large enough to show them side by side."""
    body = joint.second.body
    has_no_other_joint = all(body not in (other.first.body, other.second.body) or other is joint for other in placed.mechanism.joints)
    is_sprung_mass = has_no_other_joint and placed.hangs_on_springs(body) and body != joints.GROUND
    along, across = _SPRUNG_BLOCK_SIDES if is_sprung_mass else _BLOCK_SIDES
    if placed.extents.part.turns and joint.second in points_on_axis(placed.extents):
        # A sleeve is as wide as the points at its sides are apart.
        held = [point.x for load in placed.mechanism.force_elements for point in _ends_of(load) if point.body == body]
        return _BLOCK_SIDES[0] * placed.unit, (2 * max(map(abs, held), default=0.01 * placed.unit) / placed.unit + 0.042) * placed.unit
    return along * placed.unit, across * placed.unit


def _ends_of(load: ForceElement) -> tuple[Point, ...]:
    return (load.first, load.second) if isinstance(load, Spring | Damper) else ()


def _straight_guide_shapes(placed: PlacedMechanism, joint: joints.Joint, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = placed.unit
    (low, _), (high, _) = guide_centreline(joint, placed.extents)
    width = _block_sides(placed, joint)[1]
    offset = ram_offsets(placed.extents).get(joint.name, 0.0)
    if not fixed:
        return [make_box("slot", axes, (low, high, -width / 2, width / 2))]
    if offset:
        low, high = low - 0.06 * u, high + 0.06 * u
    start, end = axes_to_plane(axes, low, 0.0), axes_to_plane(axes, high, 0.0)
    if placed.extents.part.turns and max(abs(start[0]), abs(end[0])) < 1e-6 * u:
        return [Lines("guide", ((start, end),))]
    middles = ((side, axes_to_plane(axes, (low + high) / 2, offset + side * 0.5 * width)) for side in (1, -1))
    # The lining of both walls leans to the same side.
    return [make_wall(middle, axes[2] - side * math.pi / 2, (high - low) / 2, 0.035 * u, lean=side) for side, middle in middles]


def _is_guided_by_slider(placed: PlacedMechanism, drive: joints.Joint) -> bool:
    """Return whether the driven body also runs in a guide, so that its path needs no line."""
    bodies = {drive.first.body, drive.second.body}
    return any(Glyph.GUIDE in joint.glyphs and {joint.first.body, joint.second.body} == bodies for joint in placed.mechanism.joints)


def _slot_shapes(joint: joints.Joint, extents: MechanismExtents, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = extents.length_scale
    low, high = extents.joint_travels[joint.name]
    rim = "frame plate" if fixed else "plate"
    edges = ((rim, STRIP_WIDTH), ("slot", _SLOT_WIDTH), (rim, -_SLOT_WIDTH))
    if isinstance(joint, joints.ArcSlot) and high - low > 2 * math.pi - 0.4:
        return [Circle(role, axes[0], axes[1], joint.radius + width * u / 2) for role, width in edges]
    chain = place_points(axes, guide_centreline(joint, extents))
    if isinstance(joint, joints.CurveSlot) and isinstance(joint.curve, PolarCurve):
        return [Polygon(role, make_parallel_outline(chain, width * u / 2)) for role, width in edges]
    return [*([make_band(rim, chain, STRIP_WIDTH * u)] if fixed else []), make_band("slot", chain, _SLOT_WIDTH * u)]


def block_parts(placed: PlacedMechanism, *, behind: bool) -> Iterator[Attached]:
    """Yield the blocks that slide in straight guides: those behind the outline of their body, which they would hide, or the others.

    A rack is its own block. A ram has a lug that carries its pin.
    """
    for joint in placed.mechanism.joints:
        if Glyph.GUIDE in joint.glyphs and not _is_drawn_elsewhere(placed, joint) and _hides_outline(placed, joint) == behind:
            length, width = _block_sides(placed, joint)
            shapes: list[DrawnShape] = []
            if offset := ram_offsets(placed.extents).get(joint.name, 0.0):
                length = RAM_LENGTH * placed.unit
                shapes.append(make_bar("block", (0.0, 0.0), (0.0, offset), 0.07 * placed.unit))
            shapes.append(make_rectangle("block", -length / 2, length / 2, offset - width / 2, offset + width / 2))
            yield Attached(frame=_block_axes(placed.extents, joint), shapes=tuple(shapes))


def _hides_outline(placed: PlacedMechanism, joint: joints.Joint) -> bool:
    """Return whether the block of a slider would stand in front of corners of the outline of its body."""
    reach = max(_block_sides(placed, joint)) / 2
    own = (one for one in placed.mechanism.outlines if one.origin.body == joint.second.body)
    corners = ((x + one.origin.x, y + one.origin.y) for one in own for x, y in outline_points(one.outline))
    return any(math.dist(corner, (joint.second.x, joint.second.y)) < reach for corner in corners)


def _block_axes(extents: MechanismExtents, joint: joints.Joint) -> Frame:
    """Return the axes of the block of a slider: the origin is the point that it guides, and x leads along its guide."""

    def frame(moment: Moment) -> PoseTuple:
        placed = extents.placed_at(moment)
        return *placed.position(joint.second), _guide_axes(placed, joint)[2]

    return frame


def pin_points(placed: PlacedMechanism, without: Collection[joints.Point]) -> Iterator[joints.Point]:
    """Yield the points of the visible pins: pins, ends of links, points in slots, and points that rotate on a sliding block.

    None is at the points `without` a pin. A bead, which does not rotate and is held in one point, has no pin.
    """
    beads = _bead_bodies(placed)
    rotating_bodies = {body.name for body in placed.mechanism.bodies if body.can_rotate}
    for joint in placed.mechanism.joints:
        if Glyph.PINS in joint.glyphs:
            yield from (end for end in (joint.first, joint.second) if end.body not in beads and end not in without)
        is_in_slot = Glyph.PIN_IN_SLOT in joint.glyphs and joint.second.body not in beads
        is_on_block = Glyph.PIN_ON_BLOCK in joint.glyphs and {joint.first.body, joint.second.body} & rotating_bodies
        if (Glyph.PIN in joint.glyphs or is_in_slot or is_on_block) and not {joint.first, joint.second} & {*without}:
            yield joint.second


def _bead_bodies(placed: PlacedMechanism) -> set[str]:
    """Return the names of bodies that do not rotate and are held at their mass centre only, in slots or by links."""
    held_only_in_point: dict[str, bool] = {}
    for joint in placed.mechanism.joints:
        for point in (joint.first, joint.second):
            is_point_only = bool(joint.glyphs & {Glyph.PINS, Glyph.PIN_IN_SLOT}) and not (point.x or point.y)
            held_only_in_point[point.body] = held_only_in_point.get(point.body, True) and is_point_only
    return {body.name for body in placed.mechanism.bodies if not body.can_rotate and held_only_in_point.get(body.name)}


def foot_parts(placed: PlacedMechanism) -> Iterator[Attached]:
    """Yield a hatched foot under every pin, link or block on the ground; above it where the mechanism hangs."""
    feet: list[joints.Point] = []
    for joint in placed.mechanism.joints:
        if isinstance(joint, joints.Weld) and not placed.extents.part.turns:
            continue  # a foot would look as if the part could turn
        if Glyph.FEET in joint.glyphs:
            feet += (joint.first, joint.second)
        elif Glyph.FOOT in joint.glyphs:
            feet.append(joint.second)
    positions = [(foot.x, foot.y) for foot in feet if foot.body == joints.GROUND]
    if placed.extents.part.turns:
        yield attached.fixed(_hub_shapes(positions, placed.unit), turns=True)
        return
    for point in distinct_points(positions, 0.01 * placed.unit):
        foot, *ground = _foot_shape(point, placed.unit, above=point[1] > placed.extents.mean_height)
        if _is_behind_outline(placed, bounding_box([foot, *ground])):
            continue  # what shows in its slots would look like dirt
        yield attached.fixed([foot], turns=True)
        yield attached.fixed(ground)


def _is_behind_outline(placed: PlacedMechanism, box: BoundingBox) -> bool:
    """Return whether a box (m) is hidden by the outline of a body but for its slots and holes."""
    left, right, bottom, top = box
    corners = [(x, y) for x in (left, right) for y in (bottom, top)]
    for one in placed.mechanism.outlines:
        drawn = [(x + one.origin.x, y + one.origin.y) for x, y in outline_points(one.outline)]
        hull = convex_hull(place_points(placed.pose(one.origin.body), drawn))
        if convex_hull([*hull, *corners]) == hull:
            return True
    return False


def _hub_shapes(positions: Sequence[Vec2], u: float) -> Iterator[DrawnShape]:
    """Yield what on a spindle carries the pins of a plane that turns: at each height an arm across the axis, around a hub."""
    half = 0.5 * _HUB_WIDTH * u
    for y in sorted({round(y, 9) for _, y in positions}):
        xs = [0.0, *(x for x, other in positions if abs(other - y) < 1e-8)]
        if max(xs) > min(xs):
            yield make_bar("frame", (min(xs), y), (max(xs), y), _HUB_WIDTH * u)
        yield make_rectangle("frame", -SPINDLE_WIDTH * u, SPINDLE_WIDTH * u, y - 1.3 * half, y + 1.3 * half)


def points_on_axis(extents: MechanismExtents) -> list[Point]:
    """Return the points that slide along the spindle of a plane that turns."""
    guides = (joint for joint in extents.part.mechanism.joints if Glyph.GUIDE in joint.glyphs and joint.first.body == GROUND)
    return [joint.second for joint in guides if abs(joint.first.x) < 1e-9 * extents.length_scale]


def _foot_shape(position: Vec2, u: float, *, above: bool) -> tuple[DrawnShape, ...]:
    x, y = position
    half_width = 0.06 * u
    height = 0.09 * u
    ground_thickness = 0.04 * u
    base = y + height if above else y - height
    bottom = base if above else base - ground_thickness
    box = (x - 1.5 * half_width, x + 1.5 * half_width, bottom, bottom + ground_thickness)
    line = Lines("wall", (((box[0], base), (box[1], base)),))
    return (Polygon("frame", ((x, y), (x - half_width, base), (x + half_width, base))), make_hatching("hatching", box, 0.034 * u), line)


def toothed_bodies(extents: MechanismExtents) -> set[str]:
    """Return the names of bodies drawn as wheels or racks."""
    wheels = {point.body for joint in extents.part.mechanism.joints for point, _ in _wheels_of(extents, joint)}
    return wheels | rack_bodies(extents.part.mechanism)


def rack_bodies(mechanism: Mechanism) -> set[str]:
    """Return the names of bodies drawn as racks."""
    return {joint.second.body for joint in mechanism.joints if Glyph.RACK in joint.glyphs} - {joints.GROUND}


def wheel_parts(placed: PlacedMechanism, *, fixed: bool) -> Iterator[Attached]:
    """Yield the wheels that the ground holds (`fixed`), rims without spokes, or wheels with spokes that rotate; larger ones behind."""
    u = placed.unit
    # A wheel can mesh with several others.
    wheels: dict[tuple[str, float, float, int], tuple[joints.Point, float]] = {}
    for joint in placed.mechanism.joints:
        for point, radius in _wheels_of(placed.extents, joint):
            wheels.setdefault((point.body, point.x, point.y, round(200 * radius / u)), (point, radius))
    shown = [wheel for wheel in wheels.values() if (wheel[0].body == GROUND) == fixed]
    for point, radius in sorted(shown, key=lambda wheel: -wheel[1]):
        wheel = spoked_wheel(radius, max(radius - 0.035 * u, 0.72 * radius), 0.045 * u, (point.x, point.y))
        shapes = wheel[:2] if fixed else wheel
        yield Attached(frame=placed.extents.body_axes(point.body), shapes=tuple(shapes))


def spoked_wheel(radius: float, rim_radius: float, max_hub_radius: float, centre: Vec2 = (0.0, 0.0)) -> list[DrawnShape]:
    """Return a wheel with four spokes, one of them marked; `rim_radius` (m) is the inner one of its rim."""
    x, y = centre
    ends = [axes_to_plane((x, y, k * math.pi / 2), rim_radius, 0.0) for k in range(4)]
    return [
        Circle("wheel", x, y, radius),
        Circle("wheel web", x, y, rim_radius),
        Lines("spoke", tuple(((x, y), end) for end in ends[1:])),
        Lines("marked spoke", (((x, y), ends[0]),)),
        Circle("wheel", x, y, min(0.22 * rim_radius, max_hub_radius)),
    ]


def _wheels_of(extents: MechanismExtents, joint: joints.Joint) -> list[tuple[joints.Point, float]]:
    """Return the centres on their bodies and the radii (m) of the wheels of a joint."""
    mechanism, u = extents.part.mechanism, extents.length_scale
    if isinstance(joint, joints.RackAndPinion):
        return [(joint.first, abs(joint.radius))]
    if not isinstance(joint, joints.Gear):
        return []
    centres = wheel_centres(mechanism, extents.poses, joint)
    if not centres:
        return []
    positions = (point_path(mechanism, extents.poses[:1], centre)[0] for centre in centres)
    centre_distance = math.dist(*positions)
    if centre_distance > 0.02 * u:
        radii = [float(radius[0]) for radius in wheel_radii(joint.ratio, np.array([centre_distance]))]
    else:
        second = _CONCENTRIC_WHEEL_RADIUS * u / max(abs(joint.ratio), 1.0)
        is_alike = abs(abs(joint.ratio) - 1.0) < 0.1  # as bevel wheels: the smaller one shows that they turn differently
        radii = [(0.7 if is_alike else abs(joint.ratio)) * second, second]
    return list(zip(centres, radii, strict=True))


def rack_parts(placed: PlacedMechanism) -> Iterator[Attached]:
    """Yield toothed bars that touch the circles of their pinions during the whole run."""
    u = placed.unit
    for joint in placed.mechanism.joints:
        if not isinstance(joint, joints.RackAndPinion):
            continue
        side, axes = _rack_contact(placed, joint)
        start, end = _rack_ends(placed, joint)
        back_offset = side * _RACK_THICKNESS * u
        rack = make_box("rack", axes, (start, end, 0.0, back_offset))
        count = max(round((end - start) / (0.045 * u)), 2)
        tooth_positions = (start + (k + 0.5) * (end - start) / count for k in range(count))
        teeth = Lines("tooth", tuple(place_points(axes, ((x, 0.0), (x, 0.4 * back_offset))) for x in tooth_positions))
        yield placed.extents.attach(placed.extents.body_axes(joint.second.body), [rack, teeth])


def _rack_ends(placed: PlacedMechanism, joint: joints.RackAndPinion) -> tuple[float, float]:
    """Return the start and end of a rack (m) along it, from where it touches its pinion now."""
    x, y = placed.position(joint.first)
    rack_x, rack_y = placed.position(joint.second)
    low, high = placed.extents.joint_travels[joint.name]
    place = (rack_x - x) * math.cos(joint.angle) + (rack_y - y) * math.sin(joint.angle)
    return place - high - _RACK_MARGIN * placed.unit, place - low + _RACK_MARGIN * placed.unit


def _rack_contact(placed: PlacedMechanism, joint: joints.RackAndPinion) -> tuple[float, PoseTuple]:
    """Return the side (+1 or -1) of the pinion on which its rack touches it, and axes there with x along the rack."""
    # A pinion that rotates anticlockwise drives a rack on the right of the forward direction.
    side = -1.0 if joint.radius > 0 else 1.0
    return side, (*axes_to_plane((*placed.position(joint.first), joint.angle), 0.0, side * abs(joint.radius)), joint.angle)


def rack_bed_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the beds of racks that are fixed, or that the ground guides."""
    u = placed.unit
    sliders = (joint for joint in placed.mechanism.joints if isinstance(joint, joints.Slider))
    guided_bodies = {slider.second.body for slider in sliders if slider.first.body == joints.GROUND}
    for joint in placed.mechanism.joints:
        if isinstance(joint, joints.RackAndPinion) and joint.second.body in {joints.GROUND, *guided_bodies}:
            side, axes = _rack_contact(placed, joint)
            start, end = _rack_ends(placed, joint)
            is_fixed = joint.second.body == joints.GROUND  # below a rack that moves, the bed is where its pinion is
            position = axes_to_plane(axes, (start + end) / 2 if is_fixed else 0.0, side * _RACK_THICKNESS * u)
            half_length = (end - start) / 2 + (0.0 if is_fixed else _BED_MARGIN * u)
            yield make_wall(position, joint.angle - side * math.pi / 2, half_length, 0.035 * u)

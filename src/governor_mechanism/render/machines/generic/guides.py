"""Generic drawing of guides: straight guides, slots, their sliding blocks, and the feet of ground pins."""

import math
from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import GROUND, ArcSlot, CurveSlot, Distance, Joint, Pin, Prismatic, Slider, TranslationalDriver, Weld
from governor_mechanism.render.geometry.outlines import distinct_points, make_band, make_wall
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    axes_to_plane,
    make_hatching,
    place_points,
)
from governor_mechanism.render.machines.generic.extents import MechanismExtents
from governor_mechanism.render.machines.generic.gears import rack_bodies
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism
from governor_mechanism.types import FloatArray

_SLOT_WIDTH, STRIP_WIDTH = 0.046, 0.100
"""Widths of a slot and of the strip around it, as fractions of the length scale."""
_BLOCK_SIDES, _SPRUNG_BLOCK_SIDES = (0.15, 0.08), (0.16, 0.22)
"""Sides, along and across the guide, of a sliding block and of a mass held by springs in its guide, as fractions of the length scale."""
_GUIDE_EXTENSION = 0.12
"""Length of a guide beyond the travel at each end, as a fraction of the length scale."""
_N_SLOT_SEGMENTS = 48
"""Number of straight segments of a drawn slot."""


def guide_centreline(joint: Joint, extents: MechanismExtents) -> list[Vec2]:
    """Return the centre line of the guide of the joint's second point (m, in the axes of the joint's first point)."""
    low, high = extents.joint_travels[joint.name]
    extension = _GUIDE_EXTENSION * extents.length_scale
    match joint:
        case ArcSlot(radius=radius):
            extension = min(0.6 * extension / radius, 0.2)
            angles = np.linspace(low - extension, max(high + extension, low + extension), _N_SLOT_SEGMENTS + 1)
            return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
        case CurveSlot(curve=curve):
            first, last = low - 0.6 * extension, high + 0.6 * extension
            if isinstance(curve, SplineCurve):
                # A table curve ends at its first and last point; it is drawn whole unless the run uses a small part of it.
                max_extension = 0.5 * (high - low) + extension
                first, last = (max(low - max_extension, min(curve.x[0], low)), min(high + max_extension, max(curve.x[-1], high)))
            xs = np.linspace(first, last, _N_SLOT_SEGMENTS + 1)
            return list(zip(xs.tolist(), _curve_ordinates(curve, xs).tolist(), strict=True))
        case _:
            return [(low - extension, 0.0), (high + extension, 0.0)]


def _curve_ordinates(curve: Curve, xs: FloatArray) -> FloatArray:
    match curve:
        case PolynomialCurve(coefficients=coefficients):
            return np.asarray(np.polynomial.polynomial.polyval(xs, coefficients), dtype=np.float64)
        case SplineCurve(x=x, y=y):
            return np.asarray(CubicSpline(x, y)(xs))
    raise NotImplementedError(f"curves of type {type(curve).__name__} cannot be drawn")


def guide_shapes(placed: PlacedMechanism, *, fixed: bool) -> Iterator[DrawnShape]:
    """Yield the guides on the ground (`fixed`) or on bodies; the plate of a body is drawn elsewhere."""
    for joint in placed.mechanism.joints:
        if joint.name not in placed.extents.joint_travels or (joint.first.body == GROUND) != fixed:
            continue
        axes = _guide_axes(placed, joint)
        match joint:
            case Slider() if not (fixed and joint.second.body in rack_bodies(placed.mechanism)):
                yield from _straight_guide_shapes(placed, joint, axes, fixed=fixed)
            case ArcSlot() | CurveSlot():
                yield from _slot_shapes(joint, placed.extents, axes, fixed=fixed)
            case TranslationalDriver() if fixed and not _is_guided_by_slider(placed, joint):
                yield Lines("guide", (place_points(axes, guide_centreline(joint, placed.extents)),))


def _guide_axes(placed: PlacedMechanism, joint: Joint) -> PoseTuple:
    """Return the axes of a guide: origin in the joint's first point, x along a straight guide."""
    angle = joint.angle if isinstance(joint, Slider | CurveSlot | TranslationalDriver) else 0.0
    return *placed.position(joint.first), placed.pose(joint.first.body)[2] + angle


def _block_sides(placed: PlacedMechanism, joint: Slider) -> Vec2:
    """Return the sides of the block of a slider; a mass on springs is large enough to show them side by side."""
    body = joint.second.body
    has_no_other_joint = all(body not in (other.first.body, other.second.body) or other is joint for other in placed.mechanism.joints)
    is_sprung_mass = has_no_other_joint and placed.hangs_on_springs(body) and body != GROUND
    along, across = _SPRUNG_BLOCK_SIDES if is_sprung_mass else _BLOCK_SIDES
    return along * placed.unit, across * placed.unit


def _straight_guide_shapes(placed: PlacedMechanism, joint: Slider, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = placed.unit
    (low, _), (high, _) = guide_centreline(joint, placed.extents)
    width = _block_sides(placed, joint)[1]
    if not fixed:
        return [make_box("slot", axes, ((low + high) / 2, 0.0), (high - low, width))]
    start, end = axes_to_plane(axes, low, 0.0), axes_to_plane(axes, high, 0.0)
    if placed.extents.part.turns and max(abs(start[0]), abs(end[0])) < 1e-6 * u:
        return [Lines("guide", ((start, end),))]
    middles = ((side, axes_to_plane(axes, (low + high) / 2, side * 0.5 * width)) for side in (1, -1))
    return [make_wall(middle, axes[2] - side * math.pi / 2, (high - low) / 2, 0.035 * u) for side, middle in middles]


def _is_guided_by_slider(placed: PlacedMechanism, drive: TranslationalDriver) -> bool:
    """Return whether the driven body also runs in a guide, so that its path needs no line."""
    bodies = {drive.first.body, drive.second.body}
    return any(isinstance(joint, Slider) and {joint.first.body, joint.second.body} == bodies for joint in placed.mechanism.joints)


def _slot_shapes(joint: ArcSlot | CurveSlot, extents: MechanismExtents, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = extents.length_scale
    low, high = extents.joint_travels[joint.name]
    rim = "frame plate" if fixed else "plate"
    if isinstance(joint, ArcSlot) and high - low > 2 * math.pi - 0.4:
        edges = (("", STRIP_WIDTH), ("slot", _SLOT_WIDTH), (rim, -_SLOT_WIDTH))
        return [Circle(role or rim, axes[0], axes[1], joint.radius + w * u / 2) for role, w in edges]
    chain = place_points(axes, guide_centreline(joint, extents))
    return [*([make_band(rim, chain, STRIP_WIDTH * u)] if fixed else []), make_band("slot", chain, _SLOT_WIDTH * u)]


def block_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the blocks that slide in straight guides; a rack is its own block."""
    for joint in placed.mechanism.joints:
        if isinstance(joint, Slider) and joint.second.body not in rack_bodies(placed.mechanism):
            axes = (*placed.position(joint.second), _guide_axes(placed, joint)[2])
            yield make_box("block", axes, (0.0, 0.0), _block_sides(placed, joint))


def pin_centres(placed: PlacedMechanism) -> Iterator[Vec2]:
    """Yield the visible pin positions: pins, ends of links, points in slots, and points that rotate on a sliding block.

    A bead, which does not rotate and is held in one point, has no pin.
    """
    beads = _bead_bodies(placed)
    rotating_bodies = {body.name for body in placed.mechanism.bodies if body.can_rotate}
    for joint in placed.mechanism.joints:
        match joint:
            case Distance():
                yield from (placed.position(end) for end in (joint.first, joint.second) if end.body not in beads)
            case Pin():
                yield placed.position(joint.second)
            case ArcSlot() | CurveSlot() if joint.second.body not in beads:
                yield placed.position(joint.second)
            case Slider() if not isinstance(joint, Prismatic) and ({joint.first.body, joint.second.body} & rotating_bodies):
                yield placed.position(joint.second)


def _bead_bodies(placed: PlacedMechanism) -> set[str]:
    """Return the names of bodies that do not rotate and are held at their mass centre only, in slots or by links."""
    held_only_in_point: dict[str, bool] = {}
    for joint in placed.mechanism.joints:
        for point in (joint.first, joint.second):
            is_point_only = isinstance(joint, Distance | ArcSlot | CurveSlot) and not (point.x or point.y)
            held_only_in_point[point.body] = held_only_in_point.get(point.body, True) and is_point_only
    return {body.name for body in placed.mechanism.bodies if not body.can_rotate and held_only_in_point.get(body.name)}


def foot_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield a hatched foot under every pin, link, block or weld on the ground; above it where the mechanism hangs."""
    positions = [
        (mine.x, mine.y)
        for joint in placed.mechanism.joints
        for mine in (joint.first, joint.second)
        if mine.body == GROUND
        and (isinstance(joint, Pin | Distance | Weld) or (mine is joint.second and isinstance(joint, Slider | ArcSlot | CurveSlot)))
    ]
    for point in distinct_points(positions, 0.01 * placed.unit):
        yield from _foot_shape(point, placed.unit, above=point[1] > placed.extents.mean_height)


def _foot_shape(position: Vec2, u: float, *, above: bool) -> tuple[DrawnShape, ...]:
    x, y = position
    half_width, height, ground_thickness = 0.06 * u, 0.09 * u, 0.04 * u
    base = y + height if above else y - height
    bottom = base if above else base - ground_thickness
    box = (x - 1.5 * half_width, x + 1.5 * half_width, bottom, bottom + ground_thickness)
    line = Lines("wall", (((box[0], base), (box[1], base)),))
    return (Polygon("frame", ((x, y), (x - half_width, base), (x + half_width, base))), make_hatching("hatching", box, 0.034 * u), line)


def make_box(role: str, axes: PoseTuple, centre: Vec2, sides: Vec2) -> Polygon:
    """Return a box with its centre and the lengths of its sides (m) in axes."""
    a, b = sides[0] / 2, sides[1] / 2
    corners = ((a, b), (-a, b), (-a, -b), (a, -b))
    return Polygon(role, tuple(axes_to_plane(axes, centre[0] + f, centre[1] + g) for f, g in corners))

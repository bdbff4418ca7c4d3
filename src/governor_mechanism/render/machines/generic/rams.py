"""Generic drawing of rams: sliding bodies whose guide must stand aside, because another body passes along it.

A body that only slides moves alike in every parallel guide, so that its guide may be drawn beside the line of its pin.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.model.force_elements import Damper
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.outlines import make_arrow
from governor_mechanism.render.geometry.points import axes_to_plane, point_path
from governor_mechanism.render.geometry.primitives import DrawnShape, TextShape
from governor_mechanism.render.machines.generic.placed_mechanism import LoadFunction, MechanismExtents, PlacedMechanism
from governor_mechanism.render.number_format import format_name

RAM_LENGTH, BLOCK_WIDTH = 0.30, 0.08
"""Length of a ram, and width of a guide, as fractions of the length scale."""
_CLEARANCE = 0.16
"""Distance of the guide's middle from the points that pass along it, relative to the length scale: half a bar, half a block, a wall."""
_MAX_OFFSET = 0.35
_ARROW_LENGTH, _ARROW_HEAD_SIZE, _LETTER_WIDTH = 0.30, 0.06, 0.0235
"""Length of the largest force and of its head, and width of a letter, as fractions of the length scale."""


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


@once_per_object
def ram_drags(extents: MechanismExtents) -> Mapping[str, tuple[Slider, LoadFunction, float]]:
    """Return the dampers that resist a sliding body along its guide and have no room to be drawn in it.

    By name of the damper: the slider, its force on the body along the guide over time (N; the second component is zero), and the largest.
    """
    mechanism, drags = extents.part.mechanism, {}
    for slider in mechanism.joints:
        if not isinstance(slider, Slider) or slider.name not in ram_offsets(extents):
            continue
        low, high = extents.joint_travels[slider.name]
        is_passed = low <= RAM_LENGTH / 2 * extents.length_scale and high >= -RAM_LENGTH / 2 * extents.length_scale
        for damper in mechanism.force_elements:
            if isinstance(damper, Damper) and {damper.first, damper.second} == {slider.first, slider.second} and is_passed:
                force = _drag_along_guide(extents, slider.second, slider.angle, damper.damping)
                drags[damper.name] = (slider, force, float(np.abs(force(extents.run.times)[0]).max()))
    return drags


def _drag_along_guide(extents: MechanismExtents, point: Point, angle: float, damping: float) -> LoadFunction:
    """Return the force of a damper (N) on a body that only slides along a guide, over time."""
    velocities = extents.select_bodies(extents.run.velocities)[:, extents.part.mechanism.body_index(point.body), :2]
    forces = -damping * rotate_vector(-angle, *velocities.T)[0]
    return lambda times: np.array([np.interp(times, extents.run.times, forces), np.zeros(len(times))])


def drag_arrow_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the force of each drag as an arrow at the face of the ram, of a length proportional to it, in front of the ram."""
    u = placed.unit
    for slider, force, largest in ram_drags(placed.extents).values():
        fraction = float(force(np.array([placed.time]))[0, 0]) / largest if largest > 0.0 else 0.0
        axes = (*placed.position(slider.second), slider.angle)
        offset, face = ram_offsets(placed.extents)[slider.name], RAM_LENGTH / 2 * u
        # A push ends at the face, a pull begins there.
        ends = (face, face + abs(fraction) * _ARROW_LENGTH * u)
        start, end = ends if fraction > 0.0 else ends[::-1]
        yield from make_arrow("force", (axes_to_plane(axes, start, offset), axes_to_plane(axes, end, offset)), _ARROW_HEAD_SIZE * u)


def drag_caption_shapes(extents: MechanismExtents) -> Iterator[DrawnShape]:
    """Yield what the arrow of each drag means, above its guide: a damper resists both strokes, not only that of a cut."""
    u = extents.length_scale
    for name, (slider, _, largest) in ram_drags(extents).items():
        text = f"{format_name(name)}: damper, both strokes, up to {largest:.3g} N"
        low, _ = extents.joint_travels[slider.name]
        x, y = axes_to_plane((slider.first.x, slider.first.y, slider.angle), low, ram_offsets(extents)[slider.name] + 0.13 * u)
        yield TextShape("scale", x, y, text, _LETTER_WIDTH * len(text) * u)

"""Generic drawing of any mechanism from its bodies, joints, force elements and poses."""

from collections.abc import Iterator
from dataclasses import replace

from governor_mechanism.model.joints import GROUND, Glyph, Joint
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Moment, axes_along, fixed, shapes_of
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Vec2, bounding_box
from governor_mechanism.render.machines.generic import bodies, force_elements, joints, reading_marks
from governor_mechanism.render.machines.generic.frames import RIM_ROLES, WEB_ROLE
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents
from governor_mechanism.types import FloatArray

_LINK_WIDTH, _PIN_RADIUS = 0.030, 0.016
"""Width of a massless link and radius of a pin, as fractions of the length scale."""
_SYMMETRY_RATIO = 0.04
"""Difference of the extents to both sides of the axis, relative to their sum, below which a part is round."""


class GenericDrawing(MechanismExtents):
    """Drawing of any mechanism."""

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the axis of a rotating plane, discs and circles of cranks, the guides on the ground, feet, walls and captions."""
        placed = self.placed_at(Moment(self.poses[len(self.poses) // 2], 0.0))
        yield fixed(self._axis_shapes())
        yield from joints.wheel_parts(placed, fixed=True)
        yield fixed(bodies.crank_shapes(self))
        yield from joints.guide_parts(placed, fixed=True)
        yield fixed(joints.rack_bed_shapes(placed))
        yield from joints.foot_parts(placed)
        yield fixed(force_elements.wall_shapes(placed))
        yield fixed(joints.drag_caption_shapes(self))

    def _axis_shapes(self) -> Iterator[DrawnShape]:
        """Yield the axis of a plane that turns."""
        if self.part.turns:
            ground_points = [point for joint in self.part.mechanism.joints for point in (joint.first, joint.second) if point.body == GROUND]
            heights = [float(self.poses[:, :, 1].min()), float(self.poses[:, :, 1].max()), *(point.y for point in ground_points)]
            margin = 0.2 * self.length_scale
            yield Lines("axis", (((0.0, min(heights) - margin), (0.0, max(heights) + margin)),))

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
        yield from sorted(others, key=lambda part: part.shapes[0].role not in RIM_ROLES)  # bars are in front of frames
        yield from (self._link_part(joint) for joint in self.part.mechanism.joints if Glyph.BAR in joint.glyphs)
        yield from force_elements.translational_element_parts(placed)
        yield from joints.block_parts(placed)
        yield from (part for part in (*slotted, *bodies_without) if part.shapes[0].role in ("block", "ball"))
        yield from force_elements.torsional_element_parts(placed)
        yield from force_elements.drive_parts(placed)
        pins = list(joints.pin_points(placed))
        yield from (force_elements.eye_part(self, "pivot", point, _PIN_RADIUS * self.length_scale) for point in pins)
        yield from force_elements.output_effect_parts(self)
        yield from bodies.tracer_parts(placed)
        yield from force_elements.force_arrow_parts(self)
        yield self.flex(joints.drag_arrow_shapes, section_only=True)
        yield from reading_marks.reading_mark_parts(self)

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

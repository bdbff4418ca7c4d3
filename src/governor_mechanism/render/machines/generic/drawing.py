"""Generic drawing of any mechanism from its bodies, joints, force elements and poses."""

from collections.abc import Iterator

from governor_mechanism.model.joints import GROUND, Glyph
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines
from governor_mechanism.render.machines.generic import bodies, cranks, force_elements, joints, rams, reading_marks
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents, PlacedMechanism
from governor_mechanism.types import FloatArray

_LINK_WIDTH, _PIN_RADIUS = 0.040, 0.020
"""Width of a massless link and radius of a pin, as fractions of the length scale."""


class GenericDrawing(MechanismExtents):
    """Drawing of any mechanism."""

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the axis of a rotating plane, discs and circles of cranks, the guides on the ground, feet, walls and captions."""
        placed = self._place(self.poses[len(self.poses) // 2], 0.0)
        if self.part.turns:
            ground_points = [point for joint in self.part.mechanism.joints for point in (joint.first, joint.second) if point.body == GROUND]
            heights = [float(self.poses[:, :, 1].min()), float(self.poses[:, :, 1].max()), *(point.y for point in ground_points)]
            margin = 0.2 * self.length_scale
            yield Lines("axis", (((0.0, min(heights) - margin), (0.0, max(heights) + margin)),))
        yield from cranks.crank_shapes(self)
        yield from joints.guide_shapes(placed, fixed=True)
        yield from joints.rack_bed_shapes(placed)
        yield from joints.foot_shapes(placed)
        yield from force_elements.wall_shapes(placed)
        yield from rams.drag_caption_shapes(self)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield torques, wheels, bodies, links, blocks, force elements and pins.

        Slotted bodies are behind what slides in them; masses and balls are in front of plates and links.
        """
        placed = self._place(pose, time)
        slotted, shapes_of_bodies = (list(bodies.body_shapes(placed, slotted=is_slotted)) for is_slotted in (True, False))
        yield from force_elements.torque_arrow_shapes(placed)
        yield from joints.rack_shapes(placed)
        yield from joints.wheel_shapes(placed)
        yield from (shape for shape in slotted if shape.role != "ball")
        yield from joints.guide_shapes(placed, fixed=False)
        yield from (shape for shape in shapes_of_bodies if shape.role not in ("block", "ball"))
        for joint in self.part.mechanism.joints:
            if Glyph.BAR in joint.glyphs:
                yield make_bar("link", placed.position(joint.first), placed.position(joint.second), _LINK_WIDTH * placed.unit)
        yield from force_elements.translational_element_shapes(placed)
        yield from joints.block_shapes(placed)
        yield from (shape for shape in (*slotted, *shapes_of_bodies) if shape.role in ("block", "ball"))
        yield from force_elements.torsional_element_shapes(placed)
        yield from force_elements.drive_shapes(placed)
        yield from (Circle("pivot", *point, _PIN_RADIUS * placed.unit) for point in joints.pin_centres(placed))
        yield from force_elements.output_effect_shapes(placed)
        yield from bodies.tracer_shapes(placed)
        yield from force_elements.force_arrow_shapes(placed)
        yield from rams.drag_arrow_shapes(placed)
        yield from reading_marks.reading_mark_shapes(placed)

    def named_places(self, poses: FloatArray) -> dict[str, FloatArray]:
        """Return the places (n, 2) m of the parts that have names, at poses (n, bodies, 3)."""
        return {body.name: poses[:, k, :2] for k, body in enumerate(self.part.mechanism.bodies)}

    def _place(self, pose: FloatArray, time: float) -> PlacedMechanism:
        return PlacedMechanism(extents=self, poses=[(x, y, angle) for x, y, angle in pose.tolist()], time=time)

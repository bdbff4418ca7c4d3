"""What the drawing of a machine is: shapes in metres, without colours, fixed or attached to what moves, and the view from above."""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from functools import cached_property
from typing import ClassVar

from governor_mechanism.render.geometry.attached import Attached, BodyAxes, DrawnPart, Frame, Moment, fixed_axes, into_axes, shapes_of
from governor_mechanism.render.geometry.outlines import make_bar, select_extreme_rows
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    bounding_box,
    drawn_ball_radius,
    drawn_point_paths,
    enclose_boxes,
    is_wording,
)
from governor_mechanism.render.geometry.recording import enclose_recorded, record_parts
from governor_mechanism.render.part_run import PartRun
from governor_mechanism.types import FloatArray

_MARGIN_RATIO = 0.02
"""Free border around the shapes, as a fraction of the larger side."""


class Dimension:
    """A dimension of the drawn machine (SI)."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, drawing: PartRun, owner: type) -> float:
        return drawing.part.dimensions[self._name]


class MachineDrawing(PartRun, ABC):
    """Drawing of a machine during a run.

    Shapes are listed back to front. Every pose gives the same number of shapes, of the same kinds and roles.
    `panel_readings` are the readings of the side panel, most important first; `plan_caption` is the text at the plan view, line by line.
    `shows_bodies` is whether bodies are drawn where they are; a diagram of a valve gear, for one, has a map of its own.
    """

    shows_bodies: ClassVar[bool] = False
    panel_readings: ClassVar[tuple[str, ...]] = ()
    plan_caption: ClassVar[tuple[str, ...]] = ("from above",)

    @abstractmethod
    def fixed_parts(self) -> Iterable[Attached]:
        """Return what does not move during the run, back to front."""

    @abstractmethod
    def moving_parts(self) -> Iterable[DrawnPart]:
        """Return what moves, in front of what does not, back to front."""

    @property
    def shows_joint_forces(self) -> bool:
        """Whether the forces of the joints are among the shapes."""
        return False

    @cached_property
    def fixed(self) -> tuple[Attached, ...]:
        """What does not move, which takes long to find."""
        return tuple(self.fixed_parts())

    @cached_property
    def moving(self) -> tuple[DrawnPart, ...]:
        """What moves."""
        return tuple(self.moving_parts())

    def background_shapes(self) -> Iterable[DrawnShape]:
        """Return the shapes that do not move during the run."""
        return shapes_of(self.fixed, self.first_moment)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterable[DrawnShape]:
        """Return the moving shapes at a pose (bodies, 3) and a time (s)."""
        return shapes_of(self.moving, Moment(pose, time))

    @cached_property
    def first_moment(self) -> Moment:
        """Start of the run: shapes are drawn where they stand then, and attached."""
        return Moment(self.poses[0], float(self.run.times[0]))

    def body_axes(self, name: str) -> Frame:
        """Return the axes of a body; those of the ground do not move."""
        index = self.part.mechanism.body_index(name)
        return BodyAxes(index) if index >= 0 else fixed_axes

    def attach(self, frame: Frame, shapes: Iterable[DrawnShape], *, turns: bool = True) -> Attached:
        """Return shapes, drawn in the plane where they stand at the first moment, attached to axes."""
        local = into_axes(frame(self.first_moment), shapes)
        return Attached(frame=frame, shapes=local, turns=turns)

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterable[DrawnShape]:
        """Yield the rotating plane from above, at a spindle angle (rad): every body at its distance from the axis."""
        u = self.part.mechanism.length_scale
        c = math.cos(angle)
        s = math.sin(angle)
        positions = [(x * c, x * s) for x in pose[:, 0].tolist()]
        yield from (make_bar("arm", (0.0, 0.0), point, 0.05 * u) for point in positions)
        for body, point in zip(self.part.mechanism.bodies, positions, strict=True):
            yield Circle("ball", *point, 0.7 * drawn_ball_radius(body.mass, u))

    def traced_path(self, poses: FloatArray) -> FloatArray | None:
        """Return the path (n, 2) (m) to draw, if there is one, for poses (n, bodies, 3)."""
        return None

    def dial_shapes(self, pose: FloatArray, angle: float, ring_radius: float) -> tuple[DrawnShape, ...]:
        """Return the rotating plane from above, turned anticlockwise by `angle` (rad), with a hand to its ring of a radius (m)."""
        end = (ring_radius * math.cos(angle), ring_radius * math.sin(angle))
        hand = Lines("hand", (((0.0, 0.0), end),))
        return hand, *self.plan_shapes(pose, angle), Circle("hub", 0.0, 0.0, 0.05 * ring_radius)

    def dial_ring_radius(self) -> float:
        """Return the radius (m) of a ring that contains the plan view at every pose of the run."""
        plans = (self.plan_shapes(pose, 0.0) for pose in self.poses[select_extreme_rows(self.poses)])
        return 1.10 * max(max(map(abs, bounding_box(plan))) for plan in plans)

    @cached_property
    def static_shapes(self) -> tuple[DrawnShape, ...]:
        """The background shapes, which take long to find."""
        return tuple(self.background_shapes())

    @cached_property
    def bounds(self) -> BoundingBox:
        """The box (m) that contains every shape of the run, with a margin."""
        return self._enclose(self.static_shapes)

    @cached_property
    def bare_bounds(self) -> BoundingBox:
        """The box (m) that contains every shape of the run but words and keys, with a margin."""
        return self._enclose(shape for shape in self.static_shapes if not is_wording(shape))

    def _enclose(self, resting: Iterable[DrawnShape]) -> BoundingBox:
        """Return the box (m) around resting shapes and all that moves, with a margin."""
        left, right, bottom, top = enclose_boxes([bounding_box(resting), self._moving_box])
        margin = _MARGIN_RATIO * max(right - left, top - bottom)
        return left - margin, right + margin, bottom - margin, top + margin

    @cached_property
    def _moving_box(self) -> BoundingBox:
        """The box (m) that contains all that moves."""
        rows = select_extreme_rows(drawn_point_paths(self.part.mechanism, self.poses))
        moments = [Moment(self.poses[k], float(self.run.times[k])) for k in rows]
        return enclose_recorded(record_parts(self.moving, moments))

"""A mechanism at one pose, with the extents of its run: what every shape of the generic drawing depends on."""

import math
from abc import ABC
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_rows import point_path, rotate_vector
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque
from governor_mechanism.model.joints import GROUND, ArcSlot, Glyph, Joint, Pin, Point, RackAndPinion
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.geometry.attached import Flexible, Moment, fixed_axes, once_per_moment
from governor_mechanism.render.geometry.primitives import ELEVATION_RECT, DrawnShape, PoseTuple, Vec2, axes_to_plane, drawn_point_paths
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.part_run import sample_input
from governor_mechanism.types import FloatArray

ELEVATION_ASPECT_RATIO = (ELEVATION_RECT[2] - ELEVATION_RECT[0]) / (ELEVATION_RECT[3] - ELEVATION_RECT[1])
"""Width over height of the machine's rectangle in the frame."""
LoadFunction = Callable[[FloatArray], FloatArray]
"""Components (2, n) of a force (N), or a torque (N m) and 0, at times (n,) s."""


class MechanismExtents(MachineDrawing, ABC):
    """Extents of a part of a run: its length scale, the ranges of its motion, and its loads over time."""

    @once_per_moment
    def placed_at(self, moment: Moment) -> "PlacedMechanism":
        """Return the mechanism at a moment."""
        poses = [(x, y, angle) for x, y, angle in moment.pose.tolist()]
        return PlacedMechanism(extents=self, poses=poses, time=moment.time)

    def flex(
        self,
        shapes_at: Callable[["PlacedMechanism"], Iterable[DrawnShape]],
        *,
        axes_at: Callable[["PlacedMechanism"], PoseTuple] | None = None,
        turns: bool = False,
        section_only: bool = False,
    ) -> Flexible:
        """Return shapes that follow from the whole mechanism at a moment; if `axes_at` is given, they are in axes that do so."""
        frame = fixed_axes if axes_at is None else lambda moment: axes_at(self.placed_at(moment))
        return Flexible(shapes_at=lambda moment: shapes_at(self.placed_at(moment)), frame=frame, turns=turns, section_only=section_only)

    @cached_property
    def length_scale(self) -> float:
        """Length (m) that sizes what the scene leaves open, such as the width of a bar."""
        sides = np.ptp(drawn_point_paths(self.part.mechanism, self.poses).reshape(-1, 2), axis=0)
        length_scale = float(max(sides[0], ELEVATION_ASPECT_RATIO * sides[1]))
        own_scale = self.part.mechanism.length_scale
        # A mechanism that hardly moves and has no extent is measured by its flywheel, or by its own length scale.
        return length_scale if length_scale > 1e-3 * own_scale else 2 * self.flywheel_radius or own_scale

    @cached_property
    def mean_height(self) -> float:
        """Mean height (m) of the drawn points."""
        return float(drawn_point_paths(self.part.mechanism, self.poses)[..., 1].mean())

    @cached_property
    def flywheel_radius(self) -> float:
        """Radius (m) of a rim with the mass and the moment of inertia of the only body; 0 for several bodies or a point mass."""
        body, *others = self.part.mechanism.bodies
        xx, yy, _ = body.second_moments.in_plane
        return math.sqrt(max(xx + yy, 0.0) / body.mass) if body.can_rotate and not others else 0.0

    @cached_property
    def joint_travels(self) -> Mapping[str, Vec2]:
        """Smallest and largest displacement (m, or rad in an arc slot) of a joint's second point in the axes of its first."""
        return {joint.name: travel for joint in self.part.mechanism.joints if (travel := self._joint_travel(joint)) is not None}

    @property
    def replaced_guides(self) -> frozenset[str]:
        """Names of the sliders whose guides and blocks a drawing shows in its own way."""
        return frozenset()

    def element_length_range(self, element: Spring | Damper) -> Vec2:
        """Return the shortest and the longest length (m) of a spring or damper."""
        lengths = np.hypot(*self._separation(element.first, element.second).T)
        return float(lengths.min()), float(lengths.max())

    def load_fractions(self, load: Force | Torque, time: float) -> Vec2:
        """Return the components of a force, or a torque and 0, at a time (s), relative to the largest load of its type over the run."""
        largest = self._largest_loads[type(load)]
        if not largest > 0.0:
            return 0.0, 0.0
        x, y = (self.load_functions[load.name](np.array([time]))[:, 0] / largest).tolist()
        return x, y

    @cached_property
    def load_functions(self) -> Mapping[str, LoadFunction]:
        """Forces and torques over time, by name."""
        elements = self.run.scene.mechanism.force_elements  # these depend on the readings of the run
        loads = {element.name: element for element in elements if isinstance(element, Force | Torque)}
        return {name: self._load_function(load) for name, load in self.select_entries(loads).items()}

    @cached_property
    def _largest_loads(self) -> Mapping[type, float]:
        """Largest load of each type over the run (N or N m)."""
        largest: defaultdict[type, float] = defaultdict(float)
        for load in self.part.mechanism.force_elements:
            if isinstance(load, Force | Torque):
                magnitudes = np.hypot(*self.load_functions[load.name](self.run.times))
                largest[type(load)] = max(largest[type(load)], float(magnitudes.max()))
        return largest

    def _load_function(self, load: Force | Torque) -> LoadFunction:
        """Return a load over time, linear between the reported times if it depends on readings."""
        inputs = (load.x, load.y) if isinstance(load, Force) else (load.moment, InputFunction())
        if any(one.depends_on_readings for one in inputs):
            samples = [sample_input(self.run, one) for one in inputs]
            return lambda times: np.array([np.interp(times, self.run.times, values) for values in samples])
        functions = [CubicTimeFunction(one) for one in inputs]
        return lambda times: np.array([function(times) for function in functions])

    def _separation(self, first: Point, second: Point) -> FloatArray:
        """Return the position (n, 2) m of a point relative to another one over the run."""
        return point_path(self.part.mechanism, self.poses, second) - point_path(self.part.mechanism, self.poses, first)

    def _joint_travel(self, joint: Joint) -> Vec2 | None:
        """Return the smallest and the largest displacement of a joint over the run, or None for a joint without one."""
        separation = self._separation(joint.first, joint.second)
        body = self.part.mechanism.body_index(joint.first.body)
        angles = self.poses[:, body, 2] if body >= 0 else np.zeros(len(self.poses))
        match joint:
            case ArcSlot():
                x, y = rotate_vector(-angles, *separation.T)
                travel: FloatArray = np.unwrap(np.arctan2(y, x))
            case RackAndPinion():
                travel = separation @ np.array([math.cos(joint.angle), math.sin(joint.angle)])
            case _ if joint.glyphs & {Glyph.GUIDE, Glyph.SLOT, Glyph.PATH}:
                travel = rotate_vector(-(angles + getattr(joint, "angle", 0.0)), *separation.T)[0]
            case _:
                return None
        return float(travel.min()), float(travel.max())


@dataclass(frozen=True, kw_only=True)
class PlacedMechanism:
    """A mechanism at the poses of its bodies and a time (s)."""

    extents: MechanismExtents
    poses: Sequence[PoseTuple]
    time: float

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.extents.part.mechanism

    @property
    def unit(self) -> float:
        """Length scale of the drawing (m)."""
        return self.extents.length_scale

    def pose(self, body: str) -> PoseTuple:
        """Return the pose of a body; that of the ground is zero."""
        index = self.mechanism.body_index(body)
        return (0.0, 0.0, 0.0) if index < 0 else self.poses[index]

    def position(self, point: Point) -> Vec2:
        """Return the position of a point (m)."""
        return axes_to_plane(self.pose(point.body), point.x, point.y)

    def hinge_position(self, first: str, second: str) -> Vec2:
        """Return the position (m) of the hinge of two bodies."""
        return self.position(self.hinge_point(first, second))

    def hinge_point(self, first: str, second: str, default: Point | None = None) -> Point:
        """Return the point of the pin of two bodies, or `default`, or a mass centre.

        The mass centre is that of the second body, or of the first if the second is the ground.
        """
        bodies = {first, second}
        pins = (joint for joint in self.mechanism.joints if isinstance(joint, Pin))
        points = (pin.second for pin in pins if {pin.first.body, pin.second.body} == bodies)
        return next(points, default) or Point(body=first if second == GROUND else second)

    def hangs_on_springs(self, body: str) -> bool:
        """Return whether a spring or damper acts on a body."""
        return any(isinstance(load, Spring | Damper) and body in load.bodies for load in self.mechanism.force_elements)

"""Drawing of the slider crank: the mechanism as any other, and the forces that its joints carry as arrows."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from governor_mechanism.effects.masses import CrankMasses
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.joints import Pin, Point, Slider
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, fixed
from governor_mechanism.render.geometry.outlines import make_arrow
from governor_mechanism.render.geometry.primitives import DrawnShape, TextShape, round_step
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.generic.joints import BLOCK_WIDTH
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

_LARGEST_LENGTH = 2.4
"""Length of the arrow of the largest force, as a multiple of the crank."""
_HEAD_SIZE = 0.05
_LETTER_WIDTH = 0.0225
_LINE_HEIGHT = 0.07
"""Length of the head of an arrow, width of a letter and height of a line, as fractions of the length scale."""
_KEY_DISTANCE = 0.11
"""Distance of the key from the crank circle, as a fraction of the length scale."""
_MAX_KEY_STEPS = 3
"""The key shows a round force; the largest force is at most this multiple of it."""


_KEY = "forces on crank, rod and crosshead at their joints"


class _Load(NamedTuple):
    """Force (n, 2) N of a joint on a body at a point; its arrow begins at a distance `start` from there, relative to the length scale."""

    point: Point
    forces: FloatArray
    start: float


class SliderCrankDrawing(GenericDrawing):
    """Drawing of a slider crank. Only a run with masses has loads to show, and only those that rigid bodies determine."""

    crank = Dimension("crank")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield what any mechanism shows, and the key of the forces."""
        yield from super().fixed_parts()
        yield fixed(self._key_shapes())

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield what any mechanism shows, and the forces of the joints on the later of their parts."""
        yield from super().moving_parts()
        yield Flexible(shapes_at=self._reaction_shapes, section_only=True)

    @property
    def shows_joint_forces(self) -> bool:
        """Whether the forces of the joints are among the shapes."""
        return bool(self._loads)

    def _reaction_shapes(self, moment: Moment) -> Iterator[DrawnShape]:
        """Yield the forces of the joints at a moment."""
        pose, time = moment
        for load in self._loads:
            x, y = point_path(self.part.mechanism, pose[None], load.point)[0].tolist()
            across, up = (float(np.interp(time, self.run.times, load.forces[:, k])) * self._metres_per_newton for k in (0, 1))
            # The force of a guide begins at the face of the block, in front of which it would hardly be seen.
            face, length = load.start * self.length_scale, math.hypot(across, up)
            x, y = (x + face * across / length, y + face * up / length) if length > 0.0 else (x, y)
            yield from make_arrow("reaction", ((x, y), (x + across, y + up)), _HEAD_SIZE * self.length_scale)

    @cached_property
    def _loads(self) -> Sequence[_Load]:
        """The forces of the pins and of the guide; none for a massless mechanism."""
        if not self.find_effect(CrankMasses):
            return ()
        joints = {joint.name: joint for joint in self.part.mechanism.joints if isinstance(joint, Pin | Slider)}
        reactions = self.select_entries(self.run.reactions)
        return [
            _Load(joint.second, reactions[name].force, BLOCK_WIDTH / 2 if isinstance(joint, Slider) else 0.0)
            for name, joint in joints.items()
            if name in reactions and reactions[name].determined.all()
        ]

    @cached_property
    def _largest_force(self) -> float:
        """Largest force over the run, N."""
        return max((float(np.hypot(*load.forces.T).max()) for load in self._loads), default=0.0)

    @property
    def _metres_per_newton(self) -> float:
        return _LARGEST_LENGTH * self.crank / self._largest_force if self._largest_force > 0.0 else 0.0

    def _key_shapes(self) -> Iterator[DrawnShape]:
        """Yield an arrow of a round force with its number, and what the arrows are, below the mechanism."""
        if not self._largest_force > 0.0:
            return
        u, force = self.length_scale, round_step(self._largest_force, _MAX_KEY_STEPS)
        lowest = -self.crank - _KEY_DISTANCE * u
        left, length = -self.crank, force * self._metres_per_newton
        number = f"{force / 1e3:g} kN" if force >= 1e3 else f"{force:g} N"
        yield from make_arrow("reaction key", ((left, lowest), (left + length, lowest)), _HEAD_SIZE * u)
        x = left + length + 0.04 * u
        yield TextShape("scale", x, lowest, number, _LETTER_WIDTH * len(number) * u)
        yield TextShape("scale", left, lowest - _LINE_HEIGHT * u, _KEY, _LETTER_WIDTH * len(_KEY) * u)

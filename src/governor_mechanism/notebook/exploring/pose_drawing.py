"""Drawing of a mechanism at any pose of its travel."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.shape_svg import draw_shapes, frame_picture, write_text
from governor_mechanism.render.geometry.pixel_view import PixelRect, PixelView, fit_view
from governor_mechanism.render.geometry.primitives import BoundingBox, round_step
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.motion_at_rest import motion_at_rest
from governor_mechanism.render.style import MUTED, PAPER
from governor_mechanism.types import FloatArray

WIDTH, HEIGHT = 320.0, 400.0
"""Size of a drawing, pixels."""
_SHAPES_RECT: PixelRect = (8.0, 8.0, WIDTH - 8.0, HEIGHT - 30.0)
"""Rectangle of the shapes."""


MAX_POSES = 37
"""Number of poses of a drawing, as one for every 10 degrees of a turn; their shapes take most of the time of a new drawing."""

DRAWN_FROM_RUNS = {"flywheel_engine"}
"""Machines whose drawing shows forces of a run, as pressures of steam; here they are drawn from their bodies."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PoseDrawing:
    """Drawing of the only part of a scene over its travel.

    Attributes
    ----------
    scene
        Scene of one part.
    poses
        Poses over the travel; shape (n, bodies, 3).
    readings
        Readings by name at these poses, SI; shape (n,).
    """

    scene: Scene
    poses: FloatArray
    readings: Mapping[str, FloatArray]

    @cached_property
    def box(self) -> BoundingBox:
        """The box (m) that contains the mechanism at all poses."""
        return self._drawing.bounds

    def draw(
        self,
        pose: FloatArray,  # pose of all bodies; shape (bodies, 3)
        box: BoundingBox,  # what the picture shows, m
        *,
        is_faded: bool = False,  # whether it is pale, since it shows an earlier state
    ) -> str:
        """Return a picture of the mechanism."""
        view = fit_view(box, _SHAPES_RECT)
        # The poses of the drawing are a curve without time, so that the time at which it stands is any.
        moving = draw_shapes(self._drawing.moving_shapes(pose, 0.0), view)
        elements = f"{draw_shapes(self._drawing.static_shapes, view)}{moving}{_scale_bar(view)}"
        return frame_picture(elements, WIDTH, HEIGHT, PAPER, f"drawing of {self.scene.title}", is_faded=is_faded)

    @cached_property
    def _drawing(self) -> MachineDrawing:
        rows = np.unique(np.linspace(0, len(self.poses) - 1, MAX_POSES).astype(int))
        readings = {name: values[rows] for name, values in self.readings.items()}
        motion = motion_at_rest(self.scene, self.poses[rows], readings)
        if self.scene.part.machine in DRAWN_FROM_RUNS:
            return GenericDrawing(run=motion, part=self.scene.part)
        return drawing_of(motion, self.scene.part)


def _scale_bar(view: PixelView) -> str:
    """Return a scale bar of a round length in millimetres below the shapes."""
    left, _, right, bottom = view.rect
    length, start, y = round_step((right - left) / view.scale, 5), left + 6.0, bottom + 14.0
    end = start + length * view.scale
    bar = f"M{start:.1f} {y:.1f}H{end:.1f}M{start:.1f} {y - 3:.1f}v6M{end:.1f} {y - 3:.1f}v6"
    text = write_text(end + 6.0, y, f"{length * 1e3:g} mm", height=10.0, colour=MUTED)
    return f'<path d="{bar}" stroke="{MUTED}" stroke-width="0.8"/>{text}'

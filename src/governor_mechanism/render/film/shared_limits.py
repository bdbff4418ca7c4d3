"""Limits that the frames of several runs share, for comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2
from governor_mechanism.render.machines.registry import drawing_bounds, plan_ring_radius


@dataclass(frozen=True, kw_only=True)
class SharedLimits:
    """Limits of a frame under its title.

    `boxes` are the bounding boxes (m) of the parts, `ring_radius` (m) is that of the plan of the last one. `axis_limits` are those of
    the readings in display units, by names of part and reading.
    """

    title: str
    boxes: tuple[BoundingBox, ...]
    ring_radius: float
    axis_limits: Mapping[tuple[str, str], Vec2]

    @classmethod
    def from_run(cls, run: Trajectory, frame_data: Sequence[FrameData]) -> SharedLimits:
        """Return the limits of the shown parts of a single run."""
        main = frame_data[-1]
        return cls(
            title=run.scene.title,
            boxes=tuple(drawing_bounds(data.part, data.run_poses, data.run_times, data.effect_state) for data in frame_data),
            ring_radius=plan_ring_radius(main.part, main.run_poses, main.effect_state),
            axis_limits={},
        )

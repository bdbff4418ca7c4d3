"""Limits that the frames of several runs share, for comparison."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2
from governor_mechanism.render.machines.registry import drawing_bounds, plan_ring_radius


@dataclass(frozen=True, kw_only=True)
class SharedLimits:
    """Bounding box (m), radius of the plan (m) and axis limits of the readings in display units, with the title of one frame."""

    title: str
    box: BoundingBox
    ring_radius: float
    axis_limits: Mapping[str, Vec2]

    @classmethod
    def from_run(cls, run: Trajectory, frame_data: FrameData) -> SharedLimits:
        """Return the limits of a single run."""
        part, poses, effect_state = frame_data.part, frame_data.run_poses, frame_data.effect_state
        return cls(
            title=run.scene.title,
            box=drawing_bounds(part, poses, frame_data.run_times, effect_state),
            ring_radius=plan_ring_radius(part, poses, effect_state),
            axis_limits={},
        )

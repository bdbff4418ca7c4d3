"""What pictures of several runs have in common, so that they can be compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import Moments
from governor_mechanism.render.geometry.primitives import Box, Pair
from governor_mechanism.render.machines.registry import extent, plan_ring


@dataclass(frozen=True, kw_only=True)
class Frame:
    """The box (m) shown, the plan's ring (m), the ends of the readings' axes in everyday units; one picture's title."""

    title: str
    box: Box
    ring: float
    limits: Mapping[str, Pair]

    @classmethod
    def around(cls, run: Trajectory, moments: Moments) -> Frame:
        """The frame of a run by itself."""
        part, poses, acting = moments.part, moments.all_poses, moments.acting
        return cls(
            title=run.scene.title,
            box=extent(part, poses, moments.all_times, acting),
            ring=plan_ring(part, poses, acting),
            limits={},
        )

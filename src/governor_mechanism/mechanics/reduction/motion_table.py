"""A scene's way as far as it has been laid, and what to say where it ends."""

from __future__ import annotations

import time

import numpy as np

from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lowering import IS_SPINDLE_FREE, lower_reduced_scene, time_functions_of
from governor_mechanism.mechanics.reduction.node_evaluation import make_node_workspace
from governor_mechanism.mechanics.reduction.table import allocate_table, evaluate_poses, grow_table
from governor_mechanism.mechanics.reduction.table_refinement import (
    AT_BOUND,
    AT_LIMIT,
    PIECE_ADDED,
    START_TABLE,
    TABLE_ENDED,
    TABLE_FULL,
    extend_table,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

BOUND_TOLERANCE = 1e-3
"""Of the coordinate's unit: a way that cannot be laid so near its bound ends there: the joints hardly settle it."""

INITIAL_TABLE_CAPACITY = 32
"""So many pieces have room at first."""


NO_POSES = np.zeros((0, 3))
"""The poses that stand where none are asked for."""


class MotionTable:
    """The way of one scene from a start; `share` makes its pieces that much narrower at first.

    curves are its programs, where they are known.
    """

    def __init__(
        self,
        scene: Scene,
        q: float,
        poses: FloatArray,
        width_ratio: float = 1.0,
        time_functions: tuple[CubicTimeFunction, ...] | None = None,
    ) -> None:
        start_time = time.perf_counter()
        self.scene = scene
        self.arrays, self.forces = lower_reduced_scene(scene)
        self.time_functions = time_functions_of(scene) if time_functions is None else time_functions
        self.has_free_spindle = bool(self.forces.parameters[IS_SPINDLE_FREE])
        self._workspace = make_node_workspace(self.arrays)
        self.table = allocate_table(self.arrays, INITIAL_TABLE_CAPACITY)
        self.table.next_widths[:] *= width_ratio
        self.setup_time = 0.0
        """Seconds that laying has taken."""
        self.is_started = self._extend_table(START_TABLE, q, poses) == PIECE_ADDED and self.extend(1)
        self.setup_time = time.perf_counter() - start_time

    @property
    def n_pieces(self) -> int:
        """How many there are."""
        return int(self.table.n_pieces[0])

    def extend(self, side: int) -> bool:
        """Whether one more piece could be laid below (0) or above (1)."""
        start_time = time.perf_counter()
        status = self._extend_table(side)
        if status == TABLE_FULL:
            self.table = grow_table(self.table)
            status = self._extend_table(side)
        self.setup_time += time.perf_counter() - start_time
        return bool(status != TABLE_ENDED)

    def _extend_table(self, action: int, q: float = 0.0, poses: FloatArray = NO_POSES) -> int:
        return extend_table(self.arrays, self._workspace, self.table, action, q, poses)

    def end_coordinate(self, side: int) -> float:
        """Where the way ends below (0) or above (1): at the coordinate's bound, or as far as it could be laid."""
        edge = float(self.table.intervals[self.table.end_pieces[side], side])
        bound = self.arrays.high if side == 1 else self.arrays.low
        return bound if abs(edge - bound) < BOUND_TOLERANCE * self.arrays.coordinate_scale else edge

    def end_message(self, side: int) -> tuple[bool, str]:
        """Whether the description ends where the way does, and what happens there."""
        mechanism, reason = self.scene.part.mechanism, int(self.table.end_reasons[side])
        own_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
        other_limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
        bound = self.arrays.high if side == 1 else self.arrays.low
        if own_limits and (reason == AT_BOUND or self.end_coordinate(side) == bound):
            limit, at_high = own_limits[0], side == 1
        elif reason >= AT_LIMIT:
            limit, at_high = other_limits[(reason - AT_LIMIT) // 2], bool((reason - AT_LIMIT) % 2)
        else:
            return False, (
                f"{mechanism.coordinate!r} stands at a dead centre, or the joints at a change point, and does not "
                f"settle the mechanism there, at {self.end_coordinate(side):.6g}"
            )
        return True, f"{limit.reading}: {limit.high_message if at_high else limit.low_message}"

    def evaluate_poses(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and their derivative (n, bodies, 3) at values (n,) of the coordinate that have been laid."""
        flat_poses = np.empty((2, len(values), len(self.arrays.pose_scales)))
        evaluate_poses(self.table, np.ascontiguousarray(values), flat_poses[0], flat_poses[1])
        poses, tangents = flat_poses.reshape(2, len(values), len(self.arrays.bodies), 3)
        return poses, tangents

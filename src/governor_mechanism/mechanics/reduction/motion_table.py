"""Motion table of one scene: it grows with the motion, and says why it ends."""

import time
from functools import cached_property

import numpy as np

from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.reduction.lowering import lower_reduced_scene
from governor_mechanism.mechanics.reduction.node_evaluation import make_reduction_workspace
from governor_mechanism.mechanics.reduction.shaft import parts_with_coordinate
from governor_mechanism.mechanics.reduction.table import (
    BOUND_TOLERANCE,
    EndReason,
    ExtensionStatus,
    PeriodIndex,
    allocate_table,
    evaluate_poses,
    grow_table,
)
from governor_mechanism.mechanics.reduction.table_refinement import extend_table
from governor_mechanism.model.results.outcome import FLIGHT_DETAIL
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

INITIAL_TABLE_CAPACITY = 32
"""Number of pieces allocated at first."""


class MotionTable:
    """The motion table of one scene, from its initial configuration on.

    Parameters
    ----------
    scene
        The scene; its mechanism has one degree of freedom.
    q
        Leading coordinate at the start, SI.
    poses
        Poses at the start; shape (bodies, 3).
    width_ratio
        Factor on the width of the first pieces.

    Attributes
    ----------
    scene
        The scene.
    arrays
        The lowered mechanism.
    model
        The forces along the coordinate, not yet on the table.
    time_functions
        Given spindle speed, loads of force elements, friction forces, factors of these.
    table
        The pieces.
    setup_time
        Wall time spent on the table, s.
    is_started
        Whether the first piece could be computed.
    """

    def __init__(self, scene: Scene, q: float, poses: FloatArray, width_ratio: float = 1.0) -> None:
        start_time = time.perf_counter()
        self.scene = scene
        self.arrays, model, self.time_functions = lower_reduced_scene(scene)
        self.model = model.with_own_results()
        self._workspace = make_reduction_workspace(self.arrays)
        self.table = allocate_table(self.arrays, INITIAL_TABLE_CAPACITY, q, poses.copy())
        self.table.next_widths[:] *= width_ratio
        self.setup_time = 0.0
        """Wall time spent on the table, s."""
        self.is_started = self.extend(1)
        self.setup_time = time.perf_counter() - start_time

    @property
    def n_pieces(self) -> int:
        """Number of pieces."""
        return int(self.table.n_pieces[0])

    def extend(self, side: int) -> bool:
        """Add a piece below (0) or above (1); return whether that was possible."""
        start_time = time.perf_counter()
        status = extend_table(self.arrays, self._workspace, self.table, side)
        if status == ExtensionStatus.TABLE_FULL:
            self.table = grow_table(self.table)
            status = extend_table(self.arrays, self._workspace, self.table, side)
        self.setup_time += time.perf_counter() - start_time
        return status != ExtensionStatus.TABLE_ENDED

    def end_coordinate(self, side: int) -> float:
        """Return the coordinate at which the table ends below (0) or above (1): its bound, or the end of the last piece."""
        edge = self.edge(side)
        bound = self._bound(side)
        return bound if abs(edge - bound) < BOUND_TOLERANCE * self.arrays.assembly.coordinate_scale else edge

    def edge(self, side: int) -> float:
        """Return the coordinate up to which the table has values, below (0) or above (1)."""
        return float(self.table.intervals[self.table.end_pieces[side], side])

    def end_message(self, side: int, *, stops_short: bool = False) -> tuple[bool, str]:
        """Return whether the table ends at a limit given in the scene, and what happens there.

        `stops_short` is whether the motion turns back between the end of the table and the bound of the coordinate.
        """
        prefix, part = parts_with_coordinate(self.scene)[0]
        mechanism = part.mechanism
        own_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
        other_limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
        reason = EndReason.AT_SINGULARITY if stops_short else int(self.table.end_reasons[side])
        coordinate = self.edge(side) if stops_short else self.end_coordinate(side)
        is_at_bound = not stops_short and coordinate == self._bound(side)
        if reason == EndReason.TOO_FAR:
            return True, FLIGHT_DETAIL
        if own_limits and (reason == EndReason.AT_BOUND or is_at_bound):
            limit, at_high = own_limits[0], side == 1
        elif reason >= EndReason.AT_LIMIT:
            limit, at_high = other_limits[(reason - EndReason.AT_LIMIT) // 2], bool((reason - EndReason.AT_LIMIT) % 2)
        else:
            return False, (
                f"{prefix + mechanism.coordinate!r} is at a turning point, or the joints at a change point, and does not determine "
                f"the poses at {coordinate:.6g}"
            )
        return True, f"{prefix}{limit.reading}: {limit.high_message if at_high else limit.low_message}"

    def _bound(self, side: int) -> float:
        return self.arrays.high if side == 1 else self.arrays.low

    def evaluate_poses(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and their derivative (n, bodies, 3) at values (n,) of the coordinate: tabulated ones, or solved a little beyond."""
        is_beyond = (values < self.edge(0)) | (values > self.edge(1))
        beyond = np.flatnonzero(is_beyond & (self.table.periodicity[PeriodIndex.PERIOD] == 0.0))
        inner_values = np.clip(values, self.edge(0), self.edge(1)) if len(beyond) else values
        poses, tangents = evaluate_poses(self.table, np.ascontiguousarray(inner_values))
        if len(beyond):
            distances = (values - inner_values)[beyond, np.newaxis, np.newaxis]
            nodes, is_solved = self._solver.try_solve_nodes(poses[beyond] + distances * tangents[beyond], values[beyond])
            poses[beyond[is_solved]], tangents[beyond[is_solved]] = nodes[is_solved, 0], nodes[is_solved, 1]
        return poses, tangents

    def count_solved(self, values: FloatArray) -> int:
        """Return the number of values (n,) a little beyond the table, from the first on, at which the joints close."""
        inner_values = np.clip(values, self.edge(0), self.edge(1))
        poses, tangents = evaluate_poses(self.table, np.ascontiguousarray(inner_values))
        guesses = poses + (values - inner_values)[:, np.newaxis, np.newaxis] * tangents
        is_solved = self._solver.try_solve_nodes(guesses, values)[1]
        return len(values) if is_solved.all() else int(np.argmin(is_solved))

    @cached_property
    def _solver(self) -> CoordinateSolver:
        return CoordinateSolver(parts_with_coordinate(self.scene)[0][1].mechanism)

"""A scene's way as far as it has been laid, and what to say where it ends."""

from __future__ import annotations

import time

import numpy as np

from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.mechanics.reduction.lowering import FREE, curves_of, make_plan
from governor_mechanism.mechanics.reduction.node_evaluation import make_bench
from governor_mechanism.mechanics.reduction.table import make_laid, more_room, places_at
from governor_mechanism.mechanics.reduction.table_refinement import BEGIN, BEYOND, BOUND, ENDED, FULL, LAID, lay
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

HAIR = 1e-3
"""Of the coordinate's unit: a way that cannot be laid so near its bound ends there: the joints hardly settle it."""

ROOM = 32
"""So many pieces have room at first."""


NOWHERE = np.zeros((0, 3))
"""The poses that stand where none are asked for."""


class Way:
    """The way of one scene from a start; `share` makes its pieces that much narrower at first.

    curves are its programs, where they are known.
    """

    def __init__(
        self, scene: Scene, q: float, poses: FloatArray, share: float = 1.0, curves: tuple[TimeCurve, ...] | None = None
    ) -> None:
        started = time.perf_counter()
        self.scene = scene
        self.plan, self.acts = make_plan(scene)
        self.curves = curves_of(scene) if curves is None else curves
        self.free = bool(self.acts.numbers[FREE])
        self._bench = make_bench(self.plan)
        self.laid = make_laid(self.plan, ROOM)
        self.laid.width[:] *= share
        self.building = 0.0
        """Seconds that laying has taken."""
        self.begun = self._lay(BEGIN, q, poses) == LAID and self.extended(1)
        self.building = time.perf_counter() - started

    @property
    def pieces(self) -> int:
        """How many there are."""
        return int(self.laid.number[0])

    def extended(self, side: int) -> bool:
        """Whether one more piece could be laid below (0) or above (1)."""
        started = time.perf_counter()
        done = self._lay(side)
        if done == FULL:
            self.laid = more_room(self.laid)
            done = self._lay(side)
        self.building += time.perf_counter() - started
        return bool(done != ENDED)

    def _lay(self, what: int, q: float = 0.0, poses: FloatArray = NOWHERE) -> int:
        return lay(self.plan, self._bench, self.laid, what, q, poses)

    def end(self, side: int) -> float:
        """Where the way ends below (0) or above (1): at the coordinate's bound, or as far as it could be laid."""
        edge = float(self.laid.edges[self.laid.ends[side], side])
        bound = self.plan.high if side == 1 else self.plan.low
        return bound if abs(edge - bound) < HAIR * self.plan.unit else edge

    def words(self, side: int) -> tuple[bool, str]:
        """Whether the description ends where the way does, and what happens there."""
        mechanism, why = self.scene.part.mechanism, int(self.laid.why[side])
        own = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
        others = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
        bound = self.plan.high if side == 1 else self.plan.low
        if own and (why == BOUND or self.end(side) == bound):
            limit, above = own[0], side == 1
        elif why >= BEYOND:
            limit, above = others[(why - BEYOND) // 2], bool((why - BEYOND) % 2)
        else:
            return False, (
                f"{mechanism.coordinate!r} stands at a dead centre, or the joints at a change point, and does not "
                f"settle the mechanism there, at {self.end(side):.6g}"
            )
        return True, f"{limit.reading}: {limit.above if above else limit.below}"

    def places(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and their derivative (n, bodies, 3) at values (n,) of the coordinate that have been laid."""
        flat = np.empty((2, len(values), len(self.plan.units)))
        places_at(self.laid, np.ascontiguousarray(values), flat[0], flat[1])
        poses, ahead = flat.reshape(2, len(values), len(self.plan.bodies), 3)
        return poses, ahead

"""Many scenes that differ in numbers alone, each ridden with as little as can be: no certificate, no report.

For scenes in which tables are all that acts: a given steady speed, gravity, the spindle's turning, heavy bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.base import reported_times
from governor_mechanism.engines.reduced.integration import ABOVE, BELOW, DONE, advance
from governor_mechanism.engines.reduced.run import FIRST_STEP, LONGEST_STEP
from governor_mechanism.integrators.reduced_dop853 import make_stages
from governor_mechanism.mechanics.dynamics.characteristic_scales import pace
from governor_mechanism.mechanics.kinematics.output_variables import measure
from governor_mechanism.mechanics.reduction.equation_of_motion import FLOWS, make_line
from governor_mechanism.mechanics.reduction.lowering import make_plan
from governor_mechanism.mechanics.reduction.node_evaluation import make_bench, reach
from governor_mechanism.mechanics.reduction.table import Laid, make_laid, places_at
from governor_mechanism.mechanics.reduction.table_refinement import BEGIN, LAID, lay
from governor_mechanism.model.mechanism import LineAngle
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import announce
from governor_mechanism.types import FloatArray

ROOM = 16
"""So many pieces have room; a motion that needs more is left to the engine."""


@dataclass(frozen=True)
class Glimpse:
    """What is kept of a ride: times (n,) s, and some readings and their rates (n,) SI by name."""

    times: FloatArray
    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    error_estimate: None = None


class Batch:
    """Rides scenes like one, which starts at a value and rate of its coordinate, at the tolerance of one step.

    names are the readings that are wanted.
    """

    def __init__(self, like: Scene, names: Sequence[str], tolerance: float, most: int) -> None:
        announce("advance", 30)
        self._times, self._names = reported_times(like), list(names)
        self._tolerance, self._most = tolerance, most
        plan, _ = make_plan(like)
        self._bench, self._stages = make_bench(plan), make_stages()
        count = len(self._times)
        self._found, self._modes = np.empty((count, 2 + FLOWS)), np.zeros((count, 1), dtype=np.int64)
        self._cubics, self._mode = np.zeros((1, 5)), np.zeros(1, dtype=np.int64)
        self._events, self._told = np.empty((0, 3)), np.zeros(2, dtype=np.int64)
        self._counts = np.zeros(4, dtype=np.int64)

    def glimpse(self, scene: Scene) -> Glimpse | None:
        """A scene's ride; None where it is no plain one, from a start that can be assembled to the last time."""
        plan, acts = make_plan(scene)
        mechanism, name = scene.part.mechanism, scene.part.mechanism.coordinate
        start, rate = scene.start.values.get(name), scene.start.rates.get(name, 0.0)
        if not plan.plain or not isinstance(start, float) or not plan.low < start < plan.high:
            return None
        poses = np.array(mechanism.sketch, dtype=np.float64)
        laid = make_laid(plan, ROOM)
        if not reach(plan, self._bench, start, poses) or lay(plan, self._bench, laid, BEGIN, start, poses) != LAID:
            return None
        if lay(plan, self._bench, laid, 1, start, poses) != LAID:
            return None
        state, now, filled, end = np.array([start, rate, *(0.0,) * FLOWS]), 0.0, 1, float(self._times[-1])
        self._found[0] = state
        longest, code = LONGEST_STEP * pace(scene), BELOW
        step = FIRST_STEP * longest
        line = make_line(laid, acts, self._cubics, self._mode)
        self._counts[:] = 0
        while code in (BELOW, ABOVE):
            limits = self._tolerance, step, longest, self._most
            code, step, reached, now = advance(
                line, (now, end), self._times[filled:], state, limits, self._stages, self._found[filled:],
                self._modes[filled:], self._events, self._told, self._counts,
            )  # fmt: skip
            filled += reached
            if code in (BELOW, ABOVE) and lay(plan, self._bench, laid, code - BELOW, start, poses) != LAID:
                return None
        if code != DONE or filled < len(self._times):
            return None
        return self._seen(scene, laid, filled)

    def _seen(self, scene: Scene, laid: Laid, filled: int) -> Glimpse:
        mechanism, rows = scene.part.mechanism, self._found
        readings, rates = {}, {}
        others = [name for name in self._names if name != mechanism.coordinate]
        if mechanism.coordinate in self._names:
            readings[mechanism.coordinate], rates[mechanism.coordinate] = rows[:, 0].copy(), rows[:, 1].copy()
        if others:
            flat = np.empty((2, filled, 3 * len(mechanism.bodies)))
            places_at(laid, rows[:, 0].copy(), flat[0], flat[1])
            poses, ahead = flat.reshape(2, filled, -1, 3)
            for name in others:
                found = measure(mechanism, name, poses)
                wraps = isinstance(mechanism.reading(name), LineAngle)
                readings[name] = np.unwrap(found.value) if wraps else found.value
                rates[name] = np.sum(found.gradient * ahead, axis=(-2, -1)) * rows[:, 1]
        return Glimpse(self._times, readings, rates)

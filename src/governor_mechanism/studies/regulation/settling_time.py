"""Settling: how soon a governor comes to its new rest after a change of load, against the strength of its oil brake."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import Reduction
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.studies.regression import SLEEVE, uncertified
from governor_mechanism.types import FloatArray

SETTLED = 0.02
"""Of the way between two rests: nearer than that to the new one it has settled."""


@dataclass(frozen=True, kw_only=True)
class Settling:
    """How long it takes to settle after a change of load, against the strength of the oil brake on the sleeve.

    brakes (n,) N s/m; times (n,) s, from when the load changes until the arms leave, for the last time, a band of
    `within` (part of their whole change) about the new rest; infinite where they do not settle in the run. best: the
    brake with the shortest time, and that time.
    """

    title: str
    brakes: FloatArray
    times: FloatArray
    within: float
    best: tuple[float, float]


def settling(scene: Scene, brakes: Sequence[float] | FloatArray, within: float = SETTLED) -> Settling:
    """Run a scene of a free spindle whose torque changes with oil brakes of these strengths (n,) N s/m on the sleeve.

    The new rest is the one that belongs to the angular momentum at the end. Time counts from the first jump of the
    torque. Raises MechanismError for a scene without such a spindle, and where no brake settles it in its run.
    """
    spindle = scene.spindle
    if not isinstance(spindle, FreeSpindle) or spindle.torque.constant:
        raise MechanismError("settling is that of a free spindle whose torque changes; give spindle.torque in time")
    times, values = spindle.torque.times, spindle.torque.values
    since = times[next(k for k, (before, value) in enumerate(pairwise(values)) if value != before)]
    others = tuple(effect for effect in scene.effects if not isinstance(effect, OilBrake))

    def time_of(brake: float) -> float:
        oil = OilBrake(reading=SLEEVE, linear=brake)
        return _settled_at(uncertified(replace(scene, effects=(*others, oil))), within) - since

    asked = np.asarray(brakes, dtype=np.float64)
    taken = np.array([time_of(brake) for brake in asked.tolist()])
    if not np.any(np.isfinite(taken)):
        raise MechanismError(f"no brake settles it within {scene.run.duration:g} s; run it longer")
    k = int(np.argmin(taken))
    bounds = (asked[max(k - 1, 0)], asked[min(k + 1, len(asked) - 1)])
    finer = minimize_scalar(
        lambda brake: min(time_of(brake), 1e3 * scene.run.duration),
        bounds=bounds,
        method="bounded",
        options={"xatol": 1e-3 * asked[k]},
    )
    best = min((float(taken[k]), float(asked[k])), (float(finer.fun), float(finer.x)))
    return Settling(title=scene.title, brakes=asked, times=taken, within=within, best=(best[1], best[0]))


def _settled_at(run: Trajectory, within: float) -> float:
    """When (s) the coordinate comes for good to within a part of its whole change of its new rest, or infinity."""
    scene = run.scene
    name = scene.part.mechanism.coordinate
    values = run.readings[name]
    rest = _rest_of_momentum(run)
    width = within * abs(rest - float(values[0]))
    off = values - rest
    curve = CubicHermiteSpline(run.times, off, run.rates[name])
    passages = np.concatenate([curve.solve(side * width, extrapolate=False) for side in (-1.0, 1.0)])
    late = run.times > 0.8 * run.times[-1]
    if passages.size == 0 or np.max(np.abs(off[late])) > width:
        return math.inf
    return float(passages.max())


def _rest_of_momentum(run: Trajectory) -> float:
    """Where the governor rests on its free spindle with the angular momentum that it has at the end."""
    reduction, last = Reduction(run.scene), float(run.readings[run.scene.part.mechanism.coordinate][-1])
    momentum = 2 * run.energy.rotation[-1] / run.readings["spindle_speed"][-1]

    def force(value: float) -> float:
        here = reduction.at([value], run.poses[-1])
        speed = momentum / (reduction.rest_inertia + here.spindle[0])
        return float(here.potential_slope[0] - 0.5 * speed**2 * here.spindle_slope[0])

    width = 1e-3
    while force(last - width) * force(last + width) > 0:
        width *= 2
    return float(brentq(force, last - width, last + width, xtol=1e-13))

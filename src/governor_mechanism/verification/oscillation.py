"""What all governors are checked by: where a scene comes to rest, and the period of its small swings, on runs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.engines import choose
from governor_mechanism.engines.impulse.relaxation import settled
from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.model.scene import RunSettings, Scene, Start
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.verification.report import Row

SWING = 1e-3
"""rad: amplitude of the small free swing, and half that of a second one."""


def run_of(scene: Scene) -> Trajectory:
    """A run of the scene by the engine it asks for."""
    engine, reason = choose(scene.run.engine, scene)
    return engine.run(scene, reason=reason)


def rpm(speed: float) -> str:
    """A speed (rad/s) as it is told."""
    return f"{speed * 30 / math.pi:.6g} rpm"


def settled_row(scene: Scene, quantity: str, *, start: float, expected: float) -> Row:
    """Where the scene comes to rest from a start (rad); NaN, which fails the row, where it does not."""
    try:
        found = settled(scene, start)
    except RunFailed:
        found = math.nan
    return Row(
        quantity=quantity,
        simulated=found,
        expected=expected,
        allowed=1e-8,
        unit="rad",
        reason="at rest the stepping has no error; the joint solver leaves about 1e-11",
    )


def swing_row(scene: Scene, reading: str, *, angle: float, period: float, at: str) -> Row:
    """The period (s) of swings of a reading about its rest at an angle (rad), so small that none could be smaller."""
    one, two = (
        (_period(scene, reading, angle, swing, period) + _period(scene, reading, angle, -swing, period)) / 2
        for swing in (SWING, 2 * SWING)
    )
    return Row(
        quantity=f"period of an infinitely small swing at {at}",
        simulated=(4 * one - two) / 3,
        expected=period,
        allowed=1e-7 * period,
        unit="s",
        reason="swings of two sizes to both sides, extrapolated to none; the runs' accuracy stays",
    )


def _period(scene: Scene, reading: str, angle: float, swing: float, period: float) -> float:
    swinging = replace(
        scene,
        start=Start(values={reading: angle + swing}),
        run=RunSettings(duration=2.2 * period, every=period / 50, accuracy=1e-9),
    )
    return measured_period(run_of(swinging), reading, angle)


def measured_period(run: Trajectory, reading: str, middle: float) -> float:
    """Time (s) between the first and the last upward passage of a reading through `middle`, per whole swing."""
    curve = CubicHermiteSpline(run.times, run.readings[reading] - middle, run.rates[reading])
    passages = np.asarray(curve.roots(extrapolate=False))
    upward = passages[curve(passages, 1) > 0]
    if len(upward) < 2:
        raise MechanismError(
            f"{reading} swings less than once through {middle:.6g} in {run.times[-1]:.6g} s: no period"
        )
    return float((upward[-1] - upward[0]) / (len(upward) - 1))

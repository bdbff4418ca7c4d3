"""What all governors are checked by: where a scene comes to rest, and the period of its small swings, on runs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.engines import select_engine
from governor_mechanism.engines.impulse.relaxation import relax_to_equilibrium
from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.model.scene import RunSettings, Scene, Start
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.verification.report import ComparisonRow

SMALL_AMPLITUDE = 1e-3
"""rad: amplitude of the small free swing, and half that of a second one."""


def run_scene(scene: Scene) -> Trajectory:
    """A run of the scene by the engine it asks for."""
    engine, reason = select_engine(scene.run.engine, scene)
    return engine.run(scene, reason=reason)


def format_rpm(speed: float) -> str:
    """A speed (rad/s) as it is told."""
    return f"{speed * 30 / math.pi:.6g} rpm"


def check_relaxation(scene: Scene, quantity: str, *, start: float, expected: float) -> ComparisonRow:
    """Where the scene comes to rest from a start (rad); NaN, which fails the row, where it does not."""
    try:
        rest_position = relax_to_equilibrium(scene, start)
    except RunFailed:
        rest_position = math.nan
    return ComparisonRow(
        quantity=quantity,
        simulated=rest_position,
        expected=expected,
        allowed=1e-8,
        unit="rad",
        reason="at rest the stepping has no error; the joint solver leaves about 1e-11",
    )


def check_oscillation_period(scene: Scene, reading: str, *, angle: float, period: float, label: str) -> ComparisonRow:
    """The period (s) of swings of a reading about its rest at an angle (rad), so small that none could be smaller."""
    small_amplitude_period, double_amplitude_period = (
        (_simulate_period(scene, reading, angle, amplitude, period) + _simulate_period(scene, reading, angle, -amplitude, period)) / 2
        for amplitude in (SMALL_AMPLITUDE, 2 * SMALL_AMPLITUDE)
    )
    return ComparisonRow(
        quantity=f"period of an infinitely small swing at {label}",
        simulated=(4 * small_amplitude_period - double_amplitude_period) / 3,
        expected=period,
        allowed=1e-7 * period,
        unit="s",
        reason="swings of two sizes to both sides, extrapolated to none; the runs' accuracy stays",
    )


def _simulate_period(scene: Scene, reading: str, angle: float, amplitude: float, period: float) -> float:
    oscillating_scene = replace(
        scene,
        start=Start(values={reading: angle + amplitude}),
        run=RunSettings(duration=2.2 * period, output_interval=period / 50, accuracy=1e-9),
    )
    return measure_period(run_scene(oscillating_scene), reading, angle)


def measure_period(run: Trajectory, reading: str, level: float) -> float:
    """Time (s) between the first and the last upward passage of a reading through `middle`, per whole swing."""
    curve = CubicHermiteSpline(run.times, run.readings[reading] - level, run.rates[reading])
    crossings = np.asarray(curve.roots(extrapolate=False))
    upward_crossings = crossings[curve(crossings, 1) > 0]
    if len(upward_crossings) < 2:
        raise MechanismError(f"{reading} swings less than once through {level:.6g} in {run.times[-1]:.6g} s: no period")
    return float((upward_crossings[-1] - upward_crossings[0]) / (len(upward_crossings) - 1))

"""Checks common to all governors: relaxation to an equilibrium, and the period of small oscillations."""

import math
from collections.abc import Iterable, Iterator

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.engines.impulse.relaxation import relax_to_equilibrium
from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.model.part import Start
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.verification.comparisons import run_scene
from governor_mechanism.verification.report import ComparisonRow

SMALL_AMPLITUDE = 1e-3
"""Amplitude of the small oscillation (rad); a second one has twice the amplitude."""


def format_rpm(speed: float) -> str:
    """Return a speed (rad/s) as text in rpm."""
    return f"{speed * 30 / math.pi:.6g} rpm"


def check_stability(
    scene: Scene, reading: str, *, angle: float, squared_frequency: float, starts: Iterable[float], label: str
) -> Iterator[ComparisonRow | str]:
    """Yield relaxation from each start and small-oscillation period of an equilibrium (rad); a note if it is unstable."""
    if squared_frequency <= 0:
        yield f"the equilibrium at {label} is unstable: relaxation and oscillation are not checked"
        return
    for start in starts:
        yield check_relaxation(scene, f"relaxation from {math.degrees(start):.4g} deg to {label}", start=start, expected=angle)
    yield check_oscillation_period(scene, reading, angle=angle, period=2 * math.pi / math.sqrt(squared_frequency), label=label)


def check_relaxation(scene: Scene, quantity: str, *, start: float, expected: float) -> ComparisonRow:
    """Return the comparison of the position (rad) to which the scene relaxes; NaN, which fails the row, if it does not."""
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
        reason="at equilibrium the time integration has no error; the joint solver leaves about 1e-11",
    )


def check_oscillation_period(scene: Scene, reading: str, *, angle: float, period: float, label: str) -> ComparisonRow:
    """Return the comparison of the period (s) of a reading about an equilibrium (rad), extrapolated to amplitude zero."""
    small_amplitude_period, double_amplitude_period = (
        (_simulate_period(scene, reading, angle, amplitude, period) + _simulate_period(scene, reading, angle, -amplitude, period)) / 2
        for amplitude in (SMALL_AMPLITUDE, 2 * SMALL_AMPLITUDE)
    )
    return ComparisonRow(
        quantity=f"small-oscillation period at {label}",
        simulated=(4 * small_amplitude_period - double_amplitude_period) / 3,
        expected=period,
        allowed=1e-7 * period,
        unit="s",
        reason="two amplitudes to both sides, extrapolated to zero; the accuracy of the runs remains",
    )


def _simulate_period(scene: Scene, reading: str, angle: float, amplitude: float, period: float) -> float:
    """Return the period (s) of an oscillation of the given amplitude (rad)."""
    oscillating_scene = scene.with_changes(
        start=Start(values={reading: angle + amplitude}), run=RunSettings(duration=2.2 * period, output_interval=period / 50, accuracy=1e-9)
    )
    return measure_period(run_scene(oscillating_scene), reading, angle)


def measure_period(run: Trajectory, reading: str, level: float) -> float:
    """Return the time (s) per cycle between the first and the last upward crossing of `level` by a reading."""
    curve = CubicHermiteSpline(run.times, run.readings[reading] - level, run.rates[reading])
    crossings = np.asarray(curve.roots(extrapolate=False))
    upward_crossings = crossings[curve(crossings, 1) > 0]
    if len(upward_crossings) < 2:
        raise MechanismError(f"{reading} completes no cycle about {level:.6g} in {run.times[-1]:.6g} s: there is no period")
    return float((upward_crossings[-1] - upward_crossings[0]) / (len(upward_crossings) - 1))

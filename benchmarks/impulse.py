"""Gain of the staggered scheme over plain use of pymunk, and of extrapolation; ratios within one process.

Usage: python benchmarks/impulse.py

The true error is relative to the one-coordinate equation of motion, integrated by scipy at tolerance 1e-13.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.model.results.trajectory import Trajectory

REPEATS = 5
TIMES = np.linspace(0.0, 10.0, 201)


def main() -> None:
    """Print the tables."""
    scene = gm.load("porter")
    scene = scene.with_changes(start=replace(scene.start, rates={"arm_angle": 0.15}))
    governor = closed.PendulumGovernor(**scene.part.dimensions)
    speed = scene.spindle.speeds[0]

    def slope(_: float, state: NDArray[np.float64]) -> list[float]:
        """Return the state derivative of the one-coordinate equation."""
        bend = closed.arm_acceleration(governor, arm_angle=state[0], arm_rate=state[1], spindle_speed=speed)
        return [state[1], float(bend)]

    start = [scene.start.values["arm_angle"], 0.15]
    true = solve_ivp(slope, (0, 10), start, method="DOP853", t_eval=TIMES, rtol=1e-13, atol=1e-14).y[0]

    def row(name: str, engine: ImpulseEngine, accuracy: float | None = None) -> tuple[float, float]:
        """Print one row."""
        run, seconds = best_of(lambda: engine.run(scene, times=TIMES, accuracy=accuracy))
        error = float(np.max(np.abs(run.readings["arm_angle"] - true)))
        estimate = "" if run.error_estimate is None else f"{run.error_estimate:.1e}"
        microseconds = seconds / run.cost.steps * 1e6
        print(f"| {name} | {error:.1e} | {estimate} | {run.cost.steps:,} | {seconds * 1e3:.1f} | {microseconds:.2f} |")
        return error, microseconds

    print("| Porter governor, 10 s, 201 reported times | true error, rad | its own estimate | steps | ms | µs a step |")
    print("|---|---|---|---|---|---|")
    plain = row("plain pymunk, 1 ms", ImpulseEngine(step=1e-3, plain=True))
    staggered = row("staggered, 1 ms", ImpulseEngine(step=1e-3, runs=1))
    row("staggered, 0.5 ms", ImpulseEngine(step=5e-4, runs=1))
    row("plain pymunk, 0.1 ms", ImpulseEngine(step=1e-4, plain=True))
    for accuracy in (1e-4, 1e-6, 1e-8, 1e-10):
        row(f"extrapolated, asked {accuracy:g}", ImpulseEngine(), accuracy)
    print()
    print(f"Staggered against plain at 1 ms: error {plain[0] / staggered[0]:,.0f} times smaller (target 100), ", end="")
    print(f"cost per step {staggered[1] / plain[1]:.2f} times (target at most 1.3).")


def best_of(work: Callable[[], Trajectory]) -> tuple[Trajectory, float]:
    """Return the result, and the shortest time (s) of several runs after a warm-up run."""
    result, shortest = work(), np.inf
    for _ in range(REPEATS):
        started = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - started)
    return result, shortest


if __name__ == "__main__":
    main()

"""Cost of sweeps: rows made together and one by one, rows that end early, processes, and memory.

Usage: python benchmarks/sweep.py
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import governor_mechanism as gm
from governor_mechanism.model.scene import Scene

ROW_COUNTS = (1_000, 10_000, 100_000)
"""Numbers of rows of the sweeps whose memory is measured."""


def main() -> None:
    """Print the tables, or with a number of rows the peak memory of that sweep."""
    if len(sys.argv) > 1:
        print(measure_memory(int(sys.argv[1])))
        return
    print_governors()
    print_processes()
    print_memory()


def porter_for_two_seconds() -> Scene:
    """Return the shipped Porter governor for two seconds."""
    scene = gm.load("porter")
    return replace(scene, run=replace(scene.run, duration=2.0))


def governors(n_arms: int, n_sleeves: int) -> dict[str, list[float]]:
    """Return the dimensions of different Porter governors, all of which run to the end."""
    return {
        "dimensions.arm": np.linspace(0.29, 0.35, n_arms).tolist(),
        "dimensions.sleeve_mass": np.linspace(10.0, 20.0, n_sleeves).tolist(),
    }


def print_governors() -> None:
    """Run a thousand Porter governors without certificates: those of a grid, those that fall to their dead centre, and one by one."""
    scene = porter_for_two_seconds()
    falling = {"dimensions.arm": governors(40, 25)["dimensions.arm"], "dimensions.sleeve_mass": np.linspace(60.0, 90.0, 25).tolist()}
    cases: dict[str, tuple[Mapping[str, list[float]], Any, int]] = {
        "all together (target 0.1)": (governors(40, 25), ["final arm_angle"], 1),
        "all together, two workers": (governors(40, 25), ["final arm_angle"], 2),
        "all together, every row ends early": (falling, ["final arm_angle"], 1),
        # A function as quantity needs whole runs, so each row is a run.
        "one run each": (governors(40, 25), {"final arm_angle": final_arm_angle}, 1),
    }
    print("| 1,000 Porter governors, 2 s each at 1e-8 | s | outcomes |\n|---|---|---|")
    for name, (vary, quantities, workers) in cases.items():
        found: list[Any] = []
        seconds = shortest_time(lambda: found.append(sweep(scene, vary, quantities, workers)), 3)  # noqa: B023
        print(f"| {name} | {seconds:.2f} | {', '.join(f'{count} {outcome}' for outcome, count in found[-1].outcomes.items())} |")
    print()


def sweep(scene: Scene, vary: Mapping[str, list[float]], quantities: Any, workers: int) -> Any:
    """Return a sweep at an accuracy of 1e-8 by the engine `reduced`."""
    return gm.sweep(scene, vary, quantities, engine="reduced", accuracy=1e-8, workers=workers)


def print_processes() -> None:
    """Run the shipped Porter governor 400 times by the engine `multibody`, with one worker and with two."""
    print("| 400 Porter governors, engine multibody, 10 s each | s |\n|---|---|")
    for workers in (1, 2):
        seconds = shortest_time(lambda: gm.sweep("porter", governors(20, 20), engine="multibody", workers=workers), 2)  # noqa: B023
        print(f"| {workers} workers | {seconds:.1f} |")
    print()


def print_memory() -> None:
    """Print the peak memory of sweeps of several sizes, each in a process of its own."""
    print("| Porter governors, 0.1 s each, in one process | largest memory, MB |\n|---|---|")
    for n_rows in ROW_COUNTS:
        output = subprocess.run([sys.executable, __file__, str(n_rows)], check=True, capture_output=True, text=True).stdout
        print(f"| {n_rows:,} | {float(output):.0f} |")
    print()


def measure_memory(n_rows: int) -> float:
    """Return the peak memory of this process (MB) after a sweep of this number of rows."""
    scene = gm.load("porter")
    scene = replace(scene, run=replace(scene.run, duration=0.1))
    gm.sweep(scene, governors(100, n_rows // 100), ["final arm_angle"], engine="reduced")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def final_arm_angle(run: Any) -> float:
    """Return the arm angle at the end of a run."""
    return float(run.readings["arm_angle"][-1])


def shortest_time(work: Callable[[], Any], repeats: int) -> float:
    """Return the shortest time (s) of several runs after a warm-up run."""
    work()
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return min(times)


if __name__ == "__main__":
    main()

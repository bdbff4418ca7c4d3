"""Cost of sweeps: processor time of a row, of one that ends early, processes, and memory.

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

ROW_COUNTS = (200, 2_000, 20_000)
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
    """Print the processor time of a row of Porter governors without certificates: of complete runs, and of falls to the dead centre."""
    scene = porter_for_two_seconds()
    falling = {"dimensions.arm": governors(20, 10)["dimensions.arm"], "dimensions.sleeve_mass": np.linspace(60.0, 90.0, 10).tolist()}
    cases = {"complete (target 4)": governors(20, 10), "every row ends early": falling}
    print("| 200 Porter governors, 2 s each at 1e-8, one worker | ms a row | outcomes |\n|---|---|---|")
    for name, vary in cases.items():
        found: list[Any] = []
        seconds = shortest_time(lambda: found.append(sweep(scene, vary)), 3, time.process_time)  # noqa: B023
        outcomes = ", ".join(f"{count} {outcome}" for outcome, count in found[-1].outcomes.items())
        print(f"| {name} | {1e3 * seconds / len(found[-1].rows):.2f} | {outcomes} |")
    print()


def sweep(scene: Scene, vary: Mapping[str, list[float]]) -> Any:
    """Return a sweep at an accuracy of 1e-8 by the engine `reduced`."""
    return gm.sweep(scene, vary, ["final arm_angle"], engine="reduced", accuracy=1e-8)


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


def shortest_time(work: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the shortest time (s) of several runs after a warm-up run."""
    work()
    times = []
    for _ in range(repeats):
        started = clock()
        work()
        times.append(clock() - started)
    return min(times)


if __name__ == "__main__":
    main()

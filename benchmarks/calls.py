"""What a call from Python costs: the first one, in a new process; a certified run; its events.

Usage: python benchmarks/calls.py [--no-first]
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import governor_mechanism as gm
from governor_mechanism.scenes.library import list_contents

MODELS = ("porter", "porter_load_step", "pendulum_iftomm", "slider_crank", "slide_valve_30", "quick_return", "slider_crank_torque")
MODELS_OF_SEVERAL_LOOPS = ("andrews_squeezer", "four_bar_chain")
N_REPEATS = 15
ENGINES = ("reduced", "multibody")


def best_time(calculate: Callable[[], object]) -> float:
    """Return the shortest time of several calls, ms."""
    times = []
    for _ in range(N_REPEATS):
        start = time.perf_counter()
        calculate()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def first_run_time(engine: str) -> float:
    """Return the processor time of a new process with one run, s."""
    code = f"import governor_mechanism as gm; gm.run('porter', engine='{engine}')"
    start = os.times()
    subprocess.run([sys.executable, "-c", code], check=True)
    end = os.times()
    return end.children_user + end.children_system - start.children_user - start.children_system


def print_first_runs() -> None:
    """Print the times of first runs."""
    print("| new process with a run of Porter | processor time, s (target 0.5) |\n|---|---|")
    for engine in ENGINES:
        print(f"| {engine} | {min(first_run_time(engine) for _ in range(3)):.2f} |")
    print()


def print_calls() -> None:
    """Print the times of certified runs with 1,001 reported times, and of loading."""
    times = np.linspace(0.0, 10.0, 1001)
    print("| Porter, certified to 1e-8, 1,001 times | ms | target |\n|---|---|---|")
    for engine, target in zip(ENGINES, (2, 5), strict=True):
        run_time = best_time(lambda engine=engine: gm.run("porter", engine=engine, accuracy=1e-8, times=times))
        print(f"| {engine} | {run_time:.1f} | {target} |")
    path = Path(__file__).parents[1] / "models" / "porter.toml"
    print(f"| load, by path | {best_time(lambda: gm.load(path)):.1f} | 5 |\n")


def print_events() -> None:
    """Print the times of runs and of their events."""
    print("| model, engine auto | run, ms | events, ms | events |\n|---|---|---|---|")
    for name in (*MODELS, *MODELS_OF_SEVERAL_LOOPS):
        scene = gm.load(name)
        run_time, n_events = best_time(lambda scene=scene: gm.run(scene)), len(gm.run(scene).events)
        # A run keeps its events once they are found.
        both = best_time(lambda scene=scene: gm.run(scene).events)
        print(f"| {name} | {run_time:.1f} | {max(both - run_time, 0.0):.1f} | {n_events} |")


def print_shares_of_events() -> None:
    """Print in how many of the shipped scenes the search for events takes at most a third of the run before it."""
    shares = {}
    for name in list_contents():
        scene, run_times, search_times = gm.load(name), [], []
        for _ in range(4):
            start = time.process_time()
            run = gm.run(scene)
            run_times.append(time.process_time() - start)
            start = time.process_time()
            run.event_notes  # noqa: B018  the search is made where events are read
            search_times.append(time.process_time() - start)
        shares[name] = min(search_times) / min(run_times)
    n_met = sum(share <= 1 / 3 for share in shares.values())
    largest = max(shares, key=lambda name: shares[name])
    print(f"\nEvents take at most a third of the run (the target) in {n_met} of {len(shares)} shipped scenes, half of the run or less in "
          f"{sum(share <= 1 / 2 for share in shares.values())}; the largest share is {shares[largest]:.1f}, of {largest}.")  # fmt: skip


def main() -> None:
    """Print all tables."""
    if "--no-first" not in sys.argv[1:]:
        print_first_runs()
    print_calls()
    print_events()
    print_shares_of_events()


if __name__ == "__main__":
    main()

"""Times of a governed engine: a minute with its cyclic and with its mean torque, and a stability map of 40 x 40 points.

Run it alone on a machine: python benchmarks/governed_engine.py
"""

from __future__ import annotations

import statistics
import time

import governor_mechanism as gm
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.studies.regulation.stability_map import map_stability

REPEATS = 5
TOLERANCE = 1e-8
"""Tolerance of a single run, about that with which a request of 1e-6 begins."""


def median_time(function, repeats=REPEATS):
    """Return the median time of calls, s, after one that loads kernels."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main() -> None:
    """Print the times."""
    print("| 60 s at 120 rpm | one run, ms | accepted, rejected steps | certified at 1e-6, ms | runs |")
    print("|---|---|---|---|---|")
    for name in ("governed_engine", "governed_engine_mean_torque"):
        scene = gm.load(name)
        for engine in (ReducedEngine(tolerance=TOLERANCE), MultibodyEngine(tolerance=TOLERANCE)):
            single = median_time(lambda engine=engine, scene=scene: engine.run(scene, certify=False))
            cost = engine.run(scene, certify=False).cost
            run = gm.run(scene, engine=engine.name, accuracy=1e-6)
            certified = median_time(lambda engine=engine, scene=scene: gm.run(scene, engine=engine.name, accuracy=1e-6))
            steps = f"{cost.steps}, {cost.rejected}"
            print(f"| {name}, `{engine.name}` | {1e3 * single:.0f} | {steps} | {1e3 * certified:.0f} | {run.cost.runs} |")
    for n_border in (0, 8):
        start = time.perf_counter()
        map_stability(gm.load("governed_engine"), n_border_columns=n_border, n_workers=2)
        seconds = time.perf_counter() - start
        print(f"\nA stability map of 40 x 40 points, {n_border} points of the border under the cyclic torque: ", end="")
        print(f"{seconds:.0f} s (target 60 s).")


if __name__ == "__main__":
    main()

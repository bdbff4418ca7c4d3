"""Times of a speed curve and of the equilibria at a speed: the shortest of several calls, in one process, warm.

Usage: python benchmarks/statics.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import governor_mechanism as gm

REPEATS = 20


def main() -> None:
    """Print the table."""
    print("| scene | curve of 500 points, ms (target 20) | all equilibria, ms |\n|---|---|---|")
    for name in ("watt", "watt_improved", "porter", "porter_extended_arms", "porter_uncrossed_links", "parabolic"):
        scene = gm.load(name)
        curve = shortest_time(lambda scene=scene: gm.speed_curve(scene, 500))
        rests = shortest_time(lambda scene=scene: gm.equilibria(scene))
        print(f"| {name} | {curve * 1e3:.1f} | {rests * 1e3:.1f} |")


def shortest_time(call: Callable[[], object]) -> float:
    """Return the wall time (s) of the fastest of several calls."""
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return min(times)


if __name__ == "__main__":
    main()

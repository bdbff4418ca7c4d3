"""Times that `auto` expects, as its reason states them, against the times that runs take.

Each scene runs once to warm up, and then as often as fits into a second, loaded again each time; the shortest run counts, and what its own
reason states. The times of the engines that are not chosen are measured too. A bound is right if it is at most three times too long.

With --new-processes each scene runs once, in a process of its own. What the reason states of the chosen engine is compared with the time
that the run reports, as a command prints both.

Usage: python benchmarks/predicted_times.py [--new-processes] [scene file ...]     (in addition to the shipped scenes)
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import governor_mechanism as gm
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.scenes.library import shipped_scenes

ALLOWED_RATIO = 3.0
MAX_MEASURING_TIME, MAX_REPEATS = 1.0, 6
STATED_TIME = re.compile(r"(?:about|(reduced|multibody|impulse)(?: (about|at least))?) ([0-9.e+-]+) (ms|s)")


class Prediction(NamedTuple):
    """Stated and measured time of an engine, s."""

    scene: str
    engine: str
    is_chosen: bool
    is_bound: bool
    stated: float
    measured: float

    @property
    def ratio(self) -> float:
        """Return the stated time relative to the measured one."""
        return self.stated / self.measured

    @property
    def is_right(self) -> bool:
        """Return whether the stated time is right within the allowed ratio; a bound may be too short."""
        return self.ratio <= ALLOWED_RATIO and (self.is_bound or self.ratio >= 1 / ALLOWED_RATIO)


def shortest_run(path: Path, engine: str) -> tuple[float, Trajectory]:
    """Return the shortest run of a scene but the first, and its time (s)."""
    start, runs = time.perf_counter(), list[tuple[float, Trajectory]]()
    while len(runs) < 2 or (time.perf_counter() - start < MAX_MEASURING_TIME and len(runs) < MAX_REPEATS):
        scene = gm.load(path)
        run_start = time.perf_counter()
        run = gm.run(scene, engine=engine)
        runs.append((time.perf_counter() - run_start, run))
    return min(runs[1:], key=lambda one: one[0])


def compare_times(path: Path) -> Iterator[Prediction]:
    """Yield what the reason of a run states, and what was measured."""
    measured, run = shortest_run(path, "auto")
    for name, word, number, unit in STATED_TIME.findall(run.cost.reason):
        stated, engine = float(number) * (1e-3 if unit == "ms" else 1.0), name or run.cost.engine
        time_of_engine = shortest_run(path, engine)[0] if name else measured
        yield Prediction(path.stem, engine, not name, word == "at least", stated, time_of_engine)


def compare_in_new_process(path: Path) -> Iterator[Prediction]:
    """Yield what the reason of the first run of a process states of its engine, and the time that the run reports."""
    script = "import sys, governor_mechanism as gm; cost = gm.run(gm.load(sys.argv[1])).cost; "
    script += "print(cost.engine, cost.wall_time + cost.setup_time, cost.reason)"
    done = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True)
    if done.returncode:
        raise gm.MechanismError(done.stderr.strip().splitlines()[-1])
    engine, measured, reason = done.stdout.split(" ", 2)
    for name, _, number, unit in STATED_TIME.findall(reason):
        if not name:
            yield Prediction(path.stem, engine, True, False, float(number) * (1e-3 if unit == "ms" else 1.0), float(measured))


def main() -> None:
    """Print the table and the shares."""
    predictions, arguments = list[Prediction](), sys.argv[1:]
    compare = compare_in_new_process if "--new-processes" in arguments else compare_times
    print("| scene | engine | | stated, ms | measured, ms | stated / measured |\n|---|---|---|---|---|---|")
    for path in [*shipped_scenes().values(), *(Path(one) for one in arguments if one != "--new-processes")]:
        try:
            for row in compare(path):
                predictions.append(row)
                kind = "chosen" if row.is_chosen else "at least" if row.is_bound else "about"
                print(
                    f"| {row.scene} | {row.engine} | {kind} | {1e3 * row.stated:.4g} | {1e3 * row.measured:.4g} | {row.ratio:.2g} |",
                    flush=True,
                )
        except gm.MechanismError as error:
            print(f"| {path.stem} | refused: {str(error)[:60]} | | | | |")
    print("\n| times | right | within 3 | of |\n|---|---|---|---|")
    groups = {
        "of the chosen engine": [row for row in predictions if row.is_chosen],
        "of others, about": [row for row in predictions if not (row.is_chosen or row.is_bound)],
        "of others, at least": [row for row in predictions if row.is_bound],
    }
    for name, rows in groups.items():
        n_near = sum(1 / ALLOWED_RATIO <= row.ratio <= ALLOWED_RATIO for row in rows)
        print(f"| {name} | {sum(row.is_right for row in rows)} | {n_near} | {len(rows)} |")


if __name__ == "__main__":
    main()

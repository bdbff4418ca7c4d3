"""Cost of the reduced engine: against hand-written C for the one-coordinate equation, and of building.

Usage: python benchmarks/reduced.py
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import DOP853

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import MAX_STEP_LIMIT, StepPlan
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.engines.reduced.run import ReducedRun
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

TIMES = np.linspace(0.0, 10.0, 201)
TOLERANCES = 10.0 ** -np.arange(3.0, 15.0, 0.25)


def main() -> None:
    """Print the tables."""
    scene = gm.load("porter")
    scene = scene.with_changes(start=replace(scene.start, rates={"arm_angle": 0.15}))
    compare_with_c(scene)
    print_whole_runs(scene)
    print_new_process_time()


def compare_with_c(scene: Scene) -> None:
    """Compare ten seconds with 201 reported times at equal true errors."""
    compiler = shutil.which("cc")
    if compiler is None:
        print("no C compiler found: the comparison with C is skipped\n")
        return
    true = gm.run(scene, MultibodyEngine(tolerance=1e-14), times=TIMES, certify=False).readings["arm_angle"]
    by_hand = compile_c_code(compiler)
    angles, rates = np.empty(len(TIMES)), np.empty(len(TIMES))
    start = float(scene.start.values["arm_angle"])

    def run_c_code(tolerance: float) -> FloatArray:
        """Run the C code."""
        by_hand(start, 0.15, tolerance, TIMES, len(TIMES), angles, rates)
        return angles

    reduced_run = prepare_reduced_run(scene)
    # The first run builds the tables, which are not timed.
    plan = StepPlan(max_steps=MAX_STEP_LIMIT)
    reduced_run.integrate(TIMES, 1e-14, plan)
    print("| Porter governor, 10 s, 201 times | C, µs | reduced, µs | ratio (target 1.5) |\n|---|---|---|---|")
    for target in (1e-6, 1e-8, 1e-10):
        one = next(t for t in TOLERANCES if np.max(np.abs(run_c_code(t) - true)) < target)
        other = next(t for t in TOLERANCES if np.max(np.abs(reduced_run.integrate(TIMES, t, plan).states[:, 0] - true)) < target)
        c, ours = shortest_time(lambda t=one: run_c_code(t), 300), shortest_time(lambda t=other: reduced_run.integrate(TIMES, t, plan), 300)
        print(f"| largest error {target:g} rad | {c * 1e6:.0f} | {ours * 1e6:.0f} | {ours / c:.1f} |")
    print()


def compile_c_code(compiler: str) -> Callable[..., int]:
    """Compile `porter.c` and load it."""
    folder = Path(tempfile.mkdtemp())
    arrays = {
        "STAGES": DOP853.A,
        "WEIGHTS": DOP853.B,
        "ERROR_3": DOP853.E3,
        "ERROR_5": DOP853.E5,
        "DENSE_STAGES": DOP853.A_EXTRA,
        "DENSE_WEIGHTS": DOP853.D,
    }
    (folder / "tableau.h").write_text("".join(coefficient_declaration(*item) for item in arrays.items()), encoding="utf-8")
    shutil.copy(Path(__file__).with_name("porter.c"), folder)
    library = folder / "porter.so"
    options = ["-O3", "-march=native", "-shared", "-fPIC", "-o", str(library), str(folder / "porter.c"), "-lm"]
    subprocess.run([compiler, *options], check=True)
    function = ctypes.CDLL(str(library)).run
    array = np.ctypeslib.ndpointer(dtype=np.float64)
    function.argtypes = [ctypes.c_double] * 3 + [array, ctypes.c_int, array, array]
    found: Callable[..., int] = function
    return found


def coefficient_declaration(name: str, values: FloatArray) -> str:
    """Return a coefficient array of the tableau as C code."""
    sizes = "".join(f"[{size}]" for size in values.shape)
    numbers = np.array2string(values, threshold=10_000, floatmode="unique", separator=",", max_line_width=10_000)
    return f"static const double {name}{sizes} = {numbers.replace('[', '{').replace(']', '}')};\n"


def prepare_reduced_run(scene: Scene) -> ReducedRun:
    """Return the engine with its tables built."""
    runner = ReducedRunner(ReducedEngine(), scene, RunRequest(times=TIMES, accuracy=1e-8, certify=False, reason=""))
    return runner.get_reduced_run(1.0)


def print_whole_runs(scene: Scene) -> None:
    """Print the time of whole runs, and the part that builds the tables."""
    print("| Porter governor, 10 s, 1,001 times | ms | tables, ms |\n|---|---|---|")
    for accuracy in (1e-6, 1e-8, 1e-10):
        for certify in (False, True):
            runs: list[Any] = []
            run = partial(run_and_append, runs, scene, accuracy, certify)
            seconds = shortest_time(run, 20)
            setup_time = min(one.cost.setup_time for one in runs)
            description = "certified" if certify else "one run"
            print(f"| accuracy {accuracy:g}, {description} | {seconds * 1e3:.1f} | {setup_time * 1e3:.1f} |")
    print()


def run_and_append(runs: list[Any], scene: Scene, accuracy: float, certify: bool) -> None:
    """Run once and append the run to `runs`."""
    runs.append(gm.run(scene, "reduced", accuracy=accuracy, certify=certify))


def print_new_process_time() -> None:
    """Print the time of a run in a new process with cached kernels."""
    code = "import governor_mechanism as gm; gm.run('porter', 'reduced', accuracy=1e-10)"
    seconds = shortest_time(lambda: subprocess.run([sys.executable, "-c", code], check=True), 5)
    print(f"A new process with one run: {seconds:.1f} s (target 1).\n")


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

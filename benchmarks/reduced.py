"""What the reduced engine costs: against hand-written C of the one-coordinate equation, to build, and in sweeps.

python benchmarks/reduced.py
"""

from __future__ import annotations

import ctypes
import resource
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

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.engines.reduced.run import ReducedRun
from governor_mechanism.integrators import tableau as dop853_tableau
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

TIMES = np.linspace(0.0, 10.0, 201)
LADDER = 10.0 ** -np.arange(3.0, 15.0, 0.25)


def main() -> None:
    """Print the tables."""
    scene = gm.load("porter")
    scene = replace(scene, start=replace(scene.start, rates={"arm_angle": 0.15}))
    against_c(scene)
    whole_runs(scene)
    new_process()
    sweeps()


def against_c(scene: Scene) -> None:
    """Ten seconds with 201 reported times, at equal true errors."""
    compiler = shutil.which("cc")
    if compiler is None:
        print("no C compiler here: the comparison with C is left out\n")
        return
    true = gm.run(scene, MultibodyEngine(tolerance=1e-14), times=TIMES, certify=False).readings["arm_angle"]
    by_hand = compiled(compiler)
    angles, rates = np.empty(len(TIMES)), np.empty(len(TIMES))
    start = float(scene.start.values["arm_angle"])

    def hand(tolerance: float) -> FloatArray:
        by_hand(start, 0.15, tolerance, TIMES, len(TIMES), angles, rates)
        return angles

    rider = prepared(scene)
    # Building is left out: the pieces are laid by the first ride.
    rider.integrate(1e-14)
    print("| Porter governor, 10 s, 201 times | C, µs | reduced, µs | ratio (target 2.5) |\n|---|---|---|---|")
    for target in (1e-6, 1e-8, 1e-10):
        one = next(t for t in LADDER if np.max(np.abs(hand(t) - true)) < target)
        other = next(t for t in LADDER if np.max(np.abs(rider.integrate(t).states[:, 0] - true)) < target)
        c, ours = shortest(lambda t=one: hand(t), 300), shortest(lambda t=other: rider.integrate(t), 300)
        print(f"| largest error {target:g} rad | {c * 1e6:.0f} | {ours * 1e6:.0f} | {ours / c:.1f} |")
    print()


def compiled(compiler: str) -> Callable[..., int]:
    """`porter.c`, compiled here."""
    folder = Path(tempfile.mkdtemp())
    names = ("STAGES", "WEIGHTS", "ERROR_3", "ERROR_5", "DENSE_STAGES", "DENSE_WEIGHTS")
    (folder / "tableau.h").write_text("".join(map(declared, names)), encoding="utf-8")
    shutil.copy(Path(__file__).with_name("porter.c"), folder)
    library = folder / "porter.so"
    options = ["-O3", "-march=native", "-shared", "-fPIC", "-o", str(library), str(folder / "porter.c"), "-lm"]
    subprocess.run([compiler, *options], check=True)
    function = ctypes.CDLL(str(library)).run
    array = np.ctypeslib.ndpointer(dtype=np.float64)
    function.argtypes = [ctypes.c_double] * 3 + [array, ctypes.c_int, array, array]
    found: Callable[..., int] = function
    return found


def declared(name: str) -> str:
    """A coefficient array of the tableau, in C."""
    values = getattr(dop853_tableau, name)
    sizes = "".join(f"[{size}]" for size in values.shape)
    numbers = np.array2string(values, threshold=10_000, floatmode="unique", separator=",", max_line_width=10_000)
    return f"static const double {name}{sizes} = {numbers.replace('[', '{').replace(']', '}')};\n"


def prepared(scene: Scene) -> ReducedRun:
    """The engine up to where it rides."""
    follower = ReducedRunner(ReducedEngine(), scene, RunRequest(times=TIMES, accuracy=1e-8, certify=False, reason=""))
    follower.compile_kernels()
    return follower.get_reduced_run(1.0)


def whole_runs(scene: Scene) -> None:
    """What a user waits for, and how much of it builds the tables."""
    print("| Porter governor, 10 s, 1,001 times | ms | of that tables |\n|---|---|---|")
    for accuracy in (1e-6, 1e-8, 1e-10):
        for certify in (False, True):
            runs: list[Any] = []
            run = partial(kept, runs, scene, accuracy, certify)
            seconds = shortest(run, 20)
            building = min(one.cost.setup_time for one in runs)
            told = "certified" if certify else "one run"
            print(f"| asked {accuracy:g}, {told} | {seconds * 1e3:.1f} | {building * 1e3:.1f} (target 5) |")
    print()


def kept(runs: list[Any], scene: Scene, accuracy: float, certify: bool) -> None:
    """One run, added to those."""
    runs.append(gm.run(scene, "reduced", accuracy=accuracy, certify=certify))


def new_process() -> None:
    """A process of its own, its kernels kept from before."""
    code = "import governor_mechanism as gm; gm.run('porter', 'reduced', accuracy=1e-10)"
    seconds = shortest(lambda: subprocess.run([sys.executable, "-c", code], check=True), 5)
    print(f"a new process with one run: {seconds:.2f} s (target 1)\n")


def sweeps() -> None:
    """A thousand different Porter governors, 2 s each at 1e-8, without certificates."""
    scene = gm.load("porter")
    scene = replace(scene, run=replace(scene.run, duration=2.0))
    arms, sleeves = np.linspace(0.29, 0.35, 40).tolist(), np.linspace(10.0, 20.0, 25).tolist()
    vary = {"dimensions.arm": arms, "dimensions.sleeve_mass": sleeves}
    print("| 1,000 Porter governors, 2 s each at 1e-8 | s | largest memory, MB |\n|---|---|---|")
    together = shortest(lambda: gm.sweep(scene, vary, engine="reduced", accuracy=1e-8), 3)
    print(f"| all together (target 0.5) | {together:.2f} | {memory():.0f} |")
    # A function as quantity takes whole runs, so each row is one.
    single = shortest(lambda: gm.sweep(scene, vary, {"final arm_angle": last_angle}, engine="reduced", accuracy=1e-8), 1)
    print(f"| one run each (target 8) | {single:.1f} | {memory():.0f} |")


def last_angle(run: Any) -> float:
    """The arm angle at the end of a run."""
    return float(run.readings["arm_angle"][-1])


def memory() -> float:
    """The most that this process has held so far (MB)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def shortest(work: Callable[[], Any], repeats: int) -> float:
    """The shortest time of several runs after one to warm up (s)."""
    work()
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return min(times)


if __name__ == "__main__":
    main()

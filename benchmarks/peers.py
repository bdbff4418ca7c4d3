"""Comparison with two other multibody codes, Exudyn and MuJoCo: the same mechanisms, the same error measure, one process.

    pip install 'governor-mechanism[peers]'
    python benchmarks/peers.py

An error is the largest deviation of the angle at 201 reported times, in rad, against `multibody` at 1e-14. A time is that of the
simulation alone with its readings, with the model built and warmed up; times for a given error are interpolated between
settings. `peers_exudyn.py` and `peers_mujoco.py` describe the models and the settings tried to make the peers as fast as possible.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from types import ModuleType

import numpy as np

from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import MAX_STEP_LIMIT, StepPlan
from governor_mechanism.engines.multibody.engine import MultibodyRunner
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.types import FloatArray
from peers_cases import Case, Method, SettingResult, cases

PEERS = {"Exudyn": ("exudyn", "peers_exudyn"), "MuJoCo": ("mujoco", "peers_mujoco")}
"""Package of each peer, and the module with its models."""

TARGET_ERRORS = (1e-2, 1e-4, 1e-6, 1e-8)
REFERENCE_TOLERANCE = 1e-14

TIME_LIMIT = 0.8
"""Largest time of a run (s); a ladder ends at the first run that takes longer."""

MIN_TIMED_DURATION, MIN_REPEATS, MAX_REPEATS = 0.1, 3, 15
"""Time (s) in which a run is repeated, smallest number of repetitions unless a run is long, and largest number."""

IMPROVEMENT_FACTOR, MAX_STAGNANT_SETTINGS = 0.95, 2
"""A ladder of steps ends after this number of settings in a row that do not improve a small error by this factor."""

SMALL_ERROR = 1e-3

TOLERANCES = tuple(range(4, 13))
"""Decimal exponents of the tolerances."""

IMPULSE_STEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128)
"""Numbers of steps between reported times."""

INTEGRATION_ONLY = ", integration only"
WHOLE_RUN = ", whole run"
EXTRAPOLATED = "`impulse` extrapolated" + WHOLE_RUN


@dataclass(frozen=True)
class MethodResult:
    """A method of a code, and the results of its ladder of settings."""

    name: str
    settings: tuple[SettingResult, ...]

    @property
    def best(self) -> float:
        """Smallest error (rad)."""
        return min((setting.error for setting in self.settings), default=math.inf)

    def seconds(self, target: float) -> float | None:
        """Return the shortest time (s) for an error, interpolated in logarithms between settings; None if no setting reaches it."""
        found = [setting.seconds for setting in self.settings if setting.error <= target]
        for coarse, fine in pairwise(self.settings):
            if coarse.error > target >= fine.error > 0:
                fraction = math.log(coarse.error / target) / math.log(coarse.error / fine.error)
                found.append(coarse.seconds * (fine.seconds / coarse.seconds) ** fraction)
        return min(found, default=None)


def main() -> None:
    """Print the tables."""
    peers = {name: module for name in PEERS if (module := load_peer(name)) is not None}
    if not peers:
        print("No peer is installed, so there is no comparison.")
        return
    print(", ".join(str(module.VERSION) for module in peers.values()) + "\n")
    ratios = []
    for case in cases():
        exact = reference_angle(case)
        ours = [run_ladder(method, exact) for method in our_methods(case)]
        theirs = {name: [run_ladder(method, exact) for method in module.methods(case)] for name, module in peers.items()}
        print_table(case, [*ours, *(one for found in theirs.values() for method in found for one in (method, extrapolate(method, exact)))])
        ratios += [ratio_row(case, name, ours, found) for name, found in theirs.items()]
    print(
        "| times faster than | `reduced` at 1e-4 (target 500) | `multibody` at 1e-4 (target 10) | "
        "`impulse` extrapolated at 1e-6 (target 30) |\n|---|---|---|---|"
    )
    print("\n".join(ratios))


def load_peer(name: str) -> ModuleType | None:
    """Return the models of a peer; print a sentence and return None if it is not installed."""
    package, module = PEERS[name]
    try:
        importlib.import_module(package)
    except ImportError as error:
        print(f"{name} is left out ({error}); install it with: pip install 'governor-mechanism[peers]'\n")
        return None
    return importlib.import_module(module)


def reference_angle(case: Case) -> FloatArray:
    """Return the angle by multibody, and print its largest difference to reduced."""
    exact, other = (
        engine.run(case.scene, times=case.times, certify=False).readings[case.reading]
        for engine in (MultibodyEngine(tolerance=REFERENCE_TOLERANCE), ReducedEngine(tolerance=REFERENCE_TOLERANCE))
    )
    difference = float(np.max(np.abs(exact - other)))
    print(f"{case.title[0].upper()}{case.title[1:]}: `reduced` agrees with the reference within {difference:.0e} rad.\n")
    return exact


def our_methods(case: Case) -> tuple[Method, ...]:
    """Return the methods of this package: integration alone where possible, and whole runs."""
    return (
        Method(name="`reduced`" + INTEGRATION_ONLY, prepare=partial(prepare_reduced, case), ladder=TOLERANCES, stepped=False),
        Method(name="`reduced`" + WHOLE_RUN, prepare=partial(prepare_whole_run, case, reduced), ladder=TOLERANCES, stepped=False),
        Method(name="`multibody`" + INTEGRATION_ONLY, prepare=partial(prepare_multibody, case), ladder=TOLERANCES, stepped=False),
        Method(name="`multibody`" + WHOLE_RUN, prepare=partial(prepare_whole_run, case, multibody), ladder=TOLERANCES, stepped=False),
        Method(name=EXTRAPOLATED, prepare=partial(prepare_whole_run, case, partial(impulse, case)), ladder=IMPULSE_STEPS),
    )


def reduced(exponent: int) -> Engine:
    """Return the reduced engine at a tolerance."""
    return ReducedEngine(tolerance=10.0**-exponent)


def multibody(exponent: int) -> Engine:
    """Return the multibody engine at a tolerance."""
    return MultibodyEngine(tolerance=10.0**-exponent)


def impulse(case: Case, steps: int) -> Engine:
    """Return the impulse engine at a largest step, halved twice."""
    return ImpulseEngine(step=case.interval / steps, runs=3)


def prepare_whole_run(case: Case, engine: Callable[[int], Engine], setting: int) -> Callable[[], FloatArray]:
    """Return a whole run without a certificate; the peers have no certificates."""
    chosen = engine(setting)

    def run() -> FloatArray:
        """Run once and return the angles."""
        return chosen.run(case.scene, times=case.times, certify=False).readings[case.reading]

    return run


def prepare_reduced(case: Case, exponent: int) -> Callable[[], FloatArray]:
    """Return the integration of the reduced engine, with its tables built beforehand."""
    reduced_run = ReducedRunner(ReducedEngine(), case.scene, run_request(case)).get_reduced_run(1.0)
    # The first run builds the tables, which are not timed.
    plan = StepPlan(max_steps=MAX_STEP_LIMIT)
    reduced_run.integrate(case.times, REFERENCE_TOLERANCE, plan)
    return lambda: reduced_run.integrate(case.times, 10.0**-exponent, plan).states[:, 0]


def prepare_multibody(case: Case, exponent: int) -> Callable[[], FloatArray]:
    """Return the integration of the multibody engine, with its equations built beforehand, and the angle at the reported times."""
    integrator = MultibodyRunner(MultibodyEngine(), case.scene, run_request(case)).integrator
    mechanism = case.scene.part.mechanism

    def run() -> FloatArray:
        """Run once and return the angles."""
        states = integrator.integrate(10.0**-exponent, StepPlan(max_steps=MAX_STEP_LIMIT)).states
        history = integrator.state_history(states, integrator.time_grid.monitor_times[: len(states)])
        return evaluate_output_value(mechanism, case.reading, history.at(integrator.time_grid.truncate(len(states)).reported_indices).poses)

    return run


def run_request(case: Case) -> RunRequest:
    """Return one run through the reported times."""
    return RunRequest(times=case.times, accuracy=1e-8, certify=False, reason="")


def run_ladder(method: Method, exact: FloatArray) -> MethodResult:
    """Run a ladder from its coarsest setting until it takes too long or does not improve."""
    settings: list[SettingResult] = []
    n_stagnant, best = 0, math.inf
    for setting in method.ladder:
        try:
            found = measure_setting(method, setting, exact)
        except (ArithmeticError, GovernorMechanismError):
            # The step is too large, and the joints cannot be closed.
            continue
        if math.isfinite(found.error):
            settings.append(found)
            n_stagnant = 0 if found.error < IMPROVEMENT_FACTOR * best or best > SMALL_ERROR else n_stagnant + 1
            best = min(best, found.error)
        if found.seconds > TIME_LIMIT or (method.stepped and n_stagnant == MAX_STAGNANT_SETTINGS):
            break
    return MethodResult(name=method.name, settings=tuple(settings))


def measure_setting(method: Method, setting: int, exact: FloatArray) -> SettingResult:
    """Return the error of a setting, and the shortest time of several runs after a warm-up run."""
    run = method.prepare(setting)
    angles = run()
    if angles.shape != exact.shape:
        raise ArithmeticError("the run ended early")
    seconds: list[float] = []
    while not seconds or (
        seconds[0] < TIME_LIMIT and (len(seconds) < MIN_REPEATS or (sum(seconds) < MIN_TIMED_DURATION and len(seconds) < MAX_REPEATS))
    ):
        started = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - started)
    return SettingResult(setting=setting, error=float(np.max(np.abs(angles - exact))), seconds=min(seconds), angles=angles)


def extrapolate(method: MethodResult, exact: FloatArray) -> MethodResult:
    """Extrapolate two runs of a second-order scheme, one with half the step."""
    settings = {setting.setting: setting for setting in method.settings}
    found = []
    for steps, coarse in settings.items():
        if (fine := settings.get(2 * steps)) is not None:
            angles = (4 * fine.angles - coarse.angles) / 3
            error = float(np.max(np.abs(angles - exact)))
            found.append(SettingResult(setting=steps, error=error, seconds=coarse.seconds + fine.seconds, angles=angles))
    return MethodResult(name="two of these runs, Richardson extrapolation", settings=tuple(found))


def print_table(case: Case, found: Iterable[MethodResult]) -> None:
    """Print the times (ms) for the target errors."""
    headings = " | ".join(f"{target:.0e}" for target in TARGET_ERRORS)
    print(f"| {case.title}: ms for an error of | {headings} | smallest error, rad |\n|---|{'---|' * len(TARGET_ERRORS)}---|")
    for one in found:
        times = " | ".join(format_milliseconds(one.seconds(target)) for target in TARGET_ERRORS)
        print(f"| {one.name} | {times} | {one.best:.0e} |")
    print()


def format_milliseconds(seconds: float | None) -> str:
    """Return milliseconds with three digits; a dash if an error is never reached."""
    if seconds is None:
        return "–"
    milliseconds = seconds * 1e3
    return f"{milliseconds:.0f}" if milliseconds >= 100 else f"{milliseconds:.3g}"


def ratio_row(case: Case, name: str, ours: list[MethodResult], theirs: list[MethodResult]) -> str:
    """Return a table row with the ratios of the fastest method of a peer to ours: integration alone, whole runs in brackets."""
    by_name = {one.name: one for one in ours}

    def ratio(target: float, *engines: str) -> str:
        """Return one ratio as text."""
        reached = [seconds for one in theirs if (seconds := one.seconds(target)) is not None]
        if not reached:
            return f"not reached (best {min(one.best for one in theirs):.0e})"
        own = (by_name[engine].seconds(target) for engine in engines)
        first, *others = ("–" if seconds is None else format_ratio(min(reached) / seconds) for seconds in own)
        return f"{first} ({others[0]})" if others else first

    cells = (
        ratio(1e-4, "`reduced`" + INTEGRATION_ONLY, "`reduced`" + WHOLE_RUN),
        ratio(1e-4, "`multibody`" + INTEGRATION_ONLY, "`multibody`" + WHOLE_RUN),
        ratio(1e-6, EXTRAPOLATED),
    )
    return f"| {name}: {case.title} | {' | '.join(cells)} |"


def format_ratio(ratio: float) -> str:
    """Return a ratio with two significant digits."""
    return f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}"


if __name__ == "__main__":
    main()

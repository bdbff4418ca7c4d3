"""Two other multibody codes, Exudyn and MuJoCo, beside ours: the same mechanisms, the same error measure, one process.

    pip install 'governor-mechanism[peers]'
    python benchmarks/peers.py

An error is the largest of the angle at 201 reported times, in rad, against `multibody` at 1e-14. A time is that of the
simulation alone with its readings, model built and warmed up; times for a given error are interpolated between
settings. The models, and what was tried to have the peers at their best, are told in `peers_exudyn.py` and
`peers_mujoco.py`.
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
from governor_mechanism.engines.multibody.engine import MultibodyRunner as MultibodyFollower
from governor_mechanism.engines.reduced.engine import ReducedRunner as ReducedFollower
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from peers_cases import Case, FloatArray, Measured, Way, cases

PEERS = {"Exudyn": ("exudyn", "peers_exudyn"), "MuJoCo": ("mujoco", "peers_mujoco")}
"""The package that each needs, and the module with its models."""

TARGETS = (1e-2, 1e-4, 1e-6, 1e-8)
TIGHT = 1e-14

LONGEST = 0.8
"""Seconds that a run may take; a ladder ends with one that takes longer."""

TIMING, FEWEST, REPEATS = 0.1, 3, 15
"""Seconds in which a run is repeated, how often at least where it is not too long, and at most."""

FALLS, MISSES = 0.95, 2
"""A ladder of steps ends after so many in a row that do not better the best by this factor, once that is small."""

SMALL = 1e-3

TOLERANCES = tuple(range(4, 13))
"""Exponents."""

IMPULSE_STEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128)
"""Between reported times."""

STEPPING = ", steps alone"
WHOLE = ", whole run"
EXTRAPOLATED = "`impulse` extrapolated" + WHOLE


@dataclass(frozen=True)
class Climbed:
    """A way to use a code, and what its ladder gave."""

    name: str
    rungs: tuple[Measured, ...]

    @property
    def best(self) -> float:
        """The smallest error (rad)."""
        return min((rung.error for rung in self.rungs), default=math.inf)

    def seconds(self, target: float) -> float | None:
        """The shortest time for an error, between rungs on straight lines of logarithms; None if none is so good."""
        found = [rung.seconds for rung in self.rungs if rung.error <= target]
        for coarse, fine in pairwise(self.rungs):
            if coarse.error > target >= fine.error > 0:
                share = math.log(coarse.error / target) / math.log(coarse.error / fine.error)
                found.append(coarse.seconds * (fine.seconds / coarse.seconds) ** share)
        return min(found, default=None)


def main() -> None:
    """Print the tables."""
    peers = {name: module for name in PEERS if (module := peer(name)) is not None}
    if not peers:
        print("Without a peer there is nothing to compare with.")
        return
    print(", ".join(str(module.VERSION) for module in peers.values()) + "\n")
    ratios = []
    for case in cases():
        true = reference(case)
        ours = [climbed(way, true) for way in our_ways(case)]
        theirs = {name: [climbed(way, true) for way in module.ways(case)] for name, module in peers.items()}
        table(case, [*ours, *(one for found in theirs.values() for way in found for one in (way, by_hand(way, true)))])
        ratios += [ratio_row(case, name, ours, found) for name, found in theirs.items()]
    print(
        "| times faster than | `reduced` at 1e-4 (target 500) | `multibody` at 1e-4 (target 10) | "
        "`impulse` extrapolated at 1e-6 (target 30) |\n|---|---|---|---|"
    )
    print("\n".join(ratios))


def peer(name: str) -> ModuleType | None:
    """The models of a peer, or a sentence on why there are none."""
    package, module = PEERS[name]
    try:
        importlib.import_module(package)
    except ImportError as error:
        print(f"{name} is left out ({error}); install it with: pip install 'governor-mechanism[peers]'\n")
        return None
    return importlib.import_module(module)


def reference(case: Case) -> FloatArray:
    """The angle by multibody, and how far reduced agrees with it."""
    true, other = (
        engine.run(case.scene, times=case.times, certify=False).readings[case.reading]
        for engine in (MultibodyEngine(tolerance=TIGHT), ReducedEngine(tolerance=TIGHT))
    )
    apart = float(np.max(np.abs(true - other)))
    print(f"{case.title[0].upper()}{case.title[1:]}: `reduced` agrees with the reference within {apart:.0e} rad.\n")
    return true


def our_ways(case: Case) -> tuple[Way, ...]:
    """Our engines: their stepping alone where they can be asked for it, and whole runs."""
    return (
        Way(name="`reduced`" + STEPPING, prepare=partial(reduced_stepping, case), ladder=TOLERANCES, stepped=False),
        Way(name="`reduced`" + WHOLE, prepare=partial(whole, case, reduced), ladder=TOLERANCES, stepped=False),
        Way(name="`multibody`" + STEPPING, prepare=partial(multibody_stepping, case), ladder=TOLERANCES, stepped=False),
        Way(name="`multibody`" + WHOLE, prepare=partial(whole, case, multibody), ladder=TOLERANCES, stepped=False),
        Way(name=EXTRAPOLATED, prepare=partial(whole, case, partial(impulse, case)), ladder=IMPULSE_STEPS),
    )


def reduced(exponent: int) -> Engine:
    """The engine at a tolerance."""
    return ReducedEngine(tolerance=10.0**-exponent)


def multibody(exponent: int) -> Engine:
    """The engine at a tolerance."""
    return MultibodyEngine(tolerance=10.0**-exponent)


def impulse(case: Case, steps: int) -> Engine:
    """The engine at a longest step, halved twice."""
    return ImpulseEngine(step=case.interval / steps, runs=3)


def whole(case: Case, engine: Callable[[int], Engine], rung: int) -> Callable[[], FloatArray]:
    """What a user waits for, without a certificate: the peers give none."""
    chosen = engine(rung)

    def run() -> FloatArray:
        return chosen.run(case.scene, times=case.times, certify=False).readings[case.reading]

    return run


def reduced_stepping(case: Case, exponent: int) -> Callable[[], FloatArray]:
    """The engine from where its tables are laid."""
    rider = ReducedFollower(ReducedEngine(), case.scene, task(case)).get_reduced_run(1.0)
    # Building is left out: the pieces are laid by the first ride.
    rider.integrate(TIGHT)
    return lambda: rider.integrate(10.0**-exponent).states[:, 0]


def multibody_stepping(case: Case, exponent: int) -> Callable[[], FloatArray]:
    """The engine from where its equations are laid out, with the angle read at the reported times."""
    stepper = MultibodyFollower(MultibodyEngine(), case.scene, task(case)).integrator
    mechanism = case.scene.part.mechanism

    def run() -> FloatArray:
        state = stepper.state_history(stepper.integrate(10.0**-exponent).states)
        return evaluate_output_value(mechanism, case.reading, state.poses[stepper.time_grid.truncate(len(state.times)).reported_indices])

    return run


def task(case: Case) -> RunRequest:
    """One run through the reported times."""
    return RunRequest(times=case.times, accuracy=1e-8, certify=False, reason="")


def climbed(way: Way, true: FloatArray) -> Climbed:
    """A ladder from its coarsest rung to where it takes too long or is no better."""
    rungs: list[Measured] = []
    missed, best = 0, math.inf
    for rung in way.ladder:
        try:
            found = measured(way, rung, true)
        except (ArithmeticError, GovernorMechanismError):
            # Too coarse a step: the joints are lost.
            continue
        if math.isfinite(found.error):
            rungs.append(found)
            missed = 0 if found.error < FALLS * best or best > SMALL else missed + 1
            best = min(best, found.error)
        if found.seconds > LONGEST or (way.stepped and missed == MISSES):
            break
    return Climbed(name=way.name, rungs=tuple(rungs))


def measured(way: Way, rung: int, true: FloatArray) -> Measured:
    """A rung's error, and the shortest time of several runs after one to warm up."""
    run = way.prepare(rung)
    angles = run()
    if angles.shape != true.shape:
        raise ArithmeticError("the run ended early")
    seconds: list[float] = []
    while not seconds or (seconds[0] < LONGEST and (len(seconds) < FEWEST or (sum(seconds) < TIMING and len(seconds) < REPEATS))):
        started = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - started)
    return Measured(rung=rung, error=float(np.max(np.abs(angles - true))), seconds=min(seconds), angles=angles)


def by_hand(way: Climbed, true: FloatArray) -> Climbed:
    """Two runs of a second-order scheme, one with half the step, extrapolated as anyone might do it."""
    rungs = {rung.rung: rung for rung in way.rungs}
    found = []
    for steps, coarse in rungs.items():
        if (fine := rungs.get(2 * steps)) is not None:
            angles = (4 * fine.angles - coarse.angles) / 3
            error = float(np.max(np.abs(angles - true)))
            found.append(Measured(rung=steps, error=error, seconds=coarse.seconds + fine.seconds, angles=angles))
    return Climbed(name="two of these runs, extrapolated by hand", rungs=tuple(found))


def table(case: Case, found: Iterable[Climbed]) -> None:
    """Times for the errors aimed at, ms."""
    heads = " | ".join(f"{target:.0e}" for target in TARGETS)
    print(f"| {case.title}: ms for an error of | {heads} | smallest error, rad |\n|---|{'---|' * len(TARGETS)}---|")
    for one in found:
        times = " | ".join(told(one.seconds(target)) for target in TARGETS)
        print(f"| {one.name} | {times} | {one.best:.0e} |")
    print()


def told(seconds: float | None) -> str:
    """Milliseconds in three figures; a dash where an error is never reached."""
    if seconds is None:
        return "–"
    milliseconds = seconds * 1e3
    return f"{milliseconds:.0f}" if milliseconds >= 100 else f"{milliseconds:.3g}"


def ratio_row(case: Case, name: str, ours: list[Climbed], theirs: list[Climbed]) -> str:
    """How many times faster than the best way to use a peer: steps alone, in brackets whole runs."""
    by_name = {one.name: one for one in ours}

    def ratio(target: float, *engines: str) -> str:
        reached = [seconds for one in theirs if (seconds := one.seconds(target)) is not None]
        if not reached:
            return f"never so good (best {min(one.best for one in theirs):.0e})"
        own = (by_name[engine].seconds(target) for engine in engines)
        first, *others = ("–" if seconds is None else two_figures(min(reached) / seconds) for seconds in own)
        return f"{first} ({others[0]})" if others else first

    cells = (
        ratio(1e-4, "`reduced`" + STEPPING, "`reduced`" + WHOLE),
        ratio(1e-4, "`multibody`" + STEPPING, "`multibody`" + WHOLE),
        ratio(1e-6, EXTRAPOLATED),
    )
    return f"| {name}: {case.title} | {' | '.join(cells)} |"


def two_figures(ratio: float) -> str:
    """A ratio without false precision."""
    return f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}"


if __name__ == "__main__":
    main()

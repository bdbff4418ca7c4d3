"""Error against time: every engine, and every way to use it, over a ladder of settings.

A scene is run once as well as multibody can, another engine confirms that, and each setting is held against it. Runs
are made without certificates: here the error is measured.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import reported_times
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.mechanics.contact.event_log import compared
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import switches
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.studies.regression import Fitted, slope
from governor_mechanism.studies.work_precision.results import AccuracyStudy, Point, Reference, Variant
from governor_mechanism.studies.work_precision.settings import Ladder, ladders_of, spoken_step
from governor_mechanism.types import FloatArray

TIGHT = 1e-14
"""The tolerance of the reference and of what confirms it."""

MOST_SAMPLES = 200
"""Intervals between the times at which readings are compared, at most: more cost every engine time of their own."""

LONGEST = 1.0
"""Seconds that a setting may take; a ladder ends where the next would take longer."""

TIMING, FEWEST_REPEATS, MOST_REPEATS = 0.15, 3, 7
"""Seconds in which a setting is run again and again, how often in any case, and how often at most."""

CONFIRMS = 1e-3
"""An engine that comes no nearer to the reference than this confirms nothing."""

FEW = 0.5
"""Where less than this part of the time is reached, times are laid closer."""

LOST = 1.0
"""Machine sizes: bodies whose joints are open by more are lost."""

MISSES, FALLS = 2, 0.95
"""After so many settings in a row that are not better by this factor than the best, or one whose joints close no
better, a ladder of steps goes on with more iterations of the joint solver, and ends where there are no more to be had.
"""

CLOSED = 1e-11
"""Machine sizes: a joint open by less than this is open by rounding."""

RAISED, MOST_RAISED = 4, 64
"""How many times more iterations of the joint solver it goes on with, each time and in all."""

SAME = 1e-6
"""Settings whose errors differ by no more, and that take as many evaluations, gave the same run."""

NEAR_EVENTS = 0.1
"""In time scales: samples nearer to an event than it is late are left out, up to this."""

TOO_NEAR = 1e-9
"""In time scales: samples nearer to an event than this always are."""

SMALL, FITTED = 0.03, 5
"""Orders are fitted to errors below this, and to so many of the finest steps; no ladder ends before it is reached."""

LOOSER = 10.0
"""The estimate of a run is the error of one so many times looser: where another engine confirms it, it is better."""

ENDS = (Outcome.DONE, Outcome.UNCERTIFIED, Outcome.ACCURACY_MISSED, Outcome.LEFT_RANGE)
"""Ways to end that are the scene's, not the engine's."""


def accuracy_study(
    scene: Scene, longest: float = LONGEST, progress: Callable[[int, int], None] | None = None
) -> AccuracyStudy:
    """Run a scene by each engine at each setting that takes at most `longest` (s), and measure errors and times.

    progress is told how many of all settings have been dealt with. Raises MechanismError where no run is long enough
    to be compared.
    """
    if not (isinstance(longest, int | float) and 0 < longest < math.inf):
        raise MechanismError(f"the longest time of a setting must be a positive number of seconds; got {longest!r}")
    samples = min(len(reported_times(scene)) - 1, MOST_SAMPLES)
    times = np.linspace(0.0, scene.run.duration, samples + 1)
    bench = Bench(scene, times, float(longest))
    ended = bench.best.message if bench.best.outcome is Outcome.LEFT_RANGE else ""
    if ended and len(bench.best.times) < FEW * len(times):
        bench = Bench(scene, np.linspace(0.0, bench.best.times[-1], samples + 1), float(longest))
    ladders = list(ladders_of(scene))
    total = sum(len(ladder.rungs) for ladder in ladders)
    done = 0
    variants = []
    for ladder in ladders:

        def tell(rung: int, before: int = done) -> None:
            if progress is not None:
                progress(before + rung, total)

        variants.append(bench.climbed(ladder, tell))
        done += len(ladder.rungs)
        tell(0, done)
    return AccuracyStudy(
        scene=scene,
        reference=_confirmed(bench.reference, variants),
        variants=tuple(variants),
        samples=len(bench.best.times),
        time_scale=bench.time_scale,
        ended=ended,
    )


class Bench:
    """Where the engines of one scene are measured: the reference run, and the times at which they are compared.

    longest (s) is what a setting may take; a ladder ends below `enough`, or where the reference tells nothing more.
    """

    def __init__(self, scene: Scene, times: FloatArray, longest: float, enough: float = 0.0) -> None:
        self.scene, self.times, self.longest, self.enough = scene, times, longest, enough
        self.time_scale, self.size = time_scale(scene), scene.part.mechanism.size
        self.switching = switches(scene)
        engine = MultibodyEngine(tolerance=TIGHT)
        refused = engine.refusal(scene)
        if refused:
            raise MechanismError(f"there is no reference to measure errors by: {refused}")
        self.best = engine.run(scene, times=times)
        if len(self.best.times) < 2 or self.best.outcome not in ENDS:
            raise MechanismError(f"there is no reference to measure errors by: {self.best.message}")
        self.reference = self._checked(self.best.error_estimate or 0.0)

    def _checked(self, estimate: float) -> Reference:
        """The reference, confirmed by the reduced engine where that holds the scene."""
        alone = Reference(
            engine=MultibodyEngine.name, tolerance=TIGHT, estimate=estimate, confirmed_by="", confirmed=None,
            error=max(estimate, float(np.finfo(float).eps)),
        )  # fmt: skip
        other = ReducedEngine(tolerance=TIGHT)
        if other.refusal(self.scene):
            return alone
        try:
            run = other.run(self.scene, times=self.times, certify=False)
        except GovernorMechanismError:
            return alone
        if self._shortfall(run):
            return alone
        errors, late = self._compared(run)
        found = max(*errors.values(), (late or 0.0) / self.time_scale)
        return replace(alone, confirmed_by=other.name, confirmed=found, error=max(alone.error / LOOSER, found))

    def climbed(self, ladder: Ladder, tell: Callable[[int], None]) -> Variant:
        """A ladder run up to where it is not worth going on."""
        refused = ladder.rungs[0][1].refusal(self.scene)
        points: list[Point] = []
        notes: dict[str, list[str]] = {}
        missed, within, raised = 0, None, 1
        for rung, (setting, engine) in enumerate(() if refused else ladder.rungs):
            tell(rung)
            if isinstance(engine, ImpulseEngine) and raised > 1:
                engine = replace(engine, iterations=raised * engine.iterations)
            growth = 2.0 if ladder.stepped else 1.0
            if points and growth * points[-1].seconds > self.longest:
                within = self.longest
                break
            before = time.perf_counter()
            try:
                found = self._point(ladder.name, setting, engine, points[-1] if points else None)
            except GovernorMechanismError as error:
                if not points:
                    refused = str(error)
                    break
                found = str(error)
            if found is None:
                continue
            if isinstance(found, str):
                notes.setdefault(found, []).append(setting)
                raised *= RAISED if ladder.stepped and raised < MOST_RAISED else 1
                if growth * (time.perf_counter() - before) > self.longest:
                    within = self.longest
                    break
                continue
            best = min((point.reach for point in points), default=math.inf)
            points.append(found)
            if found.reach < max(self.reference.floor, self.enough):
                break
            closing = len(points) < 2 or _closing(points)
            missed = 0 if found.reach < FALLS * best or (best > SMALL and closing) else missed + 1
            if ladder.stepped and missed and (missed == MISSES or not closing):
                if raised >= MOST_RAISED:
                    break
                missed, raised = 0, RAISED * raised
        order = _order(points, self.reference.floor) if ladder.stepped else None
        return Variant(
            name=ladder.name, points=tuple(points), order=order, refused=refused, notes=_told(notes), within=within
        )

    def _point(self, variant: str, setting: str, engine: Engine, last: Point | None) -> Point | str | None:
        """One setting measured, or why there is nothing to measure; None where the last one gave the same run."""
        run, first = self._once(engine)
        shortfall = self._shortfall(run)
        if shortfall:
            return shortfall
        if isinstance(engine, ImpulseEngine):  # steps end at reported times, and may be shorter than was asked
            setting = spoken_step(run.cost.step * 2 ** (engine.levels - 1))
        if run.cost.iterations > ImpulseEngine.iterations:
            setting = f"{setting}, {run.cost.iterations} iterations"
        errors, late = self._compared(run)
        gap = float(np.max(run.joint_gap)) / self.size
        if not all(map(math.isfinite, (*errors.values(), run.energy.drift))) or not gap < LOST:
            return "its bodies are lost"
        worst = max(errors, key=lambda name: errors[name])
        evaluations = run.cost.evaluations.get("equations of motion", run.cost.steps)
        if (
            last is not None
            and evaluations == last.evaluations
            and math.isclose(errors[worst], last.error, rel_tol=SAME)
        ):
            return None
        seconds, repeats = self._timed(engine, first)
        return Point(
            variant=variant,
            engine=engine,
            setting=setting,
            error=errors[worst],
            worst=worst,
            errors=errors,
            late=late,
            reach=max(errors[worst], (late or 0.0) / self.time_scale),
            seconds=seconds,
            repeats=repeats,
            step=run.cost.step,
            evaluations=evaluations,
            joint_gap=gap,
            drift=run.energy.drift,
        )

    def _timed(self, engine: Engine, first: float) -> tuple[float, int]:
        """The shortest time of several runs; the one before them warmed up, and counts where it took too long."""
        if first > self.longest:
            return first, 1
        seconds = [self._once(engine)[1] for _ in range(FEWEST_REPEATS)]  # one may be held up by something else
        while sum(seconds) < TIMING and len(seconds) < MOST_REPEATS:
            seconds.append(self._once(engine)[1])
        return min(seconds), len(seconds)

    def _once(self, engine: Engine) -> tuple[Trajectory, float]:
        started = time.perf_counter()
        run = engine.run(self.scene, times=self.times, certify=False)
        return run, time.perf_counter() - started

    def _shortfall(self, run: Trajectory) -> str:
        """How a run ended where the reference went on, in a sentence."""
        short = len(self.best.times) - len(run.times)
        if run.outcome not in ENDS or short > 1:
            return run.message
        return ""

    def _compared(self, run: Trajectory) -> tuple[Mapping[str, float], float | None]:
        """The largest difference of each reading and each rate in its scale, away from events; how late (s) those are.

        Late is None where nothing in the scene can be held or struck.
        """
        best = self.best
        shared = min(len(best.times), len(run.times))
        kept, late = np.ones(shared, dtype=np.bool_), None
        if self.switching:
            times = best.times[:shared]
            late, _ = compared(best.events, run.events, times, 0.0)
            apart = max(min(late, NEAR_EVENTS * self.time_scale), TOO_NEAR * self.time_scale)
            kept = ~compared(best.events, run.events, times, apart * (1 + TOO_NEAR))[1]
        errors = {}
        for kind, scale, of_run, of_best in (
            ("", 1.0, run.readings, best.readings),
            ("rate of ", self.time_scale, run.rates, best.rates),
        ):
            for name, values in of_best.items():
                apart_by = np.abs(values[:shared][kept] - of_run[name][:shared][kept])
                errors[f"{kind}{name}"] = float(np.max(apart_by, initial=0.0)) * scale / best.scales[name]
        return errors, late


def _told(notes: Mapping[str, list[str]]) -> tuple[str, ...]:
    """A sentence for each reason, with the settings it is true of."""
    return tuple(
        f"{settings[0]}{f' to {settings[-1]}' if len(settings) > 1 else ''}: {reason}"
        for reason, settings in notes.items()
    )


def _closing(points: list[Point]) -> bool:
    """Whether joints still close better with shorter steps; by a quarter, where the step alone keeps them open."""
    before, after = points[-2].joint_gap, points[-1].joint_gap
    return after <= max(0.5 * before, CLOSED)


def _order(points: list[Point], floor: float) -> Fitted | None:
    """How fast errors fall with the step: the slope of their logarithms, where longest they fall on and on."""
    runs: list[list[Point]] = [[]]
    for coarser, finer in pairwise([None, *points]):
        if finer is None:
            continue
        stuck = coarser is not None and finer.error > FALLS * coarser.error
        if stuck or not floor < finer.error < SMALL:
            runs.append([])
        if floor < finer.error < SMALL:
            runs[-1].append(finer)
    fitted = max(runs, key=len)[-FITTED:]
    if len(fitted) < 3:
        return None
    return slope(*(np.log([getattr(point, name) for point in fitted]) for name in ("step", "error")))


def _confirmed(reference: Reference, variants: list[Variant]) -> Reference:
    """A reference that reduced could not confirm, confirmed by how far impulse came."""
    if reference.confirmed is not None:
        return reference
    found = [variant.best for variant in variants if variant.name.startswith("impulse") and variant.best]
    best = min(found, key=lambda point: point.reach, default=None)
    return (
        reference
        if best is None or best.reach > CONFIRMS
        else replace(reference, confirmed_by=best.variant, confirmed=best.reach)
    )

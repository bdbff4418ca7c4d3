"""Runs as a page shows them: samples, pace, readings and accuracy in words, the events of a valve, and assemblies."""

import math
import tempfile
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.events import Event
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.run_result import DeferredMotionAnalysis
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.render.film.timing import select_slow_down
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2
from governor_mechanism.render.page.views import ShownRun, show_run
from governor_mechanism.render.page.writer import MAX_TRUE_TIME_DURATION, choose_sample_times
from governor_mechanism.render.shown_readings import format_closing_lines, format_name
from governor_mechanism.studies.assemblies import list_scene_assemblies
from governor_mechanism.studies.valve_gears import tabulate_valve_timing
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity

MAX_SENTENCE_LENGTH: Final = 2000
"""Largest length of a sentence on how a run ended; a page breaks its lines itself."""


def choose_pace(run: Trajectory) -> tuple[Vec2, float]:
    """Return the limits of the time of a run, s, and how many seconds of film a second of it takes at first."""
    limits = float(run.times[0]), float(run.times[-1])
    return limits, select_slow_down(limits, limits, None, MAX_TRUE_TIME_DURATION)


def show_whole_run(run: Trajectory, boxes: Sequence[BoundingBox] = ()) -> tuple[ShownRun, float]:
    """Return what a page shows of a whole run, in given boxes or in those that fit, and its pace."""
    limits, slow_down = choose_pace(run)
    return show_run(run, None, limits, choose_sample_times(run, limits, slow_down), slow_down, boxes=boxes), slow_down


def describe_outcome(run: Trajectory) -> str:
    """Return in a line how a run ended, how accurate it is, and what was computed."""
    lines, _ = format_closing_lines(run, MAX_SENTENCE_LENGTH)
    return "; ".join([*lines, f"engine {run.cost.engine}, {1e3 * run.cost.wall_time:.3g} ms"])


def continue_with(run: Trajectory, whole: Trajectory) -> Trajectory:
    """Return a run that ends early with the rest of the last whole one behind it, as drawings had it; alone if that has other parts."""
    later = whole.times > run.times[-1]
    if run.body_names != whole.body_names or run.readings.keys() != whole.readings.keys() or run.rates.keys() != whole.rates.keys():
        return run

    def join(first: FloatArray, second: FloatArray) -> FloatArray:
        joined: FloatArray = np.concatenate([first, second[later]])
        return joined

    return replace(
        run,
        times=join(run.times, whole.times),
        poses=join(run.poses, whole.poses),
        velocities=join(run.velocities, whole.velocities),
        readings={name: join(values, whole.readings[name]) for name, values in run.readings.items()},
        rates={name: join(values, whole.rates[name]) for name, values in run.rates.items()},
        joint_gap=join(run.joint_gap, whole.joint_gap),
    )


@dataclass(frozen=True)
class _MomentResults(DeferredMotionAnalysis):
    """Results of a run of which a moment is drawn: its events are those of contacts, which need no search."""

    def events(self) -> tuple[Event, ...]:
        """Return the events of contacts in the order of time."""
        return tuple(sorted(self.result.contact_events, key=lambda event: event.time))


def prepare_moment(run: Trajectory, whole: Trajectory | None) -> Trajectory:
    """Return a run as a drawing of one of its moments needs it; one that ends early has the rest of the last whole one behind it."""
    drawn = run if whole is None else continue_with(run, whole)
    results = run.deferred_results
    if not isinstance(results, DeferredMotionAnalysis):
        return drawn
    return replace(drawn, deferred_results=_MomentResults(results.scene, results.result, results.mobility))


def list_frames(shown: ShownRun) -> list[list[float]]:
    """Return how each picture maps its plane: its scale, and the left and the top end of its box."""
    return [[view.picture.scale, view.box[0], view.box[3]] for view in shown.views]


def describe_end(run: Trajectory) -> str:
    """Return when a run ends, in words."""
    return f"At t = {run.times[-1]:.4g} s"


def describe_bounded_outcome(run: Trajectory) -> str:
    """Return how a run ended whose work was bounded, since a hand moves."""
    end = f"to t = {run.times[-1]:.4g} s while you hold it"
    return (
        f"{end}: from there on it needs many steps, as where it locks"
        if run.outcome is Outcome.STEP_LIMIT
        else f"{end}; {describe_outcome(run)}"
    )


def describe_readings(run: Trajectory) -> list[dict[str, Any]]:
    """Return the readings at the end of a run, SI and in words, with the estimates of their errors."""
    described = []
    for name, values in run.readings.items():
        value, unit = float(values[-1]), run.units.get(name, "")
        if math.isfinite(value):
            error = run.reading_errors.get(name)
            texts = {"text": format_quantity(value, unit), "estimate": "" if error is None else f"± {format_quantity(error, unit, '.1g')}"}
            described.append({"name": name, "words": format_name(name), "value": value, "error": error} | texts)
    return described


def describe_valve(run: Trajectory, theme: str) -> dict[str, Any]:
    """Return the events of the valve in words, and Zeuner's diagram as PNG in base64; raise MechanismError without such a valve."""
    from governor_mechanism.render.figures.plates import zeuner  # slow to import

    timing = tabulate_valve_timing(run.scene)
    with tempfile.TemporaryDirectory() as folder:
        path = zeuner.draw_zeuner_plate(zeuner.ValveDiagram(run.scene)).save(Path(folder) / "zeuner.png", theme)
        picture = b64encode(path.read_bytes()).decode()
    # The title stands at the head of the page.
    return {"timing": str(timing).partition("\n")[2], "picture": picture}


def describe_assemblies(run: Trajectory) -> dict[str, Any]:
    """Return how many ways there are in which the joints close, and which one is taken; raise MechanismError if they are not listed."""
    found = list_scene_assemblies(run.scene)
    return {"count": len(found), "taken": found.taken, "isComplete": found.complete, "text": str(found)}


def list_inspections(run: Trajectory) -> list[str]:
    """Return what can be asked for."""
    scene = run.scene
    has_assemblies = len(scene.parts) == 1 and scene.part.machine == CUSTOM_MACHINE
    return [name for name, has in (("valve", has_valve_events(scene)), ("assemblies", has_assemblies)) if has]

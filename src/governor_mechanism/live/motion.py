"""A motion that goes on from state to state while it is looked at, under the loads of the moment."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any, Final

import numpy as np

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.live.describing import choose_pace, describe_readings, list_frames
from governor_mechanism.model.events import Event
from governor_mechanism.model.results.records import Reaction, Recurrence, SpeedFluctuation
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2, enclose_boxes
from governor_mechanism.render.page.page_data import collect_data, collect_pictures
from governor_mechanism.render.page.views import ShownRun, show_run
from governor_mechanism.render.page.writer import choose_sample_times
from governor_mechanism.types import FloatArray

MAX_DURATION: Final = 2.0
"""Longest time, s, by which a motion is extended at once."""

REPORTED_TIMES: Final = (8, 400)
"""Least and largest number of reported times of a piece."""

KEPT_DURATION: Final = 20.0
"""Time, s, for which earlier pieces are drawn in the plots, and can be gone on from."""

PLOT_SAMPLES: Final = 240
"""Number of samples of a plot."""

LEAST_SAMPLES: Final = 6
"""Least number of moments at which a piece is drawn."""


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A run that goes on from the one before; `offset` is its time 0 on the clock of the motion, s, and `count` its times that count."""

    offset: float
    run: Trajectory
    count: int

    @property
    def times(self) -> FloatArray:
        """Times on the clock of the motion, s; shape (count,)."""
        times: FloatArray = self.offset + self.run.times[: self.count]
        return times

    def until(self, time: float) -> "Piece":
        """Return the piece up to its first time that is not before a given one, s."""
        return replace(self, count=min(int(np.searchsorted(self.times, time - 1e-12 * max(1.0, abs(time)))) + 1, self.count))


class Motion:
    """The motion that one tab shows: pieces of certified runs, each from the end of the one before; its boxes grow with the motion."""

    def __init__(self, run: Trajectory, boxes: Sequence[BoundingBox]) -> None:
        self._pieces = [Piece(offset=0.0, run=run, count=len(run.times))]
        self._boxes, self._lock = tuple(boxes), Lock()
        self._trail_length = 0.0
        """Time, s, before a piece from which on it is drawn, for what stays behind a point for a second of film."""

    def extend(self, scene: Scene, time: float, duration: float) -> dict[str, Any]:
        """Go on from the first state that is not before a time (s), for a duration (s), and return what the page shows of it."""
        # Where that state has no meaning in the scene, the motion starts again as the scene begins,
        # and a sentence says so.
        with self._lock:
            self._cut(time)
            last = self._pieces[-1]
            start = float(last.times[-1])
            span = min(max(duration, 0.0) or MAX_DURATION, MAX_DURATION)
            times = _choose_times(scene, span)
            note = ""
            try:
                run = gm.run(scene, times=times, start=last.run.state(float(last.run.times[last.count - 1])))
            except MechanismError as error:
                note = f"The motion starts again from the start of the scene: {'; '.join(error.problems)}."
                run = gm.run(scene, times=times)
                start = 0.0
                self._pieces = []
            if len(run.times) < 2:
                raise MechanismError(f"the motion does not go on: {run.message}")
            self._pieces.append(Piece(offset=start, run=run, count=len(run.times)))
            self._forget()
            return self._describe(scene) | {"note": note, "isOver": bool(run.times[-1] < times[-1]), "message": run.message}

    def _cut(self, time: float) -> None:
        """Leave out what is later than the first state that is not before a time (s)."""
        kept = [piece for piece in self._pieces if piece.offset < time] or self._pieces[:1]
        self._pieces = [*kept[:-1], kept[-1].until(time)]

    def _forget(self) -> None:
        """Leave out pieces of long ago, and those whose readings are others."""
        last = self._pieces[-1]
        end = float(last.times[-1]) - KEPT_DURATION
        self._pieces = [one for one in self._pieces if one.times[-1] > end and one.run.readings.keys() == last.run.readings.keys()]

    def _describe(self, scene: Scene) -> dict[str, Any]:
        """Return what the page shows of the last piece, with plots of the last time."""
        piece, joined = self._pieces[-1], _join(self._pieces, scene)
        limits = float(piece.times[0]), float(piece.times[-1])
        slow_down = choose_pace(self._pieces[0].run)[1]
        shown = self._show(joined, piece, (limits[0] - self._trail_length, limits[1]), slow_down)
        if any(view.trails for view in shown.views) and not self._trail_length:
            self._trail_length = 1.0 / slow_down
            shown = self._show(joined, piece, (limits[0] - self._trail_length, limits[1]), slow_down)
        self._boxes = tuple(
            enclose_boxes([view.box, view.data.drawing.bounds]) if view.has_plane and view.shows_bodies else view.box
            for view in shown.views
        )
        first = max(float(joined.times[0]), limits[1] - KEPT_DURATION)
        plotted = np.linspace(first, limits[1], PLOT_SAMPLES)
        plots = show_run(joined, None, (first, limits[1]), plotted, slow_down, boxes=self._boxes)
        return {
            "start": limits[0],
            "stop": limits[1],
            "data": collect_pictures(shown, slow_down),
            "frames": list_frames(shown),
            "plots": collect_data(replace(plots, views=[]), slow_down),
            "readings": describe_readings(piece.run),
            "accuracy": self._describe_accuracy(),
        }

    def _show(self, joined: Trajectory, piece: Piece, limits: Vec2, slow_down: float) -> ShownRun:
        """Return a joined run as it is drawn between limits of time (s), as finely as its last piece."""
        within = max(limits[0], float(joined.times[0])), limits[1]
        times = choose_sample_times(replace(piece.run, times=piece.times), within, slow_down, LEAST_SAMPLES)
        return show_run(joined, None, within, times, slow_down, boxes=self._boxes)

    def _describe_accuracy(self) -> str:
        """Return what is known of the accuracy: each certificate is that of one piece, from the state in which that begins."""
        pieces, last = self._pieces, self._pieces[-1].run
        estimates = [piece.run.error_estimate for piece in pieces]
        cost = f"engine {last.cost.engine}, {1e3 * last.cost.wall_time:.3g} ms"
        if any(estimate is None for estimate in estimates):
            return f"motion to t = {pieces[-1].times[-1]:.4g} s, not certified; {cost}"
        total = math.fsum(estimate for estimate in estimates if estimate is not None)
        return (
            f"motion to t = {pieces[-1].times[-1]:.4g} s; accurate to {estimates[-1]:.0e} in its last {last.times[-1]:.3g} s; errors of "
            f"the {len(pieces)} pieces add up to {total:.0e}, and what the motion makes of earlier ones is not in it; {cost}"
        )


def _choose_times(scene: Scene, duration: float) -> FloatArray:
    """Return the reported times (n,) s of a piece."""
    least, most = REPORTED_TIMES
    times: FloatArray = np.linspace(0.0, duration, min(max(math.ceil(duration / scene.run.output_interval), least), most) + 1)
    return times


@dataclass(frozen=True)
class JoinedResults:
    """What the pieces of a motion imply."""

    pieces: Sequence[Piece]
    rows: Sequence[slice]

    def reactions(self) -> Mapping[str, Reaction]:
        """Return the reactions by joint name."""
        found = [(piece.run.reactions, rows) for piece, rows in zip(self.pieces, self.rows, strict=True)]
        return {
            name: Reaction(
                force=np.concatenate([one[name].force[rows] for one, rows in found]),
                moment=np.concatenate([one[name].moment[rows] for one, rows in found]),
                determined=np.concatenate([one[name].determined[rows] for one, rows in found]),
            )
            for name in found[-1][0]
        }

    def events(self) -> tuple[Event, ...]:
        """Return the events in order of time."""
        return tuple(
            replace(event, time=piece.offset + event.time)
            for piece in self.pieces
            for event in piece.run.events
            if event.time <= piece.run.times[piece.count - 1]
        )

    def event_notes(self) -> tuple[str, ...]:
        """Return nothing: a motion that goes on has no list of its events."""
        return ()

    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Return those of the last piece."""
        return self.pieces[-1].run.speed_fluctuations

    def recurrences(self) -> Mapping[str, Recurrence]:
        """Return those of the last piece."""
        return self.pieces[-1].run.recurrences

    def lags_at(self, k: int) -> tuple[float, ...]:
        """Return none: a motion goes on from its pieces."""
        return ()

    def states_near_events(self, times: FloatArray) -> Mapping[int, tuple[FloatArray, FloatArray]]:
        """Return nothing: a motion that goes on is drawn at its reported times."""
        return {}


def _join(pieces: Sequence[Piece], scene: Scene) -> Trajectory:
    """Return the pieces of a motion as one run on the clock of the motion; where two meet, the later one counts."""
    last = pieces[-1].run
    rows = [slice(0, piece.count - 1) for piece in pieces[:-1]] + [slice(0, pieces[-1].count)]
    runs = [(piece.run, one) for piece, one in zip(pieces, rows, strict=True)]

    def join(values_of: Any) -> FloatArray:
        values: FloatArray = np.concatenate([values_of(run)[one] for run, one in runs])
        return values

    return replace(
        last,
        scene=scene,
        times=np.concatenate([piece.times[one] for piece, one in zip(pieces, rows, strict=True)]),
        poses=join(lambda run: run.poses),
        velocities=join(lambda run: run.velocities),
        readings={name: join(lambda run, name=name: run.readings[name]) for name in last.readings},
        rates={name: join(lambda run, name=name: run.rates[name]) for name in last.rates},
        joint_gap=join(lambda run: run.joint_gap),
        deferred_results=JoinedResults(pieces, rows),
    )

"""Sweeps: one scene run at many values of its keys, a row of numbers for each.

Every row is a pure function of the task and its index, so it does not matter which process makes it, when, or in what
company. Trajectories are dropped as soon as their numbers are taken.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from governor_mechanism.engines import choose
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.scenes.parser import scene_from_document
from governor_mechanism.studies.sweep.batch_rows import DIMENSION, Rows, rows_together
from governor_mechanism.studies.sweep.checkpoint import SweepFiles
from governor_mechanism.studies.sweep.parameters import Axis, axes_of, scene_with
from governor_mechanism.studies.sweep.quantities import Quantity, Wanted, quantities_of
from governor_mechanism.studies.sweep.results import FAILED, REFUSED, Row, Sweep
from governor_mechanism.studies.sweep.workers import by_processes, interrupts_noted
from governor_mechanism.units.quantities import shown

__all__ = ["Row", "Sweep", "Task", "rows_of", "sweep"]

CHUNK_SECONDS = 0.5
"""So long a chunk of rows should take: what an interruption loses."""

MOST_IN_CHUNK = 512

Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True)
class Task:
    """All that rows are made from; it can be pickled. The last axis runs fastest."""

    document: Mapping[str, Any]
    axes: tuple[Axis, ...]
    quantities: tuple[Quantity, ...]
    engine: str
    accuracy: float | None
    certify: bool

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    def scene(self, index: int) -> Scene:
        """The scene of a row. Raises MechanismError where it cannot be made."""
        return scene_with(self.document, [(axis.key, axis.written[place]) for axis, place in self._places(index)])

    def dimensions(self, index: int) -> dict[str, Any]:
        """The dimensions of a row that differ from the scene's, in SI, where all its axes are of dimensions."""
        return {axis.key.removeprefix(DIMENSION): axis.values[place] for axis, place in self._places(index)}

    @cached_property
    def together(self) -> Rows | None:
        """What makes the rows with little ado, where they are of that kind."""
        if self.certify:
            return None
        return rows_together(self.document, self.axes, self.quantities, self.engine, self.accuracy)

    def _places(self, index: int) -> list[tuple[Axis, int]]:
        places = []
        for count in reversed(self.shape):
            index, place = divmod(index, count)
            places.append(place)
        return list(zip(self.axes, reversed(places), strict=True))


def rows_of(task: Task, indices: Sequence[int]) -> list[Row]:
    """The rows of these indices, in their order; none depends on which others are among them."""
    return [_row(task, index) for index in indices]


def sweep(
    scene: Scene,
    vary: Mapping[str, Any] | Sequence[str],
    quantities: Wanted = None,
    *,
    engine: str = "auto",
    accuracy: float | None = None,
    certify: bool = False,
    workers: int = 1,
    out: str | Path | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Run a scene at every combination of values; `gm.sweep` says what the arguments are."""
    task = _task(scene, vary, quantities, engine, accuracy, certify, workers)
    files = None if out is None else SweepFiles(Path(out), scene, task.quantities, task.axes, _settings(task))
    rows = {} if files is None else files.kept()
    total = math.prod(task.shape)
    pending = [index for index in range(total) if index not in rows]
    if files is not None and pending:
        files.open(rows.values())
    if progress is not None:
        progress(total - len(pending), total)
    try:
        with closing(_computed(task, pending, workers)) as chunks:
            for chunk in chunks:
                rows.update((row.index, row) for row in chunk)
                if files is not None:
                    files.add(chunk)
                if progress is not None:
                    progress(len(rows), total)
    finally:
        if files is not None:
            files.close()
    found = Sweep(
        title=scene.title,
        source=scene.source,
        axes=task.axes,
        quantities=task.quantities,
        accuracy=scene.run.accuracy if accuracy is None else accuracy,
        rows=tuple(rows[index] for index in range(total)),
    )
    if files is not None:
        files.finish(found)
    return found


def _task(
    scene: Scene, vary: Any, quantities: Wanted, engine: str, accuracy: float | None, certify: bool, workers: int
) -> Task:
    """The task; MechanismError with every mistake of the request."""
    problems: list[str] = []

    def tried(make: Callable[[], Any]) -> Any:
        try:
            return make()
        except MechanismError as error:
            problems.extend(error.problems)
            return ()

    document = tried(lambda: _document(scene))
    axes = tried(lambda: axes_of(document, vary)) if document else ()
    chosen = tried(lambda: quantities_of(scene, quantities, certify=certify))
    if not isinstance(engine, str):
        problems.append(f"a sweep takes the name of an engine; found {shown(engine)}")
    else:
        tried(lambda: choose(engine, scene))
    if accuracy is not None and not (isinstance(accuracy, int | float) and 0 < accuracy < 1):
        problems.append(f"accuracy must lie between 0 and 1; got {accuracy!r}")
    if not isinstance(workers, int) or isinstance(workers, bool) or workers < 1:
        problems.append(f"workers must be a whole number of at least 1; got {workers!r}")
    given = {"run.engine": engine != "auto", "run.accuracy": accuracy is not None}
    problems += [
        f"vary: {axis.key} changes nothing where one is given for all rows; leave that or this out"
        for axis in axes
        if given.get(axis.key)
    ]
    names = [axis.key for axis in axes]
    problems += [f"quantity {one.name!r} has the name of a key; choose another" for one in chosen if one.name in names]
    if problems:
        raise MechanismError(*problems)
    return Task(document=document, axes=axes, quantities=chosen, engine=engine, accuracy=accuracy, certify=certify)


def _document(scene: Scene) -> Mapping[str, Any]:
    """What the rows' scenes are read from; a scene that was changed since it was read may differ in its [run] alone."""
    if not scene.document:
        raise MechanismError("a sweep changes keys of a scene file, and this scene comes from none; load one")
    read = scene_from_document(scene.document, scene.source)
    if replace(read, run=scene.run, title=scene.title) != scene:
        raise MechanismError(
            "this scene was changed after it was read, and a sweep reads it anew for each row; change its document"
        )
    return scene.document if read.run == scene.run else {**scene.document, "run": asdict(scene.run)}


def _settings(task: Task) -> dict[str, Any]:
    return {
        "scene": dict(task.document),
        "axes": {axis.key: list(axis.written) for axis in task.axes},
        "quantities": {one.name: one.identity for one in task.quantities},
        "engine": task.engine,
        "accuracy": task.accuracy,
        "certify": task.certify,
    }


def _row(task: Task, index: int) -> Row:
    try:
        if task.together is not None:
            glimpse = task.together.glimpse(task.dimensions(index))
            if glimpse is not None:
                numbers = tuple(one.of(glimpse) for one in task.quantities)
                return Row(index=index, numbers=numbers, outcome=Outcome.UNCERTIFIED.name.lower(), message="")
        run = _run(task, task.scene(index))
        return _told(task, index, run)
    except GovernorMechanismError as error:
        return _empty(task, index, REFUSED, getattr(error, "problems", (str(error),)))
    except Exception as error:  # whatever one row meets, the others go on; the row tells it
        return _empty(task, index, FAILED, [f"{type(error).__name__}: {error}"])


def _run(task: Task, scene: Scene) -> Trajectory:
    chosen, reason = choose(scene.run.engine if task.engine == "auto" else task.engine, scene, task.accuracy)
    return chosen.run(scene, accuracy=task.accuracy, certify=task.certify, reason=reason)


def _told(task: Task, index: int, run: Trajectory) -> Row:
    """The numbers of a run; of one that ended early only how far it came, for its last value is not the final one."""
    outcome = run.outcome
    whole = outcome.ok or outcome.name == "ACCURACY_MISSED"
    numbers = tuple(
        one.of(run) if whole or (one.rule == "duration" and len(run.times)) else math.nan for one in task.quantities
    )
    message = "" if outcome.ok else " ".join(run.message.split())
    return Row(index=index, numbers=numbers, outcome=outcome.name.lower(), message=message)


def _empty(task: Task, index: int, outcome: str, problems: Sequence[str]) -> Row:
    message = " ".join("; ".join(problems).split())
    return Row(index=index, numbers=(math.nan,) * len(task.quantities), outcome=outcome, message=message)


class _Pace:
    """Indices in chunks that take about CHUNK_SECONDS, as the rows before them took."""

    def __init__(self, indices: Sequence[int], workers: int) -> None:
        self._indices = indices
        self._size = 1
        self._most = min(MOST_IN_CHUNK, max(len(indices) // (2 * workers), 1))

    def __iter__(self) -> Iterator[list[int]]:
        start = 0
        while start < len(self._indices):
            end = start + self._size
            yield list(self._indices[start:end])
            start = end

    def took(self, rows: int, seconds: float) -> None:
        """Learn from a chunk; at most four times the rows at once, for the first ones may not be like the others."""
        fitting = int(CHUNK_SECONDS * rows / max(seconds, 1e-9))
        self._size = max(1, min(fitting, 4 * rows, self._most))


def _computed(task: Task, indices: Sequence[int], workers: int) -> Generator[list[Row], None, None]:
    """Chunks of rows as they come, made here, or by processes."""
    pace = _Pace(indices, workers)
    alone = workers == 1 or len(indices) < 2
    made = _here(task, pace) if alone else by_processes(partial(_timed, task), pace, min(workers, len(indices)))
    for rows, seconds in made:
        pace.took(len(rows), seconds)
        yield rows


def _here(task: Task, pace: _Pace) -> Iterator[tuple[list[Row], float]]:
    """Made in this process; rows that a Ctrl-C has struck are no rows."""
    with interrupts_noted() as struck:
        for chunk in pace:
            made = _timed(task, chunk)
            if struck():
                raise KeyboardInterrupt
            yield made


def _timed(task: Task, indices: Sequence[int]) -> tuple[list[Row], float]:
    began = time.perf_counter()
    rows = rows_of(task, indices)
    return rows, time.perf_counter() - began

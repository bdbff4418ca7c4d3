"""Sweeps: one scene run at many values of its keys, one row of numbers each.

Each row is a pure function of the task and its index, whichever process computes it, and whenever. Trajectories are
dropped as soon as their numbers are taken.
"""

import math
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from governor_mechanism.engines import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.scenes.problems import ProblemCollector
from governor_mechanism.studies.sweep.batch_rows import DIMENSION_PREFIX, BatchedRows, make_batched_rows
from governor_mechanism.studies.sweep.checkpoint import RowWriter, SweepFiles
from governor_mechanism.studies.sweep.parameters import AxisGrid, parse_axes, parse_scene_with
from governor_mechanism.studies.sweep.quantities import QuantityRequest, RunQuantity, parse_quantities
from governor_mechanism.studies.sweep.results import ROW_FAILED, ROW_OK, ROW_REFUSED, Sweep, SweepRow
from governor_mechanism.studies.sweep.workers import map_in_processes, record_interrupts
from governor_mechanism.units.quantities import format_value

TARGET_CHUNK_TIME = 0.5
"""Target time of a chunk of rows, s; an interruption loses at most about as much."""

MAX_CHUNK_SIZE = 512
"""Maximum number of rows in a chunk."""

SweepProgress = Callable[[int, int], None]
"""Callback with the number of finished rows and of all rows."""


@dataclass(frozen=True, kw_only=True)
class SweepTask(AxisGrid):
    """Everything that determines the rows; it can be pickled."""

    document: Mapping[str, Any]
    quantities: tuple[RunQuantity, ...]
    engine: str
    accuracy: float | None
    certify: bool

    def build_scene(self, index: int) -> Scene:
        """Return the scene of a row; raise MechanismError if it is invalid."""
        return parse_scene_with(self.document, [(axis.key, axis.document_values[place]) for axis, place in self.places(index)])

    def changed_dimensions(self, index: int) -> dict[str, Any]:
        """Return the dimensions of a row that differ from the scene's, SI, if all axes are dimensions."""
        return {axis.key.removeprefix(DIMENSION_PREFIX): axis.values[place] for axis, place in self.places(index)}

    @cached_property
    def batched_rows(self) -> BatchedRows | None:
        """Fast path for the rows, or None if it does not apply."""
        if self.certify:
            return None
        return make_batched_rows(self.document, self.axes, self.quantities, self.engine, self.accuracy)


def compute_rows(task: SweepTask, indices: Sequence[int]) -> list[SweepRow]:
    """Return the rows of these indices in their order; no row depends on another."""
    return [_compute_row(task, index) for index in indices]


def sweep(
    scene: Scene,
    vary: Mapping[str, Any] | Sequence[str],
    quantities: QuantityRequest = None,
    *,
    engine: str = "auto",
    accuracy: float | None = None,
    certify: bool = False,
    workers: int = 1,
    out: str | Path | None = None,
    progress: SweepProgress | None = None,
) -> Sweep:
    """Run a scene at every combination of values of its keys.

    Raises MechanismError with a message for each mistake of the request, or if `out` holds another sweep.

    Parameters
    ----------
    scene
        Scene with its document, as loaded from a file.
    vary
        Axes, "key=first:last:count" or "key=value,value", or a mapping of keys to lists of values.
    quantities
        Numbers to take from each run; None requests final, least and greatest value of the leading coordinate.
    engine
        Name of the engine of all rows, or "auto".
    accuracy
        Relative accuracy of all rows; None keeps the scene's.
    certify
        Whether to estimate the error of every run.
    workers
        Number of processes; the result does not depend on it.
    out
        Folder for journal, table and record; an interrupted sweep continues from there. None writes nothing.
    progress
        Callback with the number of finished rows and of all rows.

    Returns
    -------
    Sweep
        Rows and axes.
    """
    task = _make_task(scene, vary, quantities, engine, accuracy, certify, workers)
    files = None if out is None else SweepFiles(Path(out), scene.source, task, _task_settings(task))
    rows = {} if files is None else files.read_finished_rows()
    n_rows = math.prod(task.shape)
    pending = [index for index in range(n_rows) if index not in rows]
    journal: AbstractContextManager[RowWriter] = nullcontext(lambda rows: None)
    if files is not None and pending:
        journal = files.open_journal(rows.values())
    report_progress = progress or (lambda n_done, n_rows: None)
    report_progress(n_rows - len(pending), n_rows)
    with journal as append_rows, closing(_compute_chunks(task, pending, workers)) as chunks:
        for chunk in chunks:
            rows.update((row.index, row) for row in chunk)
            append_rows(chunk)
            report_progress(len(rows), n_rows)
    result = Sweep(
        title=scene.title,
        source=scene.source,
        axes=task.axes,
        quantities=task.quantities,
        accuracy=scene.run.accuracy if accuracy is None else accuracy,
        rows=tuple(rows[index] for index in range(n_rows)),
    )
    if files is not None:
        files.write_results(result)
    return result


def _make_task(
    scene: Scene, vary: Any, quantities: QuantityRequest, engine: str, accuracy: float | None, certify: bool, workers: int
) -> SweepTask:
    """Return the task; raise MechanismError with all mistakes of the request."""
    collector = ProblemCollector()
    document = collector.attempt("", _require_unchanged_document, scene) or {}
    axes = (collector.attempt("", parse_axes, document, vary) if document else None) or ()
    parsed_quantities = collector.attempt("", partial(parse_quantities, certify=certify), scene, quantities) or ()
    with collector.at(""):
        if not isinstance(engine, str):
            raise MechanismError(f"engine must be the name of an engine; found {format_value(engine)}")
        select_engine(engine, scene)
    problems: list[str] = [*collector.problems]
    if accuracy is not None and not (isinstance(accuracy, int | float) and 0 < accuracy < 1):
        problems.append(f"accuracy must lie between 0 and 1; got {accuracy!r}")
    if not isinstance(workers, int) or isinstance(workers, bool) or workers < 1:
        problems.append(f"workers must be a whole number of at least 1; got {workers!r}")
    given_for_all = {"run.engine": engine != "auto", "run.accuracy": accuracy is not None}
    problems += [
        f"vary: {axis.key} has no effect if it is also given for all rows; leave one of the two out"
        for axis in axes
        if given_for_all.get(axis.key)
    ]
    names = [axis.key for axis in axes]
    problems += [
        f"quantity {one.name!r} has the name of a varied key; choose another name" for one in parsed_quantities if one.name in names
    ]
    if problems:
        raise MechanismError(*problems)
    return SweepTask(document=document, axes=axes, quantities=parsed_quantities, engine=engine, accuracy=accuracy, certify=certify)


def _require_unchanged_document(scene: Scene) -> Mapping[str, Any]:
    """Return the document of the rows; the scene may differ from it only in its [run]."""
    if not scene.document:
        raise MechanismError("a sweep varies keys of a scene file, but this scene was not loaded from a file; load one")
    parsed_scene = parse_scene_document(scene.document, scene.source)
    if replace(parsed_scene, run=scene.run, title=scene.title) != scene:
        raise MechanismError("this scene was changed after loading, but a sweep parses its document for each row; change the document")
    return scene.document if parsed_scene.run == scene.run else {**scene.document, "run": asdict(scene.run)}


def _task_settings(task: SweepTask) -> dict[str, Any]:
    return {
        "scene": task.document,
        "axes": {axis.key: axis.document_values for axis in task.axes},
        "quantities": {one.name: one.identity for one in task.quantities},
        "engine": task.engine,
        "accuracy": task.accuracy,
        "certify": task.certify,
    }


def _compute_row(task: SweepTask, index: int) -> SweepRow:
    try:
        if task.batched_rows is not None:
            uncertified_result = task.batched_rows.run_uncertified(task.changed_dimensions(index))
            if uncertified_result is not None:
                numbers = tuple(one.evaluate(uncertified_result) for one in task.quantities)
                return SweepRow(index=index, numbers=numbers, outcome=ROW_OK)
        scene = task.build_scene(index)
        chosen_engine, reason = select_engine(scene.run.engine if task.engine == "auto" else task.engine, scene, task.accuracy)
        return _make_row(task, index, chosen_engine.run(scene, accuracy=task.accuracy, certify=task.certify, reason=reason))
    except GovernorMechanismError as error:
        return _make_failed_row(task, index, ROW_REFUSED, getattr(error, "problems", (str(error),)))
    except Exception as error:  # an error of one row is stored in that row; the others continue
        return _make_failed_row(task, index, ROW_FAILED, [f"{type(error).__name__}: {error}"])


def _make_row(task: SweepTask, index: int, run: Trajectory) -> SweepRow:
    """Return the numbers of a run; a run that ended early has only its duration, because its last value is not the final one."""
    outcome = run.outcome
    has_final_values = outcome.ok or outcome.name == "ACCURACY_MISSED"
    numbers = tuple(
        one.evaluate(run) if has_final_values or (one.rule == "duration" and len(run.times)) else math.nan for one in task.quantities
    )
    message = "" if outcome.ok else " ".join(run.message.split())
    name = ROW_OK if outcome is Outcome.NOT_CERTIFIED else outcome.name.lower()
    return SweepRow(index=index, numbers=numbers, outcome=name, message=message)


def _make_failed_row(task: SweepTask, index: int, outcome: str, problems: Sequence[str]) -> SweepRow:
    message = " ".join("; ".join(problems).split())
    return SweepRow(index=index, numbers=(math.nan,) * len(task.quantities), outcome=outcome, message=message)


class _ChunkScheduler:
    """Iterator over chunks of indices that take about TARGET_CHUNK_TIME each, estimated from the rows before."""

    def __init__(self, indices: Sequence[int], workers: int) -> None:
        self._indices = indices
        self._size = 1
        self._max_size = min(MAX_CHUNK_SIZE, max(len(indices) // (2 * workers), 1))

    def __iter__(self) -> Iterator[list[int]]:
        start = 0
        while start < len(self._indices):
            end = start + self._size
            yield list(self._indices[start:end])
            start = end

    def record_chunk_time(self, n_rows: int, duration: float) -> None:
        """Adapt the chunk size; it grows at most fourfold, because the first rows may not be typical."""
        fitting_size = int(TARGET_CHUNK_TIME * n_rows / max(duration, 1e-9))
        self._size = max(1, min(fitting_size, 4 * n_rows, self._max_size))


def _compute_chunks(task: SweepTask, indices: Sequence[int], workers: int) -> Generator[list[SweepRow], None, None]:
    """Yield chunks of rows as they are finished, computed in this process or in several."""
    scheduler = _ChunkScheduler(indices, workers)
    is_serial = workers == 1 or len(indices) < 2
    timed_chunks = (
        _compute_in_process(task, scheduler)
        if is_serial
        else map_in_processes(partial(_compute_rows_timed, task), scheduler, min(workers, len(indices)))
    )
    for rows, duration in timed_chunks:
        scheduler.record_chunk_time(len(rows), duration)
        yield rows


def _compute_in_process(task: SweepTask, scheduler: _ChunkScheduler) -> Iterator[tuple[list[SweepRow], float]]:
    """Yield chunks computed in this process; an interrupted chunk is dropped."""
    with record_interrupts() as was_interrupted:
        for chunk in scheduler:
            timed_chunk = _compute_rows_timed(task, chunk)
            if was_interrupted():
                raise KeyboardInterrupt
            yield timed_chunk


def _compute_rows_timed(task: SweepTask, indices: Sequence[int]) -> tuple[list[SweepRow], float]:
    start_time = time.perf_counter()
    rows = compute_rows(task, indices)
    return rows, time.perf_counter() - start_time

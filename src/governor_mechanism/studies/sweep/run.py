"""Sweeps: one scene run at many values of its keys, one row of numbers each.

Each row is a pure function of the task and its index, whichever process computes it, and whenever. Trajectories are
dropped as soon as their numbers are taken. On disk a sweep is a journal of finished rows while it runs, and at its end a table (CSV) and a
record (JSON). The first line of the journal identifies the sweep, and so does the record: a sweep never continues another one.
"""

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.files.results import package_versions
from governor_mechanism.files.writing import atomic_write, plain_value, save_json
from governor_mechanism.model.joints import RotationalDriver
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.part import EQUILIBRIUM, Spindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.equilibria import has_damping
from governor_mechanism.studies.sweep.parameters import AxisGrid, SweepAxis, parse_axes
from governor_mechanism.studies.sweep.quantities import QuantityRequest, RunQuantity, find_reading_units, parse_quantities
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.studies.sweep.rows import ROW_FAILED, ROW_OK, ROW_REFUSED, SweepRow, SweepRows
from governor_mechanism.studies.sweep.rules import DURATION_RULE, SETTLING_FRACTION, VALVE_RULES, MissingNumberError, RunNumbers
from governor_mechanism.studies.sweep.workers import RowComputer, find_computer_problems
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import format_value

DISTRIBUTION_NAME = "governor-mechanism"

SETTING_LABELS = {"scene": "scene", "axes": "values of the keys", "quantities": "quantities", "package": "version of the package"}
"""Names in messages of the settings that distinguish two sweeps."""

RowWriter = Callable[[Sequence[SweepRow]], None]
"""Function that stores rows."""


def journal_path(
    folder: Path,
    source: str,  # path of the scene file; empty for a scene without a file
) -> Path:
    """Return the path of the journal of a sweep, which exists while the sweep runs."""
    return folder / f"{Path(source).stem or 'scene'}_sweep.part"


class SweepFiles:
    """Files of one sweep in a folder, which is created. Raises MechanismError if the folder holds another sweep."""

    def __init__(self, folder: Path, source: str, grid: AxisGrid, settings: Mapping[str, Any]) -> None:
        if folder.exists() and not folder.is_dir():
            raise MechanismError(f"out: {folder} is a file; give the name of a folder")
        folder.mkdir(parents=True, exist_ok=True)
        self._journal_path = journal_path(folder, source)
        self._table_path = self._journal_path.with_suffix(".csv")
        self._record_path = self._journal_path.with_suffix(".json")
        # In the types of JSON: the identity is compared with one read from a file.
        self._identity: dict[str, Any] = plain_value({"package": package_versions()[DISTRIBUTION_NAME], **settings})
        self._n_quantities, self._n_axes, self._n_rows = len(settings["quantities"]), len(grid.axes), math.prod(grid.shape)
        self._refuse_other_sweep()

    def read_finished_rows(self) -> SweepRows:
        """Return the rows of the sweep, with those that are on disk."""
        rows = SweepRows(self._n_rows, self._n_quantities)
        if self._record_path.exists() and self._table_path.exists():
            with self._table_path.open(newline="", encoding="utf-8") as stream:
                lines = islice(csv.reader(stream), 1, None)
                rows.add(self._parse_rows([index, line[self._n_axes : -2], *line[-2:]] for index, line in enumerate(lines)))
            if rows.is_computed.all():
                return rows
            rows = SweepRows(self._n_rows, self._n_quantities)
        if self._journal_path.exists():
            with self._journal_path.open(encoding="utf-8") as stream:
                rows.add(self._parse_rows(map(_parse_json, islice(stream, 1, None))))
        return rows

    def _parse_rows(self, records: Iterable[Any]) -> Iterator[SweepRow]:
        """Yield the rows of records of index, numbers, outcome and message, without incomplete records, as of a half-written line."""
        for record in records:
            with suppress(ValueError, TypeError):
                index, cells, outcome, message = record
                numbers = tuple(math.nan if cell in (None, "") else float(cell) for cell in cells)
                if len(numbers) == self._n_quantities and 0 <= index < self._n_rows:
                    yield SweepRow(index=index, numbers=numbers, outcome=outcome, message=message)

    @contextmanager
    def open_journal(self, rows: SweepRows) -> Iterator[RowWriter]:
        """Rewrite the journal with the rows computed so far, without a half-written last line; yield a function that appends rows."""
        with atomic_write(self._journal_path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(json.dumps({"sweep": self._identity}) + "\n")
            stream.writelines(_format_journal_line(rows[index]) for index in np.flatnonzero(rows.is_computed).tolist())
        with self._journal_path.open("a", encoding="utf-8", newline="\n") as stream:

            def append_rows(new_rows: Sequence[SweepRow]) -> None:
                stream.write("".join(map(_format_journal_line, new_rows)))
                stream.flush()

            yield append_rows

    def write_results(self, sweep: Sweep) -> None:
        """Write table and record and delete the journal. The same sweep always gives the same files."""
        sweep.save_csv(self._table_path)
        summary = {"title": sweep.title, "units": sweep.units, "outcomes": sweep.outcomes, "notes": sweep.notes}
        save_json({"sweep": self._identity, **summary}, self._record_path)
        self._journal_path.unlink(missing_ok=True)

    def _refuse_other_sweep(self) -> None:
        hint = "choose another folder, or move the file"
        for path in (self._record_path, self._journal_path):
            if not path.exists():
                continue
            identity = _read_identity(path)
            if identity is None:
                raise MechanismError(f"out: {path} exists and is not the file of a sweep; {hint}")
            differing_settings = [SETTING_LABELS.get(key, key) for key in self._identity if identity.get(key) != self._identity[key]]
            if differing_settings:
                raise MechanismError(f"out: {path} belongs to another sweep (different {', '.join(differing_settings)}); {hint}")
        if self._table_path.exists() and not (self._record_path.exists() or self._journal_path.exists()):
            raise MechanismError(f"out: {self._table_path} exists, but the record of its sweep is missing; {hint}")


def count_journal_rows(path: Path) -> int:
    """Return the number of finished rows in a journal: complete lines after the one that identifies the sweep."""
    with path.open("rb") as journal:
        return max(sum(line.endswith(b"\n") for line in journal) - 1, 0)


def _read_identity(path: Path) -> Mapping[str, Any] | None:
    with path.open(encoding="utf-8", errors="replace") as stream:
        text = stream.readline() if path.suffix == ".part" else stream.read()
    record = _parse_json(text)
    identity = record.get("sweep") if isinstance(record, Mapping) else None
    return identity if isinstance(identity, Mapping) else None


def _parse_json(text: str) -> Any:
    """Return the value of a JSON text, or None if it is incomplete."""
    with suppress(ValueError):
        return json.loads(text)
    return None


def _format_journal_line(row: SweepRow) -> str:
    """Return a row as a line; JSON writes the shortest digits that give the same float."""
    return json.dumps([row.index, row.numbers_or_none, row.outcome, row.message]) + "\n"


SLIP_READING = "die_slip"
"""Reading whose range over a run is the slip of a die block."""

TRIAL_ACCURACY = 1e-3
"""Accuracy of the run that shows whether a crank turns."""


def choose_quantities(
    scene: Scene,  # the scene as it is before a key is varied
) -> tuple[list[str], str]:
    """Return the names of the quantities that characterise the motion of a scene, and the reason for them."""
    readings = find_reading_units(scene)
    if has_valve_events(scene):
        slip = [f"span {SLIP_READING}"] if SLIP_READING in readings else []
        return [*VALVE_RULES, *slip], "a turning crank drives a valve"
    if scene.mechanism.stall_limits:
        return ["mean speed", "speed fluctuation"], "gas drives the crank of an engine"
    leading = next((name for name in _leading_readings(scene) if name in readings), None)
    if leading is None:
        return [DURATION_RULE], "the scene has no reading"
    if not scene.start.values and scene.mechanism.count_drivers():
        return [f"span {leading}", f"max rate of {leading}"], "drivers prescribe the whole motion"
    return _choose_of_free_motion(scene, leading)


def _choose_of_free_motion(scene: Scene, leading: str) -> tuple[list[str], str]:
    """Return quantities of the leading reading of a scene that moves freely, and the reason."""
    spindles = [part.spindle for part in scene.parts if part.turns and isinstance(part.spindle, Spindle)]
    if any(spindle.speed_fluctuation for spindle in spindles):
        return [f"mean {leading}", f"amplitude of {leading}"], "the speed of the spindle fluctuates"
    is_damped = has_damping(scene) or any(isinstance(effect, DryFriction) for effect in scene.output_effects)
    last_change = max((spindle.times[-1] for spindle in spindles), default=0.0)
    if last_change > (1.0 - SETTLING_FRACTION) * scene.run.duration:
        return [f"min {leading}", f"max {leading}"], "the speed of the spindle changes until the run ends"
    if is_damped:
        return [f"settled {leading}"], "friction or dashpots damp the motion"
    if any(len(spindle.times) > 1 for spindle in spindles):
        return [f"min {leading}", f"max {leading}"], "the speed of the spindle changes, and nothing damps the motion"
    if EQUILIBRIUM in scene.start.values.values():
        return [f"settled {leading}"], "the motion starts in equilibrium"
    if _turns_fully(scene, leading):
        return [f"mean speed of {leading}", f"speed fluctuation of {leading}"], "a crank turns"
    return [f"mean {leading}", f"amplitude of {leading}", f"frequency of {leading}"], "nothing damps the motion"


def _leading_readings(scene: Scene) -> list[str]:
    """Return the readings, the leading one first: of a governor its coordinate, of a driven mechanism what is not the driver's angle."""
    if len(scene.parts) > 1:
        # Governors turn with a spindle; they come first.
        parts = sorted(scene.parts, key=lambda part: not part.turns)
        return [f"{part.name}.{part.mechanism.coordinate}" for part in parts]
    mechanism = scene.part.mechanism
    names = [mechanism.coordinate, *(reading.name for reading in mechanism.readings)]
    driven_bodies = {joint.second.body for joint in mechanism.joints if isinstance(joint, RotationalDriver)}
    driven = [one.name for one in mechanism.readings if isinstance(one, BodyAngle) and one.body in driven_bodies]
    return sorted(names, key=lambda name: name in driven)


def _turns_fully(scene: Scene, reading: str) -> bool:
    """Return whether a reading of a mechanism in a fixed plane is an angle that makes a whole turn in a run of the scene."""
    part, own_name = scene.part_of(reading)
    if part.turns or part.mechanism.reading(own_name).quantity != "angle":
        return False
    try:
        engine, reason = select_engine(scene.run.engine, scene, TRIAL_ACCURACY)
        angles = engine.run(scene, accuracy=TRIAL_ACCURACY, certify=False, reason=reason).readings[reading]
    except GovernorMechanismError:  # its rows say why it cannot run
        return False
    return len(angles) > 1 and abs(float(angles[-1] - angles[0])) >= math.tau


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
    reason_of_choice: str = ""

    @property
    def settings(self) -> dict[str, Any]:
        """What distinguishes the sweep from others, in types that JSON knows."""
        axes = {axis.key: axis.document_values for axis in self.axes}
        quantities = {one.name: one.identity for one in self.quantities}
        options = {name: getattr(self, name) for name in ("engine", "accuracy", "certify")}
        return {"scene": self.document, "axes": axes, "quantities": quantities, **options}

    def run(self, index: int) -> Trajectory:
        """Return the run of a row; raise MechanismError if its scene is invalid."""
        scene = parse_scene_with(self.document, [(axis.key, axis.document_values[place]) for axis, place in self.places(index)])
        chosen_engine, reason = select_engine(scene.run.engine if self.engine == "auto" else self.engine, scene, self.accuracy)
        return chosen_engine.run(scene, accuracy=self.accuracy, certify=self.certify, reason=reason)


def make_task(
    scene: Scene,
    vary: Any,  # axes, "key=first:last:count" or "key=value,value", or a mapping of keys to lists of values
    # numbers to take from each run; None requests those that characterise the motion of the scene
    quantities: QuantityRequest,
    engine: str,
    accuracy: float | None,  # relative accuracy of all rows; None keeps the scene's
    certify: bool,
    workers: int,
    cluster: Any,
) -> SweepTask:
    """Return the task of a sweep of a scene at every combination of values of its keys."""
    collector = ProblemCollector()
    document = collector.attempt("", _require_unchanged_document, scene) or {}
    axes = (collector.attempt("", parse_axes, document, vary) if document else None) or ()
    chosen_names, reason_of_choice = (None, "") if quantities is not None else choose_quantities(_scene_of_last_row(scene, axes))
    requested = chosen_names if quantities is None else quantities
    parsed_quantities = collector.attempt("", partial(parse_quantities, certify=certify), scene, requested, accuracy) or ()
    with collector.at(""):
        select_engine(engine, scene)
    problems: list[str] = [*collector.problems]
    if accuracy is not None and not (isinstance(accuracy, int | float) and 0 < accuracy < 1):
        problems.append(f"accuracy must lie between 0 and 1; got {format_value(accuracy)}")
    problems += find_computer_problems(workers, cluster)
    given_for_all = {"run.engine": engine != "auto", "run.accuracy": accuracy is not None}
    keys = [axis.key for axis in axes]
    reason = "has no effect if it is also given for all rows; leave one of the two out"
    problems += [f"vary: {key} {reason}" for key in keys if given_for_all.get(key)]
    clashes = [one.name for one in parsed_quantities if one.name in keys]
    problems += [f"quantity {name!r} has the name of a varied key; choose another name" for name in clashes]
    if problems:
        raise MechanismError(*problems)
    options: dict[str, Any] = {"engine": engine, "accuracy": accuracy, "certify": certify, "reason_of_choice": reason_of_choice}
    return SweepTask(document=document, axes=axes, quantities=parsed_quantities, **options)


def _scene_of_last_row(scene: Scene, axes: Sequence[SweepAxis]) -> Scene:
    """Return the scene of the last row, whose effects the quantities must suit; the scene itself if that row has none."""
    try:
        return parse_scene_with(scene.document, [(axis.key, axis.document_values[-1]) for axis in axes]) if axes else scene
    except MechanismError:
        return scene


def run_sweep(
    scene: Scene,
    task: SweepTask,
    # function that computes rows here or elsewhere; the rows do not depend on where
    compute: RowComputer[SweepRow],
    # folder for journal, table and record; an interrupted sweep continues from there. None writes nothing
    out: str | Path | None,
    progress: SweepProgress | None,  # callback with the number of finished rows and of all rows
) -> Sweep:
    """Run all rows of a task that are not on disk yet; raise MechanismError if `out` holds another sweep."""
    files = None if out is None else SweepFiles(Path(out), scene.source, task, task.settings)
    rows = SweepRows(math.prod(task.shape), len(task.quantities)) if files is None else files.read_finished_rows()
    _compute_missing_rows(rows, task, compute, files, progress or (lambda n_done, n_rows: None))
    tolerance = scene.run.accuracy if task.accuracy is None else task.accuracy
    columns: dict[str, Any] = {"quantities": task.quantities, "reason_of_choice": task.reason_of_choice}
    result = Sweep(title=scene.title, source=scene.source, axes=task.axes, accuracy=tolerance, rows=rows, **columns)
    if files is not None:
        files.write_results(result)
    return result


def _compute_missing_rows(
    rows: SweepRows, task: SweepTask, compute: RowComputer[SweepRow], files: SweepFiles | None, progress: SweepProgress
) -> None:
    """Add the rows that are not computed yet, and write each to the journal of the files, if there are any."""
    missing = np.flatnonzero(~rows.is_computed).tolist()
    n_done = len(rows) - len(missing)
    progress(n_done, len(rows))
    if not missing:
        return
    journal: AbstractContextManager[RowWriter] = nullcontext(lambda rows: None) if files is None else files.open_journal(rows)
    with journal as append_rows, closing(compute(partial(compute_row, task), missing)) as computed:
        for new_rows in computed:
            rows.add(new_rows)
            append_rows(new_rows)
            n_done += len(new_rows)
            progress(n_done, len(rows))


def _require_unchanged_document(scene: Scene) -> Mapping[str, Any]:
    """Return the document of the rows; the scene may differ from it only in its [run]."""
    if not scene.document:
        raise MechanismError("a sweep varies keys of a scene file, but this scene was not loaded from a file; load one")
    parsed_scene = parse_scene_document(scene.document, scene.source)
    if replace(parsed_scene, run=scene.run, title=scene.title) != scene:
        raise MechanismError("this scene was changed after loading, but a sweep parses its document for each row; change the document")
    return scene.document if parsed_scene.run == scene.run else {**scene.document, "run": asdict(scene.run)}


def compute_row(task: SweepTask, index: int) -> SweepRow:
    """Return a row, which depends on no other row."""
    numbers: tuple[float, ...] = (math.nan,) * len(task.quantities)
    try:
        numbers, outcome, message = _compute_numbers(task, task.run(index))
    except GovernorMechanismError as error:
        outcome = ROW_REFUSED
        message = "; ".join(getattr(error, "problems", (str(error),)))
    except Exception as error:  # an error of one row is stored in that row; the others continue
        outcome, message = ROW_FAILED, f"{type(error).__name__}: {error}"
    return SweepRow(index=index, numbers=numbers, outcome=outcome, message=" ".join(message.split()))


def _compute_numbers(task: SweepTask, run: Trajectory) -> tuple[tuple[float, ...], str, str]:
    """Return numbers, outcome and message of a run; one that ended early has only its duration: its last value is not the final one."""
    has_final_values = run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED
    outcome = ROW_OK if run.outcome is Outcome.NOT_CERTIFIED else run.outcome.name.lower()
    numbers = list[float]()
    missing = list[MissingNumberError]()
    shared = RunNumbers(run)
    for quantity in task.quantities:
        number = math.nan
        if has_final_values or (quantity.rule == DURATION_RULE and len(run.times)):
            try:
                number = quantity.evaluate(shared)
            except MissingNumberError as reason:
                missing.append(reason)
        numbers.append(number)
    if run.outcome.ok and missing:
        return tuple(numbers), missing[0].outcome, "; ".join(dict.fromkeys(map(str, missing)))
    return tuple(numbers), outcome, "" if run.outcome.ok else run.message

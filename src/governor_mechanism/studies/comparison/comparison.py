"""Comparison of several scenes: one table of statics and readings, the runs, and the curves for a figure."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from governor_mechanism.engines import select_engine
from governor_mechanism.engines.base import Engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import finite_or_none, plain_record
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.files.results import summarise_run
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.comparison.motion import find_shared_readings
from governor_mechanism.studies.comparison.rows import ComparedReading, reading_rows, run_rows, static_rows
from governor_mechanism.studies.comparison.statics import GovernorStatics, StaticsQuestion, evaluate_statics
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

MAX_SCENES = 6
"""Largest number of scenes: more columns and more films side by side are wider than a screen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison(PrintedResult):
    """Several scenes side by side.

    Attributes
    ----------
    names
        Short names of the scenes, no two alike.
    runs
        Their runs.
    statics
        Statics of each governor, or the reason why there are none.
    shared_readings
        Readings that at least two runs have, by plain name, with the full name in each run.
    rows
        The table.
    """

    names: tuple[str, ...]
    runs: tuple[Trajectory, ...]
    statics: tuple[GovernorStatics | str, ...]
    shared_readings: Mapping[str, tuple[str | None, ...]]
    rows: tuple[ComparedReading, ...]

    __repr__ = short_repr

    @property
    def title(self) -> str:
        """The names, as "porter vs watt"."""
        return " vs ".join(self.names)

    @property
    def governors(self) -> tuple[tuple[int, GovernorStatics], ...]:
        """Position and statics of the scenes that have statics."""
        return tuple((k, one) for k, one in enumerate(self.statics) if isinstance(one, GovernorStatics))

    @property
    def notes(self) -> tuple[str, ...]:
        """Why something is missing, and which runs ended early, one sentence each."""
        return tuple(_notes(self))

    def value(self, quantity: str, name: str) -> float | str | None:
        """Return a cell of the table.

        Parameters
        ----------
        quantity
            Quantity of the row.
        name
            Name of the scene.

        Returns
        -------
        float | str | None
            Value in SI; None if the scene has none.

        Raises
        ------
        MechanismError
            If there is no such row or scene.
        """
        rows = {row.quantity: row.values for row in self.rows}
        if quantity not in rows:
            raise MechanismError(f"the comparison has no quantity {quantity!r}; it has {', '.join(rows)}")
        if name not in self.names:
            raise MechanismError(f"the comparison has no scene {name!r}; it has {', '.join(self.names)}")
        return rows[quantity][self.names.index(name)]

    def __str__(self) -> str:
        """Return title, table and notes."""
        table = format_table(("", *self.names), [row.cells for row in self.rows], "lr")
        return "\n".join([self.title, "", table, *(["", *self.notes] if self.notes else [])])

    def as_json(self) -> dict[str, Any]:
        """Return names, rows in SI, notes and the record of each run."""
        rows = [
            plain_record(row, values=[finite_or_none(value) if isinstance(value, float) else value for value in row.values])
            for row in self.rows
        ]
        records = {name: summarise_run(run) for name, run in zip(self.names, self.runs, strict=True)}
        return {"title": self.title, "names": list(self.names), "rows": rows, "notes": list(self.notes), "runs": records}


def compare_scenes(
    scenes: Sequence[Scene],
    question: StaticsQuestion,
    *,
    engine: str | Engine = "auto",  # name of an engine, or an engine; "auto" takes that of each scene
    accuracy: float | None = None,  # accuracy of all runs; that of each scene if None
) -> Comparison:
    """Run several scenes and set their statics and readings side by side.

    Raises MechanismError if there are too few or too many scenes, or a resistance or working range that none
    of them can take.
    """
    if not 2 <= len(scenes) <= MAX_SCENES:
        raise MechanismError(f"a comparison needs 2 to {MAX_SCENES} scenes; got {len(scenes)}")
    names = _short_names(scenes)
    runs = tuple(_run(scene, engine, accuracy) for scene in scenes)
    statics = tuple(evaluate_statics(run, question) for run in runs)
    _require_answers(question, [one for one in statics if isinstance(one, GovernorStatics)])
    shared = find_shared_readings(runs)
    rows = [*static_rows(statics), *run_rows(runs), *reading_rows(runs, shared)]
    return Comparison(names=names, runs=runs, statics=statics, shared_readings=shared, rows=tuple(rows))


def _require_answers(question: StaticsQuestion, governors: Sequence[GovernorStatics]) -> None:
    """Raise MechanismError if a resistance or a working range is given that no scene can take: what one takes, others may lack."""
    if question.resistance is not None and all(one.curve.insensitivity_band is None for one in governors):
        raise MechanismError(
            f"the resistance acts along the reading {question.against!r}, and no governor here has it; give another reading"
        )
    if question.between is not None and all(one.controlling_force is None for one in governors):
        reason = next((note for one in governors for note in one.notes), "no scene is a governor")
        raise MechanismError(f"the working range holds for none of the scenes: {reason}")


def _run(scene: Scene, engine: str | Engine, accuracy: float | None) -> Trajectory:
    name = scene.run.engine if isinstance(engine, str) and engine == "auto" else engine
    selected, reason = select_engine(name, scene, accuracy)
    return selected.run(scene, accuracy=accuracy, reason=reason)


def _short_names(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """Return the names of the scene files, or the titles of scenes without one, with a number where they repeat."""
    names: list[str] = []
    for scene in scenes:
        base = Path(scene.source).stem or scene.title
        names.append(next(name for k in range(1, len(scenes) + 1) if (name := base if k == 1 else f"{base} ({k})") not in names))
    return tuple(names)


def _notes(comparison: Comparison) -> Iterator[str]:
    for name, run, statics in zip(comparison.names, comparison.runs, comparison.statics, strict=True):
        if not run.outcome.ok:
            yield f"{name}: {run.message}"
        reasons = (f"no statics: {statics}",) if isinstance(statics, str) else statics.notes
        for reason in reasons:
            yield f"{name}: {reason}"
    if not comparison.shared_readings:
        yield "the scenes have no reading in common, so that no values of a run stand beside each other"

"""Comparison of several scenes: one table of statics and readings, the runs, and the curves for a figure."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Unpack

import numpy as np

from governor_mechanism.engines import select_engine
from governor_mechanism.engines.base import Engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import finite_or_none
from governor_mechanism.model.results.pictures import Film, FilmKeywords
from governor_mechanism.model.results.result import Column, Result, format_columns, item_column
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.equilibrium_speed import WorkingRange
from governor_mechanism.studies.compared_quantities import (
    GovernorStatics,
    StaticsQuestion,
    evaluate_statics,
    find_shared_readings,
    leading_reading,
    settling_time,
)
from governor_mechanism.units.quantities import format_quantity, format_reading_name
from governor_mechanism.units.text_table import short_repr

NEGLIGIBLE_POSITION = 1e-9
"""Length or angle that is shown as zero, m or rad: rounding of positions of machines of some metres, with room."""


@dataclass(frozen=True, kw_only=True)
class ComparedReading:
    """A row of the table: quantity, SI unit, and one value for each scene; None where a scene has none."""

    quantity: str
    unit: str
    values: tuple[float | str | None, ...]

    def format_value(self, k: int) -> str:
        """Return the value of a scene as text, in customary units."""
        value = self.values[k]
        if value is None:
            return "-"
        if isinstance(value, str):
            return value
        if self.unit == "ratio":
            return f"{100 * value:.4g} %"
        is_zero = self.unit in ("m", "rad") and abs(value) < NEGLIGIBLE_POSITION
        return format_quantity(0.0 if is_zero else value, self.unit, ".5g")


def static_rows(
    statics: Sequence[GovernorStatics | str],  # statics of each scene, or the reason why it has none
) -> Iterator[ComparedReading]:
    """Yield the rows of statics that at least one scene has."""
    columns = [dict(_static_values(one)) if isinstance(one, GovernorStatics) else {} for one in statics]
    quantities = dict.fromkeys(key for column in columns for key in column)
    for quantity, unit in sorted(quantities, key=lambda key: _STATIC_ORDER.index(key[0])):
        yield ComparedReading(quantity=quantity, unit=unit, values=tuple(column.get((quantity, unit)) for column in columns))


_STATIC_ORDER = (
    "speed of the spindle",
    "sleeve in equilibrium at it",
    "equilibrium",
    "natural frequency there",
    "damping ratio there",
    "effort there, for 1 % of speed",
    "sleeve moves for 1 % of speed by",
    "insensitivity there",
    "jumps at",
    "working range of",
    "working range from",
    "working range to",
    "speed of rest, inner end",
    "speed of rest, outer end",
    "sensitiveness",
    "work capacity",
)
"""Quantities of statics in the order of the table."""


_RANGE_NAMES = {"values": "given values", "stops": "the stops", "travel": "the travel", "run": "the run"}
"""What limits a working range, in the table."""


def _static_values(statics: GovernorStatics) -> Iterator[tuple[tuple[str, str], float | str | None]]:
    """Yield the values of statics of one governor, by quantity and unit."""
    yield ("speed of the spindle", "rad/s"), statics.spindle_speed
    place = statics.equilibrium
    mode = statics.mode
    force = statics.at_equilibrium
    if place is not None:
        lift = place.readings.get("sleeve_lift")
        yield ("sleeve in equilibrium at it", "m"), lift
        state = "astatic" if place.astatic else "stable" if place.stable else "unstable"
        yield ("equilibrium", ""), "beyond a stop" if statics.is_beyond_stops else state
    if mode is not None and not (place and place.astatic):
        yield ("natural frequency there", "1/s"), mode.natural_frequency
        yield ("damping ratio there", "1"), _rounded_to_zero(mode.damping_ratio)
    if force is not None:
        effort = force.effort
        unit = {"m": "N", "rad": "N m"}[_sleeve_unit(statics, force.against)]
        yield ("effort there, for 1 % of speed", unit), float(effort.effort[0]) if effort.effort[0] else None
        travel = float(effort.lift[0]) if effort.has_lift[0] else None
        yield ("sleeve moves for 1 % of speed by", _sleeve_unit(statics, force.against)), travel
    yield from _curve_values(statics)


def _curve_values(statics: GovernorStatics) -> Iterator[tuple[tuple[str, str], float | str | None]]:
    """Yield what the speed curve and the controlling force over the travel give."""
    curve = statics.curve
    if curve.insensitivity_band is not None and statics.equilibrium is not None:
        found = float(np.interp(statics.equilibrium.coordinate, curve.coordinate, curve.insensitivity_band.insensitivity))
        yield ("insensitivity there", "ratio"), finite_or_none(found)
    if curve.folds:
        yield ("jumps at", "rad/s"), curve.folds[0][1]
    ends: WorkingRange | None = None if statics.controlling_force is None else statics.controlling_force.working_range
    if ends is None:
        return
    unit = _sleeve_unit(statics, statics.controlling_force.against) if statics.controlling_force else "m"
    yield ("working range of", ""), _RANGE_NAMES[statics.range_of]
    for end, value in zip(("from", "to"), ends.sleeve.tolist(), strict=True):
        yield (f"working range {end}", unit), value
    for end, value in zip(("inner", "outer"), ends.speed.tolist(), strict=True):
        yield (f"speed of rest, {end} end", "rad/s"), value
    yield ("sensitiveness", "ratio"), ends.sensitiveness if ends.stable else None
    yield ("work capacity", "J"), ends.work_capacity


def _sleeve_unit(statics: GovernorStatics, reading: str) -> str:
    return "rad" if statics.scene.part.mechanism.reading(reading).quantity == "angle" else "m"


def _rounded_to_zero(ratio: float) -> float:
    """Return a damping ratio, with rounding errors of an undamped motion as zero."""
    return 0.0 if abs(ratio) < 1e-9 else ratio


def run_rows(runs: Sequence[Trajectory]) -> Iterator[ComparedReading]:
    """Yield what each run shows of itself."""
    yield ComparedReading(quantity="run: end", unit="s", values=tuple(float(run.times[-1]) if len(run.times) else None for run in runs))
    leading = tuple(leading_reading(run) for run in runs)
    values = tuple(settling_time(run, name) if name in run.readings else None for run, name in zip(runs, leading, strict=True))
    if any(value is not None for value in values):
        yield ComparedReading(quantity="run: settling time (2 %)", unit="s", values=values)
    yield ComparedReading(quantity="run: events", unit="", values=tuple(str(len(run.events)) for run in runs))
    yield ComparedReading(quantity="run: engine", unit="", values=tuple(run.cost.engine for run in runs))
    yield ComparedReading(quantity="run: error estimate", unit="", values=tuple(_format_error(run) for run in runs))


def _format_error(run: Trajectory) -> str | None:
    return None if run.error_estimate is None else f"{run.error_estimate:.0e}"


def reading_rows(
    runs: Sequence[Trajectory],
    # full name of each shared reading in each run, by plain name
    shared: Mapping[str, tuple[str | None, ...]],
) -> Iterator[ComparedReading]:
    """Yield last, lowest and highest value of the shared readings."""
    for name, full_names in shared.items():
        series = [None if full is None else run.readings[full] for run, full in zip(runs, full_names, strict=True)]
        unit = next(run.units[full] for run, full in zip(runs, full_names, strict=True) if full is not None)
        for word, number in (("last", lambda one: one[-1]), ("lowest", np.min), ("highest", np.max)):
            values = tuple(None if one is None else float(number(one)) for one in series)
            yield ComparedReading(quantity=f"{format_reading_name(name)}, {word}", unit=unit, values=values)


MAX_SCENES = 6
"""Largest number of scenes: more columns and more films side by side are wider than a screen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison(Result):
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

    figure = "render.figures.comparison.comparison_figure"
    record = ("title", "names", "rows", "notes", "runs=runs_by_name")

    @property
    def columns(self) -> tuple[Column, ...]:
        """Quantity, unit, and the values of each scene."""
        scenes = [
            item_column(name, "values", k, heading=name, cell=partial(ComparedReading.format_value, k=k), side="r", in_json=False)
            for k, name in enumerate(self.names)
        ]
        return Column("quantity", ""), Column("unit"), Column("values", in_table=False), *scenes

    @property
    def runs_by_name(self) -> dict[str, Trajectory]:
        """The runs by the names of their scenes."""
        return dict(zip(self.names, self.runs, strict=True))

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

    @property
    def moving_runs(self) -> tuple[Trajectory, ...]:
        """The runs with more than one reported time, which a film shows."""
        return tuple(run for run in self.runs if len(run.times) > 1)

    def film(
        self, path: str | os.PathLike[str], *, progress: Callable[[int, int], None] | None = None, **options: Unpack[FilmKeywords]
    ) -> Film:
        """Write the moving runs side by side as an animation and return its file, which a notebook shows.

        `gm.film` documents the parameters and errors.
        """
        from governor_mechanism.notebook.result_table import film_run

        return film_run(self.moving_runs or self.runs, path, progress=progress, **options)

    def __str__(self) -> str:
        """Return title, table and notes."""
        table = format_columns(self.columns, self.rows)
        return "\n".join([self.title, "", table, *(["", *self.notes] if self.notes else [])])


def compare_scenes(
    scenes: Sequence[Scene],
    question: StaticsQuestion,
    *,
    engine: str | Engine = "auto",  # name of an engine, or an engine; "auto" takes that of each scene
    accuracy: float | None = None,  # accuracy of all runs; that of each scene if None
) -> Comparison:
    """Run several scenes and set their statics and readings side by side."""
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

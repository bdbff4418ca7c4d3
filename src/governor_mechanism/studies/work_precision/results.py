"""Results of a work-precision study: the reference, and error and time of each setting of each engine variant."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

from governor_mechanism.engines import Engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record, plain_value, save_table
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.files.table import make_data_frame
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.regression import FittedParameter
from governor_mechanism.types import DataFrame
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

REFERENCE_MARGIN_RATIO = 100.0
"""Ratio of the smallest error that is resolved to the error of the reference."""


@dataclass(frozen=True, kw_only=True)
class WorkPrecisionPoint:
    """One setting of an engine variant: its errors against the reference and its cost, run without a certificate.

    Attributes
    ----------
    variant
        Name of the engine variant.
    engine
        The engine with this setting.
    setting
        The setting as text.
    error
        Largest of `errors`, that of `worst_reading`.
    worst_reading
        Reading or rate with the largest error.
    errors
        Errors of readings and rates away from events, in their scales.
    event_time_error
        Error of the event times, s; None for a scene without contacts.
    max_error
        Larger of error and event_time_error in time scales: what an accuracy refers to.
    wall_time
        Shortest time of `n_repeats` whole runs, s.
    n_repeats
        Number of timed runs.
    wall_times
        Time of each of them, ascending, s.
    step
        Longest step of the finest run, s.
    evaluations
        Evaluations of the equations of motion.
    joint_gap
        Largest joint gap, in length scales of the mechanism.
    drift
        Energy drift in its scale.
    """

    variant: str
    engine: Engine
    setting: str
    error: float
    worst_reading: str
    errors: Mapping[str, float]
    event_time_error: float | None
    max_error: float
    wall_time: float
    n_repeats: int
    wall_times: tuple[float, ...]
    step: float
    evaluations: int
    joint_gap: float
    drift: float

    def as_json(self) -> dict[str, Any]:
        """Return the point as plain values."""
        return plain_record(self, "variant", "engine", settings={"engine": self.engine.name, **plain_value(self.engine)})


@dataclass(frozen=True, kw_only=True)
class EngineVariant:
    """One way to use an engine, coarse settings first.

    Attributes
    ----------
    name
        Name of the variant.
    points
        The measured settings.
    order
        Order of the error in the step; None where it cannot be fitted.
    refusal
        Why the engine cannot run the scene; empty if it can.
    notes
        Settings without a result, and why.
    time_limit
        Time that a setting may take, s, where finer settings are left out because of it.
    """

    name: str
    points: tuple[WorkPrecisionPoint, ...]
    order: FittedParameter | None = None
    refusal: str = ""
    notes: tuple[str, ...] = ()
    time_limit: float | None = None

    @property
    def best_point(self) -> WorkPrecisionPoint | None:
        """The point with the smallest error."""
        return min(self.points, key=lambda point: point.max_error, default=None)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Why the engine cannot run the scene, the order, and the notes."""
        order = () if self.order is None else (f"order {self.order.value:.3f} ± {self.order.standard_error:.1g}",)
        return (*([f"cannot: {self.refusal}"] if self.refusal else []), *order, *self.notes)

    def as_json(self) -> dict[str, Any]:
        """Return the variant as plain values."""
        return plain_record(self, points=[point.as_json() for point in self.points])

    def cheapest_for(self, error: float) -> WorkPrecisionPoint | None:
        """Return the fastest setting within an error; None if there is none."""
        validate_target_error(error)
        return min((point for point in self.points if point.max_error <= error), key=lambda point: point.wall_time, default=None)

    def describe_cost(self, error: float) -> str:
        """Return what an error costs with this variant, or that it is not reached, as text."""
        point, best_point = self.cheapest_for(error), self.best_point
        if point is not None:
            return f"{self.name} {format_wall_time(point.wall_time)} ({point.setting})"
        if best_point is None and self.refusal:
            return f"{self.name} cannot run this scene"
        never_reached = "never" if self.time_limit is None else f"never within {format_wall_time(self.time_limit)}"
        if best_point is None:
            return f"{self.name} {never_reached} (no setting gave a result)"
        return f"{self.name} {never_reached} (at best {best_point.max_error:.1e} in {format_wall_time(best_point.wall_time)})"


@dataclass(frozen=True, kw_only=True)
class ErrorReference:
    """The run that errors are measured against; errors are in units of the scales.

    estimate is its own error estimate (against a ten times looser tolerance), confirmation_error the difference of another engine's best
    run from it, error the error that it is taken to have.
    """

    engine: str
    tolerance: float
    estimate: float
    confirmed_by: str = ""
    confirmation_error: float | None = None
    error: float

    @property
    def resolvable_error(self) -> float:
        """Smallest error that is resolved."""
        return REFERENCE_MARGIN_RATIO * self.error

    def __str__(self) -> str:
        """Return the reference and its confirmation as one line."""
        summary = f"reference: {self.engine}, tolerance {self.tolerance:g}, own error estimate {self.estimate:.1e}"
        return f"{summary}; {self.confirmation}"

    @property
    def confirmation(self) -> str:
        """How well another engine confirms the reference, as text."""
        if self.confirmation_error is None:
            return "no other engine confirms it"
        caveat = "; below that only its own estimate holds" if self.confirmation_error > self.resolvable_error else ""
        return f"{self.confirmed_by} confirms it to {self.confirmation_error:.1e}{caveat}"


@dataclass(frozen=True, kw_only=True)
class AccuracyStudy(PrintedResult):
    """Work-precision study of a scene: every variant of every engine over its settings.

    Attributes
    ----------
    scene
        The scene.
    reference
        The run that errors are measured against.
    variants
        The engine variants.
    n_samples
        Number of compared times.
    time_scale
        Time scale of the motion, s; unit of rates and event times.
    early_end_message
        Why the reference, and with it the study, ends early; empty otherwise.
    """

    scene: Scene
    reference: ErrorReference
    variants: tuple[EngineVariant, ...]
    n_samples: int
    time_scale: float
    early_end_message: str = ""

    __repr__ = short_repr

    @property
    def points(self) -> tuple[WorkPrecisionPoint, ...]:
        """The points of all variants."""
        return tuple(point for variant in self.variants for point in variant.points)

    def variant(self, name: str) -> EngineVariant:
        """Return the variant of that name, such as "impulse staggered"."""
        variants = {variant.name: variant for variant in self.variants}
        if name not in variants:
            raise MechanismError(f"unknown variant {name!r}; available: {list(variants)}")
        return variants[name]

    def cheapest_for(self, error: float) -> WorkPrecisionPoint | None:
        """Return the fastest of all settings within an error; None if there is none.

        `gm.run(scene, point.engine)` uses it. It raises MechanismError for an error that the reference does not resolve.
        """
        self._require_resolvable(error)
        candidates = (variant.cheapest_for(error) for variant in self.variants)
        return min((point for point in candidates if point is not None), key=lambda point: point.wall_time, default=None)

    def advice(self, error: float) -> str:
        """Return which engine to use for an error and what it costs with the others, as one sentence."""
        self._require_resolvable(error)

        def seconds(variant: EngineVariant) -> float:
            point = variant.cheapest_for(error)
            return math.inf if point is None else point.wall_time

        ranked = sorted(self.variants, key=seconds)
        costs = "; ".join(variant.describe_cost(error) for variant in ranked)
        return f"for {error:g}: {'use ' if math.isfinite(seconds(ranked[0])) else 'no engine reaches it; '}{costs}"

    def __str__(self) -> str:
        """Return a table with one line per setting, and the remarks on each variant."""
        has_event_errors = any(point.event_time_error is not None for point in self.points)
        headers = ("variant", "setting", "error", *(["events, s"] if has_event_errors else []), "time", "evaluations", "joint gap", "drift")
        rows = [self._cells(point, has_event_errors=has_event_errors) for point in self.points]
        lines = [
            self.scene.title,
            str(self.reference),
            f"errors in units of each reading's scale, at {self.n_samples} times; times of one whole run, with initial state "
            "and readings, without a certificate",
            *([f"the study ends early: {self.early_end_message}"] if self.early_end_message else []),
            format_table(headers, rows, "llr"),
        ]
        return "\n".join([*lines, *(f"{variant.name}: {remark}" for variant in self.variants for remark in variant.remarks)])

    def _cells(self, point: WorkPrecisionPoint, *, has_event_errors: bool) -> list[str]:
        floor, event_error = self.reference.resolvable_error, point.event_time_error
        errors = [f"{'< ' if point.error < floor else ''}{max(point.error, floor):.1e}"]
        errors += ["" if event_error is None else f"{event_error:.1e}"] if has_event_errors else []
        defects = [f"{point.joint_gap:.1e}", f"{point.drift:.1e}"]
        return [point.variant, point.setting, *errors, format_wall_time(point.wall_time), f"{point.evaluations:,}", *defects]

    def as_json(self) -> dict[str, Any]:
        """Return the study as plain values."""
        reference = plain_record(self.reference, resolvable_error=self.reference.resolvable_error)
        variants = [variant.as_json() for variant in self.variants]
        return plain_record(self, "scene", title=self.scene.title, reference=reference, variants=variants)

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write one row per setting in SI, and return the path."""
        columns = POINT_CSV_HEADER.split(",")
        rows = ([getattr(point, column.partition(" ")[0]) for column in columns] for point in self.points)
        return save_table(columns, rows, Path(path))

    def to_dataframe(self) -> DataFrame:
        """Return a table of pandas with a row for each setting: error, time and defects, SI.

        Returns
        -------
        pandas.DataFrame
            The table.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        names = [column.partition(" ")[0] for column in POINT_CSV_HEADER.split(",")]
        return make_data_frame({name: [getattr(point, name) for point in self.points] for name in names})

    def _require_resolvable(self, error: float) -> None:
        validate_target_error(error)
        if error < self.reference.resolvable_error:
            raise MechanismError(self.unresolvable_message(error))

    def unresolvable_message(self, error: float) -> str:
        """Return why an error is too small for the reference, as a sentence."""
        reference = self.reference
        resolvable = f"{reference.resolvable_error:.1e}"
        return f"the reference has an error of {reference.error:.1e} and resolves errors from {resolvable} up; {error:g} is smaller"


POINT_CSV_HEADER = (
    "variant,setting,step [s],error,worst_reading,event_time_error [s],max_error,wall_time [s],n_repeats,evaluations,joint_gap,drift"
)
"""Header of the CSV file: attributes of a point, some with their unit."""


def validate_target_error(error: float) -> None:
    """Raise MechanismError unless the error is a number between 0 and 1.

    Raises MechanismError if it is not between 0 and 1.
    """
    if not (isinstance(error, Real) and 0 < error < 1):
        raise MechanismError(f"the error must be between 0 and 1, such as 1e-6; got {error!r}")


def format_wall_time(
    seconds: float,  # time, s
) -> str:
    """Return a time as text, such as "0.21 ms", "12 ms" or "1.3 s"."""
    if seconds >= 1:
        return f"{seconds:.2g} s"
    return f"{seconds * 1e3:.0f} ms" if seconds >= 9.95e-3 else f"{seconds * 1e3:.2g} ms"

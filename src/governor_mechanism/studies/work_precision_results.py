"""Results of a work-precision study: the reference, and error and time of each setting of each engine variant."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real

from governor_mechanism.engines import Engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.plain_runs import FittedParameter
from governor_mechanism.units.text_table import short_repr

REFERENCE_MARGIN_RATIO = 100.0
"""Ratio of the smallest error that is resolved to the error of the reference."""


@dataclass(frozen=True, kw_only=True)
class WorkPrecisionPoint(Recorded):
    """One setting of an engine variant: its errors against the reference and its cost, run without a certificate."""

    hidden = ("variant", "engine")
    derived = ("settings",)

    variant: str  # name of the engine variant
    engine: Engine  # the engine with this setting
    setting: str  # the setting as text
    error: float  # largest of `errors`, that of `worst_reading`
    worst_reading: str  # reading or rate with the largest error
    errors: Mapping[str, float]  # errors of readings and rates away from events, in their scales
    event_time_error: float | None  # error of the event times, s; None for a scene without contacts
    max_error: float  # larger of error and event_time_error in time scales: what an accuracy refers to
    wall_time: float  # shortest time of `n_repeats` whole runs, s
    n_repeats: int  # number of timed runs
    wall_times: tuple[float, ...]  # time of each of them, ascending, s
    step: float  # longest step of the finest run, s
    evaluations: int  # evaluations of the equations of motion
    joint_gap: float  # largest joint gap, in length scales of the mechanism
    drift: float  # energy drift in its scale

    @property
    def settings(self) -> dict[str, object]:
        """Name of the engine, and all its settings."""
        return {"engine": self.engine.name, **vars(self.engine)}


@dataclass(frozen=True, kw_only=True)
class EngineVariant(Recorded):
    """One way to use an engine, coarse settings first."""

    name: str  # name of the variant
    points: tuple[WorkPrecisionPoint, ...]  # the measured settings
    order: FittedParameter | None = None  # order of the error in the step; None where it cannot be fitted
    refusal: str = ""  # why the engine cannot run the scene; empty if it can
    notes: tuple[str, ...] = ()  # settings without a result, and why
    time_limit: float | None = None  # time that a setting may take, s, where finer settings are left out because of it

    @property
    def best_point(self) -> WorkPrecisionPoint | None:
        """The point with the smallest error."""
        return min(self.points, key=lambda point: point.max_error, default=None)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Why the engine cannot run the scene, the order, and the notes."""
        order = () if self.order is None else (f"order {self.order.value:.3f} ± {self.order.standard_error:.1g}",)
        return (*([f"cannot: {self.refusal}"] if self.refusal else []), *order, *self.notes)

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
class ErrorReference(Recorded):
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

    derived = ("resolvable_error",)

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
class AccuracyStudy(Result):
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

    figure = "render.figures.work_precision.work_precision_figure"
    data_files = ("csv", "json")
    record = ("title=scene.title", "reference", "variants", "n_samples", "time_scale", "early_end_message")
    has_units_in_header = True

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the points; the text has errors of events only where there are some."""
        events = "events, s" if any(point.event_time_error is not None for point in self.rows) else None
        return (
            Column("variant", "variant"),
            Column("setting", "setting"),
            Column("step", unit="s"),
            Column("error", "error", self._format_error, side="r"),
            Column("worst_reading"),
            Column("event_time_error", events, ".1e", unit="s"),
            Column("max_error"),
            Column("wall_time", "time", lambda point: format_wall_time(point.wall_time), unit="s", side="r"),
            Column("n_repeats"),
            Column("evaluations", "evaluations", ","),
            Column("joint_gap", "joint gap", ".1e"),
            Column("drift", "drift", ".1e"),
        )

    @property
    def rows(self) -> tuple[WorkPrecisionPoint, ...]:
        """The points of all variants, which are the rows of tables."""
        return self.points

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
        lines = [
            self.scene.title,
            str(self.reference),
            f"errors in units of each reading's scale, at {self.n_samples} times; times of one whole run, with initial state "
            "and readings, without a certificate",
            *([f"the study ends early: {self.early_end_message}"] if self.early_end_message else []),
            format_columns(self.columns, self.points),
        ]
        return "\n".join([*lines, *(f"{variant.name}: {remark}" for variant in self.variants for remark in variant.remarks)])

    def _format_error(self, point: WorkPrecisionPoint) -> str:
        floor = self.reference.resolvable_error
        return f"{'< ' if point.error < floor else ''}{max(point.error, floor):.1e}"

    def plot(self, requested_error: float | None = None) -> Figure:
        """Draw error against time for every setting.

        Parameters
        ----------
        requested_error
            Error to mark, with the cheapest setting of each variant that reaches it; None for none.

        Returns
        -------
        Figure
            The figure.
        """
        return self._draw(requested_error)

    def _require_resolvable(self, error: float) -> None:
        validate_target_error(error)
        if error < self.reference.resolvable_error:
            raise MechanismError(self.unresolvable_message(error))

    def unresolvable_message(self, error: float) -> str:
        """Return why an error is too small for the reference, as a sentence."""
        reference = self.reference
        resolvable = f"{reference.resolvable_error:.1e}"
        return f"the reference has an error of {reference.error:.1e} and resolves errors from {resolvable} up; {error:g} is smaller"


def validate_target_error(error: float) -> None:
    """Raise MechanismError unless the error is a number between 0 and 1."""
    if not (isinstance(error, Real) and 0 < error < 1):
        raise MechanismError(f"the error must be between 0 and 1, such as 1e-6; got {error!r}")


def format_wall_time(
    seconds: float,  # time, s
) -> str:
    """Return a time as text, such as "0.21 ms", "12 ms" or "1.3 s"."""
    if seconds >= 1:
        return f"{seconds:.2g} s"
    return f"{seconds * 1e3:.0f} ms" if seconds >= 9.95e-3 else f"{seconds * 1e3:.2g} ms"

"""What a study of accuracy found: its reference, and for every variant of an engine the error and time of each setting.

A time never stands without the error it bought.
"""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from numbers import Real
from pathlib import Path
from typing import Any

from governor_mechanism.engines import Engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.regression import FittedParameter

REFERENCE_MARGIN_RATIO = 100.0
"""How much better than an error the reference must be for that error to be told."""


@dataclass(frozen=True, kw_only=True)
class WorkPrecisionPoint:
    """One setting of a variant, run without a certificate: its errors against the reference, and what it took.

    error is the largest of `errors` (readings and their rates, in units of their scales, away from events), that of
    `worst`; late (s) is how far event times are off, None where nothing can be held or struck. reach is the larger of
    error and late, that in time scales: what an accuracy promises. seconds is the shortest of `repeats` whole runs;
    step (s) is the longest of the finest run; joint_gap is in machine sizes, drift that of the energy in its scale.
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
    step: float
    evaluations: int
    joint_gap: float
    drift: float

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        plain = {name: value for name, value in vars(self).items() if name not in ("variant", "engine", "errors")}
        return {**plain, "errors": dict(self.errors), "settings": {"engine": self.engine.name, **vars(self.engine)}}


@dataclass(frozen=True, kw_only=True)
class EngineVariant:
    """A way to use an engine, coarse settings first; order is how its error falls with its step, where it has one.

    refused says why it cannot run the scene, notes which settings came to nothing; within (s) is the time that a
    setting may take, where finer ones were left out because they would take longer.
    """

    name: str
    points: tuple[WorkPrecisionPoint, ...]
    order: FittedParameter | None = None
    refusal: str = ""
    notes: tuple[str, ...] = ()
    time_limit: float | None = None

    @property
    def best_point(self) -> WorkPrecisionPoint | None:
        """The point that came nearest to the reference."""
        return min(self.points, key=lambda point: point.max_error, default=None)

    def cheapest_for(self, error: float) -> WorkPrecisionPoint | None:
        """The quickest setting within an error; None where none is."""
        validate_target_error(error)
        return min((point for point in self.points if point.max_error <= error), key=lambda point: point.wall_time, default=None)

    def describe_cost(self, error: float) -> str:
        """What an error costs with it, or that it never reaches it, and what it does."""
        point, best_point = self.cheapest_for(error), self.best_point
        if point is not None:
            return f"{self.name} {format_wall_time(point.wall_time)} ({point.setting})"
        never_reached = "never" if self.time_limit is None else f"never within {format_wall_time(self.time_limit)}"
        if best_point is None:
            return f"{self.name} {'cannot run this scene' if self.refusal else f'{never_reached} (no setting came through)'}"
        return f"{self.name} {never_reached} (at best {best_point.max_error:.1e} in {format_wall_time(best_point.wall_time)})"


@dataclass(frozen=True, kw_only=True)
class ErrorReference:
    """The run that errors are measured against.

    estimate is its own (against ten times looser tolerance), confirmed the difference of another engine's best run
    from it, both in units of the scales; error is what it is taken to be good to.
    """

    engine: str
    tolerance: float
    estimate: float
    confirmed_by: str
    confirmation_error: float | None
    error: float

    @property
    def resolvable_error(self) -> float:
        """Errors below this are not told apart."""
        return REFERENCE_MARGIN_RATIO * self.error

    def __str__(self) -> str:
        summary = f"reference: {self.engine}, tolerance {self.tolerance:g}, by its own estimate within {self.estimate:.1e}"
        return f"{summary}; {self.confirmation}"

    @property
    def confirmation(self) -> str:
        """How far another engine confirms it."""
        if self.confirmation_error is None:
            return "no other engine confirms it"
        caveat = ", below which its own estimate stands alone" if self.confirmation_error > self.resolvable_error else ""
        return f"{self.confirmed_by} confirms it to {self.confirmation_error:.1e}{caveat}"


@dataclass(frozen=True, kw_only=True)
class AccuracyStudy:
    """Every variant of every engine over its settings. samples is the number of times at which readings are compared.

    time_scale (s) is that of the scene's motion, which event times and rates are measured in. ended says where and why
    the reference, and with it the study, ends before its time.
    """

    scene: Scene
    reference: ErrorReference
    variants: tuple[EngineVariant, ...]
    n_samples: int
    time_scale: float
    early_end_message: str = ""

    @property
    def points(self) -> tuple[WorkPrecisionPoint, ...]:
        """Those of all variants."""
        return tuple(point for variant in self.variants for point in variant.points)

    def variant(self, name: str) -> EngineVariant:
        """The one of that name, as 'impulse staggered'."""
        match = next((variant for variant in self.variants if variant.name == name), None)
        if match is None:
            raise MechanismError(f"no variant {name!r}; variants are {[variant.name for variant in self.variants]}")
        return match

    def cheapest_for(self, error: float) -> WorkPrecisionPoint | None:
        """The quickest setting of all within an error; gm.run(scene, point.engine) runs it. None where none is.

        Raises MechanismError for an error that the reference cannot tell.
        """
        self._require_resolvable(error)
        candidates = (variant.cheapest_for(error) for variant in self.variants)
        return min((point for point in candidates if point is not None), key=lambda point: point.wall_time, default=None)

    def advice(self, error: float) -> str:
        """Which engine to use for an error, and what it would cost with the others, in a sentence."""
        self._require_resolvable(error)

        def seconds(variant: EngineVariant) -> float:
            point = variant.cheapest_for(error)
            return math.inf if point is None else point.wall_time

        ranked = sorted(self.variants, key=seconds)
        costs = "; ".join(variant.describe_cost(error) for variant in ranked)
        return f"for {error:g}: {'use ' if math.isfinite(seconds(ranked[0])) else 'no engine reaches it; '}{costs}"

    def __str__(self) -> str:
        """A line for each setting, under its variant."""
        lines = [self.scene.title, str(self.reference)]
        lines.append(
            f"errors in units of each reading's scale, at {self.n_samples} times; times of one whole run, start and "
            "readings included, without a certificate"
        )
        if self.early_end_message:
            lines.append(f"the study ends early: {self.early_end_message}")
        has_event_errors = any(point.event_time_error is not None for point in self.points)
        event_heading = f"{'events, s':>10}" if has_event_errors else ""
        headings = f"{'error':>11}{event_heading}{'time':>10}{'evaluations':>13}{'joint gap':>11}{'drift':>10}"
        lines.append(f"{'':22}{'setting':{self._setting_width}}{headings}")
        for variant in self.variants:
            lines += self._format_variant(variant, has_event_errors=has_event_errors)
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        variants = [
            {
                "name": variant.name,
                "order": _order_as_json(variant.order),
                "refused": variant.refusal,
                "notes": list(variant.notes),
                "within": variant.time_limit,
                "points": [point.as_json() for point in variant.points],
            }
            for variant in self.variants
        ]
        return {
            "title": self.scene.title,
            "reference": {**asdict(self.reference), "floor": self.reference.resolvable_error},
            "samples": self.n_samples,
            "time_scale": self.time_scale,
            "ended": self.early_end_message,
            "variants": variants,
        }

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """A row for each setting, SI."""
        path = Path(path)
        with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(POINT_CSV_COLUMNS)
            for point in self.points:
                cells = (getattr(point, name.partition(" ")[0]) for name in POINT_CSV_COLUMNS)
                writer.writerow("" if cell is None else cell for cell in cells)
        return path

    def save_json(self, path: str | os.PathLike[str]) -> Path:
        """All of it."""
        path = Path(path)
        with atomic_write(path) as temporary:
            temporary.write_text(json.dumps(self.as_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
        return path

    def _require_resolvable(self, error: float) -> None:
        validate_target_error(error)
        if error < self.reference.resolvable_error:
            raise MechanismError(self.unresolvable_message(error))

    def unresolvable_message(self, error: float) -> str:
        """Why an error is less than can be told, in a sentence."""
        return (
            f"the reference is good to {self.reference.error:.1e}, which tells errors from "
            f"{self.reference.resolvable_error:.1e} on; {error:g} is less"
        )

    @property
    def _setting_width(self) -> int:
        """Letters of the longest setting, and a gap."""
        return 2 + max((len(point.setting) for point in self.points), default=16)

    def _format_variant(self, variant: EngineVariant, *, has_event_errors: bool) -> Iterator[str]:
        name = variant.name
        if variant.refusal:
            yield f"{name:22}cannot: {variant.refusal}"
        for point in variant.points:
            is_below_resolution = point.error < self.reference.resolvable_error
            error = f"{'< ' if is_below_resolution else ''}{max(point.error, self.reference.resolvable_error):.1e}"
            event_time_error = (
                "" if not has_event_errors else f"{'' if point.event_time_error is None else f'{point.event_time_error:.1e}':>10}"
            )
            yield (
                f"{name:22}{point.setting:{self._setting_width}}{error:>11}{event_time_error}{format_wall_time(point.wall_time):>10}{point.evaluations:>13,}"
                f"{point.joint_gap:>11.1e}{point.drift:>10.1e}"
            )
            name = ""
        if variant.order is not None:
            yield f"{name:22}order {variant.order.value:.3f} ± {variant.order.standard_error:.1g}"
            name = ""
        for note in variant.notes:
            yield f"{name:22}{note}"
            name = ""


POINT_CSV_COLUMNS = (
    "variant",
    "setting",
    "step [s]",
    "error",
    "worst",
    "late [s]",
    "reach",
    "seconds [s]",
    "repeats",
    "evaluations",
    "joint_gap",
    "drift",
)
"""Of the table on disk: attributes of a point."""


def validate_target_error(error: float) -> None:
    """Raise MechanismError for what is no error to ask for."""
    if not (isinstance(error, Real) and 0 < error < 1):
        raise MechanismError(f"an error to ask for lies between 0 and 1, as 1e-6; got {error!r}")


def format_wall_time(seconds: float) -> str:
    """As '0.21 ms', '12 ms', '1.3 s'."""
    if seconds >= 1:
        return f"{seconds:.2g} s"
    return f"{seconds * 1e3:.0f} ms" if seconds >= 9.95e-3 else f"{seconds * 1e3:.2g} ms"


def _order_as_json(order: FittedParameter | None) -> dict[str, float] | None:
    return None if order is None else asdict(order)

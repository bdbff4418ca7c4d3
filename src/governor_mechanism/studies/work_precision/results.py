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
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.regression import Fitted

DECADES = 100.0
"""How much better than an error the reference must be for that error to be told."""


@dataclass(frozen=True, kw_only=True)
class Point:
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
    worst: str
    errors: Mapping[str, float]
    late: float | None
    reach: float
    seconds: float
    repeats: int
    step: float
    evaluations: int
    joint_gap: float
    drift: float

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        plain = {name: value for name, value in vars(self).items() if name not in ("variant", "engine", "errors")}
        return {**plain, "errors": dict(self.errors), "settings": {"engine": self.engine.name, **vars(self.engine)}}


@dataclass(frozen=True, kw_only=True)
class Variant:
    """A way to use an engine, coarse settings first; order is how its error falls with its step, where it has one.

    refused says why it cannot run the scene, notes which settings came to nothing; within (s) is the time that a
    setting may take, where finer ones were left out because they would take longer.
    """

    name: str
    points: tuple[Point, ...]
    order: Fitted | None = None
    refused: str = ""
    notes: tuple[str, ...] = ()
    within: float | None = None

    @property
    def best(self) -> Point | None:
        """The point that came nearest to the reference."""
        return min(self.points, key=lambda point: point.reach, default=None)

    def cheapest_for(self, error: float) -> Point | None:
        """The quickest setting within an error; None where none is."""
        require_error(error)
        return min(
            (point for point in self.points if point.reach <= error), key=lambda point: point.seconds, default=None
        )

    def told_for(self, error: float) -> str:
        """What an error costs with it, or that it never reaches it, and what it does."""
        point, best = self.cheapest_for(error), self.best
        if point is not None:
            return f"{self.name} {spoken_time(point.seconds)} ({point.setting})"
        never = "never" if self.within is None else f"never within {spoken_time(self.within)}"
        if best is None:
            return f"{self.name} {'cannot run this scene' if self.refused else f'{never} (no setting came through)'}"
        return f"{self.name} {never} (at best {best.reach:.1e} in {spoken_time(best.seconds)})"


@dataclass(frozen=True, kw_only=True)
class Reference:
    """The run that errors are measured against.

    estimate is its own (against ten times looser tolerance), confirmed the difference of another engine's best run
    from it, both in units of the scales; error is what it is taken to be good to.
    """

    engine: str
    tolerance: float
    estimate: float
    confirmed_by: str
    confirmed: float | None
    error: float

    @property
    def floor(self) -> float:
        """Errors below this are not told apart."""
        return DECADES * self.error

    def __str__(self) -> str:
        told = f"reference: {self.engine}, tolerance {self.tolerance:g}, by its own estimate within {self.estimate:.1e}"
        return f"{told}; {self.confirmation}"

    @property
    def confirmation(self) -> str:
        """How far another engine confirms it."""
        if self.confirmed is None:
            return "no other engine confirms it"
        alone = ", below which its own estimate stands alone" if self.confirmed > self.floor else ""
        return f"{self.confirmed_by} confirms it to {self.confirmed:.1e}{alone}"


@dataclass(frozen=True, kw_only=True)
class AccuracyStudy:
    """Every variant of every engine over its settings. samples is the number of times at which readings are compared.

    time_scale (s) is that of the scene's motion, which event times and rates are measured in. ended says where and why
    the reference, and with it the study, ends before its time.
    """

    scene: Scene
    reference: Reference
    variants: tuple[Variant, ...]
    samples: int
    time_scale: float
    ended: str = ""

    @property
    def points(self) -> tuple[Point, ...]:
        """Those of all variants."""
        return tuple(point for variant in self.variants for point in variant.points)

    def variant(self, name: str) -> Variant:
        """The one of that name, as 'impulse staggered'."""
        found = next((one for one in self.variants if one.name == name), None)
        if found is None:
            raise MechanismError(f"no variant {name!r}; variants are {[one.name for one in self.variants]}")
        return found

    def cheapest_for(self, error: float) -> Point | None:
        """The quickest setting of all within an error; gm.run(scene, point.engine) runs it. None where none is.

        Raises MechanismError for an error that the reference cannot tell.
        """
        self._require(error)
        found = (variant.cheapest_for(error) for variant in self.variants)
        return min((point for point in found if point is not None), key=lambda point: point.seconds, default=None)

    def advice(self, error: float) -> str:
        """Which engine to use for an error, and what it would cost with the others, in a sentence."""
        self._require(error)

        def seconds(variant: Variant) -> float:
            point = variant.cheapest_for(error)
            return math.inf if point is None else point.seconds

        ranked = sorted(self.variants, key=seconds)
        told = "; ".join(variant.told_for(error) for variant in ranked)
        return f"for {error:g}: {'use ' if math.isfinite(seconds(ranked[0])) else 'no engine reaches it; '}{told}"

    def __str__(self) -> str:
        """A line for each setting, under its variant."""
        lines = [self.scene.title, str(self.reference)]
        lines.append(
            f"errors in units of each reading's scale, at {self.samples} times; times of one whole run, start and "
            "readings included, without a certificate"
        )
        if self.ended:
            lines.append(f"the study ends early: {self.ended}")
        held = any(point.late is not None for point in self.points)
        events = f"{'events, s':>10}" if held else ""
        found = f"{'error':>11}{events}{'time':>10}{'evaluations':>13}{'joint gap':>11}{'drift':>10}"
        lines.append(f"{'':22}{'setting':{self._wide}}{found}")
        for variant in self.variants:
            lines += self._lines(variant, held=held)
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        variants = [
            {
                "name": one.name,
                "order": _fitted(one.order),
                "refused": one.refused,
                "notes": list(one.notes),
                "within": one.within,
                "points": [point.as_json() for point in one.points],
            }
            for one in self.variants
        ]
        return {
            "title": self.scene.title,
            "reference": {**asdict(self.reference), "floor": self.reference.floor},
            "samples": self.samples,
            "time_scale": self.time_scale,
            "ended": self.ended,
            "variants": variants,
        }

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """A row for each setting, SI."""
        path = Path(path)
        with written_beside(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(COLUMNS)
            for point in self.points:
                cells = (getattr(point, name.partition(" ")[0]) for name in COLUMNS)
                writer.writerow("" if cell is None else cell for cell in cells)
        return path

    def save_json(self, path: str | os.PathLike[str]) -> Path:
        """All of it."""
        path = Path(path)
        with written_beside(path) as temporary:
            temporary.write_text(json.dumps(self.as_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
        return path

    def _require(self, error: float) -> None:
        require_error(error)
        if error < self.reference.floor:
            raise MechanismError(self.too_fine(error))

    def too_fine(self, error: float) -> str:
        """Why an error is less than can be told, in a sentence."""
        return (
            f"the reference is good to {self.reference.error:.1e}, which tells errors from "
            f"{self.reference.floor:.1e} on; {error:g} is less"
        )

    @property
    def _wide(self) -> int:
        """Letters of the longest setting, and a gap."""
        return 2 + max((len(point.setting) for point in self.points), default=16)

    def _lines(self, variant: Variant, *, held: bool) -> Iterator[str]:
        name = variant.name
        if variant.refused:
            yield f"{name:22}cannot: {variant.refused}"
        for point in variant.points:
            below = point.error < self.reference.floor
            error = f"{'< ' if below else ''}{max(point.error, self.reference.floor):.1e}"
            late = "" if not held else f"{'' if point.late is None else f'{point.late:.1e}':>10}"
            yield (
                f"{name:22}{point.setting:{self._wide}}{error:>11}{late}{spoken_time(point.seconds):>10}{point.evaluations:>13,}"
                f"{point.joint_gap:>11.1e}{point.drift:>10.1e}"
            )
            name = ""
        if variant.order is not None:
            yield f"{name:22}order {variant.order.value:.3f} ± {variant.order.scatter:.1g}"
            name = ""
        for note in variant.notes:
            yield f"{name:22}{note}"
            name = ""


COLUMNS = (
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


def require_error(error: float) -> None:
    """Raise MechanismError for what is no error to ask for."""
    if not (isinstance(error, Real) and 0 < error < 1):
        raise MechanismError(f"an error to ask for lies between 0 and 1, as 1e-6; got {error!r}")


def spoken_time(seconds: float) -> str:
    """As '0.21 ms', '12 ms', '1.3 s'."""
    if seconds >= 1:
        return f"{seconds:.2g} s"
    return f"{seconds * 1e3:.0f} ms" if seconds >= 9.95e-3 else f"{seconds * 1e3:.2g} ms"


def _fitted(order: Fitted | None) -> dict[str, float] | None:
    return None if order is None else asdict(order)

"""How a tolerance is found that meets an accuracy, and what is said of it, for engines with error control."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Outcome

MARGIN = 100.0
"""How much tighter than the accuracy a step is held: the estimate is the error of a run ten times looser."""

LOOSER = 10.0
"""How much looser the second run of a certificate is."""

TIGHTEST = 1e-15
"""Below this no tolerance is tried: double precision ends."""


class Certified(Protocol):
    """A run with the estimate of its error, or with none."""

    @property
    def ended(self) -> Outcome | None:
        """Why it ended early, if it did."""

    @property
    def estimate(self) -> float | None:
        """Its largest error, relative to the scales."""

    @property
    def reached(self) -> int:
        """How many of the reported times it came to."""


Run = TypeVar("Run", bound=Certified)


def refuse_settings(engine: str, tolerance: float | None, max_steps: int) -> None:
    """Raise MechanismError for settings of an engine that make no sense."""
    if tolerance is not None and not TIGHTEST <= tolerance < 1:
        raise MechanismError(f"{engine}.tolerance must lie between {TIGHTEST:g} and 1; got {tolerance!r}")
    if max_steps < 1:
        raise MechanismError(f"{engine}.max_steps must be at least 1; got {max_steps!r}")


def first_tolerance(accuracy: float) -> float:
    """The error of one step that an accuracy is first tried with."""
    return max(accuracy / MARGIN, TIGHTEST)


def tightened(certified: Callable[[float], Run], tolerance: float, accuracy: float, patience: int) -> Run:
    """A run whose estimate is within the accuracy, or the best there is; so many in a row that are no better are
    believed, for one may be bad luck."""
    best, tries = certified(tolerance), 0
    while best.estimate is not None and best.estimate > accuracy:
        # Tightened by less, a certificate may come out no better for no reason but the luck of its steps.
        tolerance *= min(max(0.5 * accuracy / best.estimate, 1e-3), 1 / LOOSER)
        if tolerance < TIGHTEST:
            break
        better = certified(tolerance)
        if better.estimate is not None and better.estimate < best.estimate and better.reached >= best.reached:
            best, tries = better, 0
            continue
        tries += 1
        if tries == patience:
            break  # rounding, not the step, sets the error now
    return best


def outcome_of(run: Certified, accuracy: float) -> Outcome:
    """How a run ended, in view of the accuracy that was asked for."""
    if run.ended is not None:
        return run.ended
    if run.estimate is None:
        return Outcome.UNCERTIFIED
    return Outcome.DONE if run.estimate <= accuracy else Outcome.ACCURACY_MISSED

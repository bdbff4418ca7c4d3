"""How a tolerance is found that meets an accuracy, and what is said of it, for engines with error control."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Outcome

TOLERANCE_SAFETY_FACTOR = 100.0
"""How much tighter than the accuracy a step is held: the estimate is the error of a run ten times looser."""

COMPARISON_TOLERANCE_RATIO = 10.0
"""How much looser the second run of a certificate is."""

MIN_STEP_TOLERANCE = 1e-15
"""Below this no tolerance is tried: double precision ends."""


class CertifiedRun(Protocol):
    """A run with the estimate of its error, or with none."""

    @property
    def early_outcome(self) -> Outcome | None:
        """Why it ended early, if it did."""

    @property
    def error_estimate(self) -> float | None:
        """Its largest error, relative to the scales."""

    @property
    def n_reached(self) -> int:
        """How many of the reported times it came to."""


Run = TypeVar("Run", bound=CertifiedRun)


def check_engine_settings(engine: str, tolerance: float | None, max_steps: int) -> None:
    """Raise MechanismError for settings of an engine that make no sense."""
    if tolerance is not None and not MIN_STEP_TOLERANCE <= tolerance < 1:
        raise MechanismError(f"{engine}.tolerance must lie between {MIN_STEP_TOLERANCE:g} and 1; got {tolerance!r}")
    if max_steps < 1:
        raise MechanismError(f"{engine}.max_steps must be at least 1; got {max_steps!r}")


def initial_tolerance(accuracy: float) -> float:
    """The error of one step that an accuracy is first tried with."""
    return max(accuracy / TOLERANCE_SAFETY_FACTOR, MIN_STEP_TOLERANCE)


def refine_tolerance(run_certified: Callable[[float], Run], tolerance: float, accuracy: float, max_stagnant_runs: int) -> Run:
    """A run whose estimate is within the accuracy, or the best there is; so many in a row that are no better are
    believed, for one may be bad luck."""
    best, n_stagnant = run_certified(tolerance), 0
    while best.error_estimate is not None and best.error_estimate > accuracy:
        # Tightened by less, a certificate may come out no better for no reason but the luck of its steps.
        tolerance *= min(max(0.5 * accuracy / best.error_estimate, 1e-3), 1 / COMPARISON_TOLERANCE_RATIO)
        if tolerance < MIN_STEP_TOLERANCE:
            break
        better = run_certified(tolerance)
        if better.error_estimate is not None and better.error_estimate < best.error_estimate and better.n_reached >= best.n_reached:
            best, n_stagnant = better, 0
            continue
        n_stagnant += 1
        if n_stagnant == max_stagnant_runs:
            break  # rounding, not the step, sets the error now
    return best


def classify_outcome(run: CertifiedRun, accuracy: float) -> Outcome:
    """How a run ended, in view of the accuracy that was asked for."""
    if run.early_outcome is not None:
        return run.early_outcome
    if run.error_estimate is None:
        return Outcome.UNCERTIFIED
    return Outcome.DONE if run.error_estimate <= accuracy else Outcome.ACCURACY_MISSED

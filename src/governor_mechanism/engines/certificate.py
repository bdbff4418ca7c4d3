"""Error certificate of engines with error control: refine the tolerance until the estimated error meets the accuracy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Outcome

TOLERANCE_SAFETY_FACTOR = 100.0
"""Ratio of accuracy to first tolerance: the estimate is the error of a run with a ten times larger tolerance."""

COMPARISON_TOLERANCE_RATIO = 10.0
"""Ratio of the comparison run's tolerance to that of the certified run."""

MIN_STEP_TOLERANCE = 1e-15
"""Smallest tolerance that is tried: double precision allows no less."""


class CertifiedRun(Protocol):
    """A run with an error estimate, or with None if it has no certificate."""

    @property
    def early_outcome(self) -> Outcome | None:
        """Return why the run ended early, or None."""

    @property
    def error_estimate(self) -> float | None:
        """Return the largest error relative to the scales, or None."""

    @property
    def n_reached(self) -> int:
        """Return how many of the reported times were reached."""


Run = TypeVar("Run", bound=CertifiedRun)


def check_engine_settings(engine: str, tolerance: float | None, max_steps: int) -> None:
    """Raise MechanismError if the tolerance or the step limit of an engine is out of range."""
    if tolerance is not None and not MIN_STEP_TOLERANCE <= tolerance < 1:
        raise MechanismError(f"{engine}.tolerance must lie between {MIN_STEP_TOLERANCE:g} and 1; got {tolerance!r}")
    if max_steps < 1:
        raise MechanismError(f"{engine}.max_steps must be at least 1; got {max_steps!r}")


def initial_tolerance(accuracy: float) -> float:
    """Return the first tolerance to try for an accuracy.

    Parameters
    ----------
    accuracy
        Requested accuracy relative to the scales.

    Returns
    -------
    float
        Error of one step, relative to the scales of the state.
    """
    return max(accuracy / TOLERANCE_SAFETY_FACTOR, MIN_STEP_TOLERANCE)


def refine_tolerance(run_certified: Callable[[float], Run], tolerance: float, accuracy: float, max_stagnant_runs: int) -> Run:
    """Return the first run whose estimate meets the accuracy, or the best run found.

    The tolerance is reduced until max_stagnant_runs in a row bring no improvement, because a single failure may be chance.
    """
    best, n_stagnant = run_certified(tolerance), 0
    while best.error_estimate is not None and best.error_estimate > accuracy:
        # With a smaller reduction the estimate may fail to improve merely by the chance of the step sizes.
        tolerance *= min(max(0.5 * accuracy / best.error_estimate, 1e-3), 1 / COMPARISON_TOLERANCE_RATIO)
        if tolerance < MIN_STEP_TOLERANCE:
            break
        better = run_certified(tolerance)
        if better.error_estimate is not None and better.error_estimate < best.error_estimate and better.n_reached >= best.n_reached:
            best, n_stagnant = better, 0
            continue
        n_stagnant += 1
        if n_stagnant == max_stagnant_runs:
            break  # the error is now rounding, not discretisation
    return best


def classify_outcome(run: CertifiedRun, accuracy: float) -> Outcome:
    """Return the outcome of a run with respect to the requested accuracy."""
    if run.early_outcome is not None:
        return run.early_outcome
    if run.error_estimate is None:
        return Outcome.UNCERTIFIED
    return Outcome.DONE if run.error_estimate <= accuracy else Outcome.ACCURACY_MISSED

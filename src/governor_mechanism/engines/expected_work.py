"""Work that a request is expected to take, as judged by its first run, and the reason for an engine, which states it."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ExpectedWork:
    """Work of all runs of a request, as expected after the first of them.

    Attributes
    ----------
    first_run_time
        Time of the first run, s. In a new process it includes what runs only once.
    n_evaluations
        Number of evaluations of the equations of motion.
    n_reported
        Number of reported times.
    """

    first_run_time: float
    n_evaluations: float
    n_reported: int


Reason = str | Callable[[ExpectedWork | None], str]
"""Why an engine was chosen; a function states it with the expected work, or without where nothing is known of it."""


def state_reason(
    reason: Reason,
    work: ExpectedWork | None,  # expected work; None if it is not known
) -> str:
    """Return a reason as text."""
    return reason if isinstance(reason, str) else reason(work)

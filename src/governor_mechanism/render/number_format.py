"""How results are put into words and everyday units on pictures."""

from __future__ import annotations

import math
import textwrap

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.trajectory import Outcome, Trajectory

FIGURE_UNITS = {"rad": ("°", 180 / math.pi), "m": ("mm", 1e3), "rad/s": ("rpm", 30 / math.pi)}
"""The everyday unit for an SI unit, and how many of it make that SI unit. Others are shown as they are."""


def display_unit_of(si_unit: str) -> tuple[str, float]:
    """The unit shown for an SI unit, and the factor to it."""
    return FIGURE_UNITS.get(si_unit, (si_unit, 1.0))


def choose_decimals(values: NDArray[np.float64]) -> int:
    """So many decimals, at most 4, that the range of the values spans some hundred steps."""
    largest = float(np.abs(values).max())
    span = float(np.ptp(values))
    if span < 1e-4 * largest:
        # As good as constant: noise must not call for decimals.
        span = 0.1 * largest
    return min(max(math.ceil(2 - math.log10(max(span, 1e-9))), 0), 4)


def format_numbers(values: NDArray[np.float64]) -> list[str]:
    """The values as texts, all with the same decimals; a rounded nought has no sign."""
    decimals = choose_decimals(values)
    return [f"{round(float(value), decimals) + 0.0:.{decimals}f}" for value in values]


def format_rounded_up(error: float) -> str:
    """An error to one digit, never smaller than it is."""
    if not (error > 0 and math.isfinite(error)):
        return f"{error:.0e}"
    decade = 10.0 ** math.floor(math.log10(error))
    # The margin keeps a whole multiple, such as 3e-07, from being rounded up by the last bit.
    return f"{math.ceil(error / decade * (1 - 1e-9)) * decade:.0e}"


def format_film_speed(slow_down: float) -> str:
    """How much slower or faster than the run a film is; nothing for true time."""
    if slow_down == 1.0:
        return ""
    return f"slowed {slow_down:.4g}x" if slow_down > 1.0 else f"sped up {1 / slow_down:.4g}x"


def format_closing_lines(run: Trajectory, width: int) -> tuple[list[str], bool]:
    """At most two lines of at most `width` letters on how accurate a run is or why it ended early; if it is bad news.

    The cause of an early end comes first and may fill both lines; what is left goes to the general sentence.
    """
    if run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED:
        return _format_accuracy(run)
    lines = textwrap.wrap(run.detail or run.outcome.value, width, max_lines=2, placeholder=" …")
    if run.detail and len(lines) == 1:
        lines.append(textwrap.shorten(run.outcome.value, width, placeholder=" …"))
    return lines, True


def _format_accuracy(run: Trajectory) -> tuple[list[str], bool]:
    requested = f"asked {run.settings.get('asked_accuracy', run.scene.run.accuracy):.0e}"
    if run.error_estimate is None:
        return [f"accuracy not certified ({requested})"], False
    is_missed = run.outcome is Outcome.ACCURACY_MISSED
    return [f"accurate {'only ' if is_missed else ''}to {format_rounded_up(run.error_estimate)}, {requested}"], is_missed

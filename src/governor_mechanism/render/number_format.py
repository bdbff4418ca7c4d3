"""Numbers, units and statements on accuracy as text for figures."""

import math
import textwrap
import unicodedata

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.units.constants import RPM

FIGURE_UNITS = {"rad": ("°", math.degrees(1.0)), "m": ("mm", 1e3), "rad/s": ("rpm", 1 / RPM), "Pa": ("bar", 1e-5), "1": ("", 1.0)}
"""Display unit of an SI unit and the factor to it. Other units are shown unchanged."""

_GREEK_CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Phi", "Psi", "Omega")
GREEK_LETTERS = {unicodedata.name(chr(code)).split()[-1].lower().replace("lamda", "lambda"): chr(code) for code in range(0x3B1, 0x3CA)}
GREEK_LETTERS |= {name: GREEK_LETTERS[name.lower()].upper() for name in _GREEK_CAPITALS}
"""Greek letters by name; capitals only where they differ from Latin ones."""


def display_unit_of(si_unit: str) -> tuple[str, float]:
    """Return the display unit of an SI unit and the factor to it."""
    return FIGURE_UNITS.get(si_unit, (si_unit, 1.0))


def format_name(name: str) -> str:
    """Return the name of a reading, part or effect as words: "governor.arm_angle" as "governor arm angle", "beta" as "β"."""
    return " ".join(GREEK_LETTERS.get(word, word) for word in name.replace(".", " ").replace("_", " ").split(" "))


def format_label(name: str, unit: str) -> str:
    """Return the label of an axis: "governor.arm_angle" in "°" as "Governor arm angle [deg]"."""
    words = format_name(name)
    # A single letter, Greek or Latin, is a symbol, whose capital would be another one.
    start = words[:1] if words[1:2] in ("", " ") else words[:1].upper()
    return start + words[1:] + (f" [{unit.replace('°', 'deg')}]" if unit else "")


def choose_decimals(values: NDArray[np.float64]) -> int:
    """Return the number of decimals, at most 4, that divides the range of the values into some hundred steps."""
    largest = float(np.abs(values).max())
    span = float(np.ptp(values))
    if span < 1e-4 * largest:
        # Practically constant: noise must not add decimals.
        span = 0.1 * largest
    return min(max(math.ceil(2 - math.log10(max(span, 1e-9))), 0), 4)


def format_numbers(values: NDArray[np.float64], all_values: NDArray[np.float64] | None = None) -> list[str]:
    """Format values with equal decimals, which suit them or the values of which they are some; a rounded zero has no sign."""
    decimals = choose_decimals(values if all_values is None else all_values)
    return [f"{round(float(value), decimals) + 0.0:.{decimals}f}" for value in values]


def format_rounded_up(error: float) -> str:
    """Format an error with one digit, rounded up."""
    if not (error > 0 and math.isfinite(error)):
        return f"{error:.0e}"
    decade = 10.0 ** math.floor(math.log10(error))
    # The margin keeps a multiple such as 3e-07 from being rounded up because of its last bit.
    return f"{math.ceil(error / decade * (1 - 1e-9)) * decade:.0e}"


def format_film_speed(slow_down: float) -> str:
    """Return how much slower or faster a film is than the machine, or an empty string for true time."""
    if slow_down == 1.0:
        return ""
    return f"{slow_down:.4g} × slower than real" if slow_down > 1.0 else f"{1 / slow_down:.4g} × faster than real"


def format_closing_lines(run: Trajectory, width: int) -> tuple[list[str], bool]:
    """Return at most two lines of at most `width` characters on accuracy or early end, and whether that is a failure.

    The cause of an early end comes first and may fill both lines; the general sentence takes what is left.
    """
    if run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED:
        return _format_accuracy(run)
    lines = textwrap.wrap(run.detail or run.outcome.value, width, max_lines=2, placeholder=" …")
    if run.detail and len(lines) == 1:
        lines.append(textwrap.shorten(run.outcome.value, width, placeholder=" …"))
    return lines, True


def _format_accuracy(run: Trajectory) -> tuple[list[str], bool]:
    """Return the line on accuracy, and whether the requested one was missed."""
    requested = f"requested {run.settings.get('asked_accuracy', run.scene.run.accuracy):.0e}"
    if run.error_estimate is None:
        return [f"accuracy not certified ({requested})"], False
    is_missed = run.outcome is Outcome.ACCURACY_MISSED
    return [f"accurate {'only ' if is_missed else ''}to {format_rounded_up(run.error_estimate)}, {requested}"], is_missed

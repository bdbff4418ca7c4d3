"""Agreement with printed numbers to their last digit."""

import math
from typing import Any


def half_unit_of_last_digit(value: float, digits: int = 12) -> float:
    """Half a unit of the last printed digit, one hundredth more for the rounding of double precision."""
    return 0.505 * 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1) if value else 0.0


def is_printed(value: Any, printed: float, digits: int = 12) -> None:
    """The value rounds to the printed one: tolerance half a unit of the last printed digit."""
    assert abs(float(value) - printed) <= half_unit_of_last_digit(printed, digits), (value, printed)

"""Customary units in SI: multiply by one to convert to SI, divide by it to show a value in it."""

import math
from typing import Final

RPM: Final = math.pi / 30
"""One revolution per minute, rad/s."""

KILOGRAM_FORCE: Final = 9.80665
"""The standard weight of one kilogram, N. Papers that round it to 9.81 N name their own."""

HORSEPOWER: Final = 75 * KILOGRAM_FORCE
"""One metric horsepower (PS), W."""

"""Customary units in SI: multiply by one to convert to SI, divide by it to show a value in it."""

import math
from typing import Final

RPM: Final = math.pi / 30
"""One revolution per minute, rad/s."""

KILOGRAM_FORCE_1853: Final = 9.81
"""One kilogram-force of the papers (1853 to 1912), N: a weight of 30 kgf has a mass of 30 kg."""

KILOGRAM_FORCE_1901: Final = 9.80665
"""One kilogram-force since the standard gravity of 1901, N."""

TECHNICAL_ATMOSPHERE: Final = 1e4 * KILOGRAM_FORCE_1853
"""One technical atmosphere of the papers, kgf/cm^2, in Pa."""

TECHNICAL_ATMOSPHERE_1901: Final = 1e4 * KILOGRAM_FORCE_1901
"""One technical atmosphere with the kilogram-force of 1901, kgf/cm^2, in Pa."""

HORSEPOWER_1853: Final = 75 * KILOGRAM_FORCE_1853
"""One horsepower of the papers, 75 kgf m/s, in W."""

HORSEPOWER_1901: Final = 75 * KILOGRAM_FORCE_1901
"""One metric horsepower, PS, with the kilogram-force of 1901, in W."""

INCH: Final = 0.0254
"""One inch, m."""

"""Aliases of array types. Shapes and units stand in the docstrings of what uses them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = Any
"""(n,) numpy records; type checkers do not know their fields."""

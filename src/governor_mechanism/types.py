"""Aliases of array types and of arguments. Docstrings give shapes and units."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
FloatOrArray = float | FloatArray
"""A number, or an array of numbers that broadcasts with the other arguments."""

QuantityValues = Sequence[float | str] | FloatArray
"""Quantities as a list, tuple or array: numbers in SI, or texts with a unit."""

InputValues = float | str | Sequence[float | str] | FloatArray
"""Values of an input: SI numbers, or text with a unit."""

Progress = Callable[[int, int], None]
"""Called with the number of finished items and of all."""

ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = Any
"""Numpy records of shape (n,); type checkers do not know their fields."""


NO_INDEX = -1
"""Index in a record of what is not there: no input, no argument, no plane, no drive."""

GROUND_INDEX = -1
"""Index of the ground among the bodies. In an array with a row for the ground behind those of the bodies it is that row."""


Vector2 = tuple[float, float]
"""Vector in the plane."""

if TYPE_CHECKING:
    import pandas
    import xarray

    DataFrame = pandas.DataFrame
    Dataset = xarray.Dataset
else:
    # Both packages are optional, and slow to import.
    DataFrame = Dataset = Any

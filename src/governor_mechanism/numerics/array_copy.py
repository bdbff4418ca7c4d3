"""Copying of arrays in kernels that do not allocate: the assignment of a slice allocates, in case both arrays overlap."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.numerics.jit import jit_in_place


@jit_in_place
def copy_array(target: NDArray[Any], source: NDArray[Any]) -> None:
    """Fill an array with the values of another one of the same shape."""
    for index in np.ndindex(target.shape):
        target[index] = source[index]

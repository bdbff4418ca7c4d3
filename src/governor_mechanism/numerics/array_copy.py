"""Copying of arrays in kernels that do not allocate: the assignment of a slice allocates, in case both arrays overlap."""

import numpy as np

from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray


@jit_internal
def copy_array(target: FloatArray, source: FloatArray) -> None:
    """Fill an array with the values of another one of the same shape."""
    for index in np.ndindex(target.shape):
        target[index] = source[index]

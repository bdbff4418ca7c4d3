"""Reactions of joints over time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.types import FloatArray
from governor_mechanism.units.short_repr import short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class Reaction:
    """Reaction of a joint on its second body at its second point, at the reported times.

    The first body takes the opposite force at that point. Gears and racks are different: their first body takes a moment of its own,
    -ratio times that of the second body, or radius times the force along the rack.

    Attributes
    ----------
    force
        Components along the axes of the plane, N; shape (n, 2).
    moment
        Moment, N m, anticlockwise; shape (n,).
    determined
        Whether rigid-body mechanics determines the reaction; shape (n,). False for redundant joints, where it is one of many solutions.
    """

    force: FloatArray
    moment: FloatArray
    determined: NDArray[np.bool_]

    __repr__ = short_repr

    def _repr_html_(self) -> str:
        """Return what a notebook shows: a row for each quantity."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    @property
    def magnitude(self) -> FloatArray:
        """Magnitude of the force, N; shape (n,)."""
        return np.hypot(self.force[:, 0], self.force[:, 1])

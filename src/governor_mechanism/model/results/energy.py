"""Energies of a run over time."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray
from governor_mechanism.units.short_repr import short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class Energy:
    """Energies at the reported times, J; shape (n,).

    Attributes
    ----------
    kinetic
        Kinetic energy of the motion in the plane.
    potential
        Potential energy of gravity and springs.
    rotation
        Kinetic energy of the rotation about the spindle, J omega^2 / 2, including that of a free spindle.
    jacobi
        Jacobi integral, constant in an exact run: kinetic + potential - rotation (+ rotation for a free spindle), minus the work of
        drivers, dampers, forces and torques. Its changes are errors.
    dissipated_energy
        Energy that dashpots, dry friction and stops have dissipated since the start.
    scale
        Energy scale of the scene, J.
    """

    kinetic: FloatArray
    potential: FloatArray
    rotation: FloatArray
    jacobi: FloatArray
    dissipated_energy: FloatArray
    scale: float

    __repr__ = short_repr

    def _repr_html_(self) -> str:
        """Return what a notebook shows: a row for each quantity."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    @property
    def drift(self) -> float:
        """Largest change of the Jacobi integral, relative to `scale`."""
        return float(np.max(np.abs(self.jacobi - self.jacobi[0]))) / self.scale if self.jacobi.size else 0.0

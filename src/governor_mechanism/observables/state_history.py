"""States of a motion at a number of times."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.types import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class StateHistory:
    """States of a motion at n times.

    Attributes
    ----------
    times
        Times, s; shape (n,).
    poses
        Position (m) of the mass centre and angle (rad) of every body; shape (n, bodies, 3).
    velocities
        Their rates, m/s and rad/s; shape (n, bodies, 3).
    work
        Work put in by changes of a given spindle speed, less the work of drivers, force elements and spindle torque, J;
        shape (n,). It includes `dissipated_energy`.
    dissipated_energy
        Energy dissipated by dashpots, dry friction and stops, J; shape (n,).
    lags
        States of first-order lags; shape (n, lags).
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    work: FloatArray
    dissipated_energy: FloatArray
    lags: FloatArray

    def at(self, indices: slice | IntArray) -> StateHistory:
        """Return the states at some of the times."""
        return StateHistory(**{name: states[indices] for name, states in vars(self).items()})

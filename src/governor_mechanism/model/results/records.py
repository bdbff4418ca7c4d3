"""Records of a run: its energies and reactions over time, and the speed fluctuation of a shaft."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.results.result import Recorded
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_reading_name
from governor_mechanism.units.text_table import short_repr


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


@dataclass(frozen=True, kw_only=True)
class SpeedFluctuation(Recorded):
    """Extreme speeds of a shaft in the last complete turn of a run."""

    derived = ("mean", "coefficient")

    # lowest, highest: lowest and highest speed, rad/s
    lowest: float
    highest: float
    # lowest_angle, highest_angle: angles at which the shaft has them, rad
    lowest_angle: float
    highest_angle: float

    @property
    def mean(self) -> float:
        """Arithmetic mean of both speeds, rad/s."""
        return 0.5 * (self.lowest + self.highest)

    @property
    def coefficient(self) -> float:
        """Coefficient of speed fluctuation, (highest - lowest) / mean."""
        return (self.highest - self.lowest) / self.mean

    def __str__(self) -> str:
        low, high = (f"{speed:.6g} rad/s at {math.degrees(angle) % 360:.4g} deg" for speed, angle in self._extremes)
        return f"in the last turn {low} to {high}, coefficient of speed fluctuation {self.coefficient:.5g}"

    @property
    def _extremes(self) -> tuple[tuple[float, float], ...]:
        return (self.lowest, self.lowest_angle), (self.highest, self.highest_angle)


@dataclass(frozen=True, kw_only=True)
class Recurrence:
    """How often a named crossing recurs, as the beat of a clock, and means of what happens from one to the next.

    Attributes
    ----------
    count
        Number of crossings.
    interval
        Mean time from one to the next, s.
    interval_error
        Its error, s; None if not certified.
    advances
        Changes of the readings that go on and do not come back, SI, by name.
    units
        SI units of these readings.
    supplied
        Work of constant forces and torques, J; None where others, drivers or a spindle drive the mechanism.
    lost
        Energy that the mechanism loses, J: that work less the gain of kinetic and potential energy.
    """

    count: int
    interval: float
    interval_error: float | None = None
    advances: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    supplied: float | None = None
    lost: float | None = None

    @property
    def frequency(self) -> float:
        """Crossings in a second, Hz."""
        return 1.0 / self.interval

    def __str__(self) -> str:
        accuracy = "" if self.interval_error is None else f", accurate to {self.interval_error:.1g} s"
        means = [f"{format_reading_name(name)} {format_quantity(way, self.units[name])}" for name, way in self.advances.items()]
        if self.supplied is not None:
            means += [f"work of the forces {self.supplied:.5g} J"] * (self.supplied != 0.0) + [f"losses {self.lost:.5g} J"]
        listed = f"; from one to the next {', '.join(means)}" if means else ""
        return f"{self.count} times, every {self.interval:.8g} s{accuracy} ({self.frequency:.7g} Hz){listed}"

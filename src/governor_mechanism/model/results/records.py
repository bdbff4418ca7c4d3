"""Records of a run: how it ended and what it cost, energies and reactions over time, speed fluctuation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.results.result import Recorded
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_reading_name
from governor_mechanism.units.text_table import short_repr


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of a run.

    Attributes
    ----------
    engine
        Name of the engine.
    reason
        Reason for the choice of the engine.
    step
        Longest step of the finest run, s, or its last one.
    steps
        Number of steps.
    runs
        Number of runs for the error certificate.
    evaluations
        Number of evaluations by force law, over all runs.
    wall_time
        Time of the simulation without setup_time, s.
    setup_time
        Time to build tables, s.
    rejected
        Number of rejected steps.
    iterations
        Number of iterations of the joint solver, if it iterates.
    method
        Integration method, if the engine has a choice.
    events
        Number of contact events: stick, slip, impact, slack.
    model_size
        Counts of the model, such as bodies and constraints.
    """

    engine: str
    reason: str
    step: float
    steps: int
    runs: int
    evaluations: Mapping[str, int]
    wall_time: float
    setup_time: float = 0.0
    rejected: int = 0
    iterations: int = 0
    method: str = ""
    events: int = 0
    model_size: Mapping[str, int] = field(default_factory=dict)

    __repr__ = short_repr


FLIGHT_DETAIL = "a body flies away"
"""Cause of the end of a run in which a body leaves every bound; its outcome is LEFT_RANGE."""


class Outcome(Enum):
    """How a run ended. Each value is a sentence for the user."""

    DONE = "ran to the end within the requested accuracy"
    NOT_CERTIFIED = "ran to the end; its accuracy was not certified"
    ACCURACY_MISSED = "ran to the end, but the requested accuracy was not reached; relax it (multibody reaches the highest)"
    LEFT_RANGE = "the mechanism leaves the range in which its description is valid, and the run ends there"
    CONTROL_OUT_OF_RANGE = "a control sets what has a range to a value outside it, and the run ends there"
    SHAFT_STALLED = "the shaft would turn back, and the run ends there"
    DEAD_CENTRE = "the coordinate of the engine has a turning point there; try engine multibody"
    STIFF = "the motion is stiff, and this engine integrates explicitly; try engine multibody"
    STEP_LIMIT = "the run needs more steps than the engine allows; shorten it, slow it, or raise max_steps"
    STALLED = "the integration cannot go on from there"
    BRANCH_UNRESOLVED = "which way the mechanism goes on there is finer than the run resolves; try a higher accuracy or engine multibody"
    JOINT_OPENED = "a joint opened by more than a second-order step explains; try engine multibody"

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and met all requirements."""
        return self in (Outcome.DONE, Outcome.NOT_CERTIFIED)

    def describe(self, detail: str) -> str:
        """Return the outcome as a sentence, after its cause if there is one."""
        return f"{detail}: {self.value}" if detail else self.value


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

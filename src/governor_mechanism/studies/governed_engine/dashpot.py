"""The dashpot of a design: the motions of engine and governor about their equilibria, and the damping with which they decay fastest.

The steady motion is stable if and only if Vyshnegradskii's x y > 1. A weak dashpot lets the governor hunt; a strong one makes it so slow
that engine and governor swing together. Between them one damping makes the slowest of all motions decay fastest. It is chosen for the worst
of full, half and no load, by the polynomial of third degree with the mean torque of the engine.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form.governed_engine import CharacteristicCoefficients, pendulum_coefficients, vyshnegradskii_parameters
from governor_mechanism.closed_form.pendulum import dynamics
from governor_mechanism.closed_form.pendulum.kinematics import LinkagePosition
from governor_mechanism.studies.governed_engine.governor import GovernorDesign

LOAD_FRACTIONS = (1.0, 0.5, 0.0)
"""Loads at which the motions are judged, relative to the rated torque."""

SEARCH_DECADES, N_SEARCH_POINTS = 4.0, 161
"""Decades below and above the aperiodic damping of the governor alone in which the best one is sought, and points there: 20 a decade."""

SEARCH_TOLERANCE = 1e-10
"""Tolerance of the decimal logarithm of the damping; the decay rate there has a kink, so that its error is of the same order."""


@dataclass(frozen=True, kw_only=True)
class LoopMotion:
    """Small motions of engine and governor about an equilibrium.

    Attributes
    ----------
    load_fraction
        Load over the rated torque.
    coefficients
        Coefficients a (1/s), b (1/s2), c (1/s3) of the characteristic polynomial s^3 + a s^2 + b s + c.
    x, y
        Vyshnegradskii's parameters; stable if x y > 1.
    roots
        Roots of the polynomial, 1/s, the least damped first.
    """

    load_fraction: float
    coefficients: CharacteristicCoefficients
    x: float
    y: float
    roots: tuple[complex, complex, complex]

    @property
    def decay_rate(self) -> float:
        """Rate at which the slowest motion decays, 1/s; negative if it grows."""
        return -max(root.real for root in self.roots)


@dataclass(frozen=True, kw_only=True)
class DashpotDesign:
    """A dashpot at the sleeve.

    Attributes
    ----------
    damping
        Its damping, N s/m.
    is_given
        Whether it was an input.
    smallest_stable_damping
        Damping with x y = 1 at the worst load, N s/m.
    motions
        The motions at full, half and no load.
    """

    damping: float
    is_given: bool
    smallest_stable_damping: float
    motions: tuple[LoopMotion, ...]

    @property
    def decay_rate(self) -> float:
        """Rate at which the slowest motion at any of the loads decays, 1/s."""
        return min(motion.decay_rate for motion in self.motions)

    @property
    def stability_margin(self) -> float:
        """Smallest x y of the loads; 1 is Vyshnegradskii's limit."""
        return min(motion.x * motion.y for motion in self.motions)


def design_dashpot(governor: GovernorDesign, flywheel_inertia: float, torque_slope: float, given: float | None) -> DashpotDesign:
    """Return the dashpot with which all motions decay fastest, or a given one.

    Parameters
    ----------
    governor
        The governor.
    flywheel_inertia
        Moment of inertia of flywheel and shaft, kg m2.
    torque_slope
        dM/dz of the engine's mean torque by the lift of the sleeve, N m/m; negative.
    given
        Damping of a given dashpot, N s/m; None to choose it.

    Returns
    -------
    DashpotDesign
        The dashpot.
    """
    shaft = {"flywheel_inertia": flywheel_inertia, "torque_slope": torque_slope, "gear_ratio": governor.gear_ratio}
    damping = _best_damping(governor, shaft) if given is None else given
    return DashpotDesign(
        damping=damping,
        is_given=given is not None,
        smallest_stable_damping=max(_limiting_damping(governor, shaft, fraction) for fraction in LOAD_FRACTIONS),
        motions=tuple(_motion(governor, shaft, fraction, damping) for fraction in LOAD_FRACTIONS),
    )


def _motion(governor: GovernorDesign, shaft: Mapping[str, Any], fraction: float, damping: float) -> LoopMotion:
    """Return the motions at a load with a dashpot."""
    coefficients = pendulum_coefficients(governor.governor, arm_angle=governor.arm_angle(fraction), sleeve_damping=damping, **shaft)
    x, y = (float(value) for value in vyshnegradskii_parameters(coefficients))
    return LoopMotion(load_fraction=fraction, coefficients=coefficients, x=x, y=y, roots=coefficients.roots())


def _limiting_damping(governor: GovernorDesign, shaft: Mapping[str, Any], fraction: float) -> float:
    """Return the damping with a b = c, N s/m: a is proportional to it, and b and c do not depend on it without self-regulation."""
    unit = _motion(governor, shaft, fraction, 1.0).coefficients
    return float(unit.c) / (float(unit.a) * float(unit.b))


def _best_damping(governor: GovernorDesign, shaft: Mapping[str, Any]) -> float:
    """Return the damping with the largest decay rate of the slowest motion at the worst load, N s/m."""
    angle = governor.arm_angle(LOAD_FRACTIONS[1])
    position = LinkagePosition(governor.governor, angle)
    inertia = float(position.in_plane_inertia_and_derivative()[0])
    stiffness = float(dynamics.stiffness(governor.governor, arm_angle=angle))
    aperiodic = 2 * np.sqrt(inertia * stiffness) / float(position.sleeve_derivative) ** 2

    def growth_rate(exponent: float) -> float:
        damping = float(aperiodic * 10.0**exponent)
        return -min(_motion(governor, shaft, fraction, damping).decay_rate for fraction in LOAD_FRACTIONS)

    grid = np.linspace(-SEARCH_DECADES, SEARCH_DECADES, N_SEARCH_POINTS)
    best = int(np.argmin([growth_rate(float(exponent)) for exponent in grid]))
    bounds = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(growth_rate, bounds=bounds, method="bounded", options={"xatol": SEARCH_TOLERANCE})
    return float(aperiodic * 10.0 ** float(found.x))

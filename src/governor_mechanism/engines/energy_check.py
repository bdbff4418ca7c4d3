"""Smallest error that explains the drift of the energy balance: no honest error estimate is below it."""

import math

import numpy as np

from governor_mechanism.model.results.energy import Energy

ENERGY_ROUNDING_RATIO = 1e-13
"""Drift relative to the largest of the energies that add up to it: rounding, summed over the steps of a run."""


def smallest_error_of_drift(
    energy: Energy,
    spring_energy_scale: float,  # m (L s)^2 with the rate s of the stiffest spring, k = m s^2, J
) -> float:
    """Return the smallest error of readings and rates, relative to their scales, that changes the energy by its drift.

    With the scales m, L and r of mass, length and rate, an error e moves every point by at most e L and changes its velocity by at most
    e L r. That changes a kinetic energy T by sqrt(2 m T) e L r, in units of m (L r)^2 by e sqrt(2 T); the work of loads by e, because r
    is at least their rate; and the energy V of a spring of stiffness k by sqrt(2 k V) e L.

    Result: error relative to the scales; 0 if the drift is rounding.
    """
    if energy.jacobi.size < 2:
        return 0.0
    terms = (energy.kinetic, energy.potential, energy.rotation, energy.jacobi)
    rounding = ENERGY_ROUNDING_RATIO * max(float(np.max(np.abs(term))) for term in terms) / energy.scale
    kinetic = float(np.max(energy.kinetic + energy.rotation)) / energy.scale
    potential = float(np.ptp(energy.potential)) * spring_energy_scale / energy.scale**2
    change_per_error = 1.0 + math.sqrt(2.0 * kinetic) + math.sqrt(2.0 * potential)
    return max(energy.drift - rounding, 0.0) / change_per_error

"""Stability of an engine under a governor, linearised at the equilibrium.

A governor with the coordinate q stands on a spindle that turns at a fixed ratio r to the engine's shaft, omega = r Omega. With its
in-plane inertia I, the moment of inertia J(q) about the spindle, the stiffness K = V'' - omega^2 J'' / 2 and M = J' omega:

    I q'' + C q' + K q = M omega        J_s Omega' = T q - r M q'

All variables are deviations from the equilibrium. T is the derivative of the shaft's torque by q, J_s the moment of inertia of all that
turns, referred to the shaft. If the spindle returns no torque to the shaft, the term r M q' is absent.

References
----------
I. A. Vyshnegradskii, Ueber directwirkende Regulatoren, Civilingenieur 23 (1877), pp. 95-132. J. C. Maxwell, On governors, Proceedings of
the Royal Society 16 (1868), pp. 270-283. The limits are Hurwitz's condition a2 a1 = a0 for s^3 + a2 s^2 + a1 s + a0.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class SpeedLoop:
    """A linearised loop of governor and engine. The units are those of a coordinate in rad; in m they change accordingly.

    Attributes
    ----------
    governor_inertia
        In-plane inertia I, kg m2.
    damping
        Damping C along the coordinate, N m s/rad.
    stiffness
        Stiffness K at constant speed, N m/rad.
    speed_moment
        M = J' omega, N m s/rad: the derivative of the centrifugal moment by the spindle speed.
    shaft_inertia
        Moment of inertia J_s, kg m2; with a reaction it includes r^2 J of the governor.
    torque_derivative
        Derivative T of the torque on the shaft by the coordinate, N m/rad; negative where the governor shuts the engine off.
    ratio
        Spindle speed relative to shaft speed r.
    is_reacting
        Whether the spindle returns its torque to the shaft, as a gear does.
    """

    governor_inertia: float
    damping: float
    stiffness: float
    speed_moment: float
    shaft_inertia: float
    torque_derivative: float
    ratio: float = 1.0
    is_reacting: bool = True


def characteristic_polynomial(loop: SpeedLoop) -> np.ndarray:
    """Return the coefficients 1, a2, a1, a0 of the characteristic polynomial, the highest power first."""
    control = -loop.ratio * loop.torque_derivative * loop.speed_moment / (loop.governor_inertia * loop.shaft_inertia)
    return np.array([1.0, loop.damping / loop.governor_inertia, _total_stiffness(loop) / loop.governor_inertia, control])


def eigenvalues(loop: SpeedLoop) -> np.ndarray:
    """Return the three eigenvalues (1/s)."""
    return np.roots(characteristic_polynomial(loop))


def limit_frequency(loop: SpeedLoop) -> float:
    """Return the angular frequency of hunting at the limit of stability, rad/s: that of the governor undamped, with an idle control.

    The stiffness with the reaction of the shaft must be positive: otherwise no damping makes the loop stable.
    """
    return math.sqrt(_total_stiffness(loop) / loop.governor_inertia)


def critical_damping(loop: SpeedLoop) -> float:
    """Return the damping below which the loop hunts, -r T M / (J_s limit_frequency^2), N m s/rad; its own damping does not matter."""
    return -loop.ratio * loop.torque_derivative * loop.speed_moment / (loop.shaft_inertia * limit_frequency(loop) ** 2)


def critical_torque_derivative(loop: SpeedLoop) -> float:
    """Return the derivative of the torque beyond which the loop hunts, -C J_s limit_frequency^2 / (r M), N m/rad."""
    return -loop.damping * loop.shaft_inertia * limit_frequency(loop) ** 2 / (loop.ratio * loop.speed_moment)


def _total_stiffness(loop: SpeedLoop) -> float:
    """Return K, with the reaction K + (r M)^2 / J_s: a free shaft slows down as the governor opens."""
    return loop.stiffness + (loop.ratio * loop.speed_moment) ** 2 / loop.shaft_inertia * loop.is_reacting

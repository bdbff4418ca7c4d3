"""Graham's dead-beat escapement on a pendulum: energy of a beat, amplitude by its balance, and rate by Airy's condition.

Tips of teeth rest on arcs about the axis of the anchor, and push it on along the oblique ends of its pallets, which wheel and anchor
follow at a constant ratio of their angles. Between both the wheel falls free by its drop. SI, rad; a beat is half a period.

The escapement is the first argument; the others are keywords. Every function raises MechanismError for a value that is not finite or out
of range.

References
----------
G. B. Airy, On the disturbances of pendulums and balances, and on the theory of escapements, Transactions of the Cambridge
Philosophical Society 3 (1826), 105-128, for the phase of a kick. The rest follows from the balance of energies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatOrArray


@dataclass(frozen=True, kw_only=True)
class DeadBeat:
    """A dead-beat escapement, and the pendulum that it keeps going.

    MechanismError is raised unless torque, travel, lift, frequency and inertia are positive, and the others are not negative.

    Attributes
    ----------
    torque
        Torque on the escape wheel, N m.
    travel
        Angle by which the wheel turns along the end of a pallet, rad.
    lift
        Angle of the anchor meanwhile, rad.
    unlock
        Angle of the anchor before the middle at which a tooth leaves its arc, rad.
    wheel_inertia
        Moment of inertia of the wheel, kg m2.
    inertia
        Moment of inertia of pendulum and anchor about the axis, kg m2.
    frequency
        Angular frequency of small oscillations of the pendulum, rad/s.
    damping
        Torque of the air over the angular velocity, N m s/rad.
    friction
        Coefficient of friction of teeth and pallets.
    arm_ratio
        Radius of the pallets over that of the tips; 1 where they meet at right angles at 45 degrees.
    """

    torque: float
    travel: float
    lift: float
    unlock: float
    inertia: float
    frequency: float
    wheel_inertia: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    arm_ratio: float = 1.0

    def __post_init__(self) -> None:
        """Validate the values."""
        units = {"torque": "N m", "travel": "rad", "lift": "rad", "inertia": "kg m2", "frequency": "rad/s", "arm_ratio": "1"}
        for name, unit in units.items():
            validate_argument(getattr(self, name), name, unit, greater_than=0.0)
        validate_fields(self, {"unlock": "rad", "wheel_inertia": "kg m2", "damping": "N m s/rad", "friction": "1"}, minimum=0.0)

    @property
    def slope(self) -> float:
        """Slope of the end of a pallet: way of the tip along the radius over the way of the pallet across it."""
        return self.travel / (self.lift * self.arm_ratio)

    @property
    def efficiency(self) -> float:
        """Share of the work of the wheel that friction leaves the anchor during an impulse."""
        return (1 - self.friction / self.slope) / (1 + self.friction * self.slope)


def impulse_energy(escapement: DeadBeat, *, amplitude: float) -> float:
    """Return the energy that the pendulum takes up in a beat.

    It is the work of the wheel along the end of a pallet, less the energy with which the wheel leaves it, times the efficiency.

    Parameters
    ----------
    escapement
        The escapement.
    amplitude
        Amplitude of the pendulum, rad.

    Returns
    -------
    float
        Energy, J.

    Raises
    ------
    MechanismError
        If the pendulum does not swing so far that a tooth is let go.
    """
    end = escapement.lift - escapement.unlock
    least = max(end, escapement.unlock)
    if not validate_argument(amplitude, "amplitude", "rad") > least:
        raise MechanismError(f"a tooth is let go from an amplitude of {least:.9g} rad on; got {amplitude:.9g} rad")
    wheel_speed = escapement.travel / escapement.lift * escapement.frequency * math.sqrt(amplitude**2 - end**2)
    return (escapement.torque * escapement.travel - escapement.wheel_inertia * wheel_speed**2 / 2) * escapement.efficiency


def lost_energy(escapement: DeadBeat, *, amplitude: float) -> float:
    """Return the energy that the pendulum loses in a beat, to the air and to the friction of teeth at rest on their arcs.

    Parameters
    ----------
    escapement
        The escapement.
    amplitude
        Amplitude of the pendulum, rad.

    Returns
    -------
    float
        Energy, J.
    """
    rubbing = escapement.friction * escapement.torque * escapement.arm_ratio * (2 * amplitude - escapement.lift)
    return math.pi / 2 * escapement.damping * escapement.frequency * amplitude**2 + rubbing


def steady_amplitude(escapement: DeadBeat) -> float:
    """Return the amplitude at which a beat gives the pendulum what it loses.

    Parameters
    ----------
    escapement
        The escapement.

    Returns
    -------
    float
        Amplitude, rad.

    Raises
    ------
    MechanismError
        If the losses stop the pendulum, or if nothing bounds the amplitude below 1 rad.
    """

    def excess(amplitude: float) -> float:
        return impulse_energy(escapement, amplitude=amplitude) - lost_energy(escapement, amplitude=amplitude)

    least = max(escapement.lift - escapement.unlock, escapement.unlock) * (1 + 1e-9)
    if excess(least) <= 0.0:
        raise MechanismError("the losses of a beat are larger than its energy at any amplitude: the clock stops")
    if excess(1.0) >= 0.0:
        raise MechanismError("the energy of a beat is larger than its losses up to an amplitude of 1 rad; give more damping")
    return find_root(excess, least, 1.0)


def circular_error(amplitude: FloatOrArray) -> FloatOrArray:
    """Return the period of a pendulum over that of small oscillations, to the fourth power of the amplitude.

    Parameters
    ----------
    amplitude
        Amplitude, rad.

    Returns
    -------
    float or ndarray
        1 + amplitude^2 / 16 + 11 amplitude^4 / 3072.
    """
    square = np.asarray(validate_argument(amplitude, "amplitude", "rad")) ** 2
    return as_scalar_or_array(1 + square / 16 + 11 * square**2 / 3072)


def kick_phase(*, position: FloatOrArray, speed_change: FloatOrArray, amplitude: float, frequency: float) -> FloatOrArray:
    """Return the phase by which a small kick sets an oscillation ahead: none at the middle, a gain before it, a loss behind it.

    Parameters
    ----------
    position
        Where it happens, rad, in the direction of the motion from the middle.
    speed_change
        Change of the speed by it, rad/s, in the direction of the motion.
    amplitude
        Amplitude, rad.
    frequency
        Angular frequency, rad/s.

    Returns
    -------
    float or ndarray
        Phase, rad.
    """
    validate_argument(amplitude, "amplitude", "rad", greater_than=0.0)
    validate_argument(frequency, "frequency", "rad/s", greater_than=0.0)
    place, change = (
        np.asarray(validate_argument(value, name, unit))
        for value, name, unit in ((position, "position", "rad"), (speed_change, "speed_change", "rad/s"))
    )
    return as_scalar_or_array(-place * change / (frequency * amplitude**2))


def beat_period(escapement: DeadBeat, *, amplitude: float) -> float:
    """Return the time of a beat with the circular error and with Airy's error of an impulse that is not about the middle.

    Parameters
    ----------
    escapement
        The escapement.
    amplitude
        Amplitude of the pendulum, rad.

    Returns
    -------
    float
        Time, s.
    """
    torque = impulse_energy(escapement, amplitude=amplitude) / escapement.lift
    start, end = (math.sqrt(amplitude**2 - x**2) for x in (escapement.unlock, escapement.lift - escapement.unlock))
    # A constant torque T over the impulse: the kicks T dt / I at x add up with x dt = x dx / (frequency sqrt(amplitude^2 - x^2)).
    phase = -torque * (start - end) / (escapement.inertia * (escapement.frequency * amplitude) ** 2)
    return math.pi / escapement.frequency * float(circular_error(amplitude)) * (1 - phase / math.pi)

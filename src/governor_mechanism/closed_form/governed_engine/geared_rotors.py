"""Two free rotors joined by a gear: speeds after engagement, lost energy, motion under torques.

The second rotor turns at ratio times the speed of the first, w2 = r w1. The gear passes an impulse P on to the second rotor and -r P on
to the first, so that J1 w1 + r J2 w2 is conserved; the angular momentum is conserved only for r = 1, as the bearings take the rest.

References
----------
E. J. Routh, Dynamics of a System of Rigid Bodies, part 1, chapter 4: impulses on bodies that turn about fixed axes.
"""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.closed_form.arguments import raise_where, validate_fields


@dataclass(frozen=True, kw_only=True)
class GearedRotors:
    """Moments of inertia (kg m2) of two rotors, and the speed of the second relative to the first; negative: opposite sense."""

    first_inertia: float
    second_inertia: float
    ratio: float

    def __post_init__(self) -> None:
        validate_fields(self, {"first_inertia": "kg m2", "second_inertia": "kg m2"}, minimum=0.0)
        validate_fields(self, {"ratio": ""})
        message = "the rotors together must have some inertia about the first axis"
        raise_where(self.referred_inertia <= 0, message, ("first_inertia + ratio^2 second_inertia", self.referred_inertia, "kg m2"))

    @property
    def referred_inertia(self) -> float:
        """Moment of inertia referred to the first axis, J1 + r^2 J2 (kg m2)."""
        return self.first_inertia + self.ratio**2 * self.second_inertia


def engaged_speed(rotors: GearedRotors, *, first_speed: float, second_speed: float) -> float:
    """Return the speed of the first rotor after engagement, (J1 w1 + r J2 w2) / (J1 + r^2 J2), rad/s."""
    return (rotors.first_inertia * first_speed + rotors.ratio * rotors.second_inertia * second_speed) / rotors.referred_inertia


def engagement_impulse(rotors: GearedRotors, *, first_speed: float, second_speed: float) -> float:
    """Return the impulse passed on to the second rotor, J1 J2 (r w1 - w2) / (J1 + r^2 J2), N m s."""
    product = rotors.first_inertia * rotors.second_inertia
    return product * (rotors.ratio * first_speed - second_speed) / rotors.referred_inertia


def engagement_loss(rotors: GearedRotors, *, first_speed: float, second_speed: float) -> float:
    """Return the kinetic energy lost in engagement, J1 J2 (r w1 - w2)^2 / (2 (J1 + r^2 J2)), J."""
    slip = rotors.ratio * first_speed - second_speed
    return slip * engagement_impulse(rotors, first_speed=first_speed, second_speed=second_speed) / 2


def geared_acceleration(rotors: GearedRotors, *, first_torque: float, second_torque: float) -> float:
    """Return the angular acceleration of the first rotor under torques on both, (t1 + r t2) / (J1 + r^2 J2), rad/s2."""
    return (first_torque + rotors.ratio * second_torque) / rotors.referred_inertia


def transmitted_torque(rotors: GearedRotors, *, first_torque: float, second_torque: float) -> float:
    """Return the torque of the gear on the second rotor, (r J2 t1 - J1 t2) / (J1 + r^2 J2), N m."""
    moment = rotors.ratio * rotors.second_inertia * first_torque - rotors.first_inertia * second_torque
    return moment / rotors.referred_inertia

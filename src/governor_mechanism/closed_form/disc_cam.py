"""A disc cam with a radial roller follower, or a flat one, on a spring: laws of lift, contact force, and the speed of lift-off.

The path of the roller's centre is given, as r(angle) = base radius + lift, so that the lift is that of the follower; or the flat
is at that distance from the shaft. The spring and the weight press the follower on the cam with `preload` at no lift; parts are rigid and
without friction. SI, rad.

The law is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite or out of range.

References
----------
H. A. Rothbart, Cam Design Handbook (2004), chapter 2, for the laws of lift. The rest follows from Newton's law.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatOrArray

CYCLOIDAL, HARMONIC = "cycloidal", "harmonic"
"""Laws of lift."""


@dataclass(frozen=True, kw_only=True)
class CamRise:
    """A rise of a cam, and the follower that it lifts.

    MechanismError is raised unless lift, angle and mass are positive and stiffness and preload are not negative.

    Attributes
    ----------
    law
        "cycloidal", s = h (u - sin(2 pi u) / 2 pi), or "harmonic", s = h (1 - cos(pi u)) / 2, with u from 0 to 1.
    lift
        Lift h, m.
    angle
        Angle of the rise, rad.
    mass
        Mass of the follower, kg.
    stiffness
        Stiffness of its spring, N/m.
    preload
        Force of spring and weight on the cam at no lift, N.
    """

    law: str
    lift: float
    angle: float
    mass: float
    stiffness: float = 0.0
    preload: float = 0.0

    def __post_init__(self) -> None:
        """Validate the values."""
        if self.law not in (CYCLOIDAL, HARMONIC):
            raise MechanismError(f"the law of a cam's lift is {CYCLOIDAL!r} or {HARMONIC!r}; got {self.law!r}")
        for name, unit in (("lift", "m"), ("angle", "rad"), ("mass", "kg")):
            validate_argument(getattr(self, name), name, unit, greater_than=0.0)
        validate_fields(self, {"stiffness": "N/m", "preload": "N"}, minimum=0.0)


def lift_at(rise: CamRise, *, share: FloatOrArray, derivative: int = 0) -> FloatOrArray:
    """Return the lift at a share of the angle of the rise, or a derivative of it by the angle of the cam.

    Parameters
    ----------
    rise
        The rise.
    share
        Share u of the angle of the rise, 0 to 1.
    derivative
        0 for the lift, m; 1, 2 or 3 for its derivatives, m/rad, m/rad2 and m/rad3.

    Returns
    -------
    float or ndarray
        Lift or derivative.

    Raises
    ------
    MechanismError
        If the share is not finite, or there is no such derivative.
    """
    u, h = validate_argument(share, "share", ""), rise.lift
    if derivative not in (0, 1, 2, 3):
        raise MechanismError(f"derivative must be 0, 1, 2 or 3; got {derivative!r}")
    if rise.law == CYCLOIDAL:
        turn = 2 * math.pi * u
        terms = (u - np.sin(turn) / (2 * math.pi), 1 - np.cos(turn), 2 * math.pi * np.sin(turn), 4 * math.pi**2 * np.cos(turn))
        return as_scalar_or_array(h * terms[derivative] / rise.angle**derivative)
    turn = math.pi * u
    terms = ((1 - np.cos(turn)) / 2, np.sin(turn) / 2, np.cos(turn) / 2, -np.sin(turn) / 2)
    return as_scalar_or_array(h * terms[derivative] * (math.pi / rise.angle) ** derivative)


def contact_force(rise: CamRise, *, share: FloatOrArray, speed: FloatOrArray) -> FloatOrArray:
    """Return the force of the cam along the follower's guide; negative where the cam would have to pull.

    Parameters
    ----------
    rise
        The rise.
    share
        Share of the angle of the rise, 0 to 1.
    speed
        Speed of the cam, rad/s.

    Returns
    -------
    float or ndarray
        Force, N.

    Raises
    ------
    MechanismError
        If a value is not finite.
    """
    omega = validate_argument(speed, "speed", "rad/s")
    press = rise.preload + rise.stiffness * np.asarray(lift_at(rise, share=share))
    return as_scalar_or_array(press + rise.mass * omega**2 * np.asarray(lift_at(rise, share=share, derivative=2)))


def curvature_radius_under_flat(rise: CamRise, *, base: float, share: FloatOrArray) -> FloatOrArray:
    """Return the radius of curvature of the cam where it touches a flat follower; without hollows and edges it is positive everywhere.

    The point of contact is beside the axis of the follower by the first derivative of the lift.

    Parameters
    ----------
    rise
        The rise.
    base
        Distance of the flat from the shaft at no lift, m.
    share
        Share of the angle of the rise, 0 to 1.

    Returns
    -------
    float or ndarray
        Radius base + s + s'', m.

    Raises
    ------
    MechanismError
        If a value is not finite, or the base is not positive.
    """
    height = validate_argument(base, "base", "m", greater_than=0.0)
    return as_scalar_or_array(height + np.asarray(lift_at(rise, share=share)) + np.asarray(lift_at(rise, share=share, derivative=2)))


def lift_off_speed(rise: CamRise) -> float:
    """Return the speed of the cam above which the follower leaves it in the second half of the rise.

    Parameters
    ----------
    rise
        The rise.

    Returns
    -------
    float
        Speed, rad/s; 0 if nothing presses the follower on the cam.
    """
    share = 1.0 if rise.law == HARMONIC else find_root(lambda u: _steepness(rise, u), 0.5, 1.0)
    press = rise.preload + rise.stiffness * float(lift_at(rise, share=share))
    return math.sqrt(press / (-rise.mass * float(lift_at(rise, share=share, derivative=2))))


def _steepness(rise: CamRise, share: float) -> float:
    """Return what is 0 where the pressing force over the deceleration is least, and falls there."""
    lift, slope, second, third = (float(lift_at(rise, share=share, derivative=k)) for k in range(4))
    return rise.stiffness * slope * second - (rise.preload + rise.stiffness * lift) * third


def lift_off_share(rise: CamRise, *, speed: float) -> float:
    """Return the share of the angle of the rise at which the follower leaves the cam.

    Parameters
    ----------
    rise
        The rise.
    speed
        Speed of the cam, rad/s; above that of `lift_off_speed`.

    Returns
    -------
    float
        Share, 0 to 1.

    Raises
    ------
    MechanismError
        If the follower stays on the cam at this speed.
    """
    least = lift_off_speed(rise)
    if not speed > least:
        raise MechanismError(f"the follower stays on the cam up to {least:.12g} rad/s; got {speed:.12g} rad/s")
    last = 1.0 if rise.law == HARMONIC else find_root(lambda u: _steepness(rise, u), 0.5, 1.0)
    return find_root(lambda u: float(contact_force(rise, share=u, speed=speed)), 0.5, last)

"""Sizing of a Porter governor with equal arms and links: the offset or the travel for a given ratio of speeds, masses, insensitivity.

The arms of length l hang at the offset e from the axis at the angle a from the vertical; the sleeve rises by z = 2 l (1 - cos a) from
its place at vertical arms; w^2 = g (1 + m) tan a / (e + l sin a) with the mass ratio m of sleeve and one ball. All arguments are keywords,
floats or arrays that broadcast; floats give a float. SI and radians. Every function raises MechanismError for a value that is not finite
or not positive where it must be.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14, equations (1)-(3) and the procedure I to VIII.
"""

from __future__ import annotations

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument
from governor_mechanism.types import FloatArray, FloatOrArray


def _positive(value: FloatOrArray, name: str, unit: str) -> FloatArray:
    return validate_argument(value, name, unit, greater_than=0.0)


def lift_of_angle(*, arm: FloatOrArray, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the lift of the sleeve, z = 2 l (1 - cos a).

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    arm_angle
        Arm angle a, rad.

    Returns
    -------
    FloatOrArray
        Lift, m.
    """
    return as_scalar_or_array(4 * _positive(arm, "arm", "m") * np.sin(validate_angle(arm_angle, "arm_angle", 90.0) / 2) ** 2)


def angle_of_lift(*, arm: FloatOrArray, lift: FloatOrArray) -> FloatOrArray:
    """Return the arm angle at which the sleeve has risen by a lift.

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    lift
        Lift z, m; 0 to 2 l.

    Returns
    -------
    FloatOrArray
        Arm angle a, rad.

    Raises
    ------
    MechanismError
        If the sleeve cannot rise so far.
    """
    length = _positive(arm, "arm", "m")
    height = validate_argument(lift, "lift", "m", minimum=0.0)
    raise_where(height >= 2 * length, "the lift must be below twice the arm", ("lift", height, "m"), ("arm", length, "m"))
    return as_scalar_or_array(2 * np.arcsin(np.sqrt(height / (4 * length))))


def speed_ratio(*, arm: FloatOrArray, offset: FloatOrArray, inner_angle: FloatOrArray, outer_angle: FloatOrArray) -> FloatOrArray:
    """Return the ratio of the equilibrium speeds at an outer and an inner arm angle; it does not depend on the masses.

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    offset
        Distance e of the suspension from the axis, m; negative for crossed arms.
    inner_angle
        Inner arm angle, rad.
    outer_angle
        Outer arm angle, rad.

    Returns
    -------
    FloatOrArray
        Outer over inner speed.

    Raises
    ------
    MechanismError
        If a ball is on or beyond the axis.
    """
    length = _positive(arm, "arm", "m")
    distance = validate_argument(offset, "offset", "m")
    inner, outer = (
        validate_angle(angle, name, 90.0, positive=True) for angle, name in ((inner_angle, "inner_angle"), (outer_angle, "outer_angle"))
    )
    radii = distance + length * np.sin(inner), distance + length * np.sin(outer)
    raise_where(np.minimum(*radii) <= 0, "the ball is on or beyond the axis", ("offset", distance, "m"), hint="increase the offset")
    return as_scalar_or_array(np.sqrt(np.tan(outer) * radii[0] / (np.tan(inner) * radii[1])))


def offset_for_speed_ratio(*, arm: FloatOrArray, inner_angle: FloatOrArray, outer_angle: FloatOrArray, ratio: FloatOrArray) -> FloatOrArray:
    """Return the offset of the suspension with which the equilibrium speeds at two arm angles have a ratio.

    From k^2 tan a1 (e + l sin a2) = tan a2 (e + l sin a1), which is linear in e.

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    inner_angle
        Inner arm angle a1, rad.
    outer_angle
        Outer arm angle a2, rad.
    ratio
        Ratio k of the outer and the inner speed.

    Returns
    -------
    FloatOrArray
        Offset e, m; negative for crossed arms.

    Raises
    ------
    MechanismError
        If the ratio is not below sqrt(tan a2 / tan a1), to which it tends with a growing offset.
    """
    length = _positive(arm, "arm", "m")
    inner, outer = (
        validate_angle(angle, name, 90.0, positive=True) for angle, name in ((inner_angle, "inner_angle"), (outer_angle, "outer_angle"))
    )
    scaled = _positive(ratio, "ratio", "") ** 2 * np.tan(inner)
    denominator = np.tan(outer) - scaled
    raise_where(denominator <= 0, "no offset gives so large a ratio of speeds", ("ratio", ratio, ""), hint="increase the outer angle")
    return as_scalar_or_array(length * (scaled * np.sin(outer) - np.tan(outer) * np.sin(inner)) / denominator)


def smallest_stable_offset(*, arm: FloatOrArray, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the offset of crossed arms with which the equilibrium at an arm angle is neutral, e = -l sin^3 a; above it, it is stable.

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    arm_angle
        Arm angle a, rad.

    Returns
    -------
    FloatOrArray
        Offset e, m.
    """
    return as_scalar_or_array(-_positive(arm, "arm", "m") * np.sin(validate_angle(arm_angle, "arm_angle", 90.0)) ** 3)


def ball_mass_for_insensitivity(
    *, resistance: FloatOrArray, mass_ratio: FloatOrArray, insensitivity: FloatOrArray, gravity: float
) -> FloatOrArray:
    """Return the mass of one ball by Zehnder's rule (I), P = W / ((1 + m) d).

    Parameters
    ----------
    resistance
        Resistance W at the sleeve, N.
    mass_ratio
        Mass m of the sleeve over that of one ball.
    insensitivity
        Degree of insensitivity d: the range of speed in which the resistance holds the sleeve, over the speed.
    gravity
        Gravitational acceleration, m/s2.

    Returns
    -------
    FloatOrArray
        Mass, kg.
    """
    loaded = 1 + validate_argument(mass_ratio, "mass_ratio", "", minimum=0.0)
    weight = _positive(resistance, "resistance", "N") / (loaded * _positive(insensitivity, "insensitivity", ""))
    return as_scalar_or_array(weight / _positive(gravity, "gravity", "m/s2"))


def sleeve_force(*, ball_mass: FloatOrArray, sleeve_mass: FloatOrArray, gravity: float) -> FloatOrArray:
    """Return the force P + Q that holds down the sleeve at standstill: the weight of one ball and of the sleeve.

    A resistance W at the sleeve makes the degree of insensitivity W / (P + Q); at a speed of 1 + p times that of equilibrium the sleeve
    exerts ((1 + p)^2 - 1) (P + Q).

    Parameters
    ----------
    ball_mass
        Mass of one ball, kg.
    sleeve_mass
        Mass of the sleeve, kg.
    gravity
        Gravitational acceleration, m/s2.

    Returns
    -------
    FloatOrArray
        Force, N.
    """
    mass = _positive(ball_mass, "ball_mass", "kg") + validate_argument(sleeve_mass, "sleeve_mass", "kg", minimum=0.0)
    return as_scalar_or_array(mass * _positive(gravity, "gravity", "m/s2"))

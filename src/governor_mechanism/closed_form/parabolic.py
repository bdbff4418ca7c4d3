"""The isochronous parabola of pendulum governors, its osculating circle, the guide along it, and the change of speed beside it.

A ball is in neutral equilibrium at the spindle speed w on a path of slope w^2 x / (g (1 + m)), the parabola x^2 = c y with its vertex on
the axis. m is `mass_ratio`, the mass of the sleeve over that of one ball; the sleeve moves twice as fast as the balls rise. x is the
distance from the spindle axis, y the height, both in m; angles are in rad.

On a circle that touches the parabola, the arm is normal to both curves at the start. Its angle is `start_angle` (from the vertical), the
ball is at `start_abscissa`, and the suspension at start_abscissa - arm sin(a). Changes of speed are relative to the equilibrium speed at
the start; load and gravity cancel.

Arguments are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that is not
finite or out of range, for angles not between 0 and 90 deg, and for a ball that crosses the axis. The linkage is a rhombus with massless
rods and no friction.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument
from governor_mechanism.types import FloatArray, FloatOrArray


def double_parameter(*, spindle_speed: FloatOrArray, mass_ratio: FloatOrArray = 0.0, gravity: FloatOrArray = 9.81) -> FloatOrArray:
    """Return the double parameter of the isochronous parabola of a spindle speed, c = 2 g (1 + m) / w^2.

    Parameters
    ----------
    spindle_speed
        Spindle speed w, rad/s; positive.
    mass_ratio
        Mass of the sleeve over the mass of one ball; at least 0.
    gravity
        Gravitational acceleration g, m/s2; positive.

    Returns
    -------
    FloatOrArray
        Double parameter c, m.

    References
    ----------
    Zehnder (1877), equation (III).
    """
    gravity_load = validate_argument(gravity, "gravity", "m/s2", greater_than=0.0) * (
        1 + validate_argument(mass_ratio, "mass_ratio", "", minimum=0.0)
    )
    return as_scalar_or_array(2 * gravity_load / validate_argument(spindle_speed, "spindle_speed", "rad/s", greater_than=0.0) ** 2)


def parabola_height(*, abscissa: FloatOrArray, double_parameter: FloatOrArray) -> FloatOrArray:
    """Return the height of the parabola above its vertex, y = x^2 / c.

    Parameters
    ----------
    abscissa
        Distance x from the axis, m.
    double_parameter
        Double parameter c, m; positive.

    Returns
    -------
    FloatOrArray
        Height y, m.
    """
    c = validate_argument(double_parameter, "double_parameter", "m", greater_than=0.0)
    return as_scalar_or_array(validate_argument(abscissa, "abscissa", "m") ** 2 / c)


def radius_of_curvature(*, abscissa: FloatOrArray, double_parameter: FloatOrArray) -> FloatOrArray:
    """Return the radius of curvature of the parabola, (c^2 + 4 x^2)^(3/2) / (2 c^2): the longest useful arm.

    Parameters
    ----------
    abscissa
        Distance x from the axis, m.
    double_parameter
        Double parameter c, m; positive.

    Returns
    -------
    FloatOrArray
        Radius of curvature, m.

    References
    ----------
    Zehnder (1877), equation (V).
    """
    c = validate_argument(double_parameter, "double_parameter", "m", greater_than=0.0)
    slope = 2 * validate_argument(abscissa, "abscissa", "m") / c
    return as_scalar_or_array(c / 2 * (1 + slope**2) ** 1.5)


def guide_transit_time(
    *, start: FloatOrArray, end: FloatOrArray, start_rate: FloatOrArray, double_parameter: FloatOrArray, mass_ratio: FloatOrArray = 0.0
) -> FloatOrArray:
    """Return the time in which balls slide without friction along a guide shaped as the isochronous parabola.

    At the speed that the guide is made for, no force acts along it, so x' sqrt(1 + k^2 x^2) is constant with k = 2 sqrt(1 + 2 m) / c.
    t = [x sqrt(1 + k^2 x^2) / 2 + asinh(k x) / (2 k)] / (x' sqrt(1 + k^2 x^2)), between the two abscissae.

    It raises MechanismError if the balls do not move toward the end.

    Parameters
    ----------
    start
        Abscissa at the start, m.
    end
        Abscissa at the end, m.
    start_rate
        Rate x' at the start, m/s; directed from start to end.
    double_parameter
        Double parameter c, m; positive.
    mass_ratio
        Mass m of the sleeve over the mass of one ball; at least 0.

    Returns
    -------
    FloatOrArray
        Time, s.
    """
    # k of the inertia of the guided balls and their sleeve, 2 M (1 + k^2 x^2)
    c = validate_argument(double_parameter, "double_parameter", "m", greater_than=0.0)
    k = 2 * np.sqrt(1 + 2 * validate_argument(mass_ratio, "mass_ratio", "", minimum=0.0)) / c
    x1 = validate_argument(start, "start", "m")
    x2 = validate_argument(end, "end", "m")
    rate = validate_argument(start_rate, "start_rate", "m/s")
    shown = (("start", x1, "m"), ("end", x2, "m"), ("start_rate", rate, "m/s"))
    is_moving_away = (rate * (x2 - x1) < 0) | ((rate == 0) & (x1 != x2))
    raise_where(is_moving_away, "the balls never reach the end: start_rate must point from start to end", *shown)
    path = (x2 * np.hypot(1, k * x2) - x1 * np.hypot(1, k * x1)) / 2 + (np.arcsinh(k * x2) - np.arcsinh(k * x1)) / (2 * k)
    return as_scalar_or_array(path / np.where(rate == 0, 1.0, rate * np.hypot(1, k * x1)))


class _ArmDisplacement(NamedTuple):
    """Rotation of the arm from the start: relative change of the ball's abscissa, and rise of the ball (m)."""

    angle: FloatArray
    abscissa: FloatArray
    angle_change: FloatArray
    abscissa_change: FloatArray
    rise: FloatArray


def _displace_arm(
    start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> _ArmDisplacement:
    """Return the displacement of the ball when the arm turns up by `angle_change` (rad)."""
    angle = validate_angle(start_angle, "start_angle", 90.0, positive=True)
    rotation = validate_argument(angle_change, "angle_change", "rad")
    abscissa = validate_argument(start_abscissa, "start_abscissa", "m", greater_than=0.0)
    length = validate_argument(arm, "arm", "m", greater_than=0.0)
    shown = (("start_angle", np.degrees(angle), "deg"), ("angle_change", np.degrees(rotation), "deg"))
    is_out_of_range = (angle + rotation <= 0) | (angle + rotation >= math.pi / 2)
    raise_where(is_out_of_range, "start_angle + angle_change must be above 0 deg and below 90 deg", *shown)
    chord = 2 * length * np.sin(rotation / 2)
    abscissa_change = chord * np.cos(angle + rotation / 2) / abscissa
    message = "the ball is on or beyond the spindle axis: no speed balances it"
    raise_where(abscissa_change <= -1, message, *shown, ("arm", length, "m"), hint="turn the arm less far down")
    return _ArmDisplacement(angle, abscissa, rotation, abscissa_change, chord * np.sin(angle + rotation / 2))


def _sqrt1pm1(change: FloatArray) -> FloatArray:
    """Return sqrt(1 + change) - 1 without cancellation."""
    return np.asarray(change / (1 + np.sqrt(1 + change)))


def equilibrium_speed_change(
    *, start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> FloatOrArray:
    """Return the relative change (w - w1) / w1 of the equilibrium speed when the arm has turned up.

    Equilibrium requires the slope of the path: w^2 / w1^2 = (tan a / tan a1) (x1 / x). On the osculating circle, whose radius
    is the radius of curvature, the speed is least at the start. It falls through the start on a longer arm and rises on a shorter one.

    Parameters
    ----------
    start_angle
        Arm angle a1 at the start, rad from the vertical.
    start_abscissa
        Distance x1 of the ball from the axis at the start, m.
    arm
        Length of the arm, m.
    angle_change
        Upward rotation a - a1 of the arm, rad.

    Returns
    -------
    FloatOrArray
        Relative change of the equilibrium speed.

    References
    ----------
    Zehnder (1877), equation (3). His own account of leaving the osculation point is `parabola_speed_change`.
    """
    displacement = _displace_arm(start_angle, start_abscissa, arm, angle_change)
    slope_change = np.sin(displacement.angle_change) / (np.cos(displacement.angle + displacement.angle_change) * np.sin(displacement.angle))
    return as_scalar_or_array(_sqrt1pm1((slope_change - displacement.abscissa_change) / (1 + displacement.abscissa_change)))


def parabola_speed_change(
    *, start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> FloatOrArray:
    """Return the relative change of the speed of the parabola on which the ball is; Zehnder took it for the equilibrium speed.

    All parabolas x^2 = c y share one vertex and w^2 is proportional to y / x^2, so w^2 / w1^2 = (y / y1) (x1 / x)^2. It is not an
    equilibrium speed; compare `equilibrium_speed_change`.

    It raises MechanismError if the ball is at the height of the vertex or below it.

    Parameters
    ----------
    start_angle
        Arm angle a1 at the start, rad from the vertical.
    start_abscissa
        Distance x1 of the ball from the axis at the start, m.
    arm
        Length of the arm, m.
    angle_change
        Upward rotation a - a1 of the arm, rad.

    Returns
    -------
    FloatOrArray
        Relative change of the speed.

    References
    ----------
    Zehnder (1877), on the osculating circle, after equation (III).
    """
    displacement = _displace_arm(start_angle, start_abscissa, arm, angle_change)
    height_change = displacement.rise / (displacement.abscissa * np.tan(displacement.angle) / 2)
    angle_change_label = ("angle_change", np.degrees(displacement.angle_change), "deg")
    message = "the ball is at or below the height of the vertex: no parabola passes there"
    raise_where(height_change <= -1, message, angle_change_label, hint="turn the arm less far down")
    change = displacement.abscissa_change
    return as_scalar_or_array(_sqrt1pm1((height_change - change * (2 + change)) / (1 + change) ** 2))

"""The isochronous parabola of pendulum governors, its osculating circle, and the guide along it.

A ball is in neutral equilibrium at the spindle speed w on a path of slope w^2 x / (g (1 + m)), the parabola x^2 = c y with its vertex on
the axis. m is `mass_ratio`, the mass of the sleeve over that of one ball; the sleeve moves twice as fast as the balls rise. x is the
distance from the spindle axis, y the height, both in m; angles are in rad.

Arguments are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that is not
finite or out of range. The linkage is a rhombus with massless rods and no friction.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument


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
    x1, x2 = validate_argument(start, "start", "m"), validate_argument(end, "end", "m")
    rate = validate_argument(start_rate, "start_rate", "m/s")
    shown = (("start", x1, "m"), ("end", x2, "m"), ("start_rate", rate, "m/s"))
    is_moving_away = (rate * (x2 - x1) < 0) | ((rate == 0) & (x1 != x2))
    raise_where(is_moving_away, "the balls never reach the end: start_rate must point from start to end", *shown)
    path = (x2 * np.hypot(1, k * x2) - x1 * np.hypot(1, k * x1)) / 2 + (np.arcsinh(k * x2) - np.arcsinh(k * x1)) / (2 * k)
    return as_scalar_or_array(path / np.where(rate == 0, 1.0, rate * np.hypot(1, k * x1)))

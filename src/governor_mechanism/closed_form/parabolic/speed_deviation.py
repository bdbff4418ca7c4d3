"""Change of speed when the ball leaves a point of the isochronous parabola on a circle that touches it.

At the start the arm is normal to both curves. Its angle is `start_angle` (rad from the vertical), the ball is at `start_abscissa` (m from
the spindle axis), and the suspension at start_abscissa - arm sin(a). Both changes are relative to the equilibrium speed at the start;
load and gravity cancel.

Arguments are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that is not
finite, for angles not between 0 and 90 deg, for a start_abscissa or an arm that is not positive, and for a ball that crosses the axis. The
linkage is a rhombus with massless rods and no friction.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_angle, validate_argument
from governor_mechanism.types import FloatArray


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

"""How the speed changes when the ball leaves a point of the isochronous parabola on a circle through it.

The circle touches the parabola at the start: there the arm, normal to both, stands at start_angle (rad from the
vertical), the ball at start_abscissa (m from the spindle axis), and its suspension at start_abscissa - arm sin(a) from
the axis. Both changes are relative to the equilibrium speed at the start and know neither load nor gravity, which cancel.

Every function takes keywords only, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError, naming the value, for numbers that are not finite, for a start_angle or an angle after the change not
between 0 and 90 deg, for a start_abscissa or an arm not above 0, and for a ball that leaves its side of the axis.
Source: L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14. Limits: rhombus, massless rods, no friction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.types import FloatArray


class _ArmDisplacement(NamedTuple):
    """From the start (angle, abscissa) by a turn: relative change of the abscissa, rise (m) of the ball."""

    angle: FloatArray
    abscissa: FloatArray
    angle_change: FloatArray
    abscissa_change: FloatArray
    rise: FloatArray


def _displace_arm(
    start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> _ArmDisplacement:
    angle, rotation = (
        validate_argument(start_angle, "start_angle", "rad", greater_than=0.0),
        validate_argument(angle_change, "angle_change", "rad"),
    )
    abscissa = validate_argument(start_abscissa, "start_abscissa", "m", greater_than=0.0)
    length = validate_argument(arm, "arm", "m", greater_than=0.0)
    start_label = ("start_angle", np.degrees(angle), "deg")
    raise_where(angle >= math.pi / 2, "start_angle must lie below 90 deg", start_label)
    shown = (start_label, ("angle_change", np.degrees(rotation), "deg"))
    is_out_of_range = (angle + rotation <= 0) | (angle + rotation >= math.pi / 2)
    raise_where(is_out_of_range, "start_angle + angle_change must lie above 0 deg and below 90 deg", *shown)
    chord = 2 * length * np.sin(rotation / 2)
    abscissa_change = chord * np.cos(angle + rotation / 2) / abscissa
    message = "the ball comes onto the spindle axis or beyond it: no speed balances it"
    raise_where(abscissa_change <= -1, message, *shown, ("arm", length, "m"), hint="turn the arm less far down")
    return _ArmDisplacement(angle, abscissa, rotation, abscissa_change, chord * np.sin(angle + rotation / 2))


def _sqrt1pm1(change: FloatArray) -> FloatArray:
    """sqrt(1 + change) - 1 without cancellation."""
    root: FloatArray = change / (1 + np.sqrt(1 + change))
    return root


def equilibrium_speed_change(
    *, start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> FloatOrArray:
    """Relative change (w - w1) / w1 of the equilibrium speed when the arm (m) has turned up by angle_change (rad).

    Rest asks for the slope of the path: w^2 / w1^2 = (tan a / tan a1) (x1 / x). On the circle of curvature, arm =
    osculating_arm, the speed is least at the start; it falls through the start on a longer arm and rises on a shorter.
    Source: Zehnder (3); his own account of leaving the osculation point is parabola_change_on_leaving.
    """
    displacement = _displace_arm(start_angle, start_abscissa, arm, angle_change)
    slope_change = np.sin(displacement.angle_change) / (np.cos(displacement.angle + displacement.angle_change) * np.sin(displacement.angle))
    return as_scalar_or_array(_sqrt1pm1((slope_change - displacement.abscissa_change) / (1 + displacement.abscissa_change)))


def parabola_speed_change(
    *, start_angle: FloatOrArray, start_abscissa: FloatOrArray, arm: FloatOrArray, angle_change: FloatOrArray
) -> FloatOrArray:
    """Relative change of the speed of the parabola on which the ball sits: what Zehnder took for the equilibrium speed.

    All parabolas x^2 = c y have one vertex and w^2 is proportional to y / x^2, so w^2 / w1^2 = (y / y1) (x1 / x)^2. No
    governor rests by it: compare speed_change_on_leaving, of the same arguments. Refuses a ball below the vertex.
    Source: Zehnder, on the circle of curvature, after (III).
    """
    displacement = _displace_arm(start_angle, start_abscissa, arm, angle_change)
    height_change = displacement.rise / (displacement.abscissa * np.tan(displacement.angle) / 2)
    angle_change_label = ("angle_change", np.degrees(displacement.angle_change), "deg")
    message = "the ball comes to the height of the vertex or below it: no parabola passes there"
    raise_where(height_change <= -1, message, angle_change_label, hint="turn the arm less far down")
    squared_abscissa_ratio = (1 + displacement.abscissa_change) ** 2
    return as_scalar_or_array(
        _sqrt1pm1((height_change - displacement.abscissa_change * (2 + displacement.abscissa_change)) / squared_abscissa_ratio)
    )

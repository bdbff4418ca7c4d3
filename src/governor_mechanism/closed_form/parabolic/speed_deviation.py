"""How the speed changes when the ball leaves a point of the isochronous parabola on a circle through it.

The circle touches the parabola at the start: there the arm, normal to both, stands at start_angle (rad from the
vertical), the ball at start_abscissa (m from the spindle axis), and its suspension at start_abscissa - arm sin(a) from
the axis. Both changes are relative to the speed of rest at the start and know neither load nor gravity, which cancel.

Every function takes keywords only, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError, naming the value, for numbers that are not finite, for a start_angle or an angle after the change not
between 0 and 90 deg, for a start_abscissa or an arm not above 0, and for a ball that leaves its side of the axis.
Source: L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14. Limits: rhombus, massless rods, no friction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.arguments import Number, as_given, checked, refuse_where
from governor_mechanism.types import FloatArray


class _Step(NamedTuple):
    """From the start (angle, abscissa) by a turn: relative change of the abscissa, rise (m) of the ball."""

    angle: FloatArray
    abscissa: FloatArray
    turn: FloatArray
    widening: FloatArray
    rise: FloatArray


def _step(start_angle: Number, start_abscissa: Number, arm: Number, angle_change: Number) -> _Step:
    angle, turn = checked(start_angle, "start_angle", "rad", above=0.0), checked(angle_change, "angle_change", "rad")
    abscissa = checked(start_abscissa, "start_abscissa", "m", above=0.0)
    length = checked(arm, "arm", "m", above=0.0)
    steep = ("start_angle", np.degrees(angle), "deg")
    refuse_where(angle >= math.pi / 2, "start_angle must lie below 90 deg", steep)
    shown = (steep, ("angle_change", np.degrees(turn), "deg"))
    out = (angle + turn <= 0) | (angle + turn >= math.pi / 2)
    refuse_where(out, "start_angle + angle_change must lie above 0 deg and below 90 deg", *shown)
    chord = 2 * length * np.sin(turn / 2)
    widening = chord * np.cos(angle + turn / 2) / abscissa
    sentence = "the ball comes onto the spindle axis or beyond it: no speed balances it"
    refuse_where(widening <= -1, sentence, *shown, ("arm", length, "m"), cure="turn the arm less far down")
    return _Step(angle, abscissa, turn, widening, chord * np.sin(angle + turn / 2))


def _of_the_root(change: FloatArray) -> FloatArray:
    """sqrt(1 + change) - 1 without cancellation."""
    root: FloatArray = change / (1 + np.sqrt(1 + change))
    return root


def speed_change_on_leaving(
    *, start_angle: Number, start_abscissa: Number, arm: Number, angle_change: Number
) -> Number:
    """Relative change (w - w1) / w1 of the speed of rest when the arm (m) has turned up by angle_change (rad).

    Rest asks for the slope of the path: w^2 / w1^2 = (tan a / tan a1) (x1 / x). On the circle of curvature, arm =
    osculating_arm, the speed is least at the start; it falls through the start on a longer arm and rises on a shorter.
    Source: Zehnder (3); his own account of leaving the osculation point is parabola_change_on_leaving.
    """
    at = _step(start_angle, start_abscissa, arm, angle_change)
    steepening = np.sin(at.turn) / (np.cos(at.angle + at.turn) * np.sin(at.angle))
    return as_given(_of_the_root((steepening - at.widening) / (1 + at.widening)))


def parabola_change_on_leaving(
    *, start_angle: Number, start_abscissa: Number, arm: Number, angle_change: Number
) -> Number:
    """Relative change of the speed of the parabola on which the ball sits: what Zehnder took for the speed of rest.

    All parabolas x^2 = c y have one vertex and w^2 is proportional to y / x^2, so w^2 / w1^2 = (y / y1) (x1 / x)^2. No
    governor rests by it: compare speed_change_on_leaving, of the same arguments. Refuses a ball below the vertex.
    Source: Zehnder, on the circle of curvature, after (III).
    """
    at = _step(start_angle, start_abscissa, arm, angle_change)
    lifting = at.rise / (at.abscissa * np.tan(at.angle) / 2)
    turned = ("angle_change", np.degrees(at.turn), "deg")
    sentence = "the ball comes to the height of the vertex or below it: no parabola passes there"
    refuse_where(lifting <= -1, sentence, turned, cure="turn the arm less far down")
    wider = (1 + at.widening) ** 2
    return as_given(_of_the_root((lifting - at.widening * (2 + at.widening)) / wider))

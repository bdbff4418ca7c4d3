"""How Dubois designs a Hartung governor: the angle of its bell cranks, the spring, its stress, the regulating force.

Every function takes keywords only, floats or arrays that broadcast; floats give a float. Each raises MechanismError,
naming the value, for numbers that are not finite or outside the range its docstring gives. All in SI.
Source: Fr. Dubois, Dinglers Polyt. J. 327 (1912), pp. 618-620; the effective spring after Doerfel.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import Number, as_given, checked, refuse_where
from governor_mechanism.types import FloatArray


def spring_abscissa(*, inner_force: Number, outer_force: Number, stroke: Number) -> Number:
    """y1 (m): how far a spring that carries inner_force (N) is drawn, when `stroke` (m) more brings outer_force (N).

    From C1 / y1 = C2 / y2 = (C2 - C1) / (y2 - y1). Both forces are positive, outer_force the larger.
    """
    first, second = _rising(inner_force, outer_force)
    return as_given(first * checked(stroke, "stroke", "m", above=0.0) / (second - first))


def crank_angle(*, weight_arm: Number, middle_abscissa: Number) -> Number:
    """Angle (rad, above 90 deg) between the arms of the bell crank: tan g = -y0 / a.

    middle_abscissa y0 (m) is the spring's at mid stroke, weight_arm a (m). It makes S stationary at mid stroke where
    the centrifugal forces lie on the spring's line.
    """
    arm = checked(weight_arm, "weight_arm", "m", above=0.0)
    return as_given(math.pi - np.arctan(checked(middle_abscissa, "middle_abscissa", "m", above=0.0) / arm))


def even_sleeve_arm(*, fulcrum_radius: Number, angle: Number, swing: Number) -> Number:
    """Arm b (m) whose end stands as far inside the axis at one end of the swing as outside it at the other.

    x_H - b sin(g + s) and x_H - b sin(g - s) are opposite for b = x_H / (sin g cos s); swing s (rad) to each side.
    """
    sines = np.sin(_obtuse(angle)) * np.cos(_swing(swing))
    return as_given(checked(fulcrum_radius, "fulcrum_radius", "m", above=0.0) / sines)


def sleeve_travel(*, sleeve_arm: Number, angle: Number, swing: Number) -> Number:
    """Rise of the sleeve (m) over the whole swing, hung vertically: b [cos(g - s) - cos(g + s)]."""
    arm = checked(sleeve_arm, "sleeve_arm", "m", above=0.0)
    return as_given(2 * arm * np.sin(_obtuse(angle)) * np.sin(_swing(swing)))


def effective_rate(*, inner_force: Number, outer_force: Number, stroke: Number) -> Number:
    """Rate (N/m) of Doerfel's line: from the force at the inner end and low speed to that at the outer end and high."""
    first, second = _rising(inner_force, outer_force)
    return as_given((second - first) / checked(stroke, "stroke", "m", above=0.0))


def coil_rate(*, wire: Number, coil: Number, turns: Number, modulus: Number) -> Number:
    """Rate k = G d^4 / (8 n D^3) (N/m) of wire d on a coil D (diameters, m), n turns, modulus G (Pa) of shear."""
    d, diameter = _wire(wire, coil)
    n, shear = checked(turns, "turns", "", above=0.0), checked(modulus, "modulus", "Pa", above=0.0)
    return as_given(shear * d**4 / (8 * n * diameter**3))


def coil_turns(*, wire: Number, coil: Number, rate: Number, modulus: Number) -> Number:
    """Turns n = L / (pi D) of a coil with a rate (N/m), L = f J_p G / (P r^2) the length of its wire. Dubois (1)."""
    length = wire_length(wire=wire, coil=coil, rate=rate, modulus=modulus)
    return as_given(np.asarray(length) / (math.pi * checked(coil, "coil", "m")))


def wire_length(*, wire: Number, coil: Number, rate: Number, modulus: Number) -> Number:
    """Length L = f J_p G / (P r^2) (m) of the wire of a coil with a rate P / f (N/m). Dubois (1)."""
    _, diameter = _wire(wire, coil)
    shear = checked(modulus, "modulus", "Pa", above=0.0)
    bar = np.asarray(polar_moment(wire=wire))
    return as_given(bar * shear / (checked(rate, "rate", "N/m", above=0.0) * (diameter / 2) ** 2))


def polar_moment(*, wire: Number) -> Number:
    """J_p = pi d^4 / 32 (m^4) of a round wire d (m)."""
    return as_given(math.pi * checked(wire, "wire", "m", above=0.0) ** 4 / 32)


def section_modulus(*, wire: Number) -> Number:
    """W_d = pi d^3 / 16 (m^3) against twisting, of a round wire d (m)."""
    return as_given(math.pi * checked(wire, "wire", "m", above=0.0) ** 3 / 16)


def coil_stress(*, wire: Number, coil: Number, force: Number) -> Number:
    """Shear stress P r / W_d (Pa) in the wire of a coil under a force (N); without the wire's curvature."""
    d, diameter = _wire(wire, coil)
    twist = checked(force, "force", "N") * diameter / 2
    return as_given(twist / np.asarray(section_modulus(wire=d)))


def regulating_force(*, static_force: Number, part: Number = 0.04) -> Number:
    """K = e S (N): what the governor can shift before its speed has changed by the part e / 2, of a static force S."""
    share = checked(part, "part", "", above=0.0)
    return as_given(share * checked(static_force, "static_force", "N", above=0.0))


def speed_limits(*, spindle_speed: Number, regulating_force: Number, static_force: Number) -> tuple[Number, Number]:
    """Speeds w sqrt(1 - K / S) and w sqrt(1 + K / S) (rad/s) at which a resistance K (N) at the sleeve gives way.

    (w'^2 - w''^2) / w^2 = 2 K / S. regulating_force K is not negative and at most static_force S.
    """
    speed = checked(spindle_speed, "spindle_speed", "rad/s", above=0.0)
    static = checked(static_force, "static_force", "N", above=0.0)
    held = checked(regulating_force, "regulating_force", "N", least=0.0)
    shown = (("regulating_force", held, "N"), ("static_force", static, "N"))
    refuse_where(held > static, "regulating_force must not exceed static_force: no low speed gives way", *shown)
    return as_given(speed * np.sqrt(1 - held / static)), as_given(speed * np.sqrt(1 + held / static))


def _rising(inner: Number, outer: Number) -> tuple[FloatArray, FloatArray]:
    first, second = checked(inner, "inner_force", "N", above=0.0), checked(outer, "outer_force", "N", above=0.0)
    shown = (("inner_force", first, "N"), ("outer_force", second, "N"))
    refuse_where(second <= first, "outer_force must exceed inner_force, or no spring has such a line", *shown)
    return first, second


def _obtuse(angle: Number) -> FloatArray:
    g = checked(angle, "angle", "rad", above=0.0)
    refuse_where(g >= math.pi, "angle must lie below 180 deg", ("angle", np.degrees(g), "deg"))
    return g


def _swing(swing: Number) -> FloatArray:
    s = checked(swing, "swing", "rad", above=0.0)
    refuse_where(s >= math.pi / 2, "swing must lie below 90 deg", ("swing", np.degrees(s), "deg"))
    return s


def _wire(wire: Number, coil: Number) -> tuple[FloatArray, FloatArray]:
    d, diameter = checked(wire, "wire", "m", above=0.0), checked(coil, "coil", "m", above=0.0)
    shown = (("coil", diameter, "m"), ("wire", d, "m"))
    refuse_where(diameter <= d, "coil must be wider than its wire", *shown)
    return d, diameter

"""How Dubois designs a Hartung governor: the angle of its bell cranks, the spring, its stress, the regulating force.

Every function takes keywords only, floats or arrays that broadcast; floats give a float. Each raises MechanismError,
naming the value, for numbers that are not finite or outside the range its docstring gives. All in SI.
Source: Fr. Dubois, Dinglers Polyt. J. 327 (1912), pp. 618-620; the effective spring after Doerfel.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.types import FloatArray


def spring_abscissa(*, inner_force: FloatOrArray, outer_force: FloatOrArray, stroke: FloatOrArray) -> FloatOrArray:
    """y1 (m): how far a spring that carries inner_force (N) is drawn, when `stroke` (m) more brings outer_force (N).

    From C1 / y1 = C2 / y2 = (C2 - C1) / (y2 - y1). Both forces are positive, outer_force the larger.
    """
    first, second = _validate_rising_forces(inner_force, outer_force)
    return as_scalar_or_array(first * validate_argument(stroke, "stroke", "m", greater_than=0.0) / (second - first))


def bell_crank_angle(*, weight_arm: FloatOrArray, middle_abscissa: FloatOrArray) -> FloatOrArray:
    """Angle (rad, above 90 deg) between the arms of the bell crank: tan g = -y0 / a.

    middle_abscissa y0 (m) is the spring's at mid stroke, weight_arm a (m). It makes S stationary at mid stroke where
    the centrifugal forces lie on the spring's line.
    """
    arm = validate_argument(weight_arm, "weight_arm", "m", greater_than=0.0)
    return as_scalar_or_array(math.pi - np.arctan(validate_argument(middle_abscissa, "middle_abscissa", "m", greater_than=0.0) / arm))


def symmetric_sleeve_arm(*, fulcrum_radius: FloatOrArray, angle: FloatOrArray, swing: FloatOrArray) -> FloatOrArray:
    """Arm b (m) whose end stands as far inside the axis at one end of the swing as outside it at the other.

    x_H - b sin(g + s) and x_H - b sin(g - s) are opposite for b = x_H / (sin g cos s); swing s (rad) to each side.
    """
    sines = np.sin(_validate_bell_crank_angle(angle)) * np.cos(_validate_swing(swing))
    return as_scalar_or_array(validate_argument(fulcrum_radius, "fulcrum_radius", "m", greater_than=0.0) / sines)


def sleeve_travel(*, sleeve_arm: FloatOrArray, angle: FloatOrArray, swing: FloatOrArray) -> FloatOrArray:
    """Rise of the sleeve (m) over the whole swing, hung vertically: b [cos(g - s) - cos(g + s)]."""
    arm = validate_argument(sleeve_arm, "sleeve_arm", "m", greater_than=0.0)
    return as_scalar_or_array(2 * arm * np.sin(_validate_bell_crank_angle(angle)) * np.sin(_validate_swing(swing)))


def effective_spring_rate(*, inner_force: FloatOrArray, outer_force: FloatOrArray, stroke: FloatOrArray) -> FloatOrArray:
    """Rate (N/m) of Doerfel's line: from the force at the inner end and low speed to that at the outer end and high."""
    first, second = _validate_rising_forces(inner_force, outer_force)
    return as_scalar_or_array((second - first) / validate_argument(stroke, "stroke", "m", greater_than=0.0))


def coil_rate(*, wire: FloatOrArray, coil: FloatOrArray, turns: FloatOrArray, modulus: FloatOrArray) -> FloatOrArray:
    """Rate k = G d^4 / (8 n D^3) (N/m) of wire d on a coil D (diameters, m), n turns, modulus G (Pa) of shear."""
    d, diameter = _validate_wire_and_coil(wire, coil)
    n, shear = (validate_argument(turns, "turns", "", greater_than=0.0), validate_argument(modulus, "modulus", "Pa", greater_than=0.0))
    return as_scalar_or_array(shear * d**4 / (8 * n * diameter**3))


def coil_turns(*, wire: FloatOrArray, coil: FloatOrArray, rate: FloatOrArray, modulus: FloatOrArray) -> FloatOrArray:
    """Turns n = L / (pi D) of a coil with a rate (N/m), L = f J_p G / (P r^2) the length of its wire. Dubois (1)."""
    length = wire_length(wire=wire, coil=coil, rate=rate, modulus=modulus)
    return as_scalar_or_array(np.asarray(length) / (math.pi * validate_argument(coil, "coil", "m")))


def wire_length(*, wire: FloatOrArray, coil: FloatOrArray, rate: FloatOrArray, modulus: FloatOrArray) -> FloatOrArray:
    """Length L = f J_p G / (P r^2) (m) of the wire of a coil with a rate P / f (N/m). Dubois (1)."""
    _, diameter = _validate_wire_and_coil(wire, coil)
    shear = validate_argument(modulus, "modulus", "Pa", greater_than=0.0)
    wire_polar_moment = np.asarray(polar_moment(wire=wire))
    return as_scalar_or_array(wire_polar_moment * shear / (validate_argument(rate, "rate", "N/m", greater_than=0.0) * (diameter / 2) ** 2))


def polar_moment(*, wire: FloatOrArray) -> FloatOrArray:
    """J_p = pi d^4 / 32 (m^4) of a round wire d (m)."""
    return as_scalar_or_array(math.pi * validate_argument(wire, "wire", "m", greater_than=0.0) ** 4 / 32)


def section_modulus(*, wire: FloatOrArray) -> FloatOrArray:
    """W_d = pi d^3 / 16 (m^3) against twisting, of a round wire d (m)."""
    return as_scalar_or_array(math.pi * validate_argument(wire, "wire", "m", greater_than=0.0) ** 3 / 16)


def coil_stress(*, wire: FloatOrArray, coil: FloatOrArray, force: FloatOrArray) -> FloatOrArray:
    """Shear stress P r / W_d (Pa) in the wire of a coil under a force (N); without the wire's curvature."""
    d, diameter = _validate_wire_and_coil(wire, coil)
    twisting_moment = validate_argument(force, "force", "N") * diameter / 2
    return as_scalar_or_array(twisting_moment / np.asarray(section_modulus(wire=d)))


def regulating_force(*, static_force: FloatOrArray, insensitivity: FloatOrArray = 0.04) -> FloatOrArray:
    """K = e S (N): what the governor can shift before its speed has changed by the part e / 2, of a static force S."""
    ratio = validate_argument(insensitivity, "part", "", greater_than=0.0)
    return as_scalar_or_array(ratio * validate_argument(static_force, "static_force", "N", greater_than=0.0))


def speed_limits(
    *, spindle_speed: FloatOrArray, regulating_force: FloatOrArray, static_force: FloatOrArray
) -> tuple[FloatOrArray, FloatOrArray]:
    """Speeds w sqrt(1 - K / S) and w sqrt(1 + K / S) (rad/s) at which a resistance K (N) at the sleeve gives way.

    (w'^2 - w''^2) / w^2 = 2 K / S. regulating_force K is not negative and at most static_force S.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s", greater_than=0.0)
    sleeve_force = validate_argument(static_force, "static_force", "N", greater_than=0.0)
    resistance = validate_argument(regulating_force, "regulating_force", "N", minimum=0.0)
    shown = (("regulating_force", resistance, "N"), ("static_force", sleeve_force, "N"))
    raise_where(resistance > sleeve_force, "regulating_force must not exceed static_force: no low speed gives way", *shown)
    return as_scalar_or_array(speed * np.sqrt(1 - resistance / sleeve_force)), as_scalar_or_array(
        speed * np.sqrt(1 + resistance / sleeve_force)
    )


def _validate_rising_forces(inner: FloatOrArray, outer: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    first, second = (
        validate_argument(inner, "inner_force", "N", greater_than=0.0),
        validate_argument(outer, "outer_force", "N", greater_than=0.0),
    )
    shown = (("inner_force", first, "N"), ("outer_force", second, "N"))
    raise_where(second <= first, "outer_force must exceed inner_force, or no spring has such a line", *shown)
    return first, second


def _validate_bell_crank_angle(angle: FloatOrArray) -> FloatArray:
    g = validate_argument(angle, "angle", "rad", greater_than=0.0)
    raise_where(g >= math.pi, "angle must lie below 180 deg", ("angle", np.degrees(g), "deg"))
    return g


def _validate_swing(swing: FloatOrArray) -> FloatArray:
    s = validate_argument(swing, "swing", "rad", greater_than=0.0)
    raise_where(s >= math.pi / 2, "swing must lie below 90 deg", ("swing", np.degrees(s), "deg"))
    return s


def _validate_wire_and_coil(wire: FloatOrArray, coil: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    d, diameter = (validate_argument(wire, "wire", "m", greater_than=0.0), validate_argument(coil, "coil", "m", greater_than=0.0))
    shown = (("coil", diameter, "m"), ("wire", d, "m"))
    raise_where(diameter <= d, "coil must be wider than its wire", *shown)
    return d, diameter

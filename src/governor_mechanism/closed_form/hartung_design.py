"""Dubois' design formulas of a Hartung governor: angle of the bell cranks, spring, shear stress, regulating force.

Arguments are keywords in SI, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that
is not finite or out of range.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620; the effective spring after Doerfel.
"""

import math

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument
from governor_mechanism.types import FloatArray, FloatOrArray


def spring_abscissa(*, inner_force: FloatOrArray, outer_force: FloatOrArray, stroke: FloatOrArray) -> FloatOrArray:
    """Return the deflection y1 of a spring at `inner_force` if a further `stroke` raises its force to `outer_force`.

    From C1 / y1 = C2 / y2 = (C2 - C1) / (y2 - y1).

    Parameters
    ----------
    inner_force
        Force C1, N; positive.
    outer_force
        Force C2, N; above inner_force.
    stroke
        Deflection y2 - y1, m; positive.

    Returns
    -------
    FloatOrArray
        Deflection y1, m.
    """
    first, second = _validate_rising_forces(inner_force, outer_force)
    return as_scalar_or_array(first * validate_argument(stroke, "stroke", "m", greater_than=0.0) / (second - first))


def bell_crank_angle(*, weight_arm: FloatOrArray, middle_abscissa: FloatOrArray) -> FloatOrArray:
    """Return the angle between the arms of the bell crank, tan g = -y0 / a.

    It makes the static sleeve force S stationary at mid stroke if the centrifugal forces are on the line of the spring.

    Parameters
    ----------
    weight_arm
        Arm a of the bell crank, m.
    middle_abscissa
        Deflection y0 of the spring at mid stroke, m.

    Returns
    -------
    FloatOrArray
        Angle g, rad; above 90 deg.
    """
    arm = validate_argument(weight_arm, "weight_arm", "m", greater_than=0.0)
    return as_scalar_or_array(math.pi - np.arctan(validate_argument(middle_abscissa, "middle_abscissa", "m", greater_than=0.0) / arm))


def symmetric_sleeve_arm(*, fulcrum_radius: FloatOrArray, angle: FloatOrArray, swing: FloatOrArray) -> FloatOrArray:
    """Return the arm b whose end is as far inside the axis at one end of the swing as outside it at the other.

    x_H - b sin(g + s) and x_H - b sin(g - s) are opposite for b = x_H / (sin g cos s).

    Parameters
    ----------
    fulcrum_radius
        Distance x_H of the fulcrum from the axis, m.
    angle
        Angle g of the bell crank, rad.
    swing
        Swing s to each side, rad.

    Returns
    -------
    FloatOrArray
        Arm b, m.
    """
    g, s = _validate_angle_and_swing(angle, swing)
    return as_scalar_or_array(validate_argument(fulcrum_radius, "fulcrum_radius", "m", greater_than=0.0) / (np.sin(g) * np.cos(s)))


def sleeve_travel(*, sleeve_arm: FloatOrArray, angle: FloatOrArray, swing: FloatOrArray) -> FloatOrArray:
    """Return the travel of a sleeve on vertical hangers over the whole swing, b [cos(g - s) - cos(g + s)].

    Parameters
    ----------
    sleeve_arm
        Arm b of the bell crank, m.
    angle
        Angle g of the bell crank, rad.
    swing
        Swing s to each side, rad.

    Returns
    -------
    FloatOrArray
        Travel, m.
    """
    g, s = _validate_angle_and_swing(angle, swing)
    return as_scalar_or_array(2 * validate_argument(sleeve_arm, "sleeve_arm", "m", greater_than=0.0) * np.sin(g) * np.sin(s))


def effective_spring_rate(*, inner_force: FloatOrArray, outer_force: FloatOrArray, stroke: FloatOrArray) -> FloatOrArray:
    """Return the rate of Doerfel's line, from the inner end at low speed to the outer end at high speed.

    Parameters
    ----------
    inner_force
        Force at the inner end, N; positive.
    outer_force
        Force at the outer end, N; above inner_force.
    stroke
        Stroke of the weights, m; positive.

    Returns
    -------
    FloatOrArray
        Rate, N/m.
    """
    first, second = _validate_rising_forces(inner_force, outer_force)
    return as_scalar_or_array((second - first) / validate_argument(stroke, "stroke", "m", greater_than=0.0))


def coil_turns(*, wire: FloatOrArray, coil: FloatOrArray, rate: FloatOrArray, modulus: FloatOrArray) -> FloatOrArray:
    """Return the number of turns n = L / (pi D) of a coil spring of a given rate.

    Parameters
    ----------
    wire
        Diameter d of the wire, m.
    coil
        Mean diameter D of the coil, m.
    rate
        Rate of the spring, N/m.
    modulus
        Shear modulus G, Pa.

    Returns
    -------
    FloatOrArray
        Number of turns.

    References
    ----------
    Dubois (1912), equation (1).
    """
    length = wire_length(wire=wire, coil=coil, rate=rate, modulus=modulus)
    return as_scalar_or_array(np.asarray(length) / (math.pi * validate_argument(coil, "coil", "m")))


def wire_length(*, wire: FloatOrArray, coil: FloatOrArray, rate: FloatOrArray, modulus: FloatOrArray) -> FloatOrArray:
    """Return the length of the wire of a coil spring, L = f J_p G / (P r^2) for the rate P / f.

    Parameters
    ----------
    wire
        Diameter d of the wire, m.
    coil
        Mean diameter 2 r of the coil, m.
    rate
        Rate P / f of the spring, N/m.
    modulus
        Shear modulus G, Pa.

    Returns
    -------
    FloatOrArray
        Length, m.

    References
    ----------
    Dubois (1912), equation (1).
    """
    _, diameter = _validate_wire_and_coil(wire, coil)
    shear = validate_argument(modulus, "modulus", "Pa", greater_than=0.0)
    wire_polar_moment = np.asarray(polar_moment(wire=wire))
    return as_scalar_or_array(wire_polar_moment * shear / (validate_argument(rate, "rate", "N/m", greater_than=0.0) * (diameter / 2) ** 2))


def polar_moment(*, wire: FloatOrArray) -> FloatOrArray:
    """Return the polar second moment of area of a round wire, J_p = pi d^4 / 32.

    Parameters
    ----------
    wire
        Diameter d of the wire, m.

    Returns
    -------
    FloatOrArray
        Polar second moment of area, m^4.
    """
    return as_scalar_or_array(math.pi * validate_argument(wire, "wire", "m", greater_than=0.0) ** 4 / 32)


def section_modulus(*, wire: FloatOrArray) -> FloatOrArray:
    """Return the torsional section modulus of a round wire, W_d = pi d^3 / 16.

    Parameters
    ----------
    wire
        Diameter d of the wire, m.

    Returns
    -------
    FloatOrArray
        Section modulus, m^3.
    """
    return as_scalar_or_array(math.pi * validate_argument(wire, "wire", "m", greater_than=0.0) ** 3 / 16)


def coil_stress(*, wire: FloatOrArray, coil: FloatOrArray, force: FloatOrArray) -> FloatOrArray:
    """Return the shear stress P r / W_d in the wire of a coil spring; the curvature of the wire is neglected.

    Parameters
    ----------
    wire
        Diameter d of the wire, m.
    coil
        Mean diameter 2 r of the coil, m.
    force
        Force P of the spring, N.

    Returns
    -------
    FloatOrArray
        Shear stress, Pa.
    """
    d, diameter = _validate_wire_and_coil(wire, coil)
    twisting_moment = validate_argument(force, "force", "N") * diameter / 2
    return as_scalar_or_array(twisting_moment / np.asarray(section_modulus(wire=d)))


def regulating_force(*, static_force: FloatOrArray, insensitivity: FloatOrArray = 0.04) -> FloatOrArray:
    """Return the regulating force K = e S: the resistance overcome before the speed has changed by the fraction e / 2.

    Parameters
    ----------
    static_force
        Static sleeve force S, N.
    insensitivity
        Degree of insensitivity e.

    Returns
    -------
    FloatOrArray
        Regulating force K, N.
    """
    ratio = validate_argument(insensitivity, "insensitivity", "", greater_than=0.0)
    return as_scalar_or_array(ratio * validate_argument(static_force, "static_force", "N", greater_than=0.0))


def speed_limits(
    *, spindle_speed: FloatOrArray, regulating_force: FloatOrArray, static_force: FloatOrArray
) -> tuple[FloatOrArray, FloatOrArray]:
    """Return the speeds w sqrt(1 - K / S) and w sqrt(1 + K / S) at which the sleeve overcomes a resistance K.

    (w'^2 - w''^2) / w^2 = 2 K / S.

    Parameters
    ----------
    spindle_speed
        Equilibrium speed w, rad/s.
    regulating_force
        Resistance K at the sleeve, N; from 0 to static_force.
    static_force
        Static sleeve force S, N.

    Returns
    -------
    tuple[FloatOrArray, FloatOrArray]
        Lower and upper speed, rad/s.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s", greater_than=0.0)
    sleeve_force = validate_argument(static_force, "static_force", "N", greater_than=0.0)
    resistance = validate_argument(regulating_force, "regulating_force", "N", minimum=0.0)
    shown = (("regulating_force", resistance, "N"), ("static_force", sleeve_force, "N"))
    raise_where(resistance > sleeve_force, "regulating_force must not exceed static_force: there is no lower speed", *shown)
    lower, upper = (speed * np.sqrt(1 + sign * resistance / sleeve_force) for sign in (-1, 1))
    return as_scalar_or_array(lower), as_scalar_or_array(upper)


def _validate_rising_forces(inner: FloatOrArray, outer: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    """Return both forces (N); they are positive and the outer is the larger."""
    first = validate_argument(inner, "inner_force", "N", greater_than=0.0)
    second = validate_argument(outer, "outer_force", "N", greater_than=0.0)
    shown = (("inner_force", first, "N"), ("outer_force", second, "N"))
    raise_where(second <= first, "outer_force must exceed inner_force", *shown)
    return first, second


def _validate_angle_and_swing(angle: FloatOrArray, swing: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    """Return the angle of the bell crank (0 to 180 deg) and the swing to each side (0 to 90 deg), rad."""
    return validate_angle(angle, "angle", 180.0, positive=True), validate_angle(swing, "swing", 90.0, positive=True)


def _validate_wire_and_coil(wire: FloatOrArray, coil: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    """Return the diameters (m) of wire and coil; the coil is wider than the wire."""
    d = validate_argument(wire, "wire", "m", greater_than=0.0)
    diameter = validate_argument(coil, "coil", "m", greater_than=0.0)
    shown = (("coil", diameter, "m"), ("wire", d, "m"))
    raise_where(diameter <= d, "coil must exceed the diameter of the wire", *shown)
    return d, diameter

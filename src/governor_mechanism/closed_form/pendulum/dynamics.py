"""Pendulum governors (Watt, improved Watt, Porter): equilibrium, stability and motion in closed form.

Geometry and symbols are those of `kinematics`, whose functions are available here too. SI and radians.

The governor is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite, for an arm_angle not between -90 and 90 deg and for a position that the link cannot reach;
further conditions are in its own docstring. There is no friction but the resistance given. Rods are rigid, slender and uniform; the
spindle is vertical; balls have any size and do not touch the spindle.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14, equations (1)-(3), for the rhombus with massless rods. The general
linkage, rods with mass and the motion follow from Lagrange's equation with T = I a'^2/2 + J w^2/2 and the potential energy V.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.closed_form.pendulum.equilibria import equilibrium_angles, squared_balance_speed, squared_given_or_equilibrium_speed
from governor_mechanism.closed_form.pendulum.kinematics import (
    LinkageGeometry,
    PendulumGovernor,
    ball_radius,
    evaluate_geometry,
    in_plane_inertia,
    in_plane_inertia_and_derivative,
    in_plane_inertia_derivative,
    potential_derivative,
    potential_derivatives,
    potential_second_derivative,
    spindle_inertia,
    spindle_inertia_derivative,
    spindle_inertia_derivatives,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray

__all__ = [
    "PendulumGovernor",
    "arm_acceleration",
    "ball_radius",
    "drive_torque",
    "equilibrium_angles",
    "equilibrium_speed",
    "falling_speed",
    "in_plane_inertia",
    "in_plane_inertia_derivative",
    "least_stable_angle",
    "potential_derivative",
    "potential_second_derivative",
    "rising_speed",
    "spindle_acceleration",
    "spindle_inertia",
    "spindle_inertia_derivative",
    "squared_oscillation_frequency",
    "stiffness",
]


def equilibrium_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the spindle speed at which the governor is in equilibrium at an arm angle, without friction.

    Rhombus, massless rods: w^2 = g (1 + m) tan a / x with m = sleeve_mass / ball_mass. General linkage, massless rods:
    w^2 x / g = tan a + (m l1 / 2 l)(tan a + tan b). With rod masses: w^2 = 2 V' / J'.

    It raises MechanismError if the ball is on or beyond the axis, or no real speed balances the weights.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.

    Returns
    -------
    FloatOrArray
        Equilibrium speed w, rad/s.

    References
    ----------
    Zehnder (1877), equation (3).
    """
    geometry = evaluate_geometry(governor, arm_angle)
    return as_scalar_or_array(np.sqrt(squared_balance_speed(governor, geometry, potential_derivatives(governor, geometry)[0])))


def rising_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray, resistance: FloatOrArray) -> FloatOrArray:
    """Return the spindle speed (rad/s) at which the arms are about to rise against a resistance (N, at the sleeve, at least 0).

    Rhombus: w'^2 = (g tan a / x)(P + Q + W) / P, Zehnder (1877), equation (1). It raises MechanismError as equilibrium_speed does.
    """
    return _resisted_speed(governor, arm_angle, resistance, +1.0)


def falling_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray, resistance: FloatOrArray) -> FloatOrArray:
    """Return the spindle speed (rad/s) at which the arms are about to fall against a resistance (N, at the sleeve, at least 0).

    Rhombus: w''^2 = (g tan a / x)(P + Q - W) / P, Zehnder (1877), equation (2). It raises MechanismError where the resistance exceeds the
    load of the weights on the sleeve, and as equilibrium_speed does.
    """
    return _resisted_speed(governor, arm_angle, resistance, -1.0)


def _resisted_speed(governor: PendulumGovernor, arm_angle: FloatOrArray, resistance: FloatOrArray, direction: float) -> FloatOrArray:
    """Return the speed (rad/s) at which the arms are about to move in the direction +1 (rise) or -1 (fall)."""
    geometry = evaluate_geometry(governor, arm_angle)
    force = validate_argument(resistance, "resistance", "N", minimum=0.0)
    resisting_moment = force * np.abs(geometry.sleeve_derivative)
    weight_moment = potential_derivatives(governor, geometry)[0]
    if direction < 0:
        message = "the resistance holds the arms up even at standstill: there is no falling speed"
        shown = (("resistance", force, "N"), ("arm_angle", np.degrees(geometry.angle), "deg"))
        raise_where((resisting_moment > weight_moment) & (weight_moment >= 0), message, *shown, hint="keep it below the sleeve_load")
    return as_scalar_or_array(np.sqrt(squared_balance_speed(governor, geometry, weight_moment + direction * resisting_moment)))


def stiffness(governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None) -> FloatOrArray:
    """Return the stiffness K = V'' - w^2 J'' / 2 (N m/rad) of the arms at constant speed; positive means stable.

    Without a spindle_speed (rad/s) it is that at the equilibrium speed, where also K = J' d(w^2)/da / 2 and, for the rhombus without rod
    masses, K = 2 l M g (1 + m)(e + l sin^3 a) / (x cos a); it then raises MechanismError as equilibrium_speed does.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    squared = squared_given_or_equilibrium_speed(governor, geometry, spindle_speed)
    return as_scalar_or_array(
        potential_derivatives(governor, geometry)[1] - squared * spindle_inertia_derivatives(governor, geometry)[1] / 2
    )


def squared_oscillation_frequency(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None
) -> FloatOrArray:
    """Return the squared angular frequency K / I of small oscillations at constant speed.

    It raises MechanismError if spindle_speed is None and there is no equilibrium speed.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a of the equilibrium, rad.
    spindle_speed
        Spindle speed, rad/s; None: the equilibrium speed at this arm angle.

    Returns
    -------
    FloatOrArray
        Squared angular frequency, rad^2/s^2; negative where unstable, with the growth rate sqrt(-K / I).
    """
    geometry = evaluate_geometry(governor, arm_angle)
    squared = squared_given_or_equilibrium_speed(governor, geometry, spindle_speed)
    arm_stiffness = potential_derivatives(governor, geometry)[1] - squared * spindle_inertia_derivatives(governor, geometry)[1] / 2
    return as_scalar_or_array(arm_stiffness / in_plane_inertia_and_derivative(governor, geometry)[0])


def _total_spindle_inertia(governor: PendulumGovernor, geometry: LinkageGeometry, constant_inertia: FloatOrArray) -> FloatArray:
    """Return J0 + J (kg m2); raise MechanismError where it is zero."""
    fixed_part = validate_argument(constant_inertia, "constant_inertia", "kg m2", minimum=0.0)
    total: FloatArray = fixed_part + np.asarray(spindle_inertia(governor, arm_angle=geometry.angle))
    message = "spindle and governor together must have some inertia about the axis"
    raise_where(total <= 0, message, ("constant_inertia + J", total, "kg m2"))
    return total


def arm_acceleration(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray, damping: FloatOrArray = 0.0
) -> FloatOrArray:
    """Return the angular acceleration of the arms from I a'' + I' a'^2 / 2 + V' - w^2 J' / 2 + c z'^2 a' = 0.

    The equation holds on both sides of the axis, as if the balls could pass through the spindle.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Current spindle speed w, rad/s, given or free.
    damping
        Damping c of a linear dashpot on the sleeve, N s/m; at least 0.

    Returns
    -------
    FloatOrArray
        Angular acceleration a'', rad/s2.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    sleeve_damping = validate_argument(damping, "damping", "N s/m", minimum=0.0)
    inertia, inertia_derivative = in_plane_inertia_and_derivative(governor, geometry)
    moment = speed**2 * spindle_inertia_derivatives(governor, geometry)[0] / 2 - potential_derivatives(governor, geometry)[0]
    return as_scalar_or_array((moment - inertia_derivative * rate**2 / 2 - sleeve_damping * geometry.sleeve_derivative**2 * rate) / inertia)


def spindle_acceleration(
    governor: PendulumGovernor,
    *,
    arm_angle: FloatOrArray,
    arm_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Return the angular acceleration of a free spindle from (J0 + J) w' + J' a' w = torque.

    It raises MechanismError if J0 + J is zero.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    constant_inertia
        Moment of inertia J0 of spindle and sleeve about the axis, kg m2; at least 0.
    torque
        Driving torque, N m.

    Returns
    -------
    FloatOrArray
        Angular acceleration w', rad/s2.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    gyroscopic = spindle_inertia_derivatives(governor, geometry)[0] * rate * speed
    return as_scalar_or_array(
        (validate_argument(torque, "torque", "N m") - gyroscopic) / _total_spindle_inertia(governor, geometry, constant_inertia)
    )


def drive_torque(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray
) -> FloatOrArray:
    """Return the torque with which the drive keeps the spindle speed while the arms move, w J' a'.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Torque, N m; positive drives.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    return as_scalar_or_array(speed * spindle_inertia_derivatives(governor, geometry)[0] * rate)


def least_stable_angle(governor: PendulumGovernor) -> float:
    """Return the arm angle at which crossed arms become stable and their equilibrium speed is least, sin^3 a = -e / l.

    It follows from d(w^2)/da = 0 and is independent of the sleeve mass.

    Parameters
    ----------
    governor
        A rhombus with massless rods and crossed arms.

    Returns
    -------
    float
        Arm angle, rad.

    Raises
    ------
    MechanismError
        For any other governor; arms that do not cross the axis are stable at every angle.

    References
    ----------
    Zehnder (1877), equation (3).
    """
    if not governor.is_rhombus or governor.arm_mass or governor.link_mass:
        raise MechanismError("least_stable_angle holds for a rhombus with massless rods; look for the zero of stiffness")
    if governor.offset >= 0:
        raise MechanismError(f"the arms do not cross the axis (offset {governor.offset:g} m): every angle is stable")
    return math.asin(math.cbrt(-governor.offset / governor.arm))

"""Pendulum governors (Watt, improved Watt, Porter): equilibrium, stability and motion in closed form.

The geometry and its symbols are those of `linkage`; everything needed is named here too. All in SI and radians.

Every function takes the governor first and the rest by keyword, floats or arrays that broadcast; floats give a float.
Every function raises MechanismError, naming the value, for numbers that are not finite, for an arm_angle not between
-90 and 90 deg and for a position that the link cannot reach; what else it refuses stands in its own docstring.

Sources: L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14, equations (1)-(3), rhombus and massless rods; the general
linkage, rods with mass and the motion follow from Lagrange's equation with T = I a'^2/2 + J w^2/2 and potential V.
Limits of all: no friction but the resistance named, rigid slender uniform rods, spindle upright, balls of any size that
do not touch the spindle.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import Number, as_given, checked, refuse_where
from governor_mechanism.closed_form.pendulum.equilibria import balanced_squared, equilibrium_angles, squared_speed
from governor_mechanism.closed_form.pendulum.kinematics import (
    PendulumGovernor,
    Position,
    ball_radius,
    in_plane,
    in_plane_inertia,
    in_plane_inertia_slope,
    link_angle,
    position,
    potential,
    potential_curvature,
    potential_slope,
    potential_slopes,
    sleeve_height,
    sleeve_height_slope,
    spindle_inertia,
    spindle_inertia_curvature,
    spindle_inertia_slope,
    spindle_slopes,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray

__all__ = [
    "PendulumGovernor",
    "arm_acceleration",
    "ball_radius",
    "drive_torque",
    "equal_speed_offset",
    "equilibrium_angles",
    "equilibrium_speed",
    "falling_speed",
    "free_spindle_oscillation_squared",
    "in_plane_inertia",
    "in_plane_inertia_slope",
    "insensitivity",
    "insensitivity_exact",
    "jacobi_integral",
    "least_stable_angle",
    "link_angle",
    "potential",
    "potential_curvature",
    "potential_slope",
    "rising_speed",
    "sleeve_height",
    "sleeve_height_slope",
    "sleeve_load",
    "small_oscillation_squared",
    "spindle_acceleration",
    "spindle_inertia",
    "spindle_inertia_curvature",
    "spindle_inertia_slope",
    "stiffness",
]


def equilibrium_speed(governor: PendulumGovernor, *, arm_angle: Number) -> Number:
    """Spindle speed (rad/s) at which the governor rests at an arm angle, without friction.

    Rhombus, massless rods: w^2 = g (1 + m) tan a / x with m = sleeve_mass / ball_mass. General linkage, massless rods:
    w^2 x / g = tan a + (m l1 / 2 l)(tan a + tan b). With rods 2 V' / J'.
    Raises MechanismError for a ball on or beyond the axis and where no real speed exists. Source: Zehnder (3).
    """
    at = position(governor, arm_angle)
    return as_given(np.sqrt(balanced_squared(governor, at, potential_slopes(governor, at)[0])))


def rising_speed(governor: PendulumGovernor, *, arm_angle: Number, resistance: Number) -> Number:
    """Spindle speed (rad/s) at which the arms are about to rise against a resistance (N, at the sleeve, not negative).

    Rhombus: w'^2 = (g tan a / x)(P + Q + W) / P. Raises as equilibrium_speed does. Source: Zehnder (1).
    """
    return _resisted_speed(governor, arm_angle, resistance, +1.0)


def falling_speed(governor: PendulumGovernor, *, arm_angle: Number, resistance: Number) -> Number:
    """Spindle speed (rad/s) at which the arms are about to fall against a resistance (N, at the sleeve, not negative).

    Rhombus: w''^2 = (g tan a / x)(P + Q - W) / P. Raises MechanismError where the resistance exceeds what the weights
    bring to the sleeve, and as equilibrium_speed does. Source: Zehnder (2).
    """
    return _resisted_speed(governor, arm_angle, resistance, -1.0)


def _resisted_speed(governor: PendulumGovernor, arm_angle: Number, resistance: Number, way: float) -> Number:
    at = position(governor, arm_angle)
    force = checked(resistance, "resistance", "N", least=0.0)
    drag = force * np.abs(at.sleeve_slope)
    weight = potential_slopes(governor, at)[0]
    if way < 0:
        sentence = "the resistance holds the arms up even with the spindle at rest: no falling speed exists"
        shown = (("resistance", force, "N"), ("arm_angle", np.degrees(at.angle), "deg"))
        refuse_where((drag > weight) & (weight >= 0), sentence, *shown, cure="keep it below the sleeve_load")
    return as_given(np.sqrt(balanced_squared(governor, at, weight + way * drag)))


def sleeve_load(governor: PendulumGovernor, *, arm_angle: Number | None = None) -> Number:
    """Downward force (N) of all weights reduced to the sleeve, V' / (sleeve rise per arm angle).

    P l / l1 + Q in a rhombus without rod masses (P one ball, Q the sleeve), the same at every angle, so arm_angle may
    be left out there. Raises MechanismError where the sleeve does not move with the arms, or without the arm_angle that
    another linkage needs. Source: Zehnder (Ia); the force at the sleeve of Dubois, Dinglers 327 (1912).
    """
    if governor.is_rhombus:
        arms = (governor.ball_mass + governor.arm_mass / 2) * governor.arm / governor.joint_length
        load = governor.gravity * (arms + governor.sleeve_mass + 1.5 * governor.link_mass)
        return as_given(load if arm_angle is None else load + 0.0 * position(governor, arm_angle).angle)
    if arm_angle is None:
        raise MechanismError("the sleeve load of a linkage that is no rhombus changes with the arms; give arm_angle")
    at = position(governor, arm_angle)
    shown = ("arm_angle", np.degrees(at.angle), "deg")
    refuse_where(at.sleeve_slope == 0, "the sleeve does not move with the arms", shown, cure="give another arm_angle")
    return as_given(potential_slopes(governor, at)[0] / at.sleeve_slope)


def insensitivity(governor: PendulumGovernor, *, resistance: Number, arm_angle: Number | None = None) -> Number:
    """Degree of insensitivity W / (P + Q): (w'^2 - w''^2) / (2 w^2), nearly (w' - w'') / w, a plain figure.

    resistance W (N, at the sleeve, not negative), over the sleeve_load; arm_angle (rad) may be left out for a rhombus.
    Raises as sleeve_load does and for a load that does not press the sleeve down. Source: Zehnder, after (3).
    """
    drag = checked(resistance, "resistance", "N", least=0.0)
    load = np.asarray(sleeve_load(governor, arm_angle=arm_angle))
    sentence = "the weights do not press the sleeve down"
    refuse_where(load <= 0, sentence, ("sleeve_load", load, "N"), cure="open the arms further")
    return as_given(drag / load)


def insensitivity_exact(governor: PendulumGovernor, *, resistance: Number, arm_angle: Number | None = None) -> Number:
    """(w' - w'') / w without approximation, sqrt(1 + d) - sqrt(1 - d) of the insensitivity d, a plain figure.

    Arguments and errors as of insensitivity; also raises MechanismError for d above 1, where no falling speed exists.
    """
    ratio = np.asarray(insensitivity(governor, resistance=resistance, arm_angle=arm_angle))
    sentence = "resistance must not exceed the sleeve_load, or no falling speed exists"
    refuse_where(ratio > 1, sentence, ("resistance / sleeve_load", ratio, ""))
    return as_given(2 * ratio / (np.sqrt(1 + ratio) + np.sqrt(1 - ratio)))


def stiffness(governor: PendulumGovernor, *, arm_angle: Number, spindle_speed: Number | None = None) -> Number:
    """Stiffness K = V'' - w^2 J'' / 2 (N m per rad) of the arms at constant speed; positive means stable.

    spindle_speed (rad/s) left out means the equilibrium speed, where also K = J' d(w^2)/da / 2 and, for the rhombus
    without rod masses, K = 2 l M g (1 + m)(e + l sin^3 a) / (x cos a). Raises as equilibrium_speed does in that case.
    """
    at = position(governor, arm_angle)
    squared = squared_speed(governor, at, spindle_speed)
    return as_given(potential_slopes(governor, at)[1] - squared * spindle_slopes(governor, at)[1] / 2)


def small_oscillation_squared(
    governor: PendulumGovernor, *, arm_angle: Number, spindle_speed: Number | None = None
) -> Number:
    """Squared angular frequency K / I (rad^2/s^2) of small oscillations at constant speed.

    Negative means unstable, with growth rate sqrt(-K / I) in 1/s. Meaningful at an equilibrium only; spindle_speed
    (rad/s) left out means the speed that makes arm_angle one. Raises as stiffness does.
    """
    at = position(governor, arm_angle)
    squared = squared_speed(governor, at, spindle_speed)
    stiff = potential_slopes(governor, at)[1] - squared * spindle_slopes(governor, at)[1] / 2
    return as_given(stiff / in_plane(governor, at)[0])


def free_spindle_oscillation_squared(
    governor: PendulumGovernor, *, arm_angle: Number, rest_inertia: Number, spindle_speed: Number | None = None
) -> Number:
    """Squared angular frequency (rad^2/s^2) when the spindle turns freely: K / I + w^2 J'^2 / ((J0 + J) I).

    rest_inertia J0 (kg m2, not negative) is that of spindle and sleeve about the axis. Negative means unstable even at
    constant angular momentum. Raises as stiffness does, and where J0 + J is zero.
    """
    at = position(governor, arm_angle)
    squared = squared_speed(governor, at, spindle_speed)
    turning = _turning_inertia(governor, at, rest_inertia)
    lever, bend = spindle_slopes(governor, at)
    stiff = potential_slopes(governor, at)[1] - squared * bend / 2 + squared * lever**2 / turning
    return as_given(stiff / in_plane(governor, at)[0])


def _turning_inertia(governor: PendulumGovernor, at: Position, rest_inertia: Number) -> FloatArray:
    rest = checked(rest_inertia, "rest_inertia", "kg m2", least=0.0)
    total: FloatArray = rest + np.asarray(spindle_inertia(governor, arm_angle=at.angle))
    sentence = "spindle and governor together must have some inertia about the axis"
    refuse_where(total <= 0, sentence, ("rest_inertia + J", total, "kg m2"))
    return total


def arm_acceleration(
    governor: PendulumGovernor, *, arm_angle: Number, arm_rate: Number, spindle_speed: Number, oil_brake: Number = 0.0
) -> Number:
    """Angular acceleration of the arms (rad/s2): I a'' + I' a'^2 / 2 + V' - w^2 J' / 2 + c z'^2 a' = 0.

    arm_rate a' and the momentary spindle_speed w in rad/s, given or free; oil_brake c (N s/m, not negative) is the
    force per speed of the sleeve. Holds on both sides of the axis, as if the balls could pass through the spindle.
    """
    at = position(governor, arm_angle)
    rate, speed = checked(arm_rate, "arm_rate", "rad/s"), checked(spindle_speed, "spindle_speed", "rad/s")
    brake = checked(oil_brake, "oil_brake", "N s/m", least=0.0)
    inertia, change = in_plane(governor, at)
    moment = speed**2 * spindle_slopes(governor, at)[0] / 2 - potential_slopes(governor, at)[0]
    return as_given((moment - change * rate**2 / 2 - brake * at.sleeve_slope**2 * rate) / inertia)


def spindle_acceleration(
    governor: PendulumGovernor,
    *,
    arm_angle: Number,
    arm_rate: Number,
    spindle_speed: Number,
    rest_inertia: Number,
    torque: Number = 0.0,
) -> Number:
    """Angular acceleration of a free spindle (rad/s2): (J0 + J) w' + J' a' w = torque (N m, positive drives).

    rest_inertia J0 (kg m2, not negative) is that of spindle and sleeve. Raises MechanismError where J0 + J is zero.
    """
    at = position(governor, arm_angle)
    rate, speed = checked(arm_rate, "arm_rate", "rad/s"), checked(spindle_speed, "spindle_speed", "rad/s")
    gyroscopic = spindle_slopes(governor, at)[0] * rate * speed
    return as_given((checked(torque, "torque", "N m") - gyroscopic) / _turning_inertia(governor, at, rest_inertia))


def jacobi_integral(
    governor: PendulumGovernor, *, arm_angle: Number, arm_rate: Number, spindle_speed: Number
) -> Number:
    """I a'^2 / 2 + V - w^2 J / 2 (J): constant along every undamped motion at constant spindle speed.

    arm_rate and spindle_speed in rad/s; the zero of V is at the suspension.
    """
    at = position(governor, arm_angle)
    rate, speed = checked(arm_rate, "arm_rate", "rad/s"), checked(spindle_speed, "spindle_speed", "rad/s")
    inertia = np.asarray(spindle_inertia(governor, arm_angle=at.angle))
    kinetic = in_plane(governor, at)[0] * rate**2 / 2 - speed**2 * inertia / 2
    return as_given(kinetic + potential(governor, arm_angle=at.angle))


def drive_torque(governor: PendulumGovernor, *, arm_angle: Number, arm_rate: Number, spindle_speed: Number) -> Number:
    """Torque (N m) the drive must supply to keep the spindle speed while the arms move, w J' a'; positive drives."""
    at = position(governor, arm_angle)
    rate, speed = checked(arm_rate, "arm_rate", "rad/s"), checked(spindle_speed, "spindle_speed", "rad/s")
    return as_given(speed * spindle_slopes(governor, at)[0] * rate)


def least_stable_angle(governor: PendulumGovernor) -> float:
    """Arm angle (rad) at which crossed arms turn stable and need the least speed: sin^3 a = -e / l.

    Holds for the rhombus without rod masses, whatever the sleeve weighs. Raises MechanismError for any other governor
    and for arms that do not cross the axis, which are stable at every angle. Source: d(w^2)/da = 0 from Zehnder (3).
    """
    if not governor.is_rhombus or governor.arm_mass or governor.link_mass:
        raise MechanismError(
            "least_stable_angle holds for a rhombus with massless rods; look for the zero of stiffness"
        )
    if governor.offset >= 0:
        raise MechanismError(f"the arms do not cross the axis (offset {governor.offset:g} m): every angle is stable")
    return math.asin(math.cbrt(-governor.offset / governor.arm))


def equal_speed_offset(*, arm: Number, lower_angle: Number, upper_angle: Number) -> Number:
    """Offset (m, negative: crossed arms) that gives two arm angles (rad) the same equilibrium speed.

    e = -l sin a1 sin a2 sin((a1 + a2)/2) / cos((a2 - a1)/2), for the rhombus with massless rods and any sleeve; between
    the angles the speed is lower. Raises MechanismError unless 0 < lower_angle < upper_angle < 90 deg.
    """
    length = checked(arm, "arm", "m", above=0.0)
    low = checked(lower_angle, "lower_angle", "rad", above=0.0)
    high = checked(upper_angle, "upper_angle", "rad")
    ends = (("lower_angle", np.degrees(low), "deg"), ("upper_angle", np.degrees(high), "deg"))
    refuse_where(high >= math.pi / 2, "upper_angle must lie below 90 deg", ends[1])
    refuse_where(low >= high, "lower_angle must lie below upper_angle", *ends)
    return as_given(-length * np.sin(low) * np.sin(high) * np.sin((low + high) / 2) / np.cos((high - low) / 2))

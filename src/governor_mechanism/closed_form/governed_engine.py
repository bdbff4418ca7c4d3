"""The loop of engine and governor, linearised by hand: its characteristic polynomial, and Vyshnegradskii's parameters.

A governor with one coordinate q is geared to the shaft of an engine: its spindle turns r times as fast. With the shaft speed w, the
inertia of the governor in its plane I(q) and about its spindle J(q), its potential energy V(q), the sleeve height z(q) and its dashpot c,
and with the shaft's own inertia J0, the kinetic energy is T = I q'^2 / 2 + (J0 + r^2 J) w^2 / 2, and Lagrange's equations are

    I q'' + I' q'^2 / 2 + V' - r^2 w^2 J' / 2 + c z'^2 q' = 0
    (J0 + r^2 J) w' + r^2 J' q' w = M(q) - L(w)

with the mean torque M of the engine, which the governor sets, and the torque L of the load. About a steady motion, with D = c z'^2,
K = V'' - r^2 w^2 J'' / 2, N = r^2 w J', g = -dM/dq, h = dL/dw and Jt = J0 + r^2 J, small changes obey

    I dq'' + D dq' + K dq - N dw = 0,        Jt dw' + h dw + N dq' + g dq = 0,

so that (I s^2 + D s + K)(Jt s + h) + N (N s + g) = 0. Its term N^2 s is the reaction of the governor on the shaft, which the classical
theory leaves out. All arguments are keywords, floats or arrays that broadcast; floats give floats. SI and radians. Every function raises
MechanismError for a value that is not finite or has the wrong sign.

References
----------
I. A. Wischnegradsky (Vyshnegradskii), Über direct wirkende Regulatoren, Civilingenieur 23 (1877), pp. 95-132, for the polynomial of third
degree and its plane of x and y.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.closed_form.pendulum import dynamics
from governor_mechanism.closed_form.pendulum.kinematics import LinkagePosition, PendulumGovernor
from governor_mechanism.types import FloatOrArray


@dataclass(frozen=True, kw_only=True)
class CharacteristicCoefficients:
    """Coefficients of the characteristic polynomial s^3 + a s^2 + b s + c of engine and governor.

    Attributes
    ----------
    a
        Coefficient of s^2, 1/s; a float or an array, as the others.
    b
        Coefficient of s, 1/s2.
    c
        Constant coefficient, 1/s3.
    """

    a: FloatOrArray
    b: FloatOrArray
    c: FloatOrArray

    def roots(self) -> tuple[complex, complex, complex]:
        """Return the three roots (1/s), the least damped first; the coefficients must be numbers."""
        coefficients = [1.0, *(float(value) for value in (self.a, self.b, self.c))]
        first, second, third = sorted(np.roots(coefficients), key=lambda root: (-root.real, -root.imag))
        return complex(first), complex(second), complex(third)


def characteristic_coefficients(
    *,
    coordinate_inertia: FloatOrArray,
    coordinate_damping: FloatOrArray,
    stiffness: FloatOrArray,
    spindle_inertia_derivative: FloatOrArray,
    spindle_speed: FloatOrArray,
    shaft_inertia: FloatOrArray,
    torque_derivative: FloatOrArray,
    gear_ratio: FloatOrArray = 1.0,
    self_regulation: FloatOrArray = 0.0,
    reacts: bool = True,
) -> CharacteristicCoefficients:
    """Return the coefficients for any governor with one coordinate q.

    Parameters
    ----------
    coordinate_inertia
        I of the kinetic energy I q'^2 / 2, kg m2 if q is an angle (all units below are for an angle).
    coordinate_damping
        D, the dashpot referred to the coordinate, N m s/rad: its damping on the sleeve times (dz/dq)^2.
    stiffness
        K = V'' - w_s^2 J'' / 2 at the constant spindle speed w_s, N m/rad.
    spindle_inertia_derivative
        J' = dJ/dq of the moment of inertia about the spindle, kg m2/rad.
    spindle_speed
        Spindle speed w_s in equilibrium, rad/s: gear_ratio times that of the shaft.
    shaft_inertia
        Moment of inertia Jt of all that turns, referred to the shaft: J0 + gear_ratio^2 (J + that of the spindle), kg m2.
    torque_derivative
        dM/dq of the engine's mean torque on the shaft, N m/rad; negative if the opening governor closes the throttle.
    gear_ratio
        Turns of the spindle in a turn of the shaft, r.
    self_regulation
        h = d(L - M)/dw of load and engine at constant throttle, N m s/rad.
    reacts
        Whether the moving governor takes torque from the shaft; False: the classical theory, without the term N^2 s.

    Returns
    -------
    CharacteristicCoefficients
        The coefficients a, b and c.
    """
    inertia = validate_argument(coordinate_inertia, "coordinate_inertia", "kg m2", greater_than=0.0)
    damping = validate_argument(coordinate_damping, "coordinate_damping", "N m s/rad", minimum=0.0)
    rate, slope = validate_argument(stiffness, "stiffness", "N m/rad"), validate_argument(torque_derivative, "torque_derivative", "N m/rad")
    ratio = validate_argument(gear_ratio, "gear_ratio", "")
    coupling = (  # N = r^2 w J', with w_s = r w
        ratio
        * validate_argument(spindle_speed, "spindle_speed", "rad/s")
        * validate_argument(spindle_inertia_derivative, "spindle_inertia_derivative", "kg m2/rad")
    )
    total = validate_argument(shaft_inertia, "shaft_inertia", "kg m2", greater_than=0.0)
    regulation = validate_argument(self_regulation, "self_regulation", "N m s/rad")
    reaction = coupling**2 if reacts else 0.0
    return CharacteristicCoefficients(
        a=as_scalar_or_array(damping / inertia + regulation / total),
        b=as_scalar_or_array(rate / inertia + (damping * regulation + reaction) / (inertia * total)),
        c=as_scalar_or_array((rate * regulation - coupling * slope) / (inertia * total)),
    )


def pendulum_coefficients(
    governor: PendulumGovernor,
    *,
    arm_angle: FloatOrArray,
    flywheel_inertia: FloatOrArray,
    torque_slope: FloatOrArray,
    sleeve_damping: FloatOrArray = 0.0,
    gear_ratio: FloatOrArray = 1.0,
    spindle_inertia: FloatOrArray = 0.0,
    self_regulation: FloatOrArray = 0.0,
    reacts: bool = True,
) -> CharacteristicCoefficients:
    """Return the coefficients of an engine under a pendulum governor in equilibrium at an arm angle.

    The speed is that at which the governor is in equilibrium there. Without friction; the load's torque does not depend on time.

    Parameters
    ----------
    governor
        Dimensions and masses of the governor: Watt, improved Watt or Porter.
    arm_angle
        Arm angle a of the equilibrium from the vertical, rad.
    flywheel_inertia
        Moment of inertia J0 of flywheel and shaft, kg m2.
    torque_slope
        dM/dz of the engine's mean torque by the lift of the sleeve, N m/m; negative if the rising sleeve closes the throttle.
    sleeve_damping
        Damping c of a linear dashpot on the sleeve, N s/m.
    gear_ratio
        Turns of the spindle in a turn of the shaft, r.
    spindle_inertia
        Constant moment of inertia of the spindle about its axis, kg m2.
    self_regulation
        h = d(L - M)/dw of load and engine at constant throttle, N m s/rad.
    reacts
        Whether balls and spindle react on the shaft; False: only the flywheel turns the shaft, as behind a coupling that follows.

    Returns
    -------
    CharacteristicCoefficients
        The coefficients a (1/s), b (1/s2) and c (1/s3).
    """
    position = LinkagePosition(governor, arm_angle)
    lift_derivative = position.sleeve_derivative
    ratio = validate_argument(gear_ratio, "gear_ratio", "")
    turning = validate_argument(spindle_inertia, "spindle_inertia", "kg m2", minimum=0.0)
    turning = turning + np.asarray(dynamics.spindle_inertia(governor, arm_angle=arm_angle))
    fixed = validate_argument(flywheel_inertia, "flywheel_inertia", "kg m2", greater_than=0.0)
    return characteristic_coefficients(
        coordinate_inertia=position.in_plane_inertia_and_derivative()[0],
        coordinate_damping=validate_argument(sleeve_damping, "sleeve_damping", "N s/m", minimum=0.0) * lift_derivative**2,
        stiffness=dynamics.stiffness(governor, arm_angle=arm_angle),
        spindle_inertia_derivative=position.spindle_inertia_derivatives()[0],
        spindle_speed=dynamics.equilibrium_speed(governor, arm_angle=arm_angle),
        shaft_inertia=fixed + ratio**2 * turning if reacts else fixed,
        torque_derivative=validate_argument(torque_slope, "torque_slope", "N m/m") * lift_derivative,
        gear_ratio=ratio,
        self_regulation=self_regulation,
        reacts=reacts,
    )


def vyshnegradskii_parameters(coefficients: CharacteristicCoefficients) -> tuple[FloatOrArray, FloatOrArray]:
    """Return Vyshnegradskii's parameters x = a / c^(1/3) and y = b / c^(2/3).

    With s = c^(1/3) t the polynomial is t^3 + x t^2 + y t + 1: the steady motion is stable if and only if x > 0 and x y > 1.

    Parameters
    ----------
    coefficients
        Coefficients of the polynomial.

    Returns
    -------
    tuple[FloatOrArray, FloatOrArray]
        The parameters x and y.

    Raises
    ------
    MechanismError
        If c is not positive: a governor without droop, or one that opens the throttle as it rises.
    """
    constant = np.asarray(coefficients.c)
    message = "the constant coefficient of the polynomial must be positive, or one root is not negative"
    raise_where(constant <= 0, message, ("c", constant, "1/s3"), hint="let the rising sleeve close the throttle")
    scale = np.cbrt(constant)
    return as_scalar_or_array(coefficients.a / scale), as_scalar_or_array(coefficients.b / scale**2)

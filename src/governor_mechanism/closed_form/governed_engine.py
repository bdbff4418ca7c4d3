"""The loop of engine and governor, linearised by hand: its characteristic polynomial, and Vyshnegradskii's parameters.

A throttle u, 0 to 1, admits air at r + u (p - r), with the pressure p of the supply and r behind the piston; the pump delivers at p. SI and
radians. The engine is the first argument of a function that has one; its load pressure does not enter.

A governor with one coordinate q is geared to the shaft of an engine: its spindle turns r times as fast. With the shaft speed w, the
inertia of the governor in its plane I(q) and about its spindle J(q), its potential energy V(q), the sleeve height z(q) and its dashpot c,
and with the shaft's own inertia J0, the kinetic energy is T = I q'^2 / 2 + (J0 + r^2 J) w^2 / 2, and Lagrange's equations are

    I q'' + I' q'^2 / 2 + V' - r^2 w^2 J' / 2 + c z'^2 q' = 0
    (J0 + r^2 J) w' + r^2 J' q' w = M(q) - L(w)

with the mean torque M of the engine, which the governor sets, and the torque L of the load. About a steady motion, with D = c z'^2,
K = V'' - r^2 w^2 J'' / 2, N = r^2 w J', g = -dM/dq, h = dL/dw and Jt = J0 + r^2 J, small changes obey

    I dq'' + D dq' + K dq - N dw = 0,        Jt dw' + h dw + N dq' + g dq = 0,

so that (I s^2 + D s + K)(Jt s + h) + N (N s + g) = 0. Its term N^2 s is the reaction of the governor on the shaft, which the classical
theory leaves out. The other arguments are keywords, floats or arrays that broadcast; floats give floats. Every function raises
MechanismError for a value that is not finite or has the wrong sign.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equations (61) to (67), with another pressure of
admission.

I. A. Wischnegradsky (Vyshnegradskii), Über direct wirkende Regulatoren, Civilingenieur 23 (1877), pp. 95-132, for the polynomial of third
degree and its plane of x and y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.closed_form.flywheel_engine import (
    AirEngine,
    expansion_pressure,
    expansion_work,
    gas_torque,
    gas_work,
    piston_travel,
    pump_work,
)
from governor_mechanism.closed_form.flywheel_equilibrium import N_SEARCH_POINTS
from governor_mechanism.closed_form.pendulum import LinkagePosition, PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatArray, FloatOrArray


def full_throttle_torque(engine: AirEngine) -> float:
    """Return the mean torque (N m) of the air in both cylinders on the shaft with the throttle open: its work in a stroke over pi."""
    return gas_work(engine) / math.pi


def throttle_torque(engine: AirEngine) -> float:
    """Return the torque (N m) that the whole throttle commands: the mean torque with it open less that with it closed.

    The mean torque is linear in u: it is that of the open throttle less 1 - u times this torque, which is A L (p - r) f / pi with the
    expansion factor f = s + (m + s) ln((m + 1) / (m + s)) of cut-off s and clearance m.

    Parameters
    ----------
    engine
        The engine.

    Returns
    -------
    float
        Torque, N m.

    Raises
    ------
    MechanismError
        If the supply is not above the pressure behind the piston.
    """
    initial = engine.clearance + engine.cut_off
    factor = engine.cut_off + initial * math.log1p((1 - engine.cut_off) / initial)
    return engine.area * engine.stroke * _surplus_pressure(engine) * factor / math.pi


def throttle_for_torque(engine: AirEngine, *, torque: FloatOrArray) -> FloatOrArray:
    """Return the opening of the throttle at which the mean torque has a value.

    Parameters
    ----------
    engine
        The engine.
    torque
        Mean torque, N m.

    Returns
    -------
    FloatOrArray
        Opening u, 0 to 1.

    Raises
    ------
    MechanismError
        If no opening gives that torque.
    """
    wanted = validate_argument(torque, "torque", "N m")
    opening = 1 - (full_throttle_torque(engine) - wanted) / throttle_torque(engine)
    hint = f"the engine gives at most {full_throttle_torque(engine):.6g} N m"
    raise_where((opening < 0) | (opening > 1), "no opening of the throttle gives this torque", ("torque", wanted, "N m"), hint=hint)
    return as_scalar_or_array(opening)


def throttled_gas_torque(engine: AirEngine, *, crank_angle: FloatOrArray, throttle: float) -> FloatOrArray:
    """Return the torque of the air in both cylinders on the shaft.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.
    throttle
        Opening u of the throttle.

    Returns
    -------
    FloatOrArray
        Torque, N m.
    """
    relative = np.asarray(expansion_pressure(engine, crank_angle=crank_angle)) / engine.supply_pressure
    missing = (1 - throttle) * _surplus_pressure(engine) * relative * engine.area * engine.stroke
    sine = np.abs(np.sin(validate_argument(crank_angle, "crank_angle", "rad")))
    return as_scalar_or_array(np.asarray(gas_torque(engine, crank_angle=crank_angle)) - missing * sine / 2)


def throttled_stored_work(engine: AirEngine, *, crank_angle: FloatOrArray, throttle: float) -> FloatOrArray:
    """Return the work of the air since the dead centre less that of the constant load that closes the cycle: what the flywheel stores.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi since the dead centre, rad, 0 to pi.
    throttle
        Opening u of the throttle.

    Returns
    -------
    FloatOrArray
        Work, J; 0 at both dead centres.
    """
    # The upper dead centre belongs to the next stroke, whose work begins at zero.
    angle = np.minimum(validate_argument(crank_angle, "crank_angle", "rad", minimum=0.0), np.nextafter(math.pi, 0.0))
    volume = engine.area * engine.stroke
    expansion = np.asarray(expansion_work(engine, crank_angle=angle))
    travel = np.asarray(piston_travel(crank_angle=angle))
    factor = (expansion / volume + engine.back_pressure * travel) / engine.supply_pressure
    missing = (1 - throttle) * _surplus_pressure(engine) * factor * volume
    mean_torque = full_throttle_torque(engine) - (1 - throttle) * throttle_torque(engine)
    return as_scalar_or_array(expansion + np.asarray(pump_work(engine, crank_angle=angle)) - missing - mean_torque * angle)


@dataclass(frozen=True, kw_only=True)
class StoredWorkRange:
    """Lowest and highest work (J) that the flywheel stores in a stroke, from 0 at the dead centre, under the load that closes the cycle."""

    lowest: float
    highest: float

    @property
    def energy(self) -> float:
        """Work between lowest and highest speed, J."""
        return self.highest - self.lowest


def find_stored_work_range(engine: AirEngine, *, throttle: float) -> StoredWorkRange:
    """Return the extremes of the work that the flywheel stores, where the torque of the air passes its mean.

    Parameters
    ----------
    engine
        The engine.
    throttle
        Opening u of the throttle.

    Returns
    -------
    StoredWorkRange
        The extremes.
    """
    mean_torque = full_throttle_torque(engine) - (1 - throttle) * throttle_torque(engine)

    def excess(angle: FloatOrArray) -> FloatArray:
        return np.asarray(throttled_gas_torque(engine, crank_angle=angle, throttle=throttle)) - mean_torque

    ends = (0.0, *engine.interval_limits, math.pi)
    grid = np.unique(np.concatenate([np.linspace(*pair, N_SEARCH_POINTS) for pair in pairwise(ends)]))
    is_driving = excess(grid) > 0
    angles = [
        find_root(lambda angle: float(excess(angle)), float(grid[k]), float(grid[k + 1]))
        for k in np.flatnonzero(is_driving[1:] != is_driving[:-1])
    ]
    works = np.asarray(throttled_stored_work(engine, crank_angle=np.array([0.0, *angles]), throttle=throttle))
    return StoredWorkRange(lowest=float(works.min()), highest=float(works.max()))


def _surplus_pressure(engine: AirEngine) -> float:
    """Return p - r, Pa, which the throttle holds back."""
    surplus = engine.supply_pressure - engine.back_pressure
    if not surplus > 0:
        raise MechanismError(
            f"supply_pressure ({engine.supply_pressure:.6g} Pa) must be above back_pressure ({engine.back_pressure:.6g} Pa), or the "
            "throttle has nothing to hold back"
        )
    return surplus


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
    rate = validate_argument(stiffness, "stiffness", "N m/rad")
    slope = validate_argument(torque_derivative, "torque_derivative", "N m/rad")
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
    turning = turning + np.asarray(pendulum.spindle_inertia(governor, arm_angle=arm_angle))
    fixed = validate_argument(flywheel_inertia, "flywheel_inertia", "kg m2", greater_than=0.0)
    return characteristic_coefficients(
        coordinate_inertia=position.in_plane_inertia_and_derivative()[0],
        coordinate_damping=validate_argument(sleeve_damping, "sleeve_damping", "N s/m", minimum=0.0) * lift_derivative**2,
        stiffness=pendulum.stiffness(governor, arm_angle=arm_angle),
        spindle_inertia_derivative=position.spindle_inertia_derivatives()[0],
        spindle_speed=pendulum.equilibrium_speed(governor, arm_angle=arm_angle),
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

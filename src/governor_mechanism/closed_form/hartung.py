"""Hartung's spring governor: equilibrium, sleeve force, stability and motion.

Two bell cranks carry a weight each on the arm a; the arm b, at the angle `angle` to it, carries the hanger of the sleeve. The lever angle
alpha (rad) is that of the arm a from the vertical, positive toward the spindle. A weight is at x = x_H - a sin alpha; the end of b is
b cos(angle + alpha) above the fulcrum. The sleeve rises as the weights move outward. A horizontal spring presses each weight inward with
the force P at its mass centre.

Arguments after the governor are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for
a value that is not finite or out of range. The weights are points; bell cranks and hangers are massless; there is no friction.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 599-620. The equations of motion follow from Lagrange's equation.
"""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument, validate_fields
from governor_mechanism.types import FloatArray, FloatOrArray


@dataclass(frozen=True, kw_only=True)
class HartungGovernor:
    """Dimensions and masses of a Hartung governor.

    MechanismError is raised unless lengths and masses are positive and the angle is between 0 and pi.

    Attributes
    ----------
    weight_arm
        Arm a of the bell crank, m.
    sleeve_arm
        Arm b of the bell crank, m.
    angle
        Angle between the arms, rad.
    fulcrum_radius
        Distance x_H of the fulcrum from the spindle axis, m.
    weight_mass
        Mass M of one weight, kg.
    sleeve_mass
        Mass m of the sleeve, kg.
    hanger
        Length of a hanger, m; infinite if the hangers are always vertical, as in the paper.
    lug_radius
        Distance of the sleeve lugs from the axis, m; used with a finite hanger only.
    gravity
        Gravitational acceleration, m/s2.
    """

    weight_arm: float
    sleeve_arm: float
    angle: float
    fulcrum_radius: float
    weight_mass: float
    sleeve_mass: float
    hanger: float = math.inf
    lug_radius: float = 0.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        positive = {"weight_arm": "m", "sleeve_arm": "m", "fulcrum_radius": "m", "weight_mass": "kg", "sleeve_mass": "kg"}
        validate_fields(self, positive if math.isinf(self.hanger) else positive | {"hanger": "m"}, greater_than=0.0)
        validate_fields(self, {"gravity": "m/s2"}, minimum=0.0)
        validate_fields(self, {"lug_radius": "m"})
        validate_angle(self.angle, "angle", 180.0, positive=True)


def weight_radius(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance of a weight's mass centre from the spindle axis, x = x_H - a sin alpha.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.

    Returns
    -------
    FloatOrArray
        Distance, m.
    """
    return as_scalar_or_array(governor.fulcrum_radius - governor.weight_arm * np.sin(_validate_lever_angle(lever_angle)))


def lift_derivative(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Return the derivative of the sleeve's height by the lever angle, z' = -b (sin(g + alpha) + cos(g + alpha) tan psi).

    g is the angle of the bell crank, psi the angle of the hanger from the vertical.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.

    Returns
    -------
    FloatOrArray
        Derivative, m/rad; negative where an outward motion of the weights lifts the sleeve.
    """
    return as_scalar_or_array(_lift_derivatives(governor, _validate_lever_angle(lever_angle))[0])


def astatic_spring_force(governor: HartungGovernor, *, lever_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """Return the spring force that balances a weight at a lever angle and a spindle speed.

    P = M w^2 x - (Q / 2) (b / a) sin(g + alpha) / cos alpha - G tan alpha, with the weights G of one weight and Q of the sleeve. With a
    hanger that is not vertical, -z' replaces b sin(g + alpha).

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Force P of one spring, N.

    References
    ----------
    Dubois (1912), p. 618.
    """
    alpha = _validate_lever_angle(lever_angle)
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    a, weight = governor.weight_arm, governor.weight_mass * governor.gravity
    sleeve_force_share = 0.5 * governor.sleeve_mass * governor.gravity * _lift_derivatives(governor, alpha)[0] / (a * np.cos(alpha))
    return as_scalar_or_array(_centrifugal_force(governor, alpha, speed) + sleeve_force_share - weight * np.tan(alpha))


def equilibrium_speed(governor: HartungGovernor, *, lever_angle: FloatOrArray, spring_force: FloatOrArray) -> FloatOrArray:
    """Return the spindle speed at which a spring force balances a weight: `astatic_spring_force` solved for the speed.

    It raises MechanismError if the spring is too weak to balance the weight at any speed.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    spring_force
        Force P of one spring, N.

    Returns
    -------
    FloatOrArray
        Spindle speed w, rad/s.
    """
    alpha = _validate_lever_angle(lever_angle)
    force = validate_argument(spring_force, "spring_force", "N")
    standstill_force = np.asarray(astatic_spring_force(governor, lever_angle=alpha, spindle_speed=0.0))
    squared_speed = (force - standstill_force) / (governor.weight_mass * np.asarray(weight_radius(governor, lever_angle=alpha)))
    message = "no spindle speed balances the weights: the spring is too weak"
    raise_where(squared_speed < 0, message, ("spring_force", force, "N"), ("lever_angle", np.degrees(alpha), "deg"))
    return as_scalar_or_array(np.sqrt(squared_speed))


def static_sleeve_force(governor: HartungGovernor, *, lever_angle: FloatOrArray, spring_force: FloatOrArray) -> FloatOrArray:
    """Return the force with which springs and weights hold down the sleeve at standstill.

    S = 2 (P + G tan alpha) (a / b) cos alpha / sin(g + alpha) + Q.

    It raises MechanismError if the lever is at or beyond the change point, where an outward motion does not lift the sleeve.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    spring_force
        Force P of one spring, N.

    Returns
    -------
    FloatOrArray
        Static sleeve force S, N.

    References
    ----------
    Dubois (1912), p. 620.
    """
    alpha = _validate_lever_angle(lever_angle)
    force = validate_argument(spring_force, "spring_force", "N")
    height_derivative = _lift_derivatives(governor, alpha)[0]
    message = "the lever is at or beyond its change point: an outward motion does not lift the sleeve"
    raise_where(height_derivative >= 0, message, ("lever_angle", np.degrees(alpha), "deg"))
    lever_ratio = governor.weight_arm * np.cos(alpha) / -height_derivative
    weight_force = governor.weight_mass * governor.gravity * np.tan(alpha)
    return as_scalar_or_array(2 * (force + weight_force) * lever_ratio + governor.sleeve_mass * governor.gravity)


def lever_inertia(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Return the generalised inertia along the lever angle, I = 2 M a^2 + m z'^2; the planar kinetic energy is I alpha'^2 / 2.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.

    Returns
    -------
    FloatOrArray
        Inertia, kg m2.
    """
    height_derivative = _lift_derivatives(governor, _validate_lever_angle(lever_angle))[0]
    return as_scalar_or_array(2 * governor.weight_mass * governor.weight_arm**2 + governor.sleeve_mass * height_derivative**2)


def stiffness(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    spring_force: FloatOrArray,
    spring_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
) -> FloatOrArray:
    """Return the stiffness (N m/rad) along the lever angle at constant speed; positive where the equilibrium is stable.

    2 [(k - M w^2) a^2 cos^2 + (P - M w^2 x) a sin - M g a cos] + m g z", sin and cos of the lever angle. The force P (N) and the rate
    k (N/m) are those of one spring. With a vertical hanger m g z" is -m g b cos(g + alpha).
    """
    alpha = _validate_lever_angle(lever_angle)
    force = validate_argument(spring_force, "spring_force", "N")
    rate = validate_argument(spring_rate, "spring_rate", "N/m")
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    a, mass = governor.weight_arm, governor.weight_mass
    sine, cosine = np.sin(alpha), np.cos(alpha)
    per_weight = (rate - mass * speed**2) * (a * cosine) ** 2
    per_weight += (force - _centrifugal_force(governor, alpha, speed)) * a * sine - mass * governor.gravity * a * cosine
    return as_scalar_or_array(2 * per_weight + governor.sleeve_mass * governor.gravity * _lift_derivatives(governor, alpha)[1])


def squared_natural_frequency(
    governor: HartungGovernor, *, lever_angle: FloatOrArray, spring_force: FloatOrArray, spring_rate: FloatOrArray
) -> FloatOrArray:
    """Return the squared natural frequency V" / I of small oscillations about an equilibrium at constant speed.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    spring_force
        Force P of one spring, N; the speed is the equilibrium speed.
    spring_rate
        Rate k of one spring, N/m.

    Returns
    -------
    FloatOrArray
        Squared natural frequency, 1/s2; negative where the equilibrium is unstable.
    """
    speed = equilibrium_speed(governor, lever_angle=lever_angle, spring_force=spring_force)
    lever_stiffness = stiffness(governor, lever_angle=lever_angle, spring_force=spring_force, spring_rate=spring_rate, spindle_speed=speed)
    return as_scalar_or_array(np.asarray(lever_stiffness) / np.asarray(lever_inertia(governor, lever_angle=lever_angle)))


def lever_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    lever_rate: FloatOrArray,
    spring_force: FloatOrArray,
    spindle_speed: FloatOrArray,
    damping: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Return the angular acceleration of the lever from Lagrange's equation.

    I alpha" + m z' z" alpha'^2 - 2 P a cos - 2 M g a sin + m g z' + 2 M w^2 x a cos = -c z'^2 alpha', sin and cos of alpha.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    lever_rate
        Angular velocity alpha', rad/s.
    spring_force
        Force P of one spring, N.
    spindle_speed
        Spindle speed w, rad/s.
    damping
        Damping c of a linear dashpot on the sleeve, N s/m; at least 0.

    Returns
    -------
    FloatOrArray
        Angular acceleration, rad/s2.
    """
    alpha = _validate_lever_angle(lever_angle)
    rate = validate_argument(lever_rate, "lever_rate", "rad/s")
    force = validate_argument(spring_force, "spring_force", "N")
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    a = governor.weight_arm
    mass = governor.weight_mass
    sleeve = governor.sleeve_mass
    height_derivative, height_second_derivative = _lift_derivatives(governor, alpha)
    generalised_force = 2 * (force - _centrifugal_force(governor, alpha, speed)) * a * np.cos(alpha)
    generalised_force += 2 * mass * governor.gravity * a * np.sin(alpha) - sleeve * governor.gravity * height_derivative
    generalised_force -= (
        sleeve * height_derivative * height_second_derivative * rate**2
        + validate_argument(damping, "damping", "N s/m", minimum=0.0) * height_derivative**2 * rate
    )
    return as_scalar_or_array(generalised_force / (2 * mass * a**2 + sleeve * height_derivative**2))


def spindle_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    lever_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Return the angular acceleration of a free spindle, (torque - J' w alpha') / (J0 + J) with J' = -4 M x a cos alpha.

    Parameters
    ----------
    governor
        Dimensions and masses.
    lever_angle
        Lever angle alpha, rad.
    lever_rate
        Angular velocity alpha', rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    constant_inertia
        Moment of inertia J0 of the spindle alone, kg m2; at least 0.
    torque
        Driving torque, N m.

    Returns
    -------
    FloatOrArray
        Angular acceleration, rad/s2.
    """
    alpha = _validate_lever_angle(lever_angle)
    rate = validate_argument(lever_rate, "lever_rate", "rad/s")
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    drive_torque = validate_argument(torque, "torque", "N m")
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    inertia_derivative = -4 * governor.weight_mass * x * governor.weight_arm * np.cos(alpha)
    total_inertia = validate_argument(constant_inertia, "constant_inertia", "kg m2", minimum=0.0) + 2 * governor.weight_mass * x**2
    return as_scalar_or_array((drive_torque - inertia_derivative * speed * rate) / total_inertia)


def relative_spread(forces: FloatArray) -> float:
    """Return the range of the forces relative to their mean: a measure of how far a sleeve force is from constant.

    It raises MechanismError if there are fewer than two forces, or their mean is zero.

    Parameters
    ----------
    forces
        Two or more forces, N; shape (n,).

    Returns
    -------
    float
        (maximum - minimum) / |mean|.
    """
    values = validate_argument(forces, "forces", "N")
    raise_where(np.asarray(values.size < 2), "a relative spread needs at least two forces", ("count", values.size, ""))
    mean = float(np.mean(values))
    raise_where(np.asarray(mean == 0.0), "a relative spread needs forces with a mean other than zero", ("mean", mean, "N"))
    return float((np.max(values) - np.min(values)) / abs(mean))


def _validate_lever_angle(lever_angle: FloatOrArray) -> FloatArray:
    """Return the angle (rad); at 90 deg from the vertical the spring has no lever arm."""
    return validate_angle(lever_angle, "lever_angle", 90.0)


def _centrifugal_force(governor: HartungGovernor, alpha: FloatArray, speed: FloatArray) -> FloatArray:
    """Return the centrifugal force of one weight, M w^2 x (N)."""
    return np.asarray(governor.weight_mass * speed**2 * weight_radius(governor, lever_angle=alpha))


def _lift_derivatives(governor: HartungGovernor, alpha: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the two derivatives of the height z of the sleeve lugs by alpha (m/rad, m/rad^2)."""
    b, phi = governor.sleeve_arm, governor.angle + alpha
    rise, reach = b * np.cos(phi), b * np.sin(phi)
    if governor.hanger == math.inf:
        return -reach, -rise
    hanger_offset = governor.fulcrum_radius - reach - governor.lug_radius
    shown = (("lever_angle", np.degrees(alpha), "deg"), ("hanger offset", np.abs(hanger_offset), "m"))
    message = "the hanger is too short: the horizontal offset of its upper end from the lug exceeds its length"
    raise_where(np.abs(hanger_offset) >= governor.hanger, message, *shown)
    hanger_drop = np.sqrt(governor.hanger**2 - hanger_offset**2)
    hanger_tangent = hanger_offset / hanger_drop
    # The derivatives of the offset by alpha are -rise and reach.
    drop_second_derivative = (rise**2 + hanger_offset * reach + (hanger_tangent * rise) ** 2) / hanger_drop
    return -reach - hanger_tangent * rise, -rise + drop_second_derivative

"""Hartung's spring governor: the spring force that balances it, its sleeve force, rest, stability and small swings.

Two weights on bell cranks: the arm a carries a weight, the arm b at the angle `angle` to it the sleeve's hanger. The
lever angle (rad) is that of the arm a from upright, positive toward the spindle: the paper's letter for it is alpha. A
weight stands at x = x_H - a sin alpha, the foot of b at the height b cos(angle + alpha) above the fulcrum; moving out,
the weights lift the sleeve. A spring presses each weight inward with the force P at its mass centre.

Every function takes keywords only after the governor, floats or arrays that broadcast; floats give a float. Each raises
MechanismError, naming the value, for numbers that are not finite or outside the range its docstring gives.
Source: Fr. Dubois, Dinglers Polyt. J. 327 (1912), pp. 599-620; motion by Lagrange's equation. Limits: weights as
points, massless bell cranks and hangers, no friction, horizontal springs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class HartungGovernor:
    """A governor's dimensions: lengths in m, masses in kg, angle in rad, gravity in m/s2.

    hanger is the length of the hangers down to lugs `lug_radius` beside the axis; infinite: always vertical, as the
    paper takes them. Raises MechanismError unless lengths and masses are positive and angle lies between 0 and pi.
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
        for name, unit in (("weight_arm", "m"), ("sleeve_arm", "m"), ("fulcrum_radius", "m")):
            validate_argument(getattr(self, name), name, unit, greater_than=0.0)
        for name in ("weight_mass", "sleeve_mass"):
            validate_argument(getattr(self, name), name, "kg", greater_than=0.0)
        validate_argument(self.gravity, "gravity", "m/s2", minimum=0.0)
        validate_argument(self.lug_radius, "lug_radius", "m")
        angle = validate_argument(self.angle, "angle", "rad", greater_than=0.0)
        raise_where(angle >= math.pi, "angle must lie below 180 deg", ("angle", np.degrees(angle), "deg"))
        if self.hanger != math.inf:
            validate_argument(self.hanger, "hanger", "m", greater_than=0.0)


def weight_radius(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Distance x = x_H - a sin alpha (m) of a weight's centre from the axis."""
    return as_scalar_or_array(governor.fulcrum_radius - governor.weight_arm * np.sin(_validate_lever_angle(lever_angle)))


def sleeve_height(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Height (m) of the sleeve's lugs above the fulcrum: b cos(angle + alpha), less the drop of a hanger."""
    height_derivatives = _lug_height_derivatives(governor, _validate_lever_angle(lever_angle))
    return as_scalar_or_array(height_derivatives[0])


def lift_derivative(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """How the sleeve's height follows the lever angle (m/rad): -b (sin(g + alpha) + cos(g + alpha) tan psi).

    g is the angle of the bell crank, psi that of the hanger from the vertical. Negative where outward lifts.
    """
    return as_scalar_or_array(_lug_height_derivatives(governor, _validate_lever_angle(lever_angle))[1])


def astatic_spring_force(governor: HartungGovernor, *, lever_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """Spring force P (N) that holds a weight at a lever angle (rad) and a spindle speed (rad/s).

    P = M w^2 x - (Q / 2) (b / a) sin(g + alpha) / cos alpha - G tan alpha, G and Q the weights of one weight and of the
    sleeve; with a hanger that is not vertical -z' takes the place of b sin(g + alpha). Source: Dubois p. 618.
    """
    alpha, speed = _validate_lever_angle(lever_angle), validate_argument(spindle_speed, "spindle_speed", "rad/s")
    a, weight = governor.weight_arm, governor.weight_mass * governor.gravity
    sleeve_force_share = 0.5 * governor.sleeve_mass * governor.gravity * _lug_height_derivatives(governor, alpha)[1] / (a * np.cos(alpha))
    return as_scalar_or_array(_centrifugal_force(governor, alpha, speed) + sleeve_force_share - weight * np.tan(alpha))


def equilibrium_speed(governor: HartungGovernor, *, lever_angle: FloatOrArray, spring_force: FloatOrArray) -> FloatOrArray:
    """Spindle speed (rad/s) at which a spring force P (N) holds a weight: astatic_spring_force solved for w.

    Raises MechanismError where no speed does, the weights being drawn outward by their own weight.
    """
    alpha, force = _validate_lever_angle(lever_angle), validate_argument(spring_force, "spring_force", "N")
    standstill_force = np.asarray(astatic_spring_force(governor, lever_angle=alpha, spindle_speed=0.0))
    squared_speed = (force - standstill_force) / (governor.weight_mass * np.asarray(weight_radius(governor, lever_angle=alpha)))
    message = "no spindle speed holds the weights there: the spring is too weak"
    raise_where(squared_speed < 0, message, ("spring_force", force, "N"), ("lever_angle", np.degrees(alpha), "deg"))
    return as_scalar_or_array(np.sqrt(squared_speed))


def static_sleeve_force(governor: HartungGovernor, *, lever_angle: FloatOrArray, spring_force: FloatOrArray) -> FloatOrArray:
    """Force S (N) with which springs and weights hold down the sleeve of a governor that stands still.

    S = 2 (P + G tan alpha) (a / b) cos alpha / sin(g + alpha) + Q; the lever must stand off its dead centre. Source:
    Dubois p. 620.
    """
    alpha, force = _validate_lever_angle(lever_angle), validate_argument(spring_force, "spring_force", "N")
    lever_ratio = _lever_ratio(governor, alpha)
    weight_force = governor.weight_mass * governor.gravity * np.tan(alpha)
    return as_scalar_or_array(2 * (force + weight_force) * lever_ratio + governor.sleeve_mass * governor.gravity)


def static_sleeve_force_at_speed(governor: HartungGovernor, *, lever_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """The same S (N) by the centrifugal force C that it balances: 2 C (a / b) cos alpha / sin(g + alpha).

    Equal to static_sleeve_force of the spring force that holds the weights at spindle_speed (rad/s).
    """
    alpha, speed = _validate_lever_angle(lever_angle), validate_argument(spindle_speed, "spindle_speed", "rad/s")
    return as_scalar_or_array(2 * _centrifugal_force(governor, alpha, speed) * _lever_ratio(governor, alpha))


def lever_inertia(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Inertia I = 2 M a^2 + m z'^2 (kg m2) along the lever angle: the kinetic energy in the plane is I alpha'^2 / 2."""
    height_derivative = _lug_height_derivatives(governor, _validate_lever_angle(lever_angle))[1]
    return as_scalar_or_array(2 * governor.weight_mass * governor.weight_arm**2 + governor.sleeve_mass * height_derivative**2)


def stiffness(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    spring_force: FloatOrArray,
    spring_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
) -> FloatOrArray:
    """Stiffness (N m/rad) of rest at a kept speed, positive where the governor is stable.

    2 [(k - M w^2) a^2 cos^2 + (P - M w^2 x) a sin - M g a cos] + m g z", sin and cos of the lever angle; spring_force
    P (N) and spring_rate k (N/m) are those of one weight. With a vertical hanger m g z" is -m g b cos(g + alpha).
    """
    alpha, force = _validate_lever_angle(lever_angle), validate_argument(spring_force, "spring_force", "N")
    rate, speed = (validate_argument(spring_rate, "spring_rate", "N/m"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    a, mass = governor.weight_arm, governor.weight_mass
    sine, cosine = np.sin(alpha), np.cos(alpha)
    per_weight = (rate - mass * speed**2) * (a * cosine) ** 2
    per_weight += (force - _centrifugal_force(governor, alpha, speed)) * a * sine - mass * governor.gravity * a * cosine
    return as_scalar_or_array(2 * per_weight + governor.sleeve_mass * governor.gravity * _lug_height_derivatives(governor, alpha)[2])


def squared_natural_frequency(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    spring_force: FloatOrArray,
    spring_rate: FloatOrArray,
    constant_inertia: FloatOrArray | None = None,
) -> FloatOrArray:
    """Squared frequency (1/s2) of small swings about rest, at a kept speed or with the spindle left to itself.

    V" / I at a kept speed; with rest_inertia J0 (kg m2, of the spindle alone) w^2 J'^2 / ((J0 + J) I) more, where
    J = 2 M x^2 and J' = -4 M x a cos alpha. The speed is that of rest. Negative where the governor is not stable.
    """
    alpha = _validate_lever_angle(lever_angle)
    speed = np.asarray(equilibrium_speed(governor, lever_angle=alpha, spring_force=spring_force))
    own_inertia = np.asarray(lever_inertia(governor, lever_angle=alpha))
    lever_stiffness = stiffness(governor, lever_angle=alpha, spring_force=spring_force, spring_rate=spring_rate, spindle_speed=speed)
    if constant_inertia is None:
        return as_scalar_or_array(np.asarray(lever_stiffness) / own_inertia)
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    total_spindle_inertia = validate_argument(constant_inertia, "rest_inertia", "kg m2", minimum=0.0) + 2 * governor.weight_mass * x**2
    inertia_derivative = -4 * governor.weight_mass * x * governor.weight_arm * np.cos(alpha)
    return as_scalar_or_array((np.asarray(lever_stiffness) + (speed * inertia_derivative) ** 2 / total_spindle_inertia) / own_inertia)


def lever_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    lever_rate: FloatOrArray,
    spring_force: FloatOrArray,
    spindle_speed: FloatOrArray,
    damping: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Acceleration (rad/s2) of the lever at a kept speed (rad/s), of Lagrange's equation along the lever angle.

    I alpha" + m z' z" alpha'^2 - 2 P a cos - 2 M g a sin + m g z' + 2 M w^2 x a cos = -brake z'^2 alpha'; brake is that
    of a linear dashpot on the sleeve (N s/m).
    """
    alpha, rate = _validate_lever_angle(lever_angle), validate_argument(lever_rate, "lever_rate", "rad/s")
    force, speed = (validate_argument(spring_force, "spring_force", "N"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    a, mass, sleeve = governor.weight_arm, governor.weight_mass, governor.sleeve_mass
    _, height_derivative, height_second_derivative = _lug_height_derivatives(governor, alpha)
    generalised_force = 2 * (force - _centrifugal_force(governor, alpha, speed)) * a * np.cos(alpha)
    generalised_force += 2 * mass * governor.gravity * a * np.sin(alpha) - sleeve * governor.gravity * height_derivative
    generalised_force -= (
        sleeve * height_derivative * height_second_derivative * rate**2
        + validate_argument(damping, "brake", "N s/m", minimum=0.0) * height_derivative**2 * rate
    )
    return as_scalar_or_array(generalised_force / (2 * mass * a**2 + sleeve * height_derivative**2))


def spindle_inertia(governor: HartungGovernor, *, lever_angle: FloatOrArray) -> FloatOrArray:
    """Moment of inertia J = 2 M x^2 (kg m2) of the weights about the spindle."""
    x = np.asarray(weight_radius(governor, lever_angle=lever_angle))
    return as_scalar_or_array(2 * governor.weight_mass * x**2)


def spindle_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: FloatOrArray,
    lever_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Acceleration (rad/s2) of a spindle left to itself: (torque - J' w alpha') / (J0 + J), J' = -4 M x a cos alpha.

    rest_inertia J0 (kg m2) is that of the spindle alone, torque (N m) what drives it.
    """
    alpha, rate = _validate_lever_angle(lever_angle), validate_argument(lever_rate, "lever_rate", "rad/s")
    speed, drive_torque = (validate_argument(spindle_speed, "spindle_speed", "rad/s"), validate_argument(torque, "torque", "N m"))
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    inertia_derivative = -4 * governor.weight_mass * x * governor.weight_arm * np.cos(alpha)
    total_inertia = validate_argument(constant_inertia, "rest_inertia", "kg m2", minimum=0.0) + 2 * governor.weight_mass * x**2
    return as_scalar_or_array((drive_torque - inertia_derivative * speed * rate) / total_inertia)


def relative_spread(forces: FloatArray) -> float:
    """Largest less smallest of some forces (n,), over their mean: how far a sleeve force is from constant."""
    values = validate_argument(forces, "forces", "N")
    raise_where(np.asarray(values.size < 2), "a spread needs two forces or more", ("count", values.size, ""))
    mean = float(np.mean(values))
    raise_where(np.asarray(mean == 0.0), "a spread needs forces whose mean is not zero", ("mean", mean, "N"))
    return float((np.max(values) - np.min(values)) / abs(mean))


def _validate_lever_angle(lever_angle: FloatOrArray) -> FloatArray:
    """The angle, refused where the weights' arm lies down: there the spring has no grip."""
    alpha = validate_argument(lever_angle, "lever_angle", "rad")
    degrees = ("lever_angle", np.degrees(alpha), "deg")
    raise_where(np.abs(alpha) >= math.pi / 2, "lever_angle must lie within 90 deg of upright", degrees)
    return alpha


def _centrifugal_force(governor: HartungGovernor, alpha: FloatArray, speed: FloatArray) -> FloatArray:
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    force: FloatArray = governor.weight_mass * speed**2 * x
    return force


def _lever_ratio(governor: HartungGovernor, alpha: FloatArray) -> FloatArray:
    """a cos alpha / -z': how far the weights move out for the sleeve's rise."""
    height_derivative = _lug_height_derivatives(governor, alpha)[1]
    message = "the lever stands at or beyond its dead centre: outward does not lift the sleeve there"
    raise_where(height_derivative >= 0, message, ("lever_angle", np.degrees(alpha), "deg"))
    lever_ratio: FloatArray = governor.weight_arm * np.cos(alpha) / -height_derivative
    return lever_ratio


def _lug_height_derivatives(governor: HartungGovernor, alpha: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Height z of the lugs above the fulcrum (m), and its two derivatives by alpha."""
    b, phi = governor.sleeve_arm, governor.angle + alpha
    height, height_derivative, height_second_derivative = b * np.cos(phi), -b * np.sin(phi), -b * np.cos(phi)
    if governor.hanger == math.inf:
        return height, height_derivative, height_second_derivative
    hanger_offset, offset_derivative, offset_second_derivative = (
        governor.fulcrum_radius - b * np.sin(phi) - governor.lug_radius,
        -b * np.cos(phi),
        b * np.sin(phi),
    )
    shown = (("lever_angle", np.degrees(alpha), "deg"), ("reach", np.abs(hanger_offset), "m"))
    message = "the hanger is too short: its upper end stands farther from the lug than it is long"
    raise_where(np.abs(hanger_offset) >= governor.hanger, message, *shown)
    hanger_drop = np.sqrt(governor.hanger**2 - hanger_offset**2)
    hanger_tangent = hanger_offset / hanger_drop
    return (
        height - hanger_drop,
        height_derivative + hanger_tangent * offset_derivative,
        height_second_derivative
        + (offset_derivative**2 + hanger_offset * offset_second_derivative + (hanger_tangent * offset_derivative) ** 2) / hanger_drop,
    )

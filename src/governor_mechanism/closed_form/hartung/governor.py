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

from governor_mechanism.closed_form.arguments import Number, as_given, checked, refuse_where
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
            checked(getattr(self, name), name, unit, above=0.0)
        for name in ("weight_mass", "sleeve_mass"):
            checked(getattr(self, name), name, "kg", above=0.0)
        checked(self.gravity, "gravity", "m/s2", least=0.0)
        checked(self.lug_radius, "lug_radius", "m")
        angle = checked(self.angle, "angle", "rad", above=0.0)
        refuse_where(angle >= math.pi, "angle must lie below 180 deg", ("angle", np.degrees(angle), "deg"))
        if self.hanger != math.inf:
            checked(self.hanger, "hanger", "m", above=0.0)


def weight_radius(governor: HartungGovernor, *, lever_angle: Number) -> Number:
    """Distance x = x_H - a sin alpha (m) of a weight's centre from the axis."""
    return as_given(governor.fulcrum_radius - governor.weight_arm * np.sin(_upright(lever_angle)))


def sleeve_height(governor: HartungGovernor, *, lever_angle: Number) -> Number:
    """Height (m) of the sleeve's lugs above the fulcrum: b cos(angle + alpha), less the drop of a hanger."""
    way = _way(governor, _upright(lever_angle))
    return as_given(way[0])


def lift_slope(governor: HartungGovernor, *, lever_angle: Number) -> Number:
    """How the sleeve's height follows the lever angle (m/rad): -b (sin(g + alpha) + cos(g + alpha) tan psi).

    g is the angle of the bell crank, psi that of the hanger from the vertical. Negative where outward lifts.
    """
    return as_given(_way(governor, _upright(lever_angle))[1])


def astatic_spring_force(governor: HartungGovernor, *, lever_angle: Number, spindle_speed: Number) -> Number:
    """Spring force P (N) that holds a weight at a lever angle (rad) and a spindle speed (rad/s).

    P = M w^2 x - (Q / 2) (b / a) sin(g + alpha) / cos alpha - G tan alpha, G and Q the weights of one weight and of the
    sleeve; with a hanger that is not vertical -z' takes the place of b sin(g + alpha). Source: Dubois p. 618.
    """
    alpha, speed = _upright(lever_angle), checked(spindle_speed, "spindle_speed", "rad/s")
    a, load = governor.weight_arm, governor.weight_mass * governor.gravity
    pull = 0.5 * governor.sleeve_mass * governor.gravity * _way(governor, alpha)[1] / (a * np.cos(alpha))
    return as_given(_centrifugal(governor, alpha, speed) + pull - load * np.tan(alpha))


def equilibrium_speed(governor: HartungGovernor, *, lever_angle: Number, spring_force: Number) -> Number:
    """Spindle speed (rad/s) at which a spring force P (N) holds a weight: astatic_spring_force solved for w.

    Raises MechanismError where no speed does, the weights being drawn outward by their own weight.
    """
    alpha, force = _upright(lever_angle), checked(spring_force, "spring_force", "N")
    at_rest = np.asarray(astatic_spring_force(governor, lever_angle=alpha, spindle_speed=0.0))
    square = (force - at_rest) / (governor.weight_mass * np.asarray(weight_radius(governor, lever_angle=alpha)))
    sentence = "no spindle speed holds the weights there: the spring is too weak"
    refuse_where(square < 0, sentence, ("spring_force", force, "N"), ("lever_angle", np.degrees(alpha), "deg"))
    return as_given(np.sqrt(square))


def static_sleeve_force(governor: HartungGovernor, *, lever_angle: Number, spring_force: Number) -> Number:
    """Force S (N) with which springs and weights hold down the sleeve of a governor that stands still.

    S = 2 (P + G tan alpha) (a / b) cos alpha / sin(g + alpha) + Q; the lever must stand off its dead centre. Source:
    Dubois p. 620.
    """
    alpha, force = _upright(lever_angle), checked(spring_force, "spring_force", "N")
    lever = _lever(governor, alpha)
    weight = governor.weight_mass * governor.gravity * np.tan(alpha)
    return as_given(2 * (force + weight) * lever + governor.sleeve_mass * governor.gravity)


def simple_static_force(governor: HartungGovernor, *, lever_angle: Number, spindle_speed: Number) -> Number:
    """The same S (N) by the centrifugal force C that it balances: 2 C (a / b) cos alpha / sin(g + alpha).

    Equal to static_sleeve_force of the spring force that holds the weights at spindle_speed (rad/s).
    """
    alpha, speed = _upright(lever_angle), checked(spindle_speed, "spindle_speed", "rad/s")
    return as_given(2 * _centrifugal(governor, alpha, speed) * _lever(governor, alpha))


def inertia(governor: HartungGovernor, *, lever_angle: Number) -> Number:
    """Inertia I = 2 M a^2 + m z'^2 (kg m2) along the lever angle: the kinetic energy in the plane is I alpha'^2 / 2."""
    rise = _way(governor, _upright(lever_angle))[1]
    return as_given(2 * governor.weight_mass * governor.weight_arm**2 + governor.sleeve_mass * rise**2)


def stiffness(
    governor: HartungGovernor, *, lever_angle: Number, spring_force: Number, spring_rate: Number, spindle_speed: Number
) -> Number:
    """Stiffness (N m/rad) of rest at a kept speed, positive where the governor is stable.

    2 [(k - M w^2) a^2 cos^2 + (P - M w^2 x) a sin - M g a cos] + m g z", sin and cos of the lever angle; spring_force
    P (N) and spring_rate k (N/m) are those of one weight. With a vertical hanger m g z" is -m g b cos(g + alpha).
    """
    alpha, force = _upright(lever_angle), checked(spring_force, "spring_force", "N")
    rate, speed = checked(spring_rate, "spring_rate", "N/m"), checked(spindle_speed, "spindle_speed", "rad/s")
    a, mass = governor.weight_arm, governor.weight_mass
    sine, cosine = np.sin(alpha), np.cos(alpha)
    per_weight = (rate - mass * speed**2) * (a * cosine) ** 2
    per_weight += (force - _centrifugal(governor, alpha, speed)) * a * sine - mass * governor.gravity * a * cosine
    return as_given(2 * per_weight + governor.sleeve_mass * governor.gravity * _way(governor, alpha)[2])


def squared_frequency(
    governor: HartungGovernor,
    *,
    lever_angle: Number,
    spring_force: Number,
    spring_rate: Number,
    rest_inertia: Number | None = None,
) -> Number:
    """Squared frequency (1/s2) of small swings about rest, at a kept speed or with the spindle left to itself.

    V" / I at a kept speed; with rest_inertia J0 (kg m2, of the spindle alone) w^2 J'^2 / ((J0 + J) I) more, where
    J = 2 M x^2 and J' = -4 M x a cos alpha. The speed is that of rest. Negative where the governor is not stable.
    """
    alpha = _upright(lever_angle)
    speed = np.asarray(equilibrium_speed(governor, lever_angle=alpha, spring_force=spring_force))
    own = np.asarray(inertia(governor, lever_angle=alpha))
    stiff = stiffness(
        governor, lever_angle=alpha, spring_force=spring_force, spring_rate=spring_rate, spindle_speed=speed
    )
    if rest_inertia is None:
        return as_given(np.asarray(stiff) / own)
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    about = checked(rest_inertia, "rest_inertia", "kg m2", least=0.0) + 2 * governor.weight_mass * x**2
    slope = -4 * governor.weight_mass * x * governor.weight_arm * np.cos(alpha)
    return as_given((np.asarray(stiff) + (speed * slope) ** 2 / about) / own)


def angular_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: Number,
    lever_rate: Number,
    spring_force: Number,
    spindle_speed: Number,
    brake: Number = 0.0,
) -> Number:
    """Acceleration (rad/s2) of the lever at a kept speed (rad/s), of Lagrange's equation along the lever angle.

    I alpha" + m z' z" alpha'^2 - 2 P a cos - 2 M g a sin + m g z' + 2 M w^2 x a cos = -brake z'^2 alpha'; brake is that
    of a linear oil brake on the sleeve (N s/m).
    """
    alpha, rate = _upright(lever_angle), checked(lever_rate, "lever_rate", "rad/s")
    force, speed = checked(spring_force, "spring_force", "N"), checked(spindle_speed, "spindle_speed", "rad/s")
    a, mass, sleeve = governor.weight_arm, governor.weight_mass, governor.sleeve_mass
    _, rise, bend = _way(governor, alpha)
    turning = 2 * (force - _centrifugal(governor, alpha, speed)) * a * np.cos(alpha)
    turning += 2 * mass * governor.gravity * a * np.sin(alpha) - sleeve * governor.gravity * rise
    turning -= sleeve * rise * bend * rate**2 + checked(brake, "brake", "N s/m", least=0.0) * rise**2 * rate
    return as_given(turning / (2 * mass * a**2 + sleeve * rise**2))


def spindle_inertia(governor: HartungGovernor, *, lever_angle: Number) -> Number:
    """Moment of inertia J = 2 M x^2 (kg m2) of the weights about the spindle."""
    x = np.asarray(weight_radius(governor, lever_angle=lever_angle))
    return as_given(2 * governor.weight_mass * x**2)


def spindle_acceleration(
    governor: HartungGovernor,
    *,
    lever_angle: Number,
    lever_rate: Number,
    spindle_speed: Number,
    rest_inertia: Number,
    torque: Number = 0.0,
) -> Number:
    """Acceleration (rad/s2) of a spindle left to itself: (torque - J' w alpha') / (J0 + J), J' = -4 M x a cos alpha.

    rest_inertia J0 (kg m2) is that of the spindle alone, torque (N m) what drives it.
    """
    alpha, rate = _upright(lever_angle), checked(lever_rate, "lever_rate", "rad/s")
    speed, drive = checked(spindle_speed, "spindle_speed", "rad/s"), checked(torque, "torque", "N m")
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    slope = -4 * governor.weight_mass * x * governor.weight_arm * np.cos(alpha)
    whole = checked(rest_inertia, "rest_inertia", "kg m2", least=0.0) + 2 * governor.weight_mass * x**2
    return as_given((drive - slope * speed * rate) / whole)


def spread(forces: FloatArray) -> float:
    """Largest less smallest of some forces (n,), over their mean: how far a sleeve force is from constant."""
    values = checked(forces, "forces", "N")
    refuse_where(np.asarray(values.size < 2), "a spread needs two forces or more", ("count", values.size, ""))
    mean = float(np.mean(values))
    refuse_where(np.asarray(mean == 0.0), "a spread needs forces whose mean is not zero", ("mean", mean, "N"))
    return float((np.max(values) - np.min(values)) / abs(mean))


def _upright(lever_angle: Number) -> FloatArray:
    """The angle, refused where the weights' arm lies down: there the spring has no grip."""
    alpha = checked(lever_angle, "lever_angle", "rad")
    degrees = ("lever_angle", np.degrees(alpha), "deg")
    refuse_where(np.abs(alpha) >= math.pi / 2, "lever_angle must lie within 90 deg of upright", degrees)
    return alpha


def _centrifugal(governor: HartungGovernor, alpha: FloatArray, speed: FloatArray) -> FloatArray:
    x = np.asarray(weight_radius(governor, lever_angle=alpha))
    force: FloatArray = governor.weight_mass * speed**2 * x
    return force


def _lever(governor: HartungGovernor, alpha: FloatArray) -> FloatArray:
    """a cos alpha / -z': how far the weights move out for the sleeve's rise."""
    rise = _way(governor, alpha)[1]
    sentence = "the lever stands at or beyond its dead centre: outward does not lift the sleeve there"
    refuse_where(rise >= 0, sentence, ("lever_angle", np.degrees(alpha), "deg"))
    lever: FloatArray = governor.weight_arm * np.cos(alpha) / -rise
    return lever


def _way(governor: HartungGovernor, alpha: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Height z of the lugs above the fulcrum (m), and its two derivatives by alpha."""
    b, phi = governor.sleeve_arm, governor.angle + alpha
    height, rise, bend = b * np.cos(phi), -b * np.sin(phi), -b * np.cos(phi)
    if governor.hanger == math.inf:
        return height, rise, bend
    reach, turn, back = (
        governor.fulcrum_radius - b * np.sin(phi) - governor.lug_radius,
        -b * np.cos(phi),
        b * np.sin(phi),
    )
    shown = (("lever_angle", np.degrees(alpha), "deg"), ("reach", np.abs(reach), "m"))
    sentence = "the hanger is too short: its upper end stands farther from the lug than it is long"
    refuse_where(np.abs(reach) >= governor.hanger, sentence, *shown)
    drop = np.sqrt(governor.hanger**2 - reach**2)
    slope = reach / drop
    return height - drop, rise + slope * turn, bend + (turn**2 + reach * back + (slope * turn) ** 2) / drop

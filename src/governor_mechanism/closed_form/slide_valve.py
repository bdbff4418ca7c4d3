"""The slide valve driven by an eccentric: displacement, error term, Marks' curves and the events of steam.

The crank angle w counts from the dead centre in which the piston stands nearest to the shaft, in the direction of
rotation; the valve's distance s and its displacement are positive away from the shaft. All in SI and radians.

Every function takes the eccentric first and the rest by keyword, floats or arrays that broadcast; floats give a float.
Every function raises MechanismError, naming the value, for numbers that are not finite and for thresholds that the
valve never reaches. An infinitely long rod is math.inf.

Sources: W. D. Marks' construction after Müller-Melchiors, Dinglers Polyt. J. 241 (1881), p. 161 (s, z', z, d, parabola
and circle); the law of cosines and what is called exact follow from the same triangle without his reductions.
Limits: rigid parts without play, valve rod guided in line with the shaft.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class Eccentric:
    """Radius r (m), rod l (m, longer than r; math.inf) and angle of advance d (rad, between -90 and 90 deg)."""

    radius: float
    rod: float
    advance: float

    def __post_init__(self) -> None:
        validate_argument(self.radius, "radius", "m", greater_than=0.0)
        if not self.rod > self.radius:  # refuses nan too
            raise MechanismError(f"rod must be longer than the radius ({self.radius:.12g} m); got {self.rod:.12g} m")
        validate_argument(self.advance, "advance", "rad")
        if not abs(self.advance) < math.pi / 2:
            raise MechanismError(f"advance must lie between -90 and 90 deg; got {math.degrees(self.advance):.12g} deg")

    @classmethod
    def from_dimensions(cls, dimensions: Mapping[str, float]) -> Eccentric:
        """From a machine's sizes by name: eccentric, eccentric_rod (m) and advance (rad)."""
        return cls(radius=dimensions["eccentric"], rod=dimensions["eccentric_rod"], advance=dimensions["advance"])

    @property
    def has_infinite_rod(self) -> bool:
        """Whether the rod is infinitely long."""
        return math.isinf(self.rod)


def _eccentric_angle(eccentric: Eccentric, crank_angle: FloatOrArray) -> FloatArray:
    """theta = w + d."""
    return validate_argument(crank_angle, "crank_angle", "rad") + eccentric.advance


def _finite_lengths(eccentric: Eccentric) -> tuple[float, float]:
    """Radius and rod, of a rod that has a length."""
    if eccentric.has_infinite_rod:
        raise MechanismError("this needs a rod of finite length; with an infinitely long one there is no error term")
    return eccentric.radius, eccentric.rod


def valve_distance(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Distance of the valve from the shaft (m): s = r sin(w + d) + sqrt(l^2 - r^2 cos^2(w + d)). Source: Zeuner."""
    r, rod = _finite_lengths(eccentric)
    theta = _eccentric_angle(eccentric, crank_angle)
    return as_scalar_or_array(r * np.sin(theta) + np.sqrt(rod**2 - (r * np.cos(theta)) ** 2))


def binomial_valve_distance(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """The same (m) by Zeuner's reduction: s = r sin(w + d) + l - (r^2 / 2 l) cos^2(w + d)."""
    r, rod = _finite_lengths(eccentric)
    theta = _eccentric_angle(eccentric, crank_angle)
    return as_scalar_or_array(r * np.sin(theta) + rod - (r * np.cos(theta)) ** 2 / (2 * rod))


def valve_velocity(eccentric: Eccentric, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Speed of the valve (m/s) at a steady crank_rate W (rad/s): W (r cos t + r^2 sin t cos t / q), t = w + d.

    q = sqrt(l^2 - r^2 cos^2 t).
    """
    theta, rate = _eccentric_angle(eccentric, crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    r, q = eccentric.radius, _rod_extent(eccentric, theta)
    return as_scalar_or_array(rate * (r * np.cos(theta) + r**2 * np.sin(theta) * np.cos(theta) / q))


def valve_acceleration(eccentric: Eccentric, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Acceleration of the valve (m/s2) at a steady crank_rate W (rad/s), q as of velocity:

    W^2 (-r sin t + r^2 cos 2t / q - r^4 sin^2 t cos^2 t / q^3).
    """
    theta, rate = _eccentric_angle(eccentric, crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    r, q = eccentric.radius, _rod_extent(eccentric, theta)
    rod_term = r**2 * np.cos(2 * theta) / q - (r**2 * np.sin(theta) * np.cos(theta)) ** 2 / q**3
    return as_scalar_or_array(rate**2 * (rod_term - r * np.sin(theta)))


def _rod_extent(eccentric: Eccentric, theta: FloatArray) -> FloatArray:
    """q: the rod's extent along the valve's line (m), infinite for an endless rod."""
    if eccentric.has_infinite_rod:
        return np.full_like(theta, math.inf)
    return np.asarray(np.sqrt(eccentric.rod**2 - (eccentric.radius * np.cos(theta)) ** 2))


def equal_lead_centre(eccentric: Eccentric) -> float:
    """Centre of the swing (m from the shaft) that makes both leads equal: d = sqrt(l^2 - r^2 cos^2 d).

    It is half the sum of the distances in the two dead centres. The middle between the extremes lies at l.
    """
    r, rod = _finite_lengths(eccentric)
    return math.sqrt(rod**2 - (r * math.cos(eccentric.advance)) ** 2)


def binomial_centre(eccentric: Eccentric) -> float:
    """The same centre (m) by Zeuner's reduction: d = l - (r^2 / 2 l) cos^2 d."""
    r, rod = _finite_lengths(eccentric)
    return rod - (r * math.cos(eccentric.advance)) ** 2 / (2 * rod)


def first_order_displacement(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Displacement (m) by Zeuner's law, x0 = r sin(w + d): that of an infinitely long rod."""
    return as_scalar_or_array(eccentric.radius * np.sin(_eccentric_angle(eccentric, crank_angle)))


def valve_displacement(eccentric: Eccentric, *, crank_angle: FloatOrArray, centre: float | None = None) -> FloatOrArray:
    """Displacement x = s - centre (m) from a centre of the swing (m from the shaft); equal_lead_centre if left out.

    For an endless rod s is r sin(w + d), counted from wherever the rod ends, and the centre is 0 if left out.
    """
    if eccentric.has_infinite_rod:
        return as_scalar_or_array(np.asarray(first_order_displacement(eccentric, crank_angle=crank_angle)) - (centre or 0.0))
    middle = equal_lead_centre(eccentric) if centre is None else centre
    return as_scalar_or_array(np.asarray(valve_distance(eccentric, crank_angle=crank_angle)) - middle)


def error_term(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Zeuner's error term with equal leads (m): z = (r^2 / 2 l) (cos^2 d - cos^2(w + d)).

    Zero at w = 0, 180, 180 - 2 d and 360 - 2 d deg; largest at 90 - d and 270 - d, least at 180 - d and 360 - d deg.
    """
    r, rod = _finite_lengths(eccentric)
    theta = _eccentric_angle(eccentric, crank_angle)
    return as_scalar_or_array(r**2 / (2 * rod) * (math.cos(eccentric.advance) ** 2 - np.cos(theta) ** 2))


def middle_error_term(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """The error term counted from the middle between the extremes (m): z' = (r^2 / 2 l) cos^2(w + d), to be taken off.

    The square is missing in the print of 1881; the formula it is taken from has it.
    """
    r, rod = _finite_lengths(eccentric)
    return as_scalar_or_array(r**2 / (2 * rod) * np.cos(_eccentric_angle(eccentric, crank_angle)) ** 2)


def exact_error_term(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """True displacement with equal leads less r sin(w + d) (m): what error_term stands for."""
    theta = _eccentric_angle(eccentric, crank_angle)
    return hyperbola_error(eccentric, theoretical=eccentric.radius * np.sin(theta))


def neglected_error_term(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """What exact_error has beyond error_term, to leading order (m): -(r^4 / 8 l^3)(cos^4(w + d) - cos^4 d).

    Right to about (r / l)^2 / 2 of r^4 / 8 l^3.
    """
    r, rod = _finite_lengths(eccentric)
    theta = _eccentric_angle(eccentric, crank_angle)
    return as_scalar_or_array(-(r**4) / (8 * rod**3) * (np.cos(theta) ** 4 - math.cos(eccentric.advance) ** 4))


def parabola_constant(eccentric: Eccentric) -> float:
    """C = r^2 (1 - cos^2 d) (m2) of Marks' parabola x0^2 = 2 l z + C; its vertex lies at z = -C / 2 l."""
    return (eccentric.radius * math.sin(eccentric.advance)) ** 2


def parabola_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """Marks' parabola: the error term z (m) over the theoretical displacement x0 = r sin(w + d) (m)."""
    _, rod = _finite_lengths(eccentric)
    return as_scalar_or_array((_validate_theoretical(eccentric, theoretical) ** 2 - parabola_constant(eccentric)) / (2 * rod))


def circle_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """Marks' circle of radius l through the two dead centres, in place of the parabola: z (m) over x0 (m).

    z = sqrt(l^2 - r^2 sin^2 d) - sqrt(l^2 - x0^2).
    """
    _, rod = _finite_lengths(eccentric)
    x0 = _validate_theoretical(eccentric, theoretical)
    return as_scalar_or_array(math.sqrt(rod**2 - parabola_constant(eccentric)) - np.sqrt(rod**2 - x0**2))


def hyperbola_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """The curve that Marks' two stand for: z (m) over x0 (m) on the hyperbola (z + d)^2 - x0^2 = l^2 - r^2, exactly."""
    r, rod = _finite_lengths(eccentric)
    x0 = _validate_theoretical(eccentric, theoretical)
    return as_scalar_or_array(np.sqrt(rod**2 - r**2 + x0**2) - equal_lead_centre(eccentric))


def _validate_theoretical(eccentric: Eccentric, value: FloatOrArray) -> FloatArray:
    x0 = validate_argument(value, "theoretical", "m")
    exceeds_radius = np.abs(x0) > eccentric.radius * (1 + 1e-12)
    raise_where(exceeds_radius, "the theoretical displacement cannot exceed the radius", ("theoretical", x0, "m"))
    return x0


def crank_angles_at(eccentric: Eccentric, *, threshold: FloatOrArray, centre: float | None = None) -> tuple[FloatOrArray, FloatOrArray]:
    """Crank angles (rad, 0 to 2 pi) at which the displacement passes a threshold t (m): rising, then falling.

    By the law of cosines, with the centre c of the swing as of displacement:
    sin(w + d) = ((c + t)^2 + r^2 - l^2) / (2 r (c + t)). For an endless rod (c + t) / r.
    """
    t, r, rod = validate_argument(threshold, "threshold", "m"), eccentric.radius, eccentric.rod
    if eccentric.has_infinite_rod:
        return _rising_and_falling_angles(eccentric, (t + (centre or 0.0)) / r, t)
    s = t + (equal_lead_centre(eccentric) if centre is None else centre)
    return _rising_and_falling_angles(eccentric, (s**2 + (r - rod) * (r + rod)) / (2 * r * s), t)


def theoretical_crank_angles_at(eccentric: Eccentric, *, threshold: FloatOrArray) -> tuple[FloatOrArray, FloatOrArray]:
    """The same by Zeuner's law without an error term: r sin(w + d) = t."""
    t = validate_argument(threshold, "threshold", "m")
    return _rising_and_falling_angles(eccentric, t / eccentric.radius, t)


def binomial_crank_angles_at(eccentric: Eccentric, *, threshold: FloatOrArray) -> tuple[FloatOrArray, FloatOrArray]:
    """The same by the error term z: r sin(w + d) = -l + sqrt(l^2 + 2 l t + r^2 sin^2 d), equal leads."""
    _, rod = _finite_lengths(eccentric)
    t = validate_argument(threshold, "threshold", "m")
    return _rising_and_falling_angles(eccentric, (np.sqrt(rod**2 + 2 * rod * t + parabola_constant(eccentric)) - rod) / eccentric.radius, t)


def _rising_and_falling_angles(eccentric: Eccentric, sine: FloatArray, threshold: FloatArray) -> tuple[FloatOrArray, FloatOrArray]:
    is_unreachable = np.abs(sine) > 1
    raise_where(is_unreachable, "the valve never stands there: lower the lap", ("threshold", threshold, "m"))
    theta = np.arcsin(np.where(is_unreachable, 0.0, sine))
    rising, falling = (np.mod(angle - eccentric.advance, math.tau) for angle in (theta, math.pi - theta))
    return as_scalar_or_array(rising), as_scalar_or_array(falling)


VALVE_EVENTS = {
    "crank end admission": (1, "outside", True),
    "crank end cut-off": (1, "outside", False),
    "crank end release": (-1, "inside", False),
    "crank end compression": (-1, "inside", True),
    "head end admission": (-1, "outside", False),
    "head end cut-off": (-1, "outside", True),
    "head end release": (1, "inside", True),
    "head end compression": (1, "inside", False),
}
"""By event: the side of its threshold, the lap that is its size, and whether the displacement rises through it."""


def event_threshold(event: str, *, outside_lap: float, inside_lap: float) -> float:
    """The displacement (m) at which an event of EVENTS happens; steam is admitted by the outer edges."""
    side, lap, _ = VALVE_EVENTS[event]
    return side * (outside_lap if lap == "outside" else inside_lap)


def event_angle(
    eccentric: Eccentric, *, event: str, outside_lap: float, inside_lap: float, law: str = "exact", centre: float | None = None
) -> float:
    """Crank angle (rad, 0 to 2 pi) of an event of EVENTS by a law: "exact", "theory" or "binomial".

    outside_lap, inside_lap (m); centre (m) as of displacement, for the exact law alone.
    """
    t = event_threshold(event, outside_lap=outside_lap, inside_lap=inside_lap)
    if law == "exact":
        angles = crank_angles_at(eccentric, threshold=t, centre=centre)
    else:
        laws = {"theory": theoretical_crank_angles_at, "binomial": binomial_crank_angles_at}
        angles = laws[law](eccentric, threshold=t)
    return float(angles[0] if VALVE_EVENTS[event][2] else angles[1])


def leads(eccentric: Eccentric, *, outside_lap: float, centre: float | None = None) -> tuple[float, float]:
    """How far the steam port is open in its own dead centre (m): at the crank end, at the head end."""
    crank_end, head_end = (float(valve_displacement(eccentric, crank_angle=w, centre=centre)) for w in (0.0, math.pi))
    return crank_end - outside_lap, -head_end - outside_lap

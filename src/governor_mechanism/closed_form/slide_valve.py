"""The slide valve driven by an eccentric: displacement, error term, Marks' curves and the valve events.

The crank angle w is zero at the dead centre at which the piston is nearest to the shaft, and grows in the direction of rotation. The
distance s of the valve and its displacement are positive away from the shaft. SI and radians. A rod may be infinitely long (math.inf).

The eccentric is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite and for a threshold that the valve does not reach. Parts are rigid, without clearance; the
valve rod is guided in line with the shaft.

References
----------
W. D. Marks' construction after Müller-Melchiors, Dinglers Polytechnisches Journal 241 (1881), p. 161 (s, z, d, parabola and circle). The
law of cosines and the exact forms follow from the same triangle without his approximations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


@dataclass(frozen=True, kw_only=True)
class Eccentric:
    """An eccentric and its rod.

    MechanismError is raised unless the rod is longer than the radius and the advance is between -90 and 90 deg.

    Attributes
    ----------
    radius
        Radius r, m.
    rod
        Length l of the rod, m; may be infinite.
    advance
        Angle of advance d, rad.
    """

    radius: float
    rod: float
    advance: float

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_argument(self.radius, "radius", "m", greater_than=0.0)
        if not self.rod > self.radius:  # refuses nan too
            raise MechanismError(f"rod must be longer than the radius ({self.radius:.12g} m); got {self.rod:.12g} m")
        validate_argument(self.advance, "advance", "rad")
        if not abs(self.advance) < math.pi / 2:
            raise MechanismError(f"advance must lie between -90 and 90 deg; got {math.degrees(self.advance):.12g} deg")

    @classmethod
    def from_dimensions(cls, dimensions: Mapping[str, float]) -> Eccentric:
        """Return the eccentric of a machine's dimensions: eccentric, eccentric_rod (m) and advance (rad).

        Parameters
        ----------
        dimensions
            Dimensions by name, SI.

        Returns
        -------
        Eccentric
            The eccentric.
        """
        return cls(radius=dimensions["eccentric"], rod=dimensions["eccentric_rod"], advance=dimensions["advance"])

    @property
    def has_infinite_rod(self) -> bool:
        """Whether the rod is infinitely long."""
        return math.isinf(self.rod)


def _eccentric_angle(eccentric: Eccentric, crank_angle: FloatOrArray) -> FloatArray:
    """Return theta = w + d (rad)."""
    return validate_argument(crank_angle, "crank_angle", "rad") + eccentric.advance


def _finite_lengths(eccentric: Eccentric) -> tuple[float, float]:
    """Return radius and rod (m); raise MechanismError for an infinitely long rod."""
    if eccentric.has_infinite_rod:
        raise MechanismError("the error term needs a rod of finite length")
    return eccentric.radius, eccentric.rod


def valve_distance(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance of the valve from the shaft (m), s = r sin(w + d) + sqrt(l^2 - r^2 cos^2(w + d)), after Zeuner."""
    r, rod = _finite_lengths(eccentric)
    theta = _eccentric_angle(eccentric, crank_angle)
    return as_scalar_or_array(r * np.sin(theta) + np.sqrt(rod**2 - (r * np.cos(theta)) ** 2))


def valve_velocity(eccentric: Eccentric, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the velocity of the valve at a steady crank rate, W (r cos t + r^2 sin t cos t / q) with t = w + d.

    q = sqrt(l^2 - r^2 cos^2 t).

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    crank_angle
        Crank angle w, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Velocity, m/s.
    """
    theta = _eccentric_angle(eccentric, crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    r, q = eccentric.radius, _rod_extent(eccentric, theta)
    return as_scalar_or_array(rate * (r * np.cos(theta) + r**2 * np.sin(theta) * np.cos(theta) / q))


def valve_acceleration(eccentric: Eccentric, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the acceleration of the valve at a steady crank rate.

    W^2 (-r sin t + r^2 cos 2t / q - r^4 sin^2 t cos^2 t / q^3), with t and q of `valve_velocity`.

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    crank_angle
        Crank angle w, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Acceleration, m/s2.
    """
    theta = _eccentric_angle(eccentric, crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    r, q = eccentric.radius, _rod_extent(eccentric, theta)
    rod_term = r**2 * np.cos(2 * theta) / q - (r**2 * np.sin(theta) * np.cos(theta)) ** 2 / q**3
    return as_scalar_or_array(rate**2 * (rod_term - r * np.sin(theta)))


def _rod_extent(eccentric: Eccentric, theta: FloatArray) -> FloatArray:
    """Return q, the extent of the rod along the line of the valve (m); infinite for an infinitely long rod."""
    if eccentric.has_infinite_rod:
        return np.full_like(theta, math.inf)
    return np.asarray(np.sqrt(eccentric.rod**2 - (eccentric.radius * np.cos(theta)) ** 2))


def equal_lead_centre(eccentric: Eccentric) -> float:
    """Return the centre of the swing that makes both leads equal, d = sqrt(l^2 - r^2 cos^2 d).

    It is the mean of the distances at the two dead centres. The middle between the extremes is at l.

    Parameters
    ----------
    eccentric
        The eccentric, with a rod of finite length.

    Returns
    -------
    float
        Distance of the centre from the shaft, m.
    """
    r, rod = _finite_lengths(eccentric)
    return math.sqrt(rod**2 - (r * math.cos(eccentric.advance)) ** 2)


def first_order_displacement(eccentric: Eccentric, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the displacement by Zeuner's law, x0 = r sin(w + d): that of an infinitely long rod.

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    crank_angle
        Crank angle w, rad.

    Returns
    -------
    FloatOrArray
        Displacement, m.
    """
    return as_scalar_or_array(eccentric.radius * np.sin(_eccentric_angle(eccentric, crank_angle)))


def valve_displacement(eccentric: Eccentric, *, crank_angle: FloatOrArray, centre: float | None = None) -> FloatOrArray:
    """Return the displacement of the valve from the centre of its swing, x = s - centre.

    With an infinitely long rod s is r sin(w + d).

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    crank_angle
        Crank angle w, rad.
    centre
        Centre of the swing, m from the shaft; None: the centre of equal leads, or 0 with an infinitely long rod.

    Returns
    -------
    FloatOrArray
        Displacement, m.
    """
    if eccentric.has_infinite_rod:
        return as_scalar_or_array(np.asarray(first_order_displacement(eccentric, crank_angle=crank_angle)) - (centre or 0.0))
    middle = equal_lead_centre(eccentric) if centre is None else centre
    return as_scalar_or_array(np.asarray(valve_distance(eccentric, crank_angle=crank_angle)) - middle)


def parabola_constant(eccentric: Eccentric) -> float:
    """Return C = r^2 (1 - cos^2 d) (m2) of Marks' parabola x0^2 = 2 l z + C; its vertex is at z = -C / 2 l."""
    return (eccentric.radius * math.sin(eccentric.advance)) ** 2


def parabola_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """Return the error term by Marks' parabola, x0^2 = 2 l z + C.

    Parameters
    ----------
    eccentric
        The eccentric, with a rod of finite length.
    theoretical
        Theoretical displacement x0 = r sin(w + d), m.

    Returns
    -------
    FloatOrArray
        Error term z, m.
    """
    _, rod = _finite_lengths(eccentric)
    return as_scalar_or_array((_validate_theoretical(eccentric, theoretical) ** 2 - parabola_constant(eccentric)) / (2 * rod))


def circle_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """Return the error term by Marks' circle of radius l through the two dead centres.

    z = sqrt(l^2 - r^2 sin^2 d) - sqrt(l^2 - x0^2).

    Parameters
    ----------
    eccentric
        The eccentric, with a rod of finite length.
    theoretical
        Theoretical displacement x0 = r sin(w + d), m.

    Returns
    -------
    FloatOrArray
        Error term z, m.
    """
    _, rod = _finite_lengths(eccentric)
    x0 = _validate_theoretical(eccentric, theoretical)
    return as_scalar_or_array(math.sqrt(rod**2 - parabola_constant(eccentric)) - np.sqrt(rod**2 - x0**2))


def hyperbola_error(eccentric: Eccentric, *, theoretical: FloatOrArray) -> FloatOrArray:
    """Return the exact error term, on the hyperbola (z + d)^2 - x0^2 = l^2 - r^2 that Marks' curves approximate.

    Parameters
    ----------
    eccentric
        The eccentric, with a rod of finite length.
    theoretical
        Theoretical displacement x0 = r sin(w + d), m.

    Returns
    -------
    FloatOrArray
        Error term z, m.
    """
    r, rod = _finite_lengths(eccentric)
    x0 = _validate_theoretical(eccentric, theoretical)
    return as_scalar_or_array(np.sqrt(rod**2 - r**2 + x0**2) - equal_lead_centre(eccentric))


def _validate_theoretical(eccentric: Eccentric, value: FloatOrArray) -> FloatArray:
    """Return the theoretical displacement (m); it is at most the radius."""
    x0 = validate_argument(value, "theoretical", "m")
    exceeds_radius = np.abs(x0) > eccentric.radius * (1 + 1e-12)
    raise_where(exceeds_radius, "the theoretical displacement cannot exceed the radius", ("theoretical", x0, "m"))
    return x0


def crank_angles_at(eccentric: Eccentric, *, threshold: FloatOrArray, centre: float | None = None) -> tuple[FloatOrArray, FloatOrArray]:
    """Return the crank angles (rad, 0 to 2 pi) at which the displacement passes a threshold t (m): rising, then falling.

    By the law of cosines, with the centre c of `valve_displacement`: sin(w + d) = ((c + t)^2 + r^2 - l^2) / (2 r (c + t)). With an
    infinitely long rod, Zeuner's law without an error term, it is (c + t) / r.
    """
    t = validate_argument(threshold, "threshold", "m")
    r = eccentric.radius
    rod = eccentric.rod
    if eccentric.has_infinite_rod:
        sine = (t + (centre or 0.0)) / r
    else:
        s = t + (equal_lead_centre(eccentric) if centre is None else centre)
        sine = (s**2 + (r - rod) * (r + rod)) / (2 * r * s)
    raise_where(np.abs(sine) > 1, "the valve never reaches the threshold: reduce the lap", ("threshold", t, "m"))
    theta = np.arcsin(sine)
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
"""By event: the sign of its threshold, the lap that is its magnitude, and whether the displacement rises through it."""


def event_threshold(event: str, *, outside_lap: float, inside_lap: float) -> float:
    """Return the displacement (m) at which a valve event occurs; the outer edges of the valve admit steam."""
    side, lap, _ = VALVE_EVENTS[event]
    return side * (outside_lap if lap == "outside" else inside_lap)


def event_angle(eccentric: Eccentric, *, event: str, outside_lap: float, inside_lap: float, centre: float | None = None) -> float:
    """Return the crank angle of a valve event; with an infinitely long rod that of Zeuner's law.

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    event
        Name of the event, a key of VALVE_EVENTS.
    outside_lap
        Outside lap, m.
    inside_lap
        Inside lap, m.
    centre
        Centre of the swing as in `valve_displacement`, m.

    Returns
    -------
    float
        Crank angle, rad, from 0 to 2 pi.
    """
    threshold = event_threshold(event, outside_lap=outside_lap, inside_lap=inside_lap)
    rising, falling = crank_angles_at(eccentric, threshold=threshold, centre=centre)
    return float(rising if VALVE_EVENTS[event][2] else falling)


def leads(eccentric: Eccentric, *, outside_lap: float, centre: float | None = None) -> tuple[float, float]:
    """Return the openings of the steam ports at their dead centres.

    Parameters
    ----------
    eccentric
        The eccentric and its rod.
    outside_lap
        Outside lap, m.
    centre
        Centre of the swing as in `valve_displacement`, m.

    Returns
    -------
    tuple[float, float]
        Lead at the crank end and at the head end, m.
    """
    crank_end, head_end = (float(valve_displacement(eccentric, crank_angle=w, centre=centre)) for w in (0.0, math.pi))
    return crank_end - outside_lap, -head_end - outside_lap

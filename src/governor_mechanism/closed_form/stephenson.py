"""Stephenson's link motion: Zeuner's first-order law, and the exact position of link, die and valve from the closure of the rods.

The crank angle w is zero at the dead centre at which the piston is nearest to the shaft, and grows in the direction of rotation.
Coordinates: x from the shaft along the valve line, y up; the crank turns clockwise in them. The link has axes with their origin in the
middle of its arc, x away from the shaft; its angle is positive anticlockwise. The die offset u is the position of the die along the arc,
from its middle toward the upper pin. The gear g is the position of the reversing lever: 1 full forward, with the die at the pin of the
forward eccentric, -1 full back. SI and radians.

The gear is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite and where the link cannot be assembled. Parts are rigid, without clearance.

References
----------
G. Zeuner's law for open and crossed rods, and the four suspensions of Müller-Melchiors on Marks' model, Dinglers Polytechnisches Journal
241 (1881), p. 161. The exact position follows from the two circles on which the rod pins lie, and the circle of the hanger.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatArray, FloatOrArray

ANGLE_STEP, MAX_ANGLE = 0.02, 0.8
"""Step of the search for the link angle, and its largest distance from the angle at which both rods are parallel, rad."""


@dataclass(frozen=True, kw_only=True)
class LinkGear:
    """A link with two equal eccentrics, suspended from a hanger.

    MechanismError is raised for lengths that are not positive, and for a link longer than its radius or its rods allow.

    Attributes
    ----------
    radius
        Eccentricity r, m.
    rod
        Length l of the eccentric rods, m.
    advance
        Angle of advance d, rad.
    link_radius
        Radius of the arc, m.
    half_link
        Half the distance c of the rod pins, m.
    setback
        Distance of the rod pins behind the arc, m.
    suspension_x, suspension_y
        Point of the link from which it hangs, in the axes of the link, m.
    hanger
        Length of the hanger, m.
    crossed
        Whether the forward eccentric drives the lower pin.
    """

    radius: float
    rod: float
    advance: float
    link_radius: float
    half_link: float
    setback: float = 0.0
    suspension_x: float = 0.0
    suspension_y: float = 0.0
    hanger: float
    crossed: bool = False

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_fields(self, dict.fromkeys(("radius", "rod", "link_radius", "half_link", "hanger"), "m"), greater_than=0.0)
        validate_fields(self, {"setback": "m", "suspension_x": "m", "suspension_y": "m", "advance": "rad"})
        if not self.half_link < min(self.rod, self.link_radius):
            raise MechanismError(
                f"half_link must be shorter than rod and link_radius; got {self.half_link:.12g} m, {self.rod:.12g} m and "
                f"{self.link_radius:.12g} m"
            )

    @classmethod
    def from_dimensions(cls, dimensions: Mapping[str, float]) -> LinkGear:
        """Return the gear of a machine's dimensions by name, SI."""
        return cls(
            radius=dimensions["eccentric"],
            rod=dimensions["eccentric_rod"],
            advance=dimensions["advance"],
            link_radius=dimensions["link_radius"],
            half_link=dimensions["half_link"],
            setback=dimensions["pin_setback"],
            suspension_x=dimensions["suspension_x"],
            suspension_y=dimensions["suspension_y"],
            hanger=dimensions["hanger"],
            crossed=bool(dimensions["crossed"]),
        )

    @property
    def half_arc(self) -> float:
        """Half the length of the arc, m: the nominal die offset in full gear."""
        return self.link_radius * math.asin(self.half_link / self.link_radius)

    @property
    def pin_x(self) -> float:
        """Abscissa of the rod pins in the axes of the link, m."""
        return math.sqrt(self.link_radius**2 - self.half_link**2) - self.link_radius - self.setback


class LinkPosition(NamedTuple):
    """Position of the valve: its distance from the shaft, m, the die offset, m, and the angle of the link, rad."""

    valve: FloatOrArray
    die_offset: FloatOrArray
    link_angle: FloatOrArray


def first_order_amplitudes(link_gear: LinkGear, *, offset_ratio: FloatOrArray) -> tuple[FloatOrArray, FloatOrArray]:
    """Return the amplitudes A and B of Zeuner's law x = A cos w + B sin w at a die offset u.

    A = r (sin d + (c^2 - u^2) / (c l) cos d) for open rods, with a minus sign for crossed ones, and B = r (u / c) cos d; with crossed rods
    the forward eccentric drives the lower pin, and B changes its sign.

    Parameters
    ----------
    link_gear
        The link and its eccentrics.
    offset_ratio
        Die offset u, relative to half the distance c of the pins.

    Returns
    -------
    tuple[FloatOrArray, FloatOrArray]
        Amplitudes A and B, m.
    """
    ratio = validate_argument(offset_ratio, "offset_ratio", "")
    r = link_gear.radius
    d = link_gear.advance
    rod_term = (1.0 - ratio**2) * link_gear.half_link / link_gear.rod * math.cos(d)
    cosine = r * (math.sin(d) + (-rod_term if link_gear.crossed else rod_term))
    sine = r * ratio * math.cos(d) * (-1.0 if link_gear.crossed else 1.0)
    return as_scalar_or_array(cosine), as_scalar_or_array(sine)


def first_order_displacement(link_gear: LinkGear, *, crank_angle: FloatOrArray, offset_ratio: FloatOrArray) -> FloatOrArray:
    """Return the displacement of the valve by Zeuner's law, A cos w + B sin w, m; see `first_order_amplitudes`."""
    w = validate_argument(crank_angle, "crank_angle", "rad")
    cosine, sine = first_order_amplitudes(link_gear, offset_ratio=offset_ratio)
    return as_scalar_or_array(np.asarray(cosine) * np.cos(w) + np.asarray(sine) * np.sin(w))


def link_position(link_gear: LinkGear, *, crank_angle: FloatOrArray, gear: FloatOrArray) -> LinkPosition:
    """Return the exact position of valve, die and link.

    At a link angle, each rod pin lies on the circle of its rod; the middle of the arc is where the two circles, shifted by the positions
    of the pins on the link, meet. The link angle is the one at which the suspension is at the distance of the hanger from its fixed end,
    (sqrt(l^2 - c^2) - x_pin + S_x, S_y - g a + h), with half the arc length a; with crossed rods, + g a.

    Parameters
    ----------
    link_gear
        The link, its eccentrics and its suspension.
    crank_angle
        Crank angle w, rad.
    gear
        Position g of the reversing lever.

    Returns
    -------
    LinkPosition
        Distance of the valve from the shaft, die offset and link angle.
    """
    angles = validate_argument(crank_angle, "crank_angle", "rad")
    gears = validate_argument(gear, "gear", "")
    shape = np.broadcast_shapes(angles.shape, gears.shape)
    pairs = zip(np.broadcast_to(angles, shape).flat, np.broadcast_to(gears, shape).flat, strict=True)
    positions: FloatArray = np.array([_position_at(link_gear, float(angle), float(one)) for angle, one in pairs]).reshape(*shape, 3)
    return LinkPosition(*(as_scalar_or_array(positions[..., k]) for k in range(3)))


def _position_at(link_gear: LinkGear, crank_angle: float, gear: float) -> tuple[float, float, float]:
    """Return the distance of the valve (m), die offset (m) and link angle (rad) at a crank angle (rad)."""
    hanger_x = math.sqrt(link_gear.rod**2 - link_gear.half_link**2) - link_gear.pin_x + link_gear.suspension_x
    nominal_offset = gear * (-link_gear.half_arc if link_gear.crossed else link_gear.half_arc)
    hanger_y = link_gear.suspension_y - nominal_offset + link_gear.hanger

    def hanger_error(angle: float) -> float:
        x, y = _arc_middle(link_gear, crank_angle, angle)
        along, up = _rotated(link_gear.suspension_x, link_gear.suspension_y, angle)
        return math.hypot(x + along - hanger_x, y + up - hanger_y) - link_gear.hanger

    # With parallel rods the link is inclined as the line of the eccentrics.
    ratio = (_eccentric(link_gear, crank_angle, -1.0)[0] - _eccentric(link_gear, crank_angle, 1.0)[0]) / (2.0 * link_gear.half_link)
    bracket = _bracket_of_root(hanger_error, math.asin(min(max(ratio, -1.0), 1.0)))
    if bracket is None:
        raise MechanismError(f"the link cannot be assembled at a crank angle of {math.degrees(crank_angle):.6g} deg in gear {gear:.6g}")
    angle = find_root(hanger_error, *bracket)
    x, y = _arc_middle(link_gear, crank_angle, angle)
    centre_x = x - link_gear.link_radius * math.cos(angle)
    centre_y = y - link_gear.link_radius * math.sin(angle)
    if abs(centre_y) >= link_gear.link_radius:
        raise MechanismError(
            f"the arc does not meet the valve line at a crank angle of {math.degrees(crank_angle):.6g} deg in gear {gear:.6g}"
        )
    die_direction = math.asin(-centre_y / link_gear.link_radius)
    return centre_x + link_gear.link_radius * math.cos(die_direction), link_gear.link_radius * (die_direction - angle), angle


def _eccentric(link_gear: LinkGear, crank_angle: float, side: float) -> tuple[float, float]:
    """Return the centre of the eccentric of the upper (side 1) or the lower pin (side -1) at a crank angle (rad), m."""
    is_forward = (side > 0.0) != link_gear.crossed
    angle = crank_angle + (link_gear.advance if is_forward else math.pi - link_gear.advance)
    return link_gear.radius * math.sin(angle), link_gear.radius * math.cos(angle)


def _arc_middle(link_gear: LinkGear, crank_angle: float, angle: float) -> tuple[float, float]:
    """Return the middle of the arc at a link angle (rad): the outer intersection of the circles of both rods; nan if there is none."""
    centres = []
    for side in (1.0, -1.0):
        pin_x, pin_y = _rotated(link_gear.pin_x, side * link_gear.half_link, angle)
        x, y = _eccentric(link_gear, crank_angle, side)
        centres.append((x - pin_x, y - pin_y))
    (x1, y1), (x2, y2) = centres
    dx, dy = x2 - x1, y2 - y1
    half_distance = 0.5 * math.hypot(dx, dy)
    if half_distance >= link_gear.rod or half_distance == 0.0:
        return math.nan, math.nan
    height = math.sqrt(link_gear.rod**2 - half_distance**2) / (2.0 * half_distance)
    # The shifted circle of the upper rod is the lower one; seen from it, the intersection away from the shaft is on the right.
    return 0.5 * (x1 + x2) + height * dy, 0.5 * (y1 + y2) - height * dx


def _rotated(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return a vector rotated anticlockwise by an angle (rad)."""
    return math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y


def _bracket_of_root(function: Callable[[float], float], start: float) -> tuple[float, float] | None:
    """Return two angles (rad) between which a function changes its sign, nearest to a start, or None."""
    ends = [(start, function(start))] * 2
    for k in range(1, round(MAX_ANGLE / ANGLE_STEP) + 1):
        for side, sign in enumerate((-1.0, 1.0)):
            angle, (last_angle, last_value) = start + sign * k * ANGLE_STEP, ends[side]
            value = function(angle)
            if value * last_value <= 0.0:
                return last_angle, angle
            ends[side] = angle, value
    return None

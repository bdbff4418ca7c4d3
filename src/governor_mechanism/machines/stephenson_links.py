"""Dimensions of Stephenson's link motion, and what contradicts them.

Coordinates are those of the valve line: x away from the shaft, y up; the crank turns clockwise in them. The link has axes with their
origin in the middle of its arc, x away from the shaft. The arc is concave to the shaft.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.machines.base import Machine, values_of
from governor_mechanism.machines.slide_valve import rod_field
from governor_mechanism.machines.slider_crank import advance_problems, rod_length_problems
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatArray, Vector2
from governor_mechanism.units.fields import entry, optional, quantity

MAX_NEWTON_STEPS = 40
"""Newton's method needs about five steps from the position of the link with both eccentrics at the shaft."""

CLOSURE_TOLERANCE = 1e-13
"""Largest error of the three rods of a closed link, relative to the length of the eccentric rods: a hundred times rounding."""

MAX_STEP_RATIO = 0.2
"""Largest displacement of the link in a Newton step, relative to the eccentric rods, and largest rotation, rad."""


@dataclass(frozen=True, kw_only=True)
class LinkGeometry:
    """The parts of a link gear that determine the position of the link, lengths in m."""

    eccentric: float  # eccentricity
    eccentric_rod: float  # both are equal
    advance: float  # of both eccentrics, rad
    link_radius: float  # of its arc
    half_link: float  # half the distance of the rod pins
    pin_setback: float  # of the rod pins behind the arc, toward the shaft
    suspension: Vector2  # point from which the link hangs, in its axes
    hanger: float  # length
    crossed: bool  # whether the forward eccentric drives the lower pin

    @property
    def half_arc(self) -> float:
        """Half the length of the arc between the rod pins, or the points of the arc in front of them, m."""
        return self.link_radius * math.asin(self.half_link / self.link_radius)

    @property
    def pins(self) -> tuple[Vector2, Vector2]:
        """Upper and lower rod pin in the axes of the link, m."""
        x = -arc_depth(self.link_radius, self.half_link) - self.pin_setback
        return (x, self.half_link), (x, -self.half_link)

    @property
    def middle_distance(self) -> float:
        """Distance of the arc's middle from the shaft with both eccentrics at the shaft and the link upright, m."""
        return math.sqrt(self.eccentric_rod**2 - self.half_link**2) - self.pins[0][0]

    def nominal_offset(self, reverser: float) -> float:
        """Return the position of the die along the arc with both eccentrics at the shaft, m; in full forward gear at the forward pin."""
        return -reverser * self.half_arc if self.crossed else reverser * self.half_arc

    def hanger_top(self, reverser: float) -> Vector2:
        """Return the fixed end of the hanger at a position of the reversing lever, m."""
        x, y = self.suspension
        return self.middle_distance + x, y - self.nominal_offset(reverser) + self.hanger

    def eccentrics(self, crank_angles: FloatArray) -> FloatArray:
        """Return the centres of the eccentrics of the upper and the lower pin at crank angles (n,) rad; shape (n, 2, 2), m."""
        forward = crank_angles + self.advance
        backward = crank_angles - self.advance + math.pi
        pair = [np.stack([np.sin(angle), np.cos(angle)], axis=-1) for angle in (forward, backward)]
        return self.eccentric * np.stack(pair[::-1] if self.crossed else pair, axis=1)

    def locate_die(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the die's distance from the shaft and place along the arc (m) at poses (n, 3); nan where the arc misses its line."""
        x, y, angle = poses.T
        centre_x = x - self.link_radius * np.cos(angle)
        centre_y = y - self.link_radius * np.sin(angle)
        with np.errstate(invalid="ignore"):
            extent = np.sqrt(self.link_radius**2 - centre_y**2)
        return centre_x + extent, self.link_radius * (np.arctan2(-centre_y, extent) - angle)

    def solve_poses(self, crank_angles: FloatArray, reverser: float) -> FloatArray:
        """Return the poses (n, 3) of the link (m, m, rad) at crank angles (n,) rad; nan where it cannot be assembled."""
        # Every pose continues that with both eccentrics at the shaft.
        anchors = np.concatenate([self.eccentrics(crank_angles), np.tile(self.hanger_top(reverser), (len(crank_angles), 1, 1))], axis=1)
        points = np.array([*self.pins, self.suspension])
        lengths = np.array([self.eccentric_rod, self.eccentric_rod, self.hanger])
        poses = np.tile([self.middle_distance, -self.nominal_offset(reverser), 0.0], (len(crank_angles), 1))
        max_steps = MAX_STEP_RATIO * np.array([self.eccentric_rod, self.eccentric_rod, 1.0])
        for _ in range(MAX_NEWTON_STEPS):
            residuals, jacobians = _evaluate_closure(poses, anchors, points, lengths)
            is_closed = np.max(np.abs(residuals), axis=1) < CLOSURE_TOLERANCE * self.eccentric_rod
            if is_closed.all():
                break
            poses = poses - np.clip(_solve_each(jacobians, residuals), -max_steps, max_steps)
        return np.where(is_closed[:, np.newaxis], poses, math.nan)


def _solve_each(matrices: FloatArray, values: FloatArray) -> FloatArray:
    """Return the solutions (n, 3) of n systems; the least one of a singular system, which has none or many."""
    try:
        return np.asarray(np.linalg.solve(matrices, values[..., np.newaxis])[..., 0])
    except np.linalg.LinAlgError:  # the pseudo-inverse takes ten times as long
        return np.asarray((np.linalg.pinv(matrices) @ values[..., np.newaxis])[..., 0])


def arc_depth(radius: float, half_chord: float) -> float:
    """Return the height of an arc over its chord, m."""
    return half_chord**2 / (radius + math.sqrt(radius**2 - half_chord**2))


def _evaluate_closure(poses: FloatArray, anchors: FloatArray, points: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the errors (n, 3) of the three rods, m, and their derivatives (n, 3, 3) by the poses (n, 3)."""
    cosine, sine = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    arm_x = cosine * points[:, 0] - sine * points[:, 1]
    arm_y = sine * points[:, 0] + cosine * points[:, 1]
    dx = poses[:, :1] + arm_x - anchors[..., 0]
    dy = poses[:, 1:2] + arm_y - anchors[..., 1]
    distances = np.hypot(dx, dy)
    jacobians = np.stack([dx, dy, arm_x * dy - arm_y * dx], axis=-1) / distances[..., np.newaxis]
    return distances - lengths, jacobians


OPEN_RODS, CROSSED_RODS = "open", "crossed"
ARC_MIDDLE = "arc middle"
CHORD_MIDDLE = "chord middle"
LOWER_PIN = "lower pin"
HALF_WAY = "half-way"
ANY_POINT = "point"

CHECKED_ANGLES: FloatArray = np.linspace(0.0, math.tau, 72, endpoint=False)
"""Crank angles at which the link must be assembled, rad."""

MAX_GEAR_STEP = 0.25
"""Largest step of the reversing lever between the gears that are checked for a lever that moves."""


@dataclass(frozen=True, kw_only=True)
class StephensonDimensions(Machine):
    """Dimensions of the link motion. Lengths in m, angles in rad, constant crank speed in rad/s.

    Attributes
    ----------
    crank
        Crank radius, m: half the stroke.
    connecting_rod
        Length of the connecting rod, m; None if infinite.
    eccentric
        Eccentricity of both eccentrics, m.
    eccentric_rod
        Length of both eccentric rods, m.
    advance
        Angle of advance of both eccentrics, rad.
    rods
        Whether the rods are open or crossed when both eccentrics are on the side of the link.
    link_radius
        Radius of the arc of the link, m; it is concave to the shaft.
    half_link
        Half the distance of the rod pins, m.
    pin_setback
        Distance of the rod pins behind the arc, toward the shaft, m.
    suspension
        Point of the link from which it hangs.
    suspension_x, suspension_y
        That point, if it is any point: from the middle of the arc, away from the shaft and up, m.
    hanger
        Length of the hanger, m. Its upper end moves up and down with the reversing lever.
    reverser
        Position of the reversing lever: 1 is full forward gear, -1 full back; or its motion over time.
    slot_half_length
        Half the length of the slot along the arc, m; None without an end.
    outside_lap, inside_lap
        Laps of the valve, m; a negative inside lap leaves the ports open in mid position.
    valve_set_at
        Position of the reversing lever at which the valve is set for equal leads.
    crank_speed
        Crank speed, rad/s; None if nothing drives the crank but a coupling or its own inertia.
    crank_start
        Crank angle at the start, rad.
    """

    crank: float = quantity("length", meaning="from the shaft to the crank pin: half the stroke")
    connecting_rod: float | None = rod_field(meaning="from the crank pin to the crosshead; endless if left out")
    eccentric: float = quantity("length", meaning="from the shaft to the centre of each eccentric")
    eccentric_rod: float = quantity("length", meaning="from the centre of each eccentric to its pin on the link")
    advance: float = quantity("angle", sign="any", meaning="by which the eccentrics run ahead of a right angle to the crank")
    rods: str = entry("choice", words=(OPEN_RODS, CROSSED_RODS), default=OPEN_RODS, meaning="arrangement of the eccentric rods")
    link_radius: float = quantity("length", meaning="of the arc of the link, which is concave to the shaft")
    half_link: float = quantity("length", meaning="that is half the distance of the rod pins")
    pin_setback: float = quantity("length", sign="any", default=0.0, meaning="of the rod pins behind the arc, toward the shaft")
    suspension: str = entry(
        "choice",
        words=(ARC_MIDDLE, CHORD_MIDDLE, LOWER_PIN, HALF_WAY, ANY_POINT),
        default=ARC_MIDDLE,
        meaning="point from which the link hangs",
    )
    suspension_x: float | None = optional("length", sign="any", meaning="from the arc's middle to the suspension, away from the shaft")
    suspension_y: float | None = optional("length", sign="any", meaning="from the arc's middle up to the suspension")
    hanger: float = quantity("length", meaning="from the link up to the arm that the reversing lever moves")
    reverser: float | PrescribedMotion = entry(
        "program", "ratio", sign="any", default=1.0, meaning="of the travel of the reversing lever: 1 is full forward gear, -1 full back"
    )
    slot_half_length: float | None = optional("length", meaning="of the slot along the arc from its middle to each end")
    outside_lap: float = quantity("length", sign="any", meaning="by which the valve in its middle covers the outer edges")
    inside_lap: float = quantity("length", sign="any", default=0.0, meaning="by which it covers the inner edges; negative leaves them open")
    valve_set_at: float = quantity("ratio", sign="any", default=1.0, meaning="of the reversing lever for which the valve has equal leads")
    crank_speed: float | None = optional("angular_speed", meaning="of the crank, which is driven")
    crank_start: float = quantity("angle", sign="any", default=0.0, meaning="of the crank at the start")

    def dimension_problems(self) -> list[str]:
        """Return sentences about rods, link, suspension, lever and laps, and gears in which the link cannot be assembled."""
        problems = [*rod_length_problems(self, {"connecting_rod": "crank", "eccentric_rod": "eccentric"}), *self._length_problems()]
        # A link of impossible lengths has no positions.
        return problems or [*self._assembly_problems()]

    def _length_problems(self) -> Iterator[str]:
        """Yield sentences about single dimensions that are impossible."""
        yield from advance_problems(self.advance)
        for name, length in (("link_radius", self.link_radius), ("eccentric_rod", self.eccentric_rod)):
            if not self.half_link < length:
                yield (
                    f"half_link ({self.half_link * 1e3:.6g} mm) must be shorter than {name} ({length * 1e3:.6g} mm), "
                    "or the link has no arc between its pins; shorten the link"
                )
        has_point = self.suspension_x is not None or self.suspension_y is not None
        if has_point != (self.suspension == ANY_POINT):
            cure = f'write suspension = "{ANY_POINT}"' if has_point else "give suspension_x and suspension_y"
            yield f'suspension is "{self.suspension}", and suspension_x and suspension_y {_is_given(has_point)}; {cure}'
        for name, value in (("reverser", max(values_of(self.reverser), key=abs)), ("valve_set_at", self.valve_set_at)):
            if abs(value) > 1.0:
                yield f"{name} ({value:.6g}) must lie between -1, full back gear, and 1, full forward gear"
        for name, lap in (("outside_lap", self.outside_lap), ("inside_lap", self.inside_lap)):
            if abs(lap) >= self.eccentric:
                yield (
                    f"{name} ({lap * 1e3:.6g} mm) must be smaller than eccentric ({self.eccentric * 1e3:.6g} mm), "
                    "or its ports never open or never close in full gear; reduce it, or enlarge eccentric"
                )

    def _assembly_problems(self) -> Iterator[str]:
        """Yield a sentence about the first gear and crank angle at which the link or its die has no position."""
        values = values_of(self.reverser)
        low, high = min(values), max(values)
        gears = np.linspace(low, high, 1 + math.ceil((high - low) / MAX_GEAR_STEP))
        for gear in {*gears.tolist(), self.valve_set_at}:
            poses = self.geometry.solve_poses(CHECKED_ANGLES, gear)
            is_open = np.isnan(poses[:, 0])
            where = f"in gear {gear:.6g} at a crank angle of {{:.6g}} deg"
            if is_open.any():
                where = where.format(math.degrees(CHECKED_ANGLES[np.argmax(is_open)]))
                yield (
                    f"the link cannot be assembled {where}: hanger ({self.hanger * 1e3:.6g} mm) and eccentric rods "
                    f"({self.eccentric_rod * 1e3:.6g} mm) do not reach it; make hanger or half_link longer, or eccentric shorter"
                )
                return
            is_off = np.isnan(self.geometry.locate_die(poses)[0])
            if is_off.any():
                where = where.format(math.degrees(CHECKED_ANGLES[np.argmax(is_off)]))
                yield f"the arc of the link does not meet the valve line {where}; make link_radius larger"
                return

    @cached_property
    def geometry(self) -> LinkGeometry:
        """The parts that determine the position of the link."""
        return LinkGeometry(
            eccentric=self.eccentric,
            eccentric_rod=self.eccentric_rod,
            advance=self.advance,
            link_radius=self.link_radius,
            half_link=self.half_link,
            pin_setback=self.pin_setback,
            suspension=self.suspension_point,
            hanger=self.hanger,
            crossed=self.rods == CROSSED_RODS,
        )

    @property
    def suspension_point(self) -> Vector2:
        """Point of the link from which it hangs: from the arc's middle, away from the shaft and up, m."""
        depth = arc_depth(self.link_radius, self.half_link)
        quarter_angle = 0.5 * math.asin(self.half_link / self.link_radius)
        points = {
            ARC_MIDDLE: (0.0, 0.0),
            CHORD_MIDDLE: (-depth, 0.0),
            LOWER_PIN: (-depth - self.pin_setback, -self.half_link),
            HALF_WAY: (-self.link_radius * (1.0 - math.cos(quarter_angle)), -self.link_radius * math.sin(quarter_angle)),
            ANY_POINT: (self.suspension_x or 0.0, self.suspension_y or 0.0),
        }
        return points[self.suspension]

    @cached_property
    def valve_centre(self) -> float:
        """Centre of the valve's motion from the shaft, m: the middle between its positions at the dead centres in the gear it is set at."""
        poses = self.geometry.solve_poses(np.array([0.0, math.pi]), self.valve_set_at)
        return float(np.mean(self.geometry.locate_die(poses)[0]))

    def slot_exit_angle(self) -> float | None:
        """Return the first crank angle (rad, from 0 to 2 pi) at which the die runs out of its slot, with the lever at rest; or None."""
        if self.slot_half_length is None or isinstance(self.reverser, PrescribedMotion):
            return None
        reverser, half_length = self.reverser, self.slot_half_length

        def overrun(angles: FloatArray) -> FloatArray:
            return np.abs(self.geometry.locate_die(self.geometry.solve_poses(angles, reverser))[1]) - half_length

        angles = self.crank_start + np.append(CHECKED_ANGLES, math.tau)
        is_out = overrun(angles) > 0
        if not is_out.any() or is_out[0]:
            return None
        k = int(np.argmax(is_out))
        return find_root(lambda angle: float(overrun(np.array([angle]))[0]), float(angles[k - 1]), float(angles[k])) % math.tau

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI. `centre` is the centre of the valve's motion; the suspension is a point of the link."""
        x, y = self.suspension_point
        derived = {"suspension_x": x, "suspension_y": y, "centre": self.valve_centre, "crossed": float(self.rods == CROSSED_RODS)}
        return super().dimensions() | derived


def _is_given(given: bool) -> str:
    return "are given" if given else "are missing"

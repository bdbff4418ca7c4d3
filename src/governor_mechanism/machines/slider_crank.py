"""Slider-crank, and what all crank machines share: a crank driven at constant speed, and placeholder masses for massless parts.

The plane is fixed. The origin is in the shaft; x points along the line of crosshead and valve, away from the shaft; y points up. The
crank turns anticlockwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, rotate_point, unit_hint, x_coordinate
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, RotationalDriver, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate
from governor_mechanism.model.part import FIXED_PLANE
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.units.fields import quantity

CRANK = "crank"
CROSSHEAD = "crosshead"
VALVE = "valve"
CONNECTING_ROD = "connecting rod"
SHAFT = "shaft"
CRANK_DRIVER = "drive"
CRANK_PIN = "crank pin"
GUDGEON_PIN = "gudgeon"
CROSSHEAD_GUIDE = "crosshead guide"

PLACEHOLDER_MASS = 1e-6
"""Mass of a massless part in the engines, kg. The driver prescribes its motion whatever the mass (a test verifies this), and the mass is
too small to load a bearing.
"""

PLACEHOLDER_INERTIA_RATIO = 10.0
"""Moment of inertia of a massless crank, relative to that of the parts it moves: the iterative joint solver converges faster with it."""


def crank_joints(speed: float | None, start_angle: float, mass_centre: float = 0.0) -> tuple[Joint, ...]:
    """Return shaft (mass centre in m from it) and driver: the angle is start_angle + speed * time (rad); free without a speed."""
    ground, on_crank = Point(body=GROUND), Point(body=CRANK, x=-mass_centre)
    if speed is None:
        return (Pin(name=SHAFT, first=ground, second=on_crank),)
    motion = PrescribedMotion.constant_rate(start_angle, speed)
    driver = RotationalDriver(name=CRANK_DRIVER, first=ground, second=on_crank, motion=motion)
    return Pin(name=SHAFT, first=ground, second=on_crank), driver


def placeholder_crank(radius: float, moved_mass: float) -> Body:
    """Return a crank of placeholder mass centred on the shaft; it moves the mass moved_mass (kg) at its radius (m)."""
    return shaft_with_crank(PLACEHOLDER_INERTIA_RATIO * moved_mass * radius**2)


def shaft_with_crank(inertia: float) -> Body:
    """Return a crank of placeholder mass centred on the shaft, with a moment of inertia (kg m2)."""
    return Body(name=CRANK, mass=PLACEHOLDER_MASS, second_moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rod_joint(name: str, driving: Point, driven: Point, length: float | None) -> Joint:
    """Return a massless rod (m). An infinite one is a slide normal to the line, in which the driving point moves."""
    if length is None:
        return Slider(name=name, first=driven, second=driving, angle=math.pi / 2)
    return Distance(name=name, first=driving, second=driven, length=length)


def advance_problems(advance: float) -> Iterator[str]:
    """Yield a sentence about an angle of advance (rad) that is a right angle or more."""
    if not abs(advance) < math.pi / 2:
        yield (
            f"advance ({math.degrees(advance):.6g} deg) must lie between -90 and 90 deg: it is measured from "
            f"the right angle to the crank{unit_hint(advance, math.pi, '30 deg')}"
        )


VALVE_DISPLACEMENT, CRANK_END_TRAVEL = "valve_displacement", "crank_end_travel"
"""Names of the readings of valve and piston, which grow away from the shaft."""
PORT_OPENINGS = ("crank_end_steam", "crank_end_exhaust", "head_end_steam", "head_end_exhaust")
"""Names of the openings of the ports; a negative opening is the overlap of a closed port."""

STEAM_READING_MEANINGS = {
    VALVE_DISPLACEMENT: "displacement of the valve from the centre of its motion, away from the shaft",
    CRANK_END_TRAVEL: "travel of the piston from the crank end of its stroke",
    "head_end_travel": "travel of the piston from the head end of its stroke",
    "crank_end_steam": "opening of the crank-end port to steam; negative where it is closed",
    "crank_end_exhaust": "opening of the crank-end port to the exhaust; negative where it is closed",
    "head_end_steam": "opening of the head-end port to steam; negative where it is closed",
    "head_end_exhaust": "opening of the head-end port to the exhaust; negative where it is closed",
}
"""What the readings of valve, piston and ports are, by name."""


def piston_readings(crosshead: Point, crank: float, crank_end: float, side: float = 1.0) -> tuple[PointCoordinate, ...]:
    """Return crank_end_travel and head_end_travel of a piston that is at the crank end where its crosshead is at `crank_end` (m)."""
    # `side` is 1 if the valve line leads away from the shaft along x, -1 if it does along -x.
    return (
        x_coordinate(CRANK_END_TRAVEL, crosshead, sign=side, zero=crank_end),
        x_coordinate("head_end_travel", crosshead, sign=-side, zero=-crank_end - 2 * crank),
    )


def port_readings(valve: Point, centre: float, outside_lap: float, inside_lap: float, side: float = 1.0) -> tuple[PointCoordinate, ...]:
    """Return the openings of steam port and exhaust at the crank end and the head end, negative where they are closed; all in m."""
    # `side` is 1 if the valve line leads away from the shaft along x, -1 if it does along -x. The valve
    # moves about `centre`, from the shaft.
    crank_end_steam, crank_end_exhaust, head_end_steam, head_end_exhaust = PORT_OPENINGS
    return (
        x_coordinate(crank_end_steam, valve, sign=side, zero=centre + outside_lap),
        x_coordinate(crank_end_exhaust, valve, sign=-side, zero=-centre + inside_lap),
        x_coordinate(head_end_steam, valve, sign=-side, zero=-centre + outside_lap),
        x_coordinate(head_end_exhaust, valve, sign=side, zero=centre + inside_lap),
    )


@dataclass(frozen=True, kw_only=True)
class SliderCrank(Machine):
    """Slider crank. Lengths in m, angles in rad, constant crank speed in rad/s."""

    name: ClassVar[str] = "slider_crank"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "crank_angle": "angle of the crank from the outer dead centre, anticlockwise, continuous over full turns",
        "crosshead_distance": "distance of the crosshead from the shaft",
        "rod_angle": "angle of the connecting rod from the line of the crosshead, anticlockwise",
    }
    plane: ClassVar[str] = FIXED_PLANE
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (CrankMasses,)
    driver_dimensions: ClassVar[tuple[str, ...]] = ("crank_speed", "crank_start")

    crank: float = quantity("length", meaning="from the shaft to the crank pin")
    connecting_rod: float = quantity("length", meaning="from the crank pin to the crosshead")
    crank_speed: float = quantity("angular_speed", meaning="of the crank, which is driven")
    crank_start: float = quantity("angle", sign="any", default=0.0, meaning="of the crank at the start, from the outer dead centre")

    def dimension_problems(self) -> list[str]:
        """Return a sentence about a rod that is too short."""
        return rod_length_problems(self, {"connecting_rod": "crank"})

    def mechanism(self, masses: CrankMasses | None = None) -> Mechanism:
        """Build crank, rod and crosshead. A massless rod is a distance. Raise MechanismError for a mass centre beyond the rod."""
        bodies = {body.name: body for body in self._bodies(masses)}
        crank_centre, rod_centre = (masses.crank_centre, self._rod_centre(masses)) if masses else (0.0, 0.0)
        crank_pin = Point(body=CRANK, x=self.crank - crank_centre)
        rod_ends = [Point(body=CONNECTING_ROD, x=x) for x in (-rod_centre, self.connecting_rod - rod_centre)]
        crosshead = Point(body=CROSSHEAD) if CROSSHEAD in bodies else rod_ends[1]
        poses = self._initial_poses(crank_centre, rod_centre)
        return Mechanism(
            bodies=tuple(bodies.values()),
            joints=(
                *crank_joints(self.crank_speed, self.crank_start, crank_centre),
                *self._rod_joints(crank_pin, rod_ends if CONNECTING_ROD in bodies else [], crosshead),
                Slider(name=CROSSHEAD_GUIDE, first=Point(body=GROUND), second=crosshead, angle=0.0),
            ),
            readings=(
                BodyAngle(name="crank_angle", quantity="angle", body=CRANK),
                x_coordinate("crosshead_distance", crosshead),
                LineAngle(name="rod_angle", quantity="angle", start=crank_pin, end=crosshead, zero=math.pi / 2),
            ),
            coordinate="crank_angle",
            length_scale=self.crank,
            initial_guess=tuple(poses[name] for name in bodies),
        )

    def _rod_joints(self, crank_pin: Point, rod_ends: Sequence[Point], crosshead: Point) -> list[Joint]:
        """Return the pins at the ends of a rod with mass, or the distance that stands for a massless rod."""
        if not rod_ends:
            return [Distance(name=CONNECTING_ROD, first=crank_pin, second=crosshead, length=self.connecting_rod)]
        pins = ((CRANK_PIN, crank_pin, rod_ends[0]), (GUDGEON_PIN, rod_ends[1], crosshead))
        return [Pin(name=name, first=first, second=second) for name, first, second in pins if first != second]

    def _rod_centre(self, masses: CrankMasses) -> float:
        """Return the distance of the rod's mass centre from the crank pin, m."""
        rod_centre = 0.5 * self.connecting_rod if masses.rod_centre is None else masses.rod_centre
        if rod_centre > self.connecting_rod:
            raise MechanismError(
                f"masses.rod_centre ({rod_centre * 1e3:.6g} mm) lies beyond the crosshead; it is measured from the crank "
                f"pin, and connecting_rod is {self.connecting_rod * 1e3:.6g} mm"
            )
        return rod_centre

    def _bodies(self, masses: CrankMasses | None) -> Iterator[Body]:
        """Yield the crank, and rod and crosshead if they have mass; a massless part that is necessary has a placeholder mass."""
        if masses is None:
            yield placeholder_crank(self.crank, PLACEHOLDER_MASS)
        else:
            yield Body(name=CRANK, mass=masses.crank, second_moments=SecondMoments(xx=masses.crank * self.crank**2 / 12))
        if masses and masses.rod:
            rod_moments = SecondMoments(xx=masses.rod_inertia or masses.rod * self.connecting_rod**2 / 12)
            yield Body(name=CONNECTING_ROD, mass=masses.rod, second_moments=rod_moments)
        crosshead_mass = masses.crosshead if masses else 0.0
        if crosshead_mass or not (masses and masses.rod):
            yield Body(name=CROSSHEAD, mass=crosshead_mass or PLACEHOLDER_MASS, can_rotate=False)

    def _initial_poses(self, crank_centre: float, rod_centre: float) -> dict[str, tuple[float, float, float]]:
        """Return the poses of crank, rod and crosshead at the start by name, from the positions of the mass centres (m)."""
        angle = self.crank_start
        pin_x, pin_y = rotate_point(self.crank, 0.0, angle)
        rod_angle = -math.asin(pin_y / self.connecting_rod)
        across, up = rotate_point(rod_centre, 0.0, rod_angle)
        return {
            CRANK: (*rotate_point(crank_centre, 0.0, angle), angle),
            CONNECTING_ROD: (pin_x + across, pin_y + up, rod_angle),
            CROSSHEAD: (pin_x + self.connecting_rod * math.cos(rod_angle), 0.0, 0.0),
        }


def rod_length_problems(machine: Machine, rods: Mapping[str, str]) -> list[str]:
    """Return sentences about rods (keys) too short for their cranks (values) to turn over; an infinite rod (None) never is."""
    lengths = [(rod, getattr(machine, rod), crank, getattr(machine, crank)) for rod, crank in rods.items()]
    return [
        f"{rod} ({length * 1e3:.6g} mm) must be longer than {crank} ({radius * 1e3:.6g} mm), or it cannot turn over; make it longer"
        for rod, length, crank, radius in lengths
        if length is not None and not length > radius
    ]

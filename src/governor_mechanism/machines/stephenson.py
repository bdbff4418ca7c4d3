"""Stephenson's link motion: two eccentrics move a curved link, a die block in its slot moves the valve.

The reversing lever raises and lowers the link, so that the die is driven by the forward eccentric (1), the backward eccentric (-1), or by
both. The crank angle is measured from the dead centre at which the piston is nearest to the shaft, as for the slide valve. In the plane
the valve line leads from the shaft along -x, and the crank turns anticlockwise. The die slips in the slot during a turn: `die_slip` is
its position along the arc from the arc's middle, positive toward the upper pin. After Müller-Melchiors on Marks' model, Dinglers
Polytechnisches Journal 241 (1881), p. 161.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from governor_mechanism.effects.masses import LinkMasses
from governor_mechanism.machines import slider_crank
from governor_mechanism.machines.base import MassElement, rotate_point, slender_rod, thin_arc, values_of, x_coordinate
from governor_mechanism.machines.slide_valve import VALVE_GUIDE
from governor_mechanism.machines.slider_crank import (
    CRANK,
    CRANK_END_TRAVEL,
    CROSSHEAD,
    PLACEHOLDER_MASS,
    STEAM_READING_MEANINGS,
    VALVE,
    VALVE_DISPLACEMENT,
    piston_readings,
    port_readings,
)
from governor_mechanism.machines.stephenson_links import StephensonDimensions
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, ArcSlot, Distance, Joint, Pin, Point, Slider, TranslationalDriver
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import ArcPosition, BodyAngle, Limit, PointCoordinate, Reading
from governor_mechanism.model.part import FIXED_PLANE
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.model.valve import Reverser, Valve

LINK = "link"
LIFTING_ARM = "lifting arm"
HANGER = "hanger"
LINK_SLOT = "link slot"
ROD_NAMES = ("forward eccentric rod", "backward eccentric rod")
LEVER, LEVER_GUIDE = "reversing lever", "lifting arm guide"


PLACEHOLDER_MASS_RATIO = 1e-3
"""Mass of a part without mass, relative to the moved masses: the iterative joint solver needs comparable masses. Its weight and inertia
load the reversing lever by as little.
"""


@dataclass(frozen=True, kw_only=True)
class StephensonGear(StephensonDimensions):
    """Stephenson's link motion with the engine that it reverses."""

    name: ClassVar[str] = "stephenson"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "crank_angle": "angle of the crank from the dead centre at the crank end, continuous over full turns",
        "die_slip": "position of the die block along the arc of the link, from the middle of the arc",
        "link_angle": "angle of the link, anticlockwise",
        "reverser": "position of the reversing lever: 1 is full forward gear, -1 full back gear",
        **STEAM_READING_MEANINGS,
    }
    plane: ClassVar[str] = FIXED_PLANE
    driver_dimensions: ClassVar[tuple[str, ...]] = ("crank_speed", "crank_start")
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (LinkMasses,)

    @property
    def is_driven(self) -> bool:
        """Whether the crank has a prescribed speed."""
        return self.crank_speed is not None

    @property
    def default_start(self) -> float:
        """Crank angle at the start, rad."""
        return self.crank_start

    def mechanism(self, masses: LinkMasses | None = None) -> Mechanism:
        """Build crank with eccentrics, rods, link, lifting arm, valve and crosshead; parts without mass have a placeholder mass."""
        return _GearBuilder(gear=self, masses=masses).mechanism()


@dataclass(frozen=True, kw_only=True)
class _GearBuilder:
    """Builder of the mechanism. A massless eccentric rod is a distance."""

    gear: StephensonDimensions
    masses: LinkMasses | None

    def mechanism(self) -> Mechanism:
        """Return the mechanism."""
        bodies = dict(self._bodies())
        return Mechanism(
            bodies=tuple(bodies),
            joints=tuple(self._joints()),
            readings=self._readings(),
            coordinate="crank_angle",
            length_scale=self.gear.crank,
            initial_guess=tuple(bodies.values()),
            limits=tuple(self._limits()),
            valve=Valve(
                displacement=VALVE_DISPLACEMENT,
                steam_lap=self.gear.outside_lap,
                exhaust_lap=self.gear.inside_lap,
                piston_travel=CRANK_END_TRAVEL,
                centre=0.0,
                stroke=2 * self.gear.crank,
                reverser=Reverser(key="dimensions.reverser", forward=1.0, back=-1.0),
            ),
        )

    @cached_property
    def _link_element(self) -> MassElement:
        """The link as a thin arc between the points in front of its pins, from the centre of the arc."""
        mass = (self.masses and self.masses.link) or self._placeholder_mass
        radius = self.gear.link_radius
        half_angle = math.asin(self.gear.half_link / self.gear.link_radius)
        return thin_arc(mass, radius, half_angle)

    @property
    def _centre_setback(self) -> float:
        """Distance of the link's mass centre from the middle of its arc, toward the shaft, m."""
        return self.gear.link_radius + self._link_element.centre[0]

    def _on_link(self, x: float, y: float) -> Point:
        """Return the point of the link with given coordinates from the middle of its arc, away from the shaft and up, m."""
        return Point(body=LINK, x=-x - self._centre_setback, y=y)

    def _bodies(self) -> Iterator[tuple[Body, tuple[float, float, float]]]:
        """Yield bodies with their poses at the start."""
        gear, angle = self.gear, self.gear.crank_start
        reverser = values_of(gear.reverser)[0]
        link = gear.geometry.solve_poses(np.array([angle]), reverser)
        x, y, link_angle = link[0].tolist()
        valve_x = float(gear.geometry.locate_die(link)[0][0])
        yield self._crank_body(), (0.0, 0.0, angle)
        yield Body(name=CROSSHEAD, mass=self._placeholder_mass, can_rotate=False), (-self._crosshead_distance(angle), 0.0, 0.0)
        valve_mass = (self.masses and self.masses.valve) or self._placeholder_mass
        yield Body(name=VALVE, mass=valve_mass, can_rotate=False), (-valve_x, 0.0, 0.0)
        along, up = rotate_point(-self._centre_setback, 0.0, link_angle)
        element = self._link_element
        yield Body(name=LINK, mass=element.mass, second_moments=element.moments), (-x - along, y + up, -link_angle)
        if isinstance(gear.reverser, PrescribedMotion):
            arm_x, arm_y = gear.geometry.hanger_top(reverser)
            yield Body(name=LIFTING_ARM, mass=self._placeholder_mass, can_rotate=False), (-arm_x, arm_y, 0.0)
        if self.masses and self.masses.eccentric_rod:
            yield from self._rod_bodies(self.masses.eccentric_rod, (x, y, link_angle))

    def _crank_body(self) -> Body:
        """Return the crank. Without a given inertia a driven one may have any; a free one must not have more than its parts."""
        if self.masses and self.masses.shaft_inertia is not None:
            return slider_crank.shaft_with_crank(self.masses.shaft_inertia)
        return slider_crank.placeholder_crank(self.gear.crank, self._moved_mass if self.gear.is_driven else 2 * PLACEHOLDER_MASS)

    @property
    def _moved_mass(self) -> float:
        """Mass that the crank moves, kg."""
        given = self.masses.link + 2 * self.masses.eccentric_rod + self.masses.valve if self.masses else 0.0
        return given or 2 * PLACEHOLDER_MASS

    @property
    def _placeholder_mass(self) -> float:
        """Mass of a part without mass, kg."""
        return max(PLACEHOLDER_MASS, PLACEHOLDER_MASS_RATIO * self._moved_mass)

    @cached_property
    def _hanger_top(self) -> Point:
        """End of the hanger: on the lifting arm, if the reversing lever moves, or fixed."""
        if isinstance(self.gear.reverser, PrescribedMotion):
            return Point(body=LIFTING_ARM)
        x, y = self.gear.geometry.hanger_top(self.gear.reverser)
        return Point(body=GROUND, x=-x, y=y)

    def _rod_bodies(self, mass: float, link: tuple[float, float, float]) -> Iterator[tuple[Body, tuple[float, float, float]]]:
        """Yield both eccentric rods with their poses, for a pose of the link in coordinates of the valve line (m, m, rad)."""
        gear = self.gear
        moments = slender_rod(mass, (gear.eccentric_rod, 0.0)).moments
        eccentrics = gear.geometry.eccentrics(np.array([gear.crank_start]))[0].tolist()
        for name, (start_x, start_y), pin in zip(self._rod_names, eccentrics, gear.geometry.pins, strict=True):
            arm_x, arm_y = rotate_point(*pin, link[2])
            end_x, end_y = link[0] + arm_x, link[1] + arm_y
            pose = -0.5 * (start_x + end_x), 0.5 * (start_y + end_y), math.atan2(end_y - start_y, start_x - end_x)
            yield Body(name=name, mass=mass, second_moments=moments), pose

    @property
    def _rod_names(self) -> tuple[str, ...]:
        """Names of the rods of the upper and the lower pin."""
        return ROD_NAMES[::-1] if self.gear.geometry.crossed else ROD_NAMES

    def _crosshead_distance(self, angle: float) -> float:
        """Return the distance of the crosshead from the shaft at a crank angle (rad), m; with an infinite rod, from its middle."""
        along, across = rotate_point(-self.gear.crank, 0.0, angle)
        return along + (0.0 if self.gear.connecting_rod is None else math.sqrt(self.gear.connecting_rod**2 - across**2))

    def _joints(self) -> Iterator[Joint]:
        """Yield the joints of engine, link, lifting arm and valve."""
        gear, ground = self.gear, Point(body=GROUND)
        crosshead, valve = Point(body=CROSSHEAD), Point(body=VALVE)
        yield from slider_crank.crank_joints(gear.crank_speed, gear.crank_start)
        yield slider_crank.rod_joint(slider_crank.CONNECTING_ROD, Point(body=CRANK, x=gear.crank), crosshead, gear.connecting_rod)
        yield Slider(name=slider_crank.CROSSHEAD_GUIDE, first=ground, second=crosshead, angle=0.0)
        eccentrics = gear.geometry.eccentrics(np.array([0.0]))[0].tolist()
        for name, (x, y), pin in zip(self._rod_names, eccentrics, gear.geometry.pins, strict=True):
            yield from self._rod_joints(name, Point(body=CRANK, x=-x, y=y), self._on_link(*pin))
        suspension = self._on_link(*gear.geometry.suspension)
        yield Distance(name=HANGER, first=self._hanger_top, second=suspension, length=gear.hanger)
        if isinstance(gear.reverser, PrescribedMotion):
            yield from self._lever_joints(gear.reverser)
        yield ArcSlot(name=LINK_SLOT, first=self._on_link(-gear.link_radius, 0.0), second=valve, radius=gear.link_radius)
        yield Slider(name=VALVE_GUIDE, first=ground, second=valve, angle=0.0)

    def _rod_joints(self, name: str, eccentric: Point, pin: Point) -> list[Joint]:
        """Return the pins of an eccentric rod with mass, or the distance that stands for a massless one."""
        if not (self.masses and self.masses.eccentric_rod):
            return [Distance(name=name, first=eccentric, second=pin, length=self.gear.eccentric_rod)]
        ends = [Point(body=name, x=x) for x in (-0.5 * self.gear.eccentric_rod, 0.5 * self.gear.eccentric_rod)]
        return [Pin(name=f"{name}, eccentric", first=eccentric, second=ends[0]), Pin(name=f"{name}, pin", first=ends[1], second=pin)]

    def _lever_joints(self, reverser: PrescribedMotion) -> list[Joint]:
        """Return the guide of the lifting arm, and what moves it up and down with the reversing lever."""
        geometry, arm = self.gear.geometry, Point(body=LIFTING_ARM)
        base = Point(body=GROUND, x=-geometry.hanger_top(0.0)[0])
        heights = tuple(geometry.hanger_top(value)[1] for value in reverser.values)
        return [
            Slider(name=LEVER_GUIDE, first=base, second=arm, angle=math.pi / 2),
            TranslationalDriver(name=LEVER, first=base, second=arm, motion=replace(reverser, values=heights), angle=math.pi / 2),
        ]

    def _readings(self) -> tuple[Reading, ...]:
        """Return crank angle, displacements of valve and die, link angle, lever, and piston and ports as those of the slide valve."""
        gear = self.gear
        valve = Point(body=VALVE)
        full_offset = self.gear.geometry.nominal_offset(1.0)
        centre = gear.valve_centre
        return (
            BodyAngle(name="crank_angle", quantity="angle", body=CRANK),
            x_coordinate(VALVE_DISPLACEMENT, valve, sign=-1.0, zero=centre),
            ArcPosition(
                name="die_slip",
                quantity="length",
                centre=self._on_link(-gear.link_radius, 0.0),
                point=valve,
                radius=-gear.link_radius,
                angle=math.pi,
            ),
            BodyAngle(name="link_angle", quantity="angle", body=LINK),
            PointCoordinate(
                name="reverser",
                quantity="ratio",
                point=self._hanger_top,
                direction_x=0.0,
                direction_y=-1.0 / full_offset,
                zero=-gear.geometry.hanger_top(0.0)[1] / full_offset,
            ),
            *piston_readings(Point(body=CROSSHEAD), gear.crank, (gear.connecting_rod or 0.0) - gear.crank, side=-1.0),
            *port_readings(valve, centre, gear.outside_lap, gear.inside_lap, side=-1.0),
        )

    def _limits(self) -> Iterator[Limit]:
        """Yield the ends of the slot, if it has ends."""
        half_length = self.gear.slot_half_length
        if half_length is not None:
            angle = self.gear.slot_exit_angle()
            where = "" if angle is None else f" at a crank angle of {math.degrees(angle):.4f} deg"
            low, high = (f"the die block runs out of the {end} end of the slot{where}" for end in ("lower", "upper"))
            yield Limit(reading="die_slip", low=-half_length, high=half_length, low_message=low, high_message=high)

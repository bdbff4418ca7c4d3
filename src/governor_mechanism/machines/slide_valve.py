"""Slide valve: an eccentric drives the valve and a crank the piston, by rods of finite or infinite length.

The crank angle is measured from the dead centre at which the piston is nearest to the shaft. That end of the cylinder is the crank end,
the other the head end. The eccentric leads the crank by a right angle plus the angle of advance. The valve admits steam with its outer
edges: to the crank end while its displacement away from the shaft exceeds the outside lap, and to the head end while its displacement
toward the shaft does. After Müller-Melchiors on Marks' construction, Dinglers Polytechnisches Journal 241 (1881), p. 161.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from governor_mechanism.machines import slider_crank
from governor_mechanism.machines.base import Machine, rotate_point, x_coordinate
from governor_mechanism.machines.slider_crank import (
    CRANK_END_TRAVEL,
    CROSSHEAD,
    STEAM_READING_MEANINGS,
    VALVE,
    VALVE_DISPLACEMENT,
    advance_problems,
    piston_readings,
    port_readings,
    rod_length_problems,
)
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import BodyAngle, Reading
from governor_mechanism.model.part import FIXED_PLANE
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import EQUAL_LEADS, MIDDLE, Valve
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.units.fields import entry, optional, quantity

ECCENTRIC_ROD, VALVE_GUIDE = "eccentric rod", "valve guide"

EQUAL_CUT_OFFS = "equal cut-offs"


rod_field = partial(optional, "length", words=("endless",))
"""Declare the length of a rod that may be left out."""


@dataclass(frozen=True, kw_only=True)
class SlideValve(Machine):
    """Slide valve. Lengths in m, angles in rad, constant crank speed in rad/s; an omitted rod is infinitely long.

    Attributes
    ----------
    crank
        Crank radius, m: half the stroke.
    connecting_rod
        Length of the connecting rod, m; None if infinite.
    eccentric
        Eccentricity, m: half the travel of the valve.
    eccentric_rod
        Length of the eccentric rod, m; None if infinite.
    advance
        Angle of advance, rad.
    outside_lap
        Outside lap, m.
    inside_lap
        Inside lap, m; negative leaves the ports open in mid position.
    crank_speed
        Crank speed, rad/s.
    crank_start
        Crank angle at the start, rad.
    setting
        Rule for the centre of the valve's motion: equal leads, middle of extremes, or equal cut-offs.
    """

    name: ClassVar[str] = "slide_valve"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "crank_angle": "angle of the crank from the dead centre at the crank end, continuous over full turns",
        **STEAM_READING_MEANINGS,
    }
    plane: ClassVar[str] = FIXED_PLANE
    driver_dimensions: ClassVar[tuple[str, ...]] = ("crank_speed", "crank_start")

    crank: float = quantity("length", meaning="from the shaft to the crank pin: half the stroke")
    connecting_rod: float | None = rod_field(meaning="from the crank pin to the crosshead; endless if left out")
    eccentric: float = quantity("length", meaning="from the shaft to the eccentric's centre: half the valve's travel")
    eccentric_rod: float | None = rod_field(meaning="from the eccentric's centre to the valve; endless if left out")
    advance: float = quantity("angle", sign="any", meaning="by which the eccentric runs ahead of a right angle to the crank")
    outside_lap: float = quantity("length", sign="any", meaning="by which the valve in its middle covers the outer edges")
    inside_lap: float = quantity("length", sign="any", default=0.0, meaning="by which it covers the inner edges; negative leaves them open")
    crank_speed: float = quantity("angular_speed", meaning="of the crank, which is driven")
    crank_start: float = quantity("angle", sign="any", default=0.0, meaning="of the crank at the start")
    setting: str = entry(
        "choice", words=(EQUAL_LEADS, MIDDLE, EQUAL_CUT_OFFS), default=EQUAL_LEADS, meaning="rule for the centre of the valve's motion"
    )

    def dimension_problems(self) -> list[str]:
        """Return sentences about rods, angle of advance, laps and ports."""
        problems = [*rod_length_problems(self, {"connecting_rod": "crank", "eccentric_rod": "eccentric"}), *self._turning_problems()]
        # The ports can only be tested for valid rods and laps.
        return problems or [*self._port_problems()]

    def _turning_problems(self) -> Iterator[str]:
        """Yield sentences about a wrong angle of advance and laps larger than the travel of the valve."""
        yield from advance_problems(self.advance)
        for name, lap in (("outside_lap", self.outside_lap), ("inside_lap", self.inside_lap)):
            if abs(lap) >= self.eccentric:
                yield (
                    f"{name} ({lap * 1e3:.6g} mm) must be smaller than the valve's travel to each side "
                    f"({self.eccentric * 1e3:.6g} mm), or its ports never open or never close; reduce it, or enlarge "
                    "eccentric"
                )

    def _port_problems(self) -> Iterator[str]:
        """Yield sentences about ports that never open or never close."""
        # The valve is at its extremes at the dead centres of the eccentric, whatever the rod.
        out = self.eccentric - self._centre_offset
        back = self.eccentric + self._centre_offset
        openings = {
            "crank end's steam port": (out, back, self.outside_lap),
            "head end's steam port": (back, out, self.outside_lap),
            "crank end's exhaust": (back, out, self.inside_lap),
            "head end's exhaust": (out, back, self.inside_lap),
        }
        for port, (opening, closing, lap) in openings.items():
            missing_event, displacement = ("opens", opening) if opening <= lap else ("closes", closing)
            if opening <= lap or closing <= -lap:
                yield (
                    f"the {port} never {missing_event}: set for {self.setting}, the valve moves {displacement * 1e3:.6g} mm that way, "
                    f"and its lap is {lap * 1e3:.6g} mm; change the lap, or take another setting"
                )

    @property
    def valve_centre(self) -> float:
        """Centre of the valve's motion from the shaft, m; with an infinite rod, from the middle of its extremes."""
        return (self.eccentric_rod or 0.0) + self._centre_offset

    @property
    def _centre_offset(self) -> float:
        """Position of the centre relative to the middle of the extremes, m."""
        if self.setting == MIDDLE:
            return 0.0
        if self.setting == EQUAL_LEADS:
            return 0.5 * (self._valve_displacement(0.0) + self._valve_displacement(math.pi))
        return self._offset_for_equal_cut_offs()

    def _valve_displacement(self, angle: float) -> float:
        """Return the position of the valve relative to the middle of its extremes at a crank angle (rad), m."""
        along, across = rotate_point(0.0, self.eccentric, -angle - self.advance)
        return along - _shortening(self.eccentric_rod, across)

    def _piston_displacement(self, angle: float) -> float:
        """Return the displacement of the piston from the crank end at a crank angle (rad), m."""
        along, across = rotate_point(self.crank, 0.0, angle)
        return self.crank - along - _shortening(self.connecting_rod, across)

    def _offset_for_equal_cut_offs(self) -> float:
        """Return the offset for cut-off after equal parts of the stroke at both ends, m."""

        def cut_off_difference(offset: float) -> float:
            crank_end_cut_off = self._piston_displacement(self._crank_angle_at(offset + self.outside_lap, rising=False))
            head_end_cut_off = 2 * self.crank - self._piston_displacement(self._crank_angle_at(offset - self.outside_lap, rising=True))
            return head_end_cut_off - crank_end_cut_off

        reach = self.eccentric - abs(self.outside_lap)
        return find_root(cut_off_difference, -reach, reach)

    def _crank_angle_at(self, displacement: float, *, rising: bool) -> float:
        """Return the crank angle (rad) at which the valve passes a position (m) relative to the middle of its extremes."""
        # Between its dead centres the displacement is monotonic.
        outermost_angle = math.pi / 2 - self.advance
        innermost_angle = outermost_angle - math.pi if rising else outermost_angle + math.pi
        return find_root(lambda angle: self._valve_displacement(angle) - displacement, innermost_angle, outermost_angle)

    def mechanism(self) -> Mechanism:
        """Build crank with eccentric, valve and crosshead from placeholder masses. An infinite rod is a crossed slide."""
        ground, pin = Point(body=GROUND), Point(body=slider_crank.CRANK, x=-self.crank)
        eccentric = replace(pin, x=self.eccentric * math.sin(self.advance), y=-self.eccentric * math.cos(self.advance))
        sliding_bodies = [Body(name=name, mass=slider_crank.PLACEHOLDER_MASS, can_rotate=False) for name in (CROSSHEAD, VALVE)]
        crosshead, valve = (Point(body=body.name) for body in sliding_bodies)
        angle = self.crank_start
        crosshead_x = (self.connecting_rod or 0.0) + self._piston_displacement(angle) - self.crank
        valve_x = (self.eccentric_rod or 0.0) + self._valve_displacement(angle)
        return Mechanism(
            bodies=(slider_crank.placeholder_crank(self.crank, 2 * slider_crank.PLACEHOLDER_MASS), *sliding_bodies),
            joints=(
                *slider_crank.crank_joints(self.crank_speed, angle),
                slider_crank.rod_joint(slider_crank.CONNECTING_ROD, pin, crosshead, self.connecting_rod),
                Slider(name=slider_crank.CROSSHEAD_GUIDE, first=ground, second=crosshead, angle=0.0),
                slider_crank.rod_joint(ECCENTRIC_ROD, eccentric, valve, self.eccentric_rod),
                Slider(name=VALVE_GUIDE, first=ground, second=valve, angle=0.0),
            ),
            readings=self._readings(crosshead, valve),
            coordinate="crank_angle",
            length_scale=self.crank,
            initial_guess=((0.0, 0.0, angle), (crosshead_x, 0.0, 0.0), (valve_x, 0.0, 0.0)),
            valve=Valve(
                displacement=VALVE_DISPLACEMENT,
                steam_lap=self.outside_lap,
                exhaust_lap=self.inside_lap,
                piston_travel=CRANK_END_TRAVEL,
                centre=0.0,
                stroke=2 * self.crank,
            ),
        )

    def _readings(self, crosshead: Point, valve: Point) -> tuple[Reading, ...]:
        """Return crank angle, valve displacement, piston displacements and port openings (negative: closed)."""
        return (
            BodyAngle(name="crank_angle", quantity="angle", body=slider_crank.CRANK),
            x_coordinate(VALVE_DISPLACEMENT, valve, zero=self.valve_centre),
            *piston_readings(crosshead, self.crank, (self.connecting_rod or 0.0) - self.crank),
            *port_readings(valve, self.valve_centre, self.outside_lap, self.inside_lap),
        )

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI; an omitted rod is infinite. `centre` is the centre of the valve's motion."""
        return super().dimensions() | {"centre": self.valve_centre}


def valve_setting(scene: Scene) -> str:
    """Return the rule for the centre of the valve's motion in the scene file; empty for a scene without a file."""
    dimensions = scene.document.get("dimensions", {})
    return str(dimensions.get("setting", SlideValve.setting)) if dimensions else ""


def prescribed_centre(scene: Scene) -> float | None:
    """Return the centre of the valve's motion, m; None for equal leads, for which the closed form has its own."""
    return None if valve_setting(scene) == EQUAL_LEADS else scene.part.dimensions["centre"]


def _shortening(rod: float | None, across: float) -> float:
    """Return how much nearer its inclination moves the far end of a rod if its near end is `across` beside the line, m."""
    return 0.0 if rod is None else across**2 / (rod + math.sqrt(rod**2 - across**2))

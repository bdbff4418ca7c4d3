"""Slider crank: a driven crank, a connecting rod, and a crosshead on a line through the shaft.

The crank angle is measured anticlockwise from the outer dead centre, at which the crosshead is farthest from the shaft. Parts are
massless unless the effect `masses` gives them mass; then the bearings carry the inertia forces.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines import driven_crank
from governor_mechanism.machines.base import Machine, rotate_point, x_coordinate
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle
from governor_mechanism.model.part import FIXED_PLANE
from governor_mechanism.units.fields import quantity


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
        crank_pin = Point(body=driven_crank.CRANK, x=self.crank - crank_centre)
        rod_ends = [Point(body=driven_crank.CONNECTING_ROD, x=x) for x in (-rod_centre, self.connecting_rod - rod_centre)]
        crosshead = Point(body=driven_crank.CROSSHEAD) if driven_crank.CROSSHEAD in bodies else rod_ends[1]
        poses = self._initial_poses(crank_centre, rod_centre)
        return Mechanism(
            bodies=tuple(bodies.values()),
            joints=(
                *driven_crank.crank_joints(self.crank_speed, self.crank_start, crank_centre),
                *self._rod_joints(crank_pin, rod_ends if driven_crank.CONNECTING_ROD in bodies else [], crosshead),
                Slider(name=driven_crank.CROSSHEAD_GUIDE, first=Point(body=GROUND), second=crosshead, angle=0.0),
            ),
            readings=(
                BodyAngle(name="crank_angle", quantity="angle", body=driven_crank.CRANK),
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
            return [Distance(name=driven_crank.CONNECTING_ROD, first=crank_pin, second=crosshead, length=self.connecting_rod)]
        pins = ((driven_crank.CRANK_PIN, crank_pin, rod_ends[0]), (driven_crank.GUDGEON_PIN, rod_ends[1], crosshead))
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
            yield driven_crank.placeholder_crank(self.crank, driven_crank.PLACEHOLDER_MASS)
        else:
            yield Body(name=driven_crank.CRANK, mass=masses.crank, second_moments=SecondMoments(xx=masses.crank * self.crank**2 / 12))
        if masses and masses.rod:
            rod_moments = SecondMoments(xx=masses.rod_inertia or masses.rod * self.connecting_rod**2 / 12)
            yield Body(name=driven_crank.CONNECTING_ROD, mass=masses.rod, second_moments=rod_moments)
        crosshead_mass = masses.crosshead if masses else 0.0
        if crosshead_mass or not (masses and masses.rod):
            yield Body(name=driven_crank.CROSSHEAD, mass=crosshead_mass or driven_crank.PLACEHOLDER_MASS, can_rotate=False)

    def _initial_poses(self, crank_centre: float, rod_centre: float) -> dict[str, tuple[float, float, float]]:
        """Return the poses of crank, rod and crosshead at the start by name, from the positions of the mass centres (m)."""
        angle = self.crank_start
        pin_x, pin_y = rotate_point(self.crank, 0.0, angle)
        rod_angle = -math.asin(pin_y / self.connecting_rod)
        across, up = rotate_point(rod_centre, 0.0, rod_angle)
        return {
            driven_crank.CRANK: (*rotate_point(crank_centre, 0.0, angle), angle),
            driven_crank.CONNECTING_ROD: (pin_x + across, pin_y + up, rod_angle),
            driven_crank.CROSSHEAD: (pin_x + self.connecting_rod * math.cos(rod_angle), 0.0, 0.0),
        }


def rod_length_problems(machine: Machine, rods: Mapping[str, str]) -> list[str]:
    """Return sentences about rods (keys) too short for their cranks (values) to turn over; an infinite rod (None) never is."""
    lengths = [(rod, getattr(machine, rod), crank, getattr(machine, crank)) for rod, crank in rods.items()]
    return [
        f"{rod} ({length * 1e3:.6g} mm) must be longer than {crank} ({radius * 1e3:.6g} mm), or it cannot turn over; make it longer"
        for rod, length, crank, radius in lengths
        if length is not None and not length > radius
    ]

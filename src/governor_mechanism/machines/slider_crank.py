"""Slider crank: a driven crank, a connecting rod, and a crosshead on a line through the shaft.

The crank angle is measured anticlockwise from the outer dead centre, at which the crosshead is farthest from the shaft. Parts are
massless unless the effect `masses` gives them mass; then the bearings carry the inertia forces.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines import driven_crank
from governor_mechanism.machines.base import Machine, dimension_field, rotate_point, x_coordinate
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle
from governor_mechanism.model.part import FIXED_PLANE


@dataclass(frozen=True, kw_only=True)
class SliderCrank(Machine):
    """Slider crank. Lengths in m, angles in rad, constant crank speed in rad/s."""

    name: ClassVar[str] = "slider_crank"
    plane: ClassVar[str] = FIXED_PLANE
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (CrankMasses,)
    driver_dimensions: ClassVar[tuple[str, ...]] = ("crank_speed", "crank_start")

    crank: float = dimension_field("length", "from the shaft to the crank pin")
    connecting_rod: float = dimension_field("length", "from the crank pin to the crosshead")
    crank_speed: float = dimension_field("angular_speed", "of the crank, which is driven")
    crank_start: float = dimension_field("angle", "of the crank at the start, from the outer dead centre", default=0.0, signed=True)

    def dimension_problems(self) -> list[str]:
        """Return a sentence about a rod that is too short."""
        return rod_length_problems(self, {"connecting_rod": "crank"})

    def mechanism(self, masses: CrankMasses | None = None) -> Mechanism:
        """Build crank, rod and crosshead. A massless rod is a distance. Raise MechanismError for a mass centre beyond the rod."""
        parts = self._build_parts(masses)
        rod_end = Point(body=driven_crank.CROSSHEAD) if parts.crosshead else self._rod_end(parts)
        crank_pin = Point(body=driven_crank.CRANK, x=self.crank - parts.crank_centre)
        return Mechanism(
            bodies=tuple(body for body in (parts.crank, parts.rod, parts.crosshead) if body),
            joints=self._joints(parts, crank_pin, rod_end),
            readings=(
                BodyAngle(name="crank_angle", quantity="angle", body=driven_crank.CRANK),
                x_coordinate("crosshead_distance", rod_end),
                LineAngle(name="rod_angle", quantity="angle", start=crank_pin, end=rod_end, zero=math.pi / 2),
            ),
            coordinate="crank_angle",
            length_scale=self.crank,
            initial_guess=self._initial_guess(parts),
        )

    def _build_parts(self, masses: CrankMasses | None) -> _CrankTrainParts:
        """Return the parts. A massless part that is necessary gets a placeholder mass."""
        placeholder = Body(name=driven_crank.CROSSHEAD, mass=driven_crank.PLACEHOLDER_MASS, can_rotate=False)
        if masses is None:
            return _CrankTrainParts(crank=driven_crank.placeholder_crank(self.crank, driven_crank.PLACEHOLDER_MASS), crosshead=placeholder)
        rod_centre = 0.5 * self.connecting_rod if masses.rod_centre is None else masses.rod_centre
        if rod_centre > self.connecting_rod:
            raise MechanismError(
                f"masses.rod_centre ({rod_centre * 1e3:.6g} mm) lies beyond the crosshead; it is measured from the crank "
                f"pin, and connecting_rod is {self.connecting_rod * 1e3:.6g} mm"
            )
        rod_moments = SecondMoments(xx=masses.rod_inertia or masses.rod * self.connecting_rod**2 / 12)
        rod = Body(name=driven_crank.CONNECTING_ROD, mass=masses.rod, second_moments=rod_moments) if masses.rod else None
        needs_crosshead = masses.crosshead or not rod
        crosshead = replace(placeholder, mass=masses.crosshead or placeholder.mass) if needs_crosshead else None
        crank_moments = SecondMoments(xx=masses.crank * self.crank**2 / 12)
        crank = Body(name=driven_crank.CRANK, mass=masses.crank, second_moments=crank_moments)
        return _CrankTrainParts(crank=crank, crank_centre=masses.crank_centre, rod=rod, rod_centre=rod_centre, crosshead=crosshead)

    def _rod_end(self, parts: _CrankTrainParts) -> Point:
        return Point(body=driven_crank.CONNECTING_ROD, x=self.connecting_rod - parts.rod_centre)

    def _joints(self, parts: _CrankTrainParts, crank_pin: Point, rod_end: Point) -> tuple[Joint, ...]:
        joints = [*driven_crank.crank_joints(self.crank_speed, self.crank_start, parts.crank_centre)]
        if not parts.rod:
            joints.append(Distance(name=driven_crank.CONNECTING_ROD, first=crank_pin, second=rod_end, length=self.connecting_rod))
        else:
            joints.append(
                Pin(name=driven_crank.CRANK_PIN, first=crank_pin, second=Point(body=driven_crank.CONNECTING_ROD, x=-parts.rod_centre))
            )
            joints += [Pin(name=driven_crank.GUDGEON_PIN, first=self._rod_end(parts), second=rod_end)] if parts.crosshead else []
        return *joints, Slider(name=driven_crank.CROSSHEAD_GUIDE, first=Point(body=GROUND), second=rod_end, angle=0.0)

    def _initial_guess(self, parts: _CrankTrainParts) -> tuple[tuple[float, float, float], ...]:
        angle = self.crank_start
        pin_x, pin_y = rotate_point(self.crank, 0.0, angle)
        rod_angle = -math.asin(pin_y / self.connecting_rod)
        across, up = rotate_point(parts.rod_centre, 0.0, rod_angle)
        crank_pose = (*rotate_point(parts.crank_centre, 0.0, angle), angle)
        rod_pose = (pin_x + across, pin_y + up, rod_angle)
        crosshead_pose = (pin_x + self.connecting_rod * math.cos(rod_angle), 0.0, 0.0)
        poses = ((parts.crank, crank_pose), (parts.rod, rod_pose), (parts.crosshead, crosshead_pose))
        return tuple(pose for body, pose in poses if body)


@dataclass(frozen=True, kw_only=True)
class _CrankTrainParts:
    """Parts of the mechanism; a rod or crosshead without mass is no body."""

    crank: Body
    crosshead: Body | None
    crank_centre: float = 0.0
    rod: Body | None = None
    rod_centre: float = 0.0


def rod_length_problems(machine: Machine, rods: Mapping[str, str]) -> list[str]:
    """Return sentences about rods (keys) too short for their cranks (values) to turn over; an infinite rod (None) never is."""
    lengths = [(rod, getattr(machine, rod), crank, getattr(machine, crank)) for rod, crank in rods.items()]
    return [
        f"{rod} ({length * 1e3:.6g} mm) must be longer than {crank} ({radius * 1e3:.6g} mm), or it cannot turn over; make it longer"
        for rod, length, crank, radius in lengths
        if length is not None and not length > radius
    ]

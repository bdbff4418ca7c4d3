"""Slider crank: a driven crank, a connecting rod, and a crosshead on a line through the shaft.

The crank angle is measured anticlockwise from the outer dead centre, at which the crosshead is farthest from the shaft. Parts are
massless unless the effect `masses` gives them mass; then the bearings carry the inertia forces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension_field, rotate_point
from governor_mechanism.machines.driven_crank import (
    CONNECTING_ROD,
    CRANK,
    CRANK_PIN,
    CROSSHEAD,
    CROSSHEAD_GUIDE,
    GUDGEON_PIN,
    PLACEHOLDER_MASS,
    driven_crank_joints,
    placeholder_crank,
)
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate
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

    def __post_init__(self) -> None:
        super().__post_init__()
        if sentence := rod_length_problem(self.connecting_rod, self.crank, "connecting_rod", "crank"):
            raise MechanismError(sentence)

    def mechanism(self, masses: CrankMasses | None = None) -> Mechanism:
        """Build crank, rod and crosshead. A massless rod is a distance. Raise MechanismError for a mass centre beyond the rod."""
        parts = self._build_parts(masses)
        rod_end = Point(body=CROSSHEAD) if parts.crosshead_mass else Point(body=CONNECTING_ROD, x=self.connecting_rod - parts.rod_centre)
        crank_pin = Point(body=CRANK, x=self.crank - parts.crank_centre)
        return Mechanism(
            bodies=self._bodies(parts),
            joints=self._joints(parts, crank_pin, rod_end),
            readings=(
                BodyAngle(name="crank_angle", quantity="angle", body=CRANK),
                PointCoordinate(name="crosshead_distance", quantity="length", point=rod_end, direction_x=1.0, direction_y=0.0),
                LineAngle(name="rod_angle", quantity="angle", start=crank_pin, end=rod_end, zero=math.pi / 2),
            ),
            coordinate="crank_angle",
            length_scale=self.crank,
            initial_guess=self._initial_guess(parts),
        )

    def _build_parts(self, masses: CrankMasses | None) -> _CrankTrainParts:
        """Return the parts. A massless part that is necessary gets a placeholder mass."""
        if masses is None:
            return _CrankTrainParts(crank=placeholder_crank(self.crank, PLACEHOLDER_MASS), crosshead_mass=PLACEHOLDER_MASS)
        rod_centre = 0.5 * self.connecting_rod if masses.rod_centre is None else masses.rod_centre
        if rod_centre > self.connecting_rod:
            raise MechanismError(
                f"masses.rod_centre ({rod_centre * 1e3:.6g} mm) lies beyond the crosshead; it is measured from the crank "
                f"pin, and connecting_rod is {self.connecting_rod * 1e3:.6g} mm"
            )
        crank_moments = SecondMoments(xx=masses.crank * self.crank**2 / 12)
        return _CrankTrainParts(
            crank=Body(name=CRANK, mass=masses.crank, second_moments=crank_moments),
            crank_centre=masses.crank_centre,
            rod_mass=masses.rod,
            rod_centre=rod_centre,
            rod_inertia=masses.rod_inertia or masses.rod * self.connecting_rod**2 / 12,
            crosshead_mass=masses.crosshead or (0.0 if masses.rod else PLACEHOLDER_MASS),
        )

    def _bodies(self, parts: _CrankTrainParts) -> tuple[Body, ...]:
        bodies = [parts.crank]
        if parts.rod_mass:
            bodies.append(Body(name=CONNECTING_ROD, mass=parts.rod_mass, second_moments=SecondMoments(xx=parts.rod_inertia)))
        if parts.crosshead_mass:
            bodies.append(Body(name=CROSSHEAD, mass=parts.crosshead_mass, can_rotate=False))
        return tuple(bodies)

    def _joints(self, parts: _CrankTrainParts, crank_pin: Point, rod_end: Point) -> tuple[Joint, ...]:
        joints = [*driven_crank_joints(self.crank_speed, self.crank_start, parts.crank_centre)]
        if parts.rod_mass:
            joints.append(Pin(name=CRANK_PIN, first=crank_pin, second=Point(body=CONNECTING_ROD, x=-parts.rod_centre)))
            if parts.crosshead_mass:
                gudgeon_on_rod = Point(body=CONNECTING_ROD, x=self.connecting_rod - parts.rod_centre)
                joints.append(Pin(name=GUDGEON_PIN, first=gudgeon_on_rod, second=rod_end))
        else:
            joints.append(Distance(name=CONNECTING_ROD, first=crank_pin, second=rod_end, length=self.connecting_rod))
        joints.append(Slider(name=CROSSHEAD_GUIDE, first=Point(body=GROUND), second=rod_end, angle=0.0))
        return tuple(joints)

    def _initial_guess(self, parts: _CrankTrainParts) -> tuple[tuple[float, float, float], ...]:
        angle = self.crank_start
        pin_x, pin_y = rotate_point(self.crank, 0.0, angle)
        rod_angle = -math.asin(pin_y / self.connecting_rod)
        across, up = rotate_point(parts.rod_centre, 0.0, rod_angle)
        reach = self.connecting_rod * math.cos(rod_angle)
        poses = [(*rotate_point(parts.crank_centre, 0.0, angle), angle)]
        poses += [(pin_x + across, pin_y + up, rod_angle)] if parts.rod_mass else []
        poses += [(pin_x + reach, 0.0, 0.0)] if parts.crosshead_mass else []
        return tuple(poses)


@dataclass(frozen=True, kw_only=True)
class _CrankTrainParts:
    """Parts of the mechanism; a rod or crosshead without mass is no body."""

    crank: Body
    crank_centre: float = 0.0
    rod_mass: float = 0.0
    rod_centre: float = 0.0
    rod_inertia: float = 0.0
    crosshead_mass: float = 0.0


def rod_length_problem(rod_length: float | None, radius: float, rod_name: str, radius_name: str) -> str:
    """Return a sentence about a rod too short for the crank to turn over; empty if it can, as with an infinite rod (None)."""
    if rod_length is None or rod_length > radius:
        return ""
    return (
        f"{rod_name} ({rod_length * 1e3:.6g} mm) must be longer than {radius_name} ({radius * 1e3:.6g} mm), "
        "or it cannot turn over; make it longer"
    )

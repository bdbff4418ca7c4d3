"""The slider crank: a driven crank, a connecting rod, a crosshead on a line through the shaft.

The crank angle counts anticlockwise from the outer dead centre, where the crosshead stands farthest from the shaft.
Parts are without mass unless the effect `masses` gives them some; then the bearings carry what their motion asks for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension, foreign_effects
from governor_mechanism.machines.driven_crank import (
    CRANK,
    CRANK_PIN,
    CROSSHEAD,
    GUDGEON,
    GUIDE,
    ROD,
    STAND_IN,
    driven_crank,
    massless_crank,
    turned,
)
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, BodyAngle, Coordinate, LineAngle, Mechanism, SecondMoments
from governor_mechanism.model.scene import FIXED


@dataclass(frozen=True, kw_only=True)
class SliderCrank(Machine):
    """Lengths in m, angles in rad, the crank's steady speed in rad/s."""

    name: ClassVar[str] = "slider_crank"
    plane: ClassVar[str] = FIXED
    driven: ClassVar[tuple[str, ...]] = ("crank_speed", "crank_start")

    crank: float = dimension("length", "from the shaft to the crank pin")
    connecting_rod: float = dimension("length", "from the crank pin to the crosshead")
    crank_speed: float = dimension("angular_speed", "of the crank, which is driven")
    crank_start: float = dimension(
        "angle", "of the crank at the start, from the outer dead centre", default=0.0, signed=True
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if sentence := short_rod(self.connecting_rod, self.crank, "connecting_rod", "crank"):
            raise MechanismError(sentence)

    def mechanism(self, masses: Masses | None = None) -> Mechanism:
        """Crank and crosshead, with a rod between them: a body where it has mass, a distance where it has none.

        Raises MechanismError for a mass that lies beyond the rod.
        """
        made = self._made(masses)
        end = Point(body=CROSSHEAD) if made.crosshead else Point(body=ROD, x=self.connecting_rod - made.rod_centre)
        pin = Point(body=CRANK, x=self.crank - made.crank_centre)
        return Mechanism(
            bodies=self._bodies(made),
            joints=self._joints(made, pin, end),
            readings=(
                BodyAngle(name="crank_angle", quantity="angle", body=CRANK),
                Coordinate(name="crosshead_distance", quantity="length", point=end, along_x=1.0, along_y=0.0),
                LineAngle(name="rod_angle", quantity="angle", start=pin, end=end, zero=math.pi / 2),
            ),
            coordinate="crank_angle",
            size=self.crank,
            sketch=self._sketch(made),
        )

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """About rods and play; masses this machine has."""
        return foreign_effects(cls.name, effects, has=(Masses,))

    def mechanism_with(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with the masses of a scene's effects."""
        listed = list(effects)
        if problems := self.effect_problems(listed):
            raise MechanismError(*problems)
        return self.mechanism(next((effect for effect in listed if isinstance(effect, Masses)), None))

    def dimensions(self) -> dict[str, float]:
        """All dimensions in SI."""
        return {
            "crank": self.crank,
            "connecting_rod": self.connecting_rod,
            "crank_speed": self.crank_speed,
            "crank_start": self.crank_start,
        }

    def _made(self, masses: Masses | None) -> _Made:
        """The parts as they are built; one without mass that cannot be left out gets a stand-in's."""
        if masses is None:
            return _Made(crank=massless_crank(self.crank, STAND_IN), crosshead=STAND_IN)
        centre = 0.5 * self.connecting_rod if masses.rod_centre is None else masses.rod_centre
        if centre > self.connecting_rod:
            raise MechanismError(
                f"masses.rod_centre ({centre * 1e3:.6g} mm) lies beyond the crosshead; it is counted from the crank "
                f"pin, and connecting_rod is {self.connecting_rod * 1e3:.6g} mm"
            )
        slender = SecondMoments(xx=masses.crank * self.crank**2 / 12)
        return _Made(
            crank=Body(name=CRANK, mass=masses.crank, moments=slender),
            crank_centre=masses.crank_centre,
            rod=masses.rod,
            rod_centre=centre,
            rod_inertia=masses.rod_inertia or masses.rod * self.connecting_rod**2 / 12,
            crosshead=masses.crosshead or (0.0 if masses.rod else STAND_IN),
        )

    def _bodies(self, made: _Made) -> tuple[Body, ...]:
        bodies = [made.crank]
        if made.rod:
            bodies.append(Body(name=ROD, mass=made.rod, moments=SecondMoments(xx=made.rod_inertia)))
        if made.crosshead:
            bodies.append(Body(name=CROSSHEAD, mass=made.crosshead, turns=False))
        return tuple(bodies)

    def _joints(self, made: _Made, pin: Point, end: Point) -> tuple[Joint, ...]:
        joints = [*driven_crank(self.crank_speed, self.crank_start, made.crank_centre)]
        if made.rod:
            joints.append(Pin(name=CRANK_PIN, first=pin, second=Point(body=ROD, x=-made.rod_centre)))
            if made.crosshead:
                rod_end = Point(body=ROD, x=self.connecting_rod - made.rod_centre)
                joints.append(Pin(name=GUDGEON, first=rod_end, second=end))
        else:
            joints.append(Distance(name=ROD, first=pin, second=end, length=self.connecting_rod))
        joints.append(Slider(name=GUIDE, first=Point(body=GROUND), second=end, angle=0.0))
        return tuple(joints)

    def _sketch(self, made: _Made) -> tuple[tuple[float, float, float], ...]:
        angle = self.crank_start
        pin_x, pin_y = turned(self.crank, 0.0, angle)
        slope = -math.asin(pin_y / self.connecting_rod)
        across, up = turned(made.rod_centre, 0.0, slope)
        reach = self.connecting_rod * math.cos(slope)
        poses = [(*turned(made.crank_centre, 0.0, angle), angle)]
        poses += [(pin_x + across, pin_y + up, slope)] if made.rod else []
        poses += [(pin_x + reach, 0.0, 0.0)] if made.crosshead else []
        return tuple(poses)


@dataclass(frozen=True, kw_only=True)
class _Made:
    """What the mechanism is built of; a rod or crosshead of no mass is no body."""

    crank: Body
    crank_centre: float = 0.0
    rod: float = 0.0
    rod_centre: float = 0.0
    rod_inertia: float = 0.0
    crosshead: float = 0.0


def short_rod(rod: float | None, radius: float, rod_name: str, radius_name: str) -> str:
    """A sentence on a rod with which the crank cannot turn over; empty where it can, as with an endless one (None)."""
    if rod is None or rod > radius:
        return ""
    return (
        f"{rod_name} ({rod * 1e3:.6g} mm) must be longer than {radius_name} ({radius * 1e3:.6g} mm), "
        "or it cannot turn over; make it longer"
    )

"""Hartung's spring governor: two weights on bell cranks, a spring to each, hangers down to the sleeve.

Geometry after Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), p. 618. The plane turns with the spindle: x from
the spindle axis, y up, the governor's cross axis at y = 0. The lever angle is that of the weights' arm from upright,
positive toward the spindle: it is largest where the weights stand innermost.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension, foreign_effects
from governor_mechanism.machines.hartung.bodies import LEFT, RIGHT, SLEEVE, Parts
from governor_mechanism.machines.hartung.geometry import CURES, Way
from governor_mechanism.machines.hartung.spring import SpringLine, spring_line, spring_problems, stress_note
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Limit, Mechanism
from governor_mechanism.model.scene import TURNING
from governor_mechanism.units.quantities import spoken

__all__ = ["LEFT", "RIGHT", "SLEEVE", "HartungGovernor"]


@dataclass(frozen=True, kw_only=True)
class HartungGovernor(Machine):
    """Two weights as points on massless bell cranks, unless an effect gives these mass; a sleeve on hangers.

    Lengths in m, masses in kg, angles in rad, speeds in rad/s. The spring of each weight presses it inward, at its
    centre and level. It is given by its force at a radius, and its rate or its wire; or by the two speeds that hold the
    weights at the inner and at the outer end of the stroke, under 9.81 m/s2.
    """

    name: ClassVar[str] = "hartung"
    plane: ClassVar[str] = TURNING

    weight_arm: float = dimension("length", "from the fulcrum of a bell crank to its weight's centre")
    sleeve_arm: float = dimension("length", "from the fulcrum to the hanger")
    bell_crank_angle: float = dimension("angle", "between its two arms, 90 to 180 deg", default=math.pi / 2)
    fulcrum_radius: float = dimension("length", "of the fulcrum from the spindle axis")
    fulcrum_height: float | None = dimension(
        "length",
        "of the fulcrum above the cross axis; as far below as weight_arm is long, if left out",
        default=None,
        signed=True,
    )
    weight_mass: float = dimension("mass", "of one weight; there are two")
    sleeve_mass: float = dimension("mass", "of the whole sleeve and its load")
    hanger: float | None = dimension(
        "length", "of the hangers, from bell crank to sleeve", default=None, word="vertical"
    )
    lug_offset: float = dimension("length", "of the sleeve's lugs from the axis", default=0.0, signed=True)
    inner_angle: float | None = dimension(
        "angle", "of the lever at the inner end of the stroke", default=None, signed=True
    )
    outer_angle: float | None = dimension(
        "angle", "of the lever at the outer end of the stroke", default=None, signed=True
    )
    spring_rate: float | None = dimension("stiffness", "of each spring", default=None)
    spring_preload: float | None = dimension("force", "of each spring at preload_radius", default=None, signed=True)
    preload_radius: float | None = dimension(
        "length", "of a weight where spring_preload is its spring's force; fulcrum_radius if left out", default=None
    )
    spring_wire: float | None = dimension("length", "of each spring's wire, its diameter", default=None)
    spring_coil: float | None = dimension("length", "of each spring's coil, its mean diameter", default=None)
    spring_turns: float | None = dimension("number", "of each spring's turns that work", default=None)
    spring_modulus: float | None = dimension("modulus", "of shear of the springs' wire", default=None, most=1e13)
    spring_stress_limit: float | None = dimension("pressure", "that the springs' wire may bear", default=None)
    inner_speed: float | None = dimension(
        "angular_speed", "that holds the weights at the inner end of the stroke", default=None
    )
    outer_speed: float | None = dimension(
        "angular_speed", "that holds the weights at the outer end of the stroke", default=None
    )
    insensitivity: float = dimension("ratio", "that the regulating force is reckoned with", default=0.04)

    def __post_init__(self) -> None:
        super().__post_init__()
        problems = [*self._angle_problems(), *self._stroke_problems(), *spring_problems(self)]
        if problems:
            raise MechanismError(*problems)
        self.spring()  # refuses two speeds that no spring holds

    @property
    def way(self) -> Way:
        """How weights, hangers and sleeve follow the lever angle."""
        return Way(
            weight_arm=self.weight_arm,
            sleeve_arm=self.sleeve_arm,
            angle=self.bell_crank_angle,
            fulcrum_radius=self.fulcrum_radius,
            hanger=self.hanger,
            lug_offset=self.lug_offset,
        )

    @property
    def fulcrum(self) -> float:
        """Height of the fulcrum above the cross axis (m)."""
        return -self.weight_arm if self.fulcrum_height is None else self.fulcrum_height

    def spring(self) -> SpringLine:
        """Each spring's force over the radius of its weight."""
        return spring_line(self)

    def mechanism(self, cranks: BellCranks | None = None) -> Mechanism:
        """Weights on levers, the sleeve on its guide, hangers between them; with cranks these have mass and size."""
        parts = Parts(governor=self, cranks=cranks)
        low, high, below, above = self.way.travel(self._middle)
        note = stress_note(self)
        return Mechanism(
            bodies=parts.bodies(),
            joints=parts.joints(),
            readings=parts.readings(self.inner_angle or 0.0),
            outputs=parts.outputs(),
            coordinate="lever_angle",
            size=max(self.weight_arm, self.sleeve_arm),
            sketch=parts.poses(self._middle),
            limits=(Limit(reading="lever_angle", low=low, high=high, below=below, above=above),),
            loads=(parts.spring(),),
            notes=(note,) if note else (),
        )

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """About rods, play and masses; bell cranks this machine has."""
        return foreign_effects(cls.name, effects, has=(BellCranks,))

    def mechanism_with(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with the bell cranks of a scene's effects."""
        listed = list(effects)
        problems = [*self.effect_problems(listed), *self._stop_problems(listed)]
        if problems:
            raise MechanismError(*problems)
        return self.mechanism(next((effect for effect in listed if isinstance(effect, BellCranks)), None))

    def dimensions(self) -> dict[str, float]:
        """All dimensions in SI; the spring as its rate and its force at preload_radius, a vertical hanger infinite."""
        spring = self.spring()
        return {
            "weight_arm": self.weight_arm,
            "sleeve_arm": self.sleeve_arm,
            "bell_crank_angle": self.bell_crank_angle,
            "fulcrum_radius": self.fulcrum_radius,
            "fulcrum_height": self.fulcrum,
            "weight_mass": self.weight_mass,
            "sleeve_mass": self.sleeve_mass,
            "hanger": math.inf if self.hanger is None else self.hanger,
            "lug_offset": self.lug_offset,
            "spring_rate": spring.rate,
            "spring_preload": spring.preload,
            "preload_radius": spring.radius,
            "insensitivity": self.insensitivity,
        }

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """A start angle outside the travel."""
        angle = values.get("lever_angle")
        low, high, below, above = self.way.travel(self._middle)
        if not isinstance(angle, float) or low < angle < high:
            return ()
        allowed = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
        return (
            f"start.lever_angle ({math.degrees(angle):g} deg) lies outside the travel of this governor, {allowed}: "
            f"{below if angle <= low else above}{_in_degrees(angle, math.pi / 2, '10 deg')}",
        )

    @property
    def _middle(self) -> float:
        """The lever angle at mid stroke, or upright (rad)."""
        if self.inner_angle is None or self.outer_angle is None:
            return 0.0
        return 0.5 * (self.inner_angle + self.outer_angle)

    def _angle_problems(self) -> list[str]:
        degrees = math.degrees(self.bell_crank_angle)
        if 90.0 - 1e-9 <= degrees <= 180.0:
            return []
        return [
            f"bell_crank_angle ({degrees:.6g} deg) must lie between 90 deg, Hartung's old right angle, and 180 deg, an "
            "arm in line with the other: beyond them the weights' way out does not lift the sleeve"
            f"{_in_degrees(self.bell_crank_angle, math.tau, '132 deg')}"
        ]

    def _stroke_problems(self) -> list[str]:
        """A stroke the wrong way round, or one that the lever or the hanger cannot go through."""
        if self.inner_angle is None or self.outer_angle is None:
            ends = {"inner_angle": self.inner_angle, "outer_angle": self.outer_angle}
            missing = [name for name, value in ends.items() if value is None]
            stroke = [] if len(missing) == 2 else [f"{missing[0]} is missing; a stroke needs both of its ends"]
            return [*stroke, *self._reach_problems(0.0, 0.0)]
        if self.outer_angle >= self.inner_angle:
            return [
                f"inner_angle ({spoken(self.inner_angle, 'rad')}) must exceed outer_angle "
                f"({spoken(self.outer_angle, 'rad')}): the lever angle is positive toward the spindle; exchange them"
            ]
        return self._reach_problems(self.outer_angle, self.inner_angle)

    def _stop_problems(self, effects: Iterable[Effect]) -> list[str]:
        """Stops of the lever that it cannot come to."""
        problems = []
        for stops in (one for one in effects if isinstance(one, Stops) and one.reading == "lever_angle"):
            ends = [self._middle, *(end for end in (stops.low, stops.high) if math.isfinite(end))]
            found = self.way.first_failure(min(ends), max(ends))
            if found is not None:
                problems.append(
                    f"the stops of 'lever_angle' lie too far apart: at {spoken(found[0], 'rad')} {found[1]}; "
                    "move them nearer"
                )
        return problems

    def _reach_problems(self, outer: float, inner: float) -> list[str]:
        found = None if self._angle_problems() else self.way.first_failure(outer, inner)
        if found is None:
            return []
        where, sentence = found
        hint = _in_degrees(max(inner, -outer), math.pi / 2, "15 deg") or f"; {CURES[sentence]}, or shorten the stroke"
        return [
            f"the stroke, lever_angle from {spoken(outer, 'rad')} to {spoken(inner, 'rad')}, cannot be gone through: "
            f"at {spoken(where, 'rad')} {sentence}{hint}"
        ]


def _in_degrees(angle: float, most: float, example: str) -> str:
    """A hint at the unit, for an angle (rad) larger than makes sense; else empty."""
    return f"; a bare number is in rad, so write it with its unit: {example}" if abs(angle) > most else ""

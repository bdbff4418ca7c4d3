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

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension_field, unsupported_effect_messages
from governor_mechanism.machines.hartung.bodies import LEFT_WEIGHT, RIGHT_WEIGHT, SLEEVE, HartungBuilder
from governor_mechanism.machines.hartung.geometry import FAILURE_HINTS, LeverGeometry
from governor_mechanism.machines.hartung.spring import LinearSpringLaw, build_spring_law, spring_problems, stress_warning
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Limit, Mechanism
from governor_mechanism.model.scene import TURNING_PLANE
from governor_mechanism.units.quantities import format_quantity

__all__ = ["LEFT_WEIGHT", "RIGHT_WEIGHT", "SLEEVE", "HartungGovernor"]


@dataclass(frozen=True, kw_only=True)
class HartungGovernor(Machine):
    """Two weights as points on massless bell cranks, unless an effect gives these mass; a sleeve on hangers.

    Lengths in m, masses in kg, angles in rad, speeds in rad/s. The spring of each weight presses it inward, at its
    centre and level. It is given by its force at a radius, and its rate or its wire; or by the two speeds that hold the
    weights at the inner and at the outer end of the stroke, under 9.81 m/s2.
    """

    name: ClassVar[str] = "hartung"
    plane: ClassVar[str] = TURNING_PLANE

    weight_arm: float = dimension_field("length", "from the fulcrum of a bell crank to its weight's centre")
    sleeve_arm: float = dimension_field("length", "from the fulcrum to the hanger")
    bell_crank_angle: float = dimension_field("angle", "between its two arms, 90 to 180 deg", default=math.pi / 2)
    fulcrum_radius: float = dimension_field("length", "of the fulcrum from the spindle axis")
    fulcrum_height: float | None = dimension_field(
        "length", "of the fulcrum above the cross axis; as far below as weight_arm is long, if left out", default=None, signed=True
    )
    weight_mass: float = dimension_field("mass", "of one weight; there are two")
    sleeve_mass: float = dimension_field("mass", "of the whole sleeve and its load")
    hanger: float | None = dimension_field("length", "of the hangers, from bell crank to sleeve", default=None, omission_word="vertical")
    lug_offset: float = dimension_field("length", "of the sleeve's lugs from the axis", default=0.0, signed=True)
    inner_angle: float | None = dimension_field("angle", "of the lever at the inner end of the stroke", default=None, signed=True)
    outer_angle: float | None = dimension_field("angle", "of the lever at the outer end of the stroke", default=None, signed=True)
    spring_rate: float | None = dimension_field("stiffness", "of each spring", default=None)
    spring_preload: float | None = dimension_field("force", "of each spring at preload_radius", default=None, signed=True)
    preload_radius: float | None = dimension_field(
        "length", "of a weight where spring_preload is its spring's force; fulcrum_radius if left out", default=None
    )
    spring_wire: float | None = dimension_field("length", "of each spring's wire, its diameter", default=None)
    spring_coil: float | None = dimension_field("length", "of each spring's coil, its mean diameter", default=None)
    spring_turns: float | None = dimension_field("number", "of each spring's turns that work", default=None)
    spring_modulus: float | None = dimension_field("modulus", "of shear of the springs' wire", default=None, max_size=1e13)
    spring_stress_limit: float | None = dimension_field("pressure", "that the springs' wire may bear", default=None)
    inner_speed: float | None = dimension_field("angular_speed", "that holds the weights at the inner end of the stroke", default=None)
    outer_speed: float | None = dimension_field("angular_speed", "that holds the weights at the outer end of the stroke", default=None)
    insensitivity: float = dimension_field("ratio", "that the regulating force is reckoned with", default=0.04)

    def __post_init__(self) -> None:
        super().__post_init__()
        problems = [*self._angle_problems(), *self._stroke_problems(), *spring_problems(self)]
        if problems:
            raise MechanismError(*problems)
        self.spring_law()  # refuses two speeds that no spring holds

    @property
    def lever_geometry(self) -> LeverGeometry:
        """How weights, hangers and sleeve follow the lever angle."""
        return LeverGeometry(
            weight_arm=self.weight_arm,
            sleeve_arm=self.sleeve_arm,
            bell_crank_angle=self.bell_crank_angle,
            fulcrum_radius=self.fulcrum_radius,
            hanger=self.hanger,
            lug_offset=self.lug_offset,
        )

    @property
    def fulcrum_y(self) -> float:
        """Height of the fulcrum above the cross axis (m)."""
        return -self.weight_arm if self.fulcrum_height is None else self.fulcrum_height

    def spring_law(self) -> LinearSpringLaw:
        """Each spring's force over the radius of its weight."""
        return build_spring_law(self)

    def mechanism(self, bell_cranks: BellCrankMasses | None = None) -> Mechanism:
        """Weights on levers, the sleeve on its guide, hangers between them; with cranks these have mass and size."""
        builder = HartungBuilder(governor=self, bell_cranks=bell_cranks)
        low, high, low_message, high_message = self.lever_geometry.travel_limits(self._middle_angle)
        note = stress_warning(self)
        return Mechanism(
            bodies=builder.bodies(),
            joints=builder.joints(),
            readings=builder.readings(self.inner_angle or 0.0),
            derived_forces=builder.outputs(),
            coordinate="lever_angle",
            length_scale=max(self.weight_arm, self.sleeve_arm),
            initial_guess=builder.poses(self._middle_angle),
            limits=(Limit(reading="lever_angle", low=low, high=high, low_message=low_message, high_message=high_message),),
            force_elements=(builder.spring(),),
            notes=(note,) if note else (),
        )

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """About rods, play and masses; bell cranks this machine has."""
        return unsupported_effect_messages(cls.name, effects, supported=(BellCrankMasses,))

    def mechanism_with_effects(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with the bell cranks of a scene's effects."""
        listed = list(effects)
        problems = [*self.effect_problems(listed), *self.stop_problems(listed)]
        if problems:
            raise MechanismError(*problems)
        return self.mechanism(next((effect for effect in listed if isinstance(effect, BellCrankMasses)), None))

    def dimensions(self) -> dict[str, float]:
        """All dimensions in SI; the spring as its rate and its force at preload_radius, a vertical hanger infinite."""
        spring = self.spring_law()
        return {
            "weight_arm": self.weight_arm,
            "sleeve_arm": self.sleeve_arm,
            "bell_crank_angle": self.bell_crank_angle,
            "fulcrum_radius": self.fulcrum_radius,
            "fulcrum_height": self.fulcrum_y,
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
        low, high, low_message, high_message = self.lever_geometry.travel_limits(self._middle_angle)
        if not isinstance(angle, float) or low < angle < high:
            return ()
        allowed = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
        return (
            f"start.lever_angle ({math.degrees(angle):g} deg) lies outside the travel of this governor, {allowed}: "
            f"{low_message if angle <= low else high_message}{_in_degrees(angle, math.pi / 2, '10 deg')}",
        )

    @property
    def _middle_angle(self) -> float:
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
                f"inner_angle ({format_quantity(self.inner_angle, 'rad')}) must exceed outer_angle "
                f"({format_quantity(self.outer_angle, 'rad')}): the lever angle is positive toward the spindle; exchange them"
            ]
        return self._reach_problems(self.outer_angle, self.inner_angle)

    def stop_problems(self, effects: Iterable[Effect]) -> list[str]:
        """Stops of the lever that it cannot come to."""
        problems = []
        for stops in (one for one in effects if isinstance(one, Stops) and one.reading == "lever_angle"):
            ends = [self._middle_angle, *(end for end in (stops.low, stops.high) if math.isfinite(end))]
            failure = self.lever_geometry.first_failure(min(ends), max(ends))
            if failure is not None:
                problems.append(
                    f"the stops of 'lever_angle' lie too far apart: at {format_quantity(failure[0], 'rad')} {failure[1]}; move them nearer"
                )
        return problems

    def _reach_problems(self, outer_angle: float, inner_angle: float) -> list[str]:
        failure = None if self._angle_problems() else self.lever_geometry.first_failure(outer_angle, inner_angle)
        if failure is None:
            return []
        lever_angle, sentence = failure
        hint = _in_degrees(max(inner_angle, -outer_angle), math.pi / 2, "15 deg") or f"; {FAILURE_HINTS[sentence]}, or shorten the stroke"
        return [
            f"the stroke, lever_angle from {format_quantity(outer_angle, 'rad')} to {format_quantity(inner_angle, 'rad')}, cannot be gone through: "
            f"at {format_quantity(lever_angle, 'rad')} {sentence}{hint}"
        ]


def _in_degrees(angle: float, max_angle: float, example: str) -> str:
    """A hint at the unit, for an angle (rad) larger than makes sense; else empty."""
    return f"; a bare number is in rad, so write it with its unit: {example}" if abs(angle) > max_angle else ""

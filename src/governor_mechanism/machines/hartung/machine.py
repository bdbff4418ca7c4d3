"""Hartung governor: two spring-loaded weights on bell cranks, with hangers to the sleeve.

Geometry after Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), p. 618. The plane turns with the spindle: x is measured from the
spindle axis, y up from the cross axis of the governor. The lever angle is that of the weight's arm from the upright, positive toward the
spindle: it is largest when the weights are innermost.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import travel_problems, unit_hint
from governor_mechanism.machines.hartung.bodies import HartungBuilder
from governor_mechanism.machines.hartung.dimensions import HartungDimensions
from governor_mechanism.machines.hartung.geometry import FAILURE_HINTS
from governor_mechanism.machines.hartung.spring import LinearSpringLaw, build_spring_law, spring_problems, stress_warning
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.units.quantities import format_quantity


@dataclass(frozen=True, kw_only=True)
class HartungGovernor(HartungDimensions):
    """Two weights as points on massless bell cranks, unless an effect gives these mass, and a sleeve on hangers.

    Lengths in m, masses in kg, angles in rad, speeds in rad/s. A horizontal spring presses each weight inward at its centre. It is given by
    its force at a radius and its rate or its wire, or by the two equilibrium speeds at the ends of the stroke under 9.81 m/s2.
    """

    name: ClassVar[str] = "hartung"
    plane: ClassVar[str] = TURNING_PLANE
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (BellCrankMasses,)

    def __post_init__(self) -> None:
        super().__post_init__()
        problems = [*self._angle_problems(), *self._stroke_problems(), *spring_problems(self)]
        if problems:
            raise MechanismError(*problems)
        self.spring_law()  # raises for two speeds that no spring satisfies

    def spring_law(self) -> LinearSpringLaw:
        """Return the force of each spring over the radius of its weight."""
        return build_spring_law(self)

    def mechanism(self, bell_cranks: BellCrankMasses | None = None) -> Mechanism:
        """Build weights, sleeve, hangers and springs; with bell-crank masses, levers and weights have mass and size."""
        builder = HartungBuilder(governor=self, bell_cranks=bell_cranks)
        low, high, low_message, high_message = self.lever_geometry.travel_limits(self.middle_angle)
        note = stress_warning(self)
        return Mechanism(
            bodies=builder.bodies(),
            joints=builder.joints(),
            readings=builder.readings(self.inner_angle or 0.0),
            derived_forces=builder.outputs(),
            coordinate="lever_angle",
            length_scale=max(self.weight_arm, self.sleeve_arm),
            initial_guess=builder.poses(self.middle_angle),
            limits=(Limit(reading="lever_angle", low=low, high=high, low_message=low_message, high_message=high_message),),
            force_elements=(builder.spring(),),
            notes=(note,) if note else (),
        )

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI: the spring by its rate and its force at preload_radius, a vertical hanger as infinite."""
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
        """Return a sentence about a start angle outside the travel."""
        return travel_problems(values, "lever_angle", self.lever_geometry.travel_limits(self.middle_angle), math.pi / 2, "10 deg")

    def _angle_problems(self) -> list[str]:
        degrees = math.degrees(self.bell_crank_angle)
        if 90.0 - 1e-9 <= degrees <= 180.0:
            return []
        return [
            f"bell_crank_angle ({degrees:.6g} deg) must lie between 90 deg, Hartung's old right angle, and 180 deg, an "
            "arm in line with the other: outside this range the sleeve does not rise as the weights move outward"
            f"{unit_hint(self.bell_crank_angle, math.tau, '132 deg')}"
        ]

    def _stroke_problems(self) -> list[str]:
        """Return sentences about a reversed stroke or one that lever or hanger cannot complete."""
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
        """Return sentences about stops that the lever cannot reach."""
        problems = []
        for stops in (one for one in effects if isinstance(one, Stops) and one.reading == "lever_angle"):
            ends = [self.middle_angle, *(end for end in (stops.low, stops.high) if math.isfinite(end))]
            failure = self.lever_geometry.first_failure(min(ends), max(ends))
            if failure is not None:
                problems.append(
                    f"the stops of 'lever_angle' are too far apart: at {format_quantity(failure[0], 'rad')} {failure[1]}; move them nearer"
                )
        return problems

    def _reach_problems(self, outer_angle: float, inner_angle: float) -> list[str]:
        failure = None if self._angle_problems() else self.lever_geometry.first_failure(outer_angle, inner_angle)
        if failure is None:
            return []
        lever_angle, sentence = failure
        hint = unit_hint(max(inner_angle, -outer_angle), math.pi / 2, "15 deg") or f"; {FAILURE_HINTS[sentence]}, or shorten the stroke"
        return [
            f"the stroke, lever_angle from {format_quantity(outer_angle, 'rad')} to {format_quantity(inner_angle, 'rad')}, "
            f"is not possible: at {format_quantity(lever_angle, 'rad')} {sentence}{hint}"
        ]

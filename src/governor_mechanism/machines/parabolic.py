"""The astatic governor: balls in parabolic guides, a sleeve that rises twice as far as they do.

After Zehnder, Dinglers Polytechnisches Journal 225 (1877): on the parabola x^2 = c y the balls rest anywhere at one
speed, w^2 = 2 g (1 + m) / c, with m the sleeve's mass over that of a ball. The plane turns with the spindle: x from the
spindle axis, y up, the vertex of the parabola at y = 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension
from governor_mechanism.model.curves import Polynomial
from governor_mechanism.model.joints import GROUND, CurveSlot, Point, Proportion, Slider
from governor_mechanism.model.mechanism import Body, Coordinate, Limit, Mechanism
from governor_mechanism.model.scene import TURNING

RIGHT, LEFT, SLEEVE = "right ball", "left ball", "sleeve"


@dataclass(frozen=True, kw_only=True)
class ParabolicGovernor(Machine):
    """Two balls as points in guides, a sleeve. Lengths in m, masses in kg."""

    name: ClassVar[str] = "parabolic_governor"
    plane: ClassVar[str] = TURNING

    double_parameter: float = dimension("length", "c of the guide x^2 = c y")
    inner_radius: float = dimension("length", "of the guide's inner end from the spindle axis")
    outer_radius: float = dimension("length", "of the guide's outer end from the spindle axis")
    ball_mass: float = dimension("mass", "of one ball; there are two")
    sleeve_mass: float = dimension("mass", "of the whole sleeve and its load")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inner_radius >= self.outer_radius:
            raise MechanismError(
                f"inner_radius ({self.inner_radius:g} m) must be less than outer_radius ({self.outer_radius:g} m)"
            )

    def mechanism(self) -> Mechanism:
        """Balls on their curves, at one height; the sleeve on the spindle, lifted twice as far."""
        curve = Polynomial(coefficients=(0.0, 0.0, 1.0 / self.double_parameter))
        ground, up = Point(body=GROUND), math.pi / 2
        right, left, sleeve = (Point(body=name) for name in (RIGHT, LEFT, SLEEVE))
        middle = 0.5 * (self.inner_radius + self.outer_radius)
        height = middle**2 / self.double_parameter
        return Mechanism(
            bodies=(
                Body(name=RIGHT, mass=self.ball_mass, turns=False),
                Body(name=LEFT, mass=self.ball_mass, turns=False),
                Body(name=SLEEVE, mass=self.sleeve_mass, turns=False),
            ),
            joints=(
                CurveSlot(name="right guide", first=ground, second=right, curve=curve),
                CurveSlot(name="left guide", first=ground, second=left, curve=curve),
                Proportion(name="balls in step", first=right, second=left, ratio=1.0, angle=up),
                Slider(name="spindle guide", first=ground, second=sleeve, angle=up),
                Proportion(name="lift", first=right, second=sleeve, ratio=2.0, angle=up, offset=-self.drop),
            ),
            readings=(
                Coordinate(name="ball_radius", quantity="length", point=right, along_x=1.0, along_y=0.0),
                Coordinate(
                    name="sleeve_lift",
                    quantity="length",
                    point=sleeve,
                    along_x=0.0,
                    along_y=1.0,
                    zero=2 * self.inner_radius**2 / self.double_parameter - self.drop,
                ),
            ),
            coordinate="ball_radius",
            size=self.outer_radius,
            sketch=((middle, height, 0.0), (-middle, height, 0.0), (0.0, 2 * height - self.drop, 0.0)),
            limits=(
                Limit(
                    reading="ball_radius",
                    low=self.inner_radius,
                    high=self.outer_radius,
                    below="the balls reach the inner end of their guide",
                    above="the balls reach the outer end of their guide",
                ),
            ),
        )

    @property
    def drop(self) -> float:
        """How far below the vertex of the parabola the sleeve hangs with the balls at it (m): drawn only."""
        return 2 * self.outer_radius

    def dimensions(self) -> dict[str, float]:
        """All dimensions in SI."""
        return {
            "double_parameter": self.double_parameter,
            "inner_radius": self.inner_radius,
            "outer_radius": self.outer_radius,
            "ball_mass": self.ball_mass,
            "sleeve_mass": self.sleeve_mass,
        }

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """A start beyond the ends of the guide."""
        radius = values.get("ball_radius")
        if not isinstance(radius, float) or self.inner_radius < radius < self.outer_radius:
            return ()
        return (
            f"start.ball_radius ({radius:g} m) lies beyond the guide, {self.inner_radius:g} to {self.outer_radius:g} m",
        )

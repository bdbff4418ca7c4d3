"""Parabolic governor (astatic): balls in parabolic guides, and a sleeve that rises twice as far.

On the parabola x^2 = c y the balls are in equilibrium everywhere at one speed, w^2 = 2 g (1 + m) / c, with m the ratio of sleeve mass
to ball mass (Zehnder, Dinglers Polytechnisches Journal 225, 1877). The plane turns with the spindle: x is measured from the spindle
axis, y up from the vertex of the parabola.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.machines.base import Machine, sleeve_lift, x_coordinate
from governor_mechanism.model.curves import PolynomialCurve
from governor_mechanism.model.joints import GROUND, CurveSlot, Point, ProportionalDisplacement, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.units.fields import quantity

RIGHT_BALL = "right ball"
LEFT_BALL = "left ball"
SLEEVE = "sleeve"


@dataclass(frozen=True, kw_only=True)
class ParabolicGovernor(Machine):
    """Two balls as points in guides, and a sleeve. Lengths in m, masses in kg."""

    name: ClassVar[str] = "parabolic_governor"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "ball_radius": "distance of the right ball from the spindle axis",
        "sleeve_lift": "height of the sleeve above its position with the balls at the inner end of the guides",
    }

    double_parameter: float = quantity("length", meaning="c of the guide x^2 = c y")
    inner_radius: float = quantity("length", meaning="of the guide's inner end from the spindle axis")
    outer_radius: float = quantity("length", meaning="of the guide's outer end from the spindle axis")
    ball_mass: float = quantity("mass", meaning="of one ball; there are two")
    sleeve_mass: float = quantity("mass", meaning="of the whole sleeve and its load")

    def dimension_problems(self) -> Iterator[str]:
        """Yield a sentence about ends of the guide in the wrong order."""
        if self.inner_radius >= self.outer_radius:
            yield f"inner_radius ({self.inner_radius:g} m) must be less than outer_radius ({self.outer_radius:g} m)"

    def mechanism(self) -> Mechanism:
        """Build the balls on their guides at equal height, and the sleeve on the spindle."""
        curve = PolynomialCurve(coefficients=(0.0, 0.0, 1.0 / self.double_parameter))
        ground, up = Point(body=GROUND), math.pi / 2
        drop = 2 * self.outer_radius  # of the sleeve below the vertex while the balls are at the vertex; it only affects the drawing
        masses = {RIGHT_BALL: self.ball_mass, LEFT_BALL: self.ball_mass, SLEEVE: self.sleeve_mass}
        right, left, sleeve = (Point(body=name) for name in masses)
        middle_radius = 0.5 * (self.inner_radius + self.outer_radius)
        height = middle_radius**2 / self.double_parameter
        lowest_sleeve = 2 * self.inner_radius**2 / self.double_parameter - drop
        travel = Limit(
            reading="ball_radius",
            low=self.inner_radius,
            high=self.outer_radius,
            low_message="the balls reach the inner end of their guide",
            high_message="the balls reach the outer end of their guide",
        )
        return Mechanism(
            bodies=tuple(Body(name=name, mass=mass, can_rotate=False) for name, mass in masses.items()),
            joints=(
                CurveSlot(name="right guide", first=ground, second=right, curve=curve),
                CurveSlot(name="left guide", first=ground, second=left, curve=curve),
                ProportionalDisplacement(name="balls in step", first=right, second=left, ratio=1.0, angle=up),
                Slider(name="spindle guide", first=ground, second=sleeve, angle=up),
                ProportionalDisplacement(name="lift", first=right, second=sleeve, ratio=2.0, angle=up, offset=-drop),
            ),
            readings=(x_coordinate("ball_radius", right), sleeve_lift(sleeve, zero=lowest_sleeve)),
            coordinate="ball_radius",
            length_scale=self.outer_radius,
            initial_guess=((middle_radius, height, 0.0), (-middle_radius, height, 0.0), (0.0, 2 * height - drop, 0.0)),
            limits=(travel,),
        )

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start beyond the ends of the guide."""
        radius = values.get("ball_radius")
        if not isinstance(radius, float) or self.inner_radius < radius < self.outer_radius:
            return ()
        return (f"start.ball_radius ({radius:g} m) lies beyond the guide, {self.inner_radius:g} to {self.outer_radius:g} m",)

"""Dimensions of a Hartung governor and the geometry that follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from governor_mechanism.machines.base import Machine, dimension_field
from governor_mechanism.machines.hartung.geometry import LeverGeometry


@dataclass(frozen=True, kw_only=True)
class HartungDimensions(Machine):
    """Dimensions of a Hartung governor. Lengths in m, masses in kg, angles in rad, speeds in rad/s."""

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
    spring_turns: float | None = dimension_field("number", "of each spring's active turns", default=None)
    spring_modulus: float | None = dimension_field("modulus", "of shear of the springs' wire", default=None, max_size=1e13)
    spring_stress_limit: float | None = dimension_field("pressure", "that the springs' wire may bear", default=None)
    inner_speed: float | None = dimension_field("angular_speed", "that holds the weights at the inner end of the stroke", default=None)
    outer_speed: float | None = dimension_field("angular_speed", "that holds the weights at the outer end of the stroke", default=None)
    insensitivity: float = dimension_field("ratio", "that the regulating force is computed with", default=0.04)

    @property
    def lever_geometry(self) -> LeverGeometry:
        """Positions of weights, hangers and sleeve over the lever angle."""
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
        """Height of the fulcrum above the cross axis, m."""
        return -self.weight_arm if self.fulcrum_height is None else self.fulcrum_height

    @property
    def middle_angle(self) -> float:
        """Lever angle at mid stroke, rad; 0 without a stroke."""
        if self.inner_angle is None or self.outer_angle is None:
            return 0.0
        return 0.5 * (self.inner_angle + self.outer_angle)

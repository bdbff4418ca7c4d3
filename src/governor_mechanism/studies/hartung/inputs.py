"""The inputs of a design, and what makes them invalid."""

import math
from dataclasses import dataclass

from governor_mechanism.closed_form.hartung.governor import HartungGovernor
from governor_mechanism.studies.design_inputs import design_input, input_kinds
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

KILOGRAM_FORCE = 9.81
"""One kilogram-force in N, with the paper's value of gravity."""
TECHNICAL_ATMOSPHERE = KILOGRAM_FORCE * 1e4
"""One technical atmosphere, kgf/cm^2, in Pa."""
HALF_STROKE_TOLERANCE_RATIO = 0.05
"""Tolerance of half_stroke relative to the geometric value; the paper's rounding is 0.008."""


@dataclass(frozen=True, kw_only=True)
class HartungInputs:
    """Inputs of a design in SI; the defaults are the paper's.

    swing is the lever's angle from the vertical to each side, rest_radius the radius of the weights at the inner end, half_stroke their
    radial travel from there to the vertical lever. angle and sleeve_arm (of the bell crank) follow from the design if they are None.
    """

    weight_mass: float = design_input("mass", 45.0)
    sleeve_mass: float = design_input("mass", 15.0)
    weight_arm: float = design_input("length", 0.115)
    rest_radius: float = design_input("length", 0.092)
    half_stroke: float = design_input("length", 0.030)
    fulcrum_height: float = design_input("length", -0.113)
    swing: float = design_input("angle", math.radians(15.0))
    slow_speed: float = design_input("angular_speed", 204 * math.pi / 30)
    fast_speed: float = design_input("angular_speed", 212 * math.pi / 30)
    wire: float = design_input("length", 0.012)
    coil: float = design_input("length", 0.080)
    modulus: float = design_input("modulus", 750_000 * TECHNICAL_ATMOSPHERE)
    stress_limit: float = design_input("pressure", 4500 * TECHNICAL_ATMOSPHERE)
    insensitivity: float = design_input("ratio", 0.04)
    angle: float | None = design_input("angle", None)
    sleeve_arm: float | None = design_input("length", None)

    @property
    def fulcrum_radius(self) -> float:
        """Distance of the fulcrum from the spindle axis (m)."""
        return self.rest_radius + self.half_stroke

    def governor(self, angle: float, sleeve_arm: float) -> HartungGovernor:
        """Return the governor with bell cranks of an angle (rad) and a sleeve arm (m)."""
        names = ("weight_arm", "fulcrum_radius", "weight_mass", "sleeve_mass")
        return HartungGovernor(**{name: getattr(self, name) for name in names}, sleeve_arm=sleeve_arm, angle=angle, gravity=KILOGRAM_FORCE)


PAPER_INPUTS = HartungInputs()
"""The inputs of the paper."""

INPUT_KINDS = input_kinds(HartungInputs)
"""Kind of quantity of each input."""


def find_input_problems(inputs: HartungInputs) -> list[str]:
    """Return sentences about inputs that are not positive or not consistent."""
    problems = [
        f"{name} must be positive; got {format_quantity(value, QUANTITY_KINDS[kind].si_unit).strip()}"
        for name, kind in INPUT_KINDS.items()
        if (value := getattr(inputs, name)) is not None and name != "fulcrum_height" and not value > 0
    ]
    if problems:
        return problems
    if inputs.slow_speed >= inputs.fast_speed:
        slow, fast = (format_quantity(speed, "rad/s") for speed in (inputs.slow_speed, inputs.fast_speed))
        problems.append(f"slow_speed ({slow}), at the inner end of the stroke, must be below fast_speed ({fast}), at the outer end")
    if inputs.insensitivity >= 1:
        problems.append(
            f"insensitivity ({inputs.insensitivity:g}) must be below 1: it is a fraction of the static sleeve force; "
            "the paper's value is 0.04"
        )
    radial_travel = inputs.weight_arm * math.sin(inputs.swing)
    if abs(inputs.half_stroke - radial_travel) > HALF_STROKE_TOLERANCE_RATIO * radial_travel:
        travel = format_quantity(radial_travel, "m", ".4g")
        problems.append(
            f"half_stroke ({format_quantity(inputs.half_stroke, 'm')}) is not consistent with weight_arm "
            f"({format_quantity(inputs.weight_arm, 'm')}) and swing ({format_quantity(inputs.swing, 'rad')}), which move a weight by "
            f"{travel} to each side; give half_stroke={travel}, or change the others"
        )
    if inputs.coil <= inputs.wire:
        problems.append(f"coil ({format_quantity(inputs.coil, 'm')}) must exceed wire ({format_quantity(inputs.wire, 'm')})")
    return problems

"""The inputs of a flywheel design, and what makes them invalid."""

import math
from dataclasses import dataclass, replace

from governor_mechanism.closed_form.flywheel.engine import AirEngine, closing_load_pressure
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design_inputs import design_input, input_kinds
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

DEFAULT_ENERGY_RATIO = 20.0
"""Ratio mu if the inputs state no requirement; the paper leaves it open."""

ENGINE_INPUTS = (
    "area",
    "stroke",
    "cut_off",
    "clearance",
    "pump_area",
    "pump_stroke",
    "pump_clearance",
    "atmospheric_pressure",
    "supply_pressure",
    "back_pressure",
)
"""Inputs that are attributes of the engine; its load may follow from them."""

_REQUIREMENTS = ("energy_ratio", "coefficient", "inertia")


@dataclass(frozen=True, kw_only=True)
class FlywheelInputs:
    """Inputs of a design in SI; by default the paper's ratios, for an engine of 13 kJ (A p L) at its mean piston speed of 1.3 m/s.

    load_pressure is the mean useful pressure of the load on the expansion piston; None ("closing" in text) is that with which the cycle
    closes. Of energy_ratio (mu, the kinetic energy at mean speed over the work stored), coefficient ((highest - lowest) / mean speed) and
    inertia (of a given wheel) at most one is given, or the energy ratio is 20. rim_share is the part of the inertia in the rim,
    width_ratio the width of the rim over its thickness; arm_stress and rim_stress are allowed stresses, as of cast iron.
    """

    area: float = design_input("area", 0.05)
    stroke: float = design_input("length", 0.65)
    cut_off: float = design_input("ratio", 0.375)
    clearance: float = design_input("ratio", 0.05)
    pump_area: float = design_input("area", 0.05)
    pump_stroke: float = design_input("length", 0.65)
    pump_clearance: float = design_input("ratio", 0.05)
    atmospheric_pressure: float = design_input("pressure", 1e5)
    supply_pressure: float = design_input("pressure", 4e5)
    back_pressure: float = design_input("pressure", 1.5e5)
    load_pressure: float | None = design_input("pressure", 0.4e5, word_for_none="closing")
    speed: float = design_input("angular_speed", math.tau)
    energy_ratio: float | None = design_input("number", None)
    coefficient: float | None = design_input("ratio", None)
    inertia: float | None = design_input("moment_of_inertia", None)
    rim_radius: float = design_input("length", 1.5)
    rim_share: float = design_input("ratio", 1.0)
    width_ratio: float = design_input("ratio", 2.0)
    density: float = design_input("density", 7200.0)
    rim_stress: float = design_input("pressure", 6e6)
    arms: float = design_input("number", 6.0)
    hub_radius: float = design_input("length", 0.15)
    arm_stress: float = design_input("pressure", 15e6)

    def engine(self) -> AirEngine:
        """Return the engine under its load."""
        dimensions = {name: getattr(self, name) for name in ENGINE_INPUTS}
        if self.load_pressure is not None:
            return AirEngine(**dimensions, load_pressure=self.load_pressure)
        # Any load serves to find the one that closes the cycle.
        return closed_cycle(AirEngine(**dimensions, load_pressure=self.atmospheric_pressure))


PAPER_INPUTS = FlywheelInputs()
"""The inputs of the paper; areas, stroke, mu, and what concerns rim and arms are ours."""


def closed_cycle(engine: AirEngine) -> AirEngine:
    """Return an engine under the load with which its cycle closes.

    Parameters
    ----------
    engine
        The engine under any load.

    Returns
    -------
    AirEngine
        The engine with another load pressure.
    """
    return replace(engine, load_pressure=closing_load_pressure(engine))


def validate_inputs(inputs: FlywheelInputs) -> None:
    """Raise MechanismError, with a sentence per mistake, for inputs of wheel and requirement that are not valid.

    Parameters
    ----------
    inputs
        The inputs; those of the engine are validated by `AirEngine`.
    """
    kinds = input_kinds(inputs)
    problems = [
        f"{name} must be positive; got {format_quantity(value, QUANTITY_KINDS[kinds[name]].si_unit).strip()}"
        for name in kinds
        if name not in (*ENGINE_INPUTS, "load_pressure") and (value := getattr(inputs, name)) is not None and not value > 0
    ]
    given = [name for name in _REQUIREMENTS if getattr(inputs, name) is not None]
    if len(given) > 1:
        problems.append(f"{' and '.join(given)} are given; give only one of {', '.join(_REQUIREMENTS)}")
    if inputs.energy_ratio is not None and 0 < inputs.energy_ratio <= 0.5:
        problems.append(f"energy_ratio must be above 0.5, where the wheel would come to rest; got {inputs.energy_ratio:g}")
    if inputs.coefficient is not None and inputs.coefficient >= 2:
        problems.append(f"coefficient must be below 2, where the wheel would come to rest; got {inputs.coefficient:g}")
    if inputs.rim_share > 1:
        problems.append(f"rim_share must be at most 1, the whole inertia; got {inputs.rim_share:g}")
    if inputs.arms != round(inputs.arms):
        problems.append(f"arms must be a whole number; got {inputs.arms:g}")
    if inputs.hub_radius >= inputs.rim_radius:
        hub, rim = (format_quantity(radius, "m") for radius in (inputs.hub_radius, inputs.rim_radius))
        problems.append(f"hub_radius ({hub}) must be below rim_radius ({rim})")
    if problems:
        raise MechanismError(*problems)

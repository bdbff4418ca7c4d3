"""Design of a flywheel after Redtenbacher: energy between the extreme speeds, inertia, rim and arms; or the fluctuation of a given wheel.

It uses the closed forms only and does not round intermediate results. The printed numbers of the paper are in `flywheel_paper`.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel.

The seven terms are recomputed twice: at the angles of 3 and 95 deg that the paper rounds to, and at the exact angles.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from governor_mechanism.closed_form import flywheel as formulas
from governor_mechanism.closed_form.arguments import as_scalar_or_array
from governor_mechanism.closed_form.flywheel_engine import (
    AirEngine,
    closing_area_ratio,
    closing_load_pressure,
    gas_torque,
    net_work,
    stored_work,
)
from governor_mechanism.closed_form.flywheel_equilibrium import Equilibrium, Fluctuation, energy_fluctuation, find_equilibria
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design.skeleton import Bounds, Design, require_valid, sentences
from governor_mechanism.units.constants import HORSEPOWER_1853, KILOGRAM_FORCE_1853
from governor_mechanism.units.fields import optional, quantity

DEFAULT_ENERGY_RATIO = 20.0
"""Ratio mu if the inputs state no requirement; the paper leaves it open."""

GRAVITY = KILOGRAM_FORCE_1853
"""Gravity for the weight of the rim, m/s2; the paper's 9.808 enters none of its numbers."""

CLOSED_CYCLE_TOLERANCE = 1e-9
"""Work that a closed cycle may gain in a stroke, relative to A p L: well above rounding."""

N_TORQUE_POINTS = 2001
"""Points of a stroke at which the largest torque on the arms is sought; its error is of the square of their distance, 1e-6."""

N_TURNS = 2
"""Turns that are simulated and shown."""

POINTS_PER_TURN = 200
"""Reported times in a turn."""

_REQUIREMENTS = ("energy_ratio", "coefficient", "inertia")
_RATIO_BOUNDS = Bounds(lowest=0.5, are_allowed=False, rule="above 0.5, where the wheel would come to rest", found="{value:g}")
_COEFFICIENT_BOUNDS = Bounds(highest=2.0, are_allowed=False, rule="below 2, where the wheel would come to rest", found="{value:g}")
_SHARE_BOUNDS = Bounds(highest=1.0, rule="at most 1, the whole inertia", found="{value:g}")


@dataclass(frozen=True, kw_only=True)
class FlywheelInputs:
    """Inputs of a design in SI; by default the paper's ratios, for an engine of 13 kJ (A p L) at its mean piston speed of 1.3 m/s.

    Of energy_ratio, coefficient and inertia at most one is given, or the energy ratio is 20. Allowed stresses are those of cast iron.
    """

    area: float = quantity("area", default=0.05, meaning="area of the expansion piston", sign="any")
    stroke: float = quantity("length", default=0.65, meaning="stroke of the expansion piston", sign="any")
    cut_off: float = quantity("ratio", default=0.375, meaning="cut-off relative to the stroke", sign="any")
    clearance: float = quantity("ratio", default=0.05, meaning="clearance relative to the volume of the stroke", sign="any")
    pump_area: float = quantity("area", default=0.05, meaning="area of the pump piston", sign="any")
    pump_stroke: float = quantity("length", default=0.65, meaning="stroke of the pump piston", sign="any")
    pump_clearance: float = quantity(
        "ratio", default=0.05, meaning="clearance of the pump relative to the volume of its stroke", sign="any"
    )
    atmospheric_pressure: float = quantity("pressure", default=1e5, meaning="absolute pressure of the atmosphere", sign="any")
    supply_pressure: float = quantity("pressure", default=4e5, meaning="absolute pressure of supply", sign="any")
    back_pressure: float = quantity("pressure", default=1.5e5, meaning="absolute pressure behind the piston", sign="any")
    load_pressure: float | None = quantity(
        "pressure",
        default=0.4e5,
        meaning="mean pressure of the load on the expansion piston; by default the cycle closes",
        sign="any",
        words=("closing",),
    )
    speed: float = quantity("angular_speed", default=math.tau, meaning="mean speed")
    energy_ratio: float | None = optional("number", meaning="mu, kinetic energy at mean speed over work stored", bounds=_RATIO_BOUNDS)
    coefficient: float | None = optional("ratio", meaning="(highest - lowest) / mean speed", bounds=_COEFFICIENT_BOUNDS)
    inertia: float | None = optional("moment_of_inertia", meaning="moment of inertia of a given wheel")
    rim_radius: float = quantity("length", default=1.5, meaning="radius of the middle of the rim")
    rim_share: float = quantity("ratio", default=1.0, meaning="part of the inertia in the rim", bounds=_SHARE_BOUNDS)
    width_ratio: float = quantity("ratio", default=2.0, meaning="width of the rim over its thickness")
    density: float = quantity("density", default=7200.0, meaning="density of the rim")
    rim_stress: float = quantity("pressure", default=6e6, meaning="allowed hoop stress of the rim")
    arms: float = quantity("number", default=6.0, meaning="number of arms")
    hub_radius: float = quantity("length", default=0.15, meaning="radius of the hub")
    arm_stress: float = quantity("pressure", default=15e6, meaning="allowed bending stress of an arm")

    def engine(self) -> AirEngine:
        """Return the engine under its load."""
        names = [one.name for one in fields(AirEngine) if one.name != "load_pressure"]
        dimensions = {name: getattr(self, name) for name in names}
        if self.load_pressure is not None:
            return AirEngine(**dimensions, load_pressure=self.load_pressure)
        # Any load serves to find the one that closes the cycle.
        return closed_cycle(AirEngine(**dimensions, load_pressure=self.atmospheric_pressure))


PAPER_INPUTS = FlywheelInputs()
"""The inputs of the paper; areas, stroke, mu, and what concerns rim and arms are ours."""


def closed_cycle(engine: AirEngine) -> AirEngine:
    """Return an engine under the load with which its cycle closes."""
    return replace(engine, load_pressure=closing_load_pressure(engine))


def _contradictions(inputs: FlywheelInputs) -> list[str]:
    """Return sentences about wheels that cannot be."""
    given = [name for name in _REQUIREMENTS if getattr(inputs, name) is not None]
    cases = {"requirements": len(given) > 1, "arms": inputs.arms != round(inputs.arms), "hub": inputs.hub_radius >= inputs.rim_radius}
    return sentences("flywheel", inputs, cases, given=" and ".join(given), possible=", ".join(_REQUIREMENTS))


@dataclass(frozen=True, kw_only=True)
class Wheel:
    """Rim and arms of a flywheel, SI.

    rim_weight is in N; rim_stress is the hoop stress of the free rim; arm_torque is the largest torque between rim and hub, arm_moment the
    bending moment of an arm at the hub, arm_depth and arm_width the axes of its elliptical section there.
    """

    rim_mass: float
    rim_weight: float
    rim_speed: float
    rim_stress: float
    rim_thickness: float
    rim_width: float
    arm_torque: float
    arm_moment: float
    arm_depth: float
    arm_width: float


@dataclass(frozen=True, kw_only=True, repr=False)
class FlywheelDesign(Design):
    """Result of a design in SI: angles rad, work J, speeds rad/s.

    Attributes
    ----------
    inputs
        The inputs.
    engine
        The engine under its load.
    interval_limits
        Crank angles at which the laws of the pressures change.
    equilibria
        All equilibria of air and load in a stroke.
    fluctuation
        Angles of lowest and highest speed, and the work stored between them.
    bracket
        That work over A p L: the paper's bracket B.
    net_work
        Work that the shaft gains in a stroke; 0 if the cycle closes.
    closing_load_pressure
        Load pressure with which the cycle closes, Pa.
    closing_area_ratio
        Ratio of pump and piston area with which it closes; None if there is none.
    power
        Power of the load at mean speed, W.
    inertia
        Moment of inertia of the flywheel, kg m2.
    energy_ratio
        Ratio mu of the mean kinetic energy to the work stored.
    coefficient
        Coefficient of speed fluctuation, (highest - lowest) / mean speed.
    lowest_speed
        Lowest speed in a stroke.
    highest_speed
        Highest speed in a stroke.
    closed_coefficient
        The coefficient of this flywheel if the load is that with which the cycle closes.
    wheel
        Rim and arms.
    warnings
        Warnings, one sentence each.
    """

    inputs: FlywheelInputs
    engine: AirEngine
    interval_limits: tuple[float, float, float]
    equilibria: tuple[Equilibrium, ...]
    fluctuation: Fluctuation
    bracket: float
    net_work: float
    closing_load_pressure: float
    closing_area_ratio: float | None
    power: float
    inertia: float
    energy_ratio: float
    coefficient: float
    lowest_speed: float
    highest_speed: float
    closed_coefficient: float
    wheel: Wheel
    warnings: tuple[str, ...] = ()

    machine = "flywheel"
    warning_start = "warning: "

    @property
    def horsepower(self) -> float:
        """Power of the load in the horsepower of the paper."""
        return self.power / HORSEPOWER_1853

    def scene_values(self, inertia: float | None = None) -> Mapping[str, object]:
        """Return what the scene adds: the periodic motion with the flywheel of the design, or of another inertia (kg m2)."""
        turn = math.tau / self.inputs.speed
        inertia = self.inertia if inertia is None else inertia
        times = {"duration": N_TURNS * turn, "output_interval": turn / POINTS_PER_TURN}
        return {"inertia": inertia, "crank_rate": self._start_speed(inertia), **times}

    def _start_speed(self, inertia: float) -> float:
        """Return the speed (rad/s) at the dead centre of the periodic motion with the mean speed of the design, by the mean of its rule."""
        engine = closed_cycle(self.engine)
        extremes = energy_fluctuation(engine)
        limits = {"inertia": inertia, "energy": extremes.energy, "mean_speed": self.inputs.speed}
        lowest, _ = formulas.speed_limits(**limits, mean_energy=self.inputs.coefficient is None and self.inputs.inertia is None)
        work = -float(stored_work(engine, crank_angle=extremes.slowest_angle))
        return float(formulas.speed_after_work(inertia=inertia, start_speed=lowest, work=work))


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_flywheel(inputs: FlywheelInputs = PAPER_INPUTS) -> FlywheelDesign:
    """Design a flywheel by the procedure of the paper, or find the fluctuation of a given one."""
    require_valid(inputs, alternatives=_contradictions)  # AirEngine validates the inputs of the engine
    engine = inputs.engine()
    extremes = energy_fluctuation(engine)
    closed = closed_cycle(engine)
    inertia, has_mean_energy = _inertia(inputs, extremes.energy)

    def limits(energy: float) -> tuple[float, float]:
        low, high = formulas.speed_limits(inertia=inertia, energy=energy, mean_speed=inputs.speed, mean_energy=has_mean_energy)
        return float(low), float(high)

    lowest, highest = limits(extremes.energy)
    closed_lowest, closed_highest = limits(energy_fluctuation(closed).energy)
    wheel = _wheel(inputs, engine, inertia)
    closed_coefficient = (closed_highest - closed_lowest) / inputs.speed
    return FlywheelDesign(
        inputs=inputs,
        engine=engine,
        interval_limits=engine.interval_limits,
        equilibria=find_equilibria(engine),
        fluctuation=extremes,
        bracket=extremes.energy / engine.full_pressure_work,
        net_work=net_work(engine),
        closing_load_pressure=closed.load_pressure,
        closing_area_ratio=_closing_area_ratio(engine),
        power=engine.load_torque * inputs.speed,
        inertia=inertia,
        energy_ratio=float(formulas.energy_ratio_of_speeds(inertia=inertia, energy=extremes.energy, lowest=lowest, highest=highest)),
        coefficient=(highest - lowest) / inputs.speed,
        lowest_speed=lowest,
        highest_speed=highest,
        closed_coefficient=closed_coefficient,
        wheel=wheel,
        warnings=tuple(_warnings(inputs, engine, closed, wheel, closed_coefficient)),
    )


def _inertia(inputs: FlywheelInputs, energy: float) -> tuple[float, bool]:
    """Return the inertia (kg m2), and whether the mean speed is the paper's rather than the arithmetic mean."""
    if inputs.inertia is not None:
        return inputs.inertia, False
    stored = {"energy": energy, "mean_speed": inputs.speed}
    if inputs.coefficient is not None:
        return float(formulas.inertia_for_coefficient(**stored, coefficient=inputs.coefficient)), False
    ratio = DEFAULT_ENERGY_RATIO if inputs.energy_ratio is None else inputs.energy_ratio
    return float(formulas.inertia_for_energy_ratio(**stored, energy_ratio=ratio)), True


def _closing_area_ratio(engine: AirEngine) -> float | None:
    try:
        return closing_area_ratio(engine)
    except MechanismError:
        return None


def _wheel(inputs: FlywheelInputs, engine: AirEngine, inertia: float) -> Wheel:
    """Return rim and arms."""
    mass = float(formulas.rim_mass(inertia=inputs.rim_share * inertia, radius=inputs.rim_radius))
    rim_speed = inputs.speed * inputs.rim_radius
    section = {"mass": mass, "radius": inputs.rim_radius, "density": inputs.density, "width_ratio": inputs.width_ratio}
    thickness = float(formulas.rim_thickness(**section))
    torques = np.asarray(gas_torque(engine, crank_angle=np.linspace(0.0, math.pi, N_TORQUE_POINTS))) - engine.load_torque
    torque = float(np.max(np.abs(torques)))
    moment = float(formulas.arm_bending_moment(torque=torque, radius=inputs.rim_radius, hub_radius=inputs.hub_radius, arms=inputs.arms))
    depth = float(formulas.arm_major_axis(bending_moment=moment, stress=inputs.arm_stress))
    return Wheel(
        rim_mass=mass,
        rim_weight=float(as_scalar_or_array(mass * GRAVITY)),
        rim_speed=rim_speed,
        rim_stress=float(formulas.rim_stress(density=inputs.density, rim_speed=rim_speed)),
        rim_thickness=thickness,
        rim_width=inputs.width_ratio * thickness,
        arm_torque=torque,
        arm_moment=moment,
        arm_depth=depth,
        arm_width=depth / 2,
    )


def _warnings(inputs: FlywheelInputs, engine: AirEngine, closed: AirEngine, wheel: Wheel, closed_coefficient: float) -> list[str]:
    """Return sentences about a cycle that does not close, and a rim that does not hold."""
    gained = net_work(engine) / engine.full_pressure_work
    slowest = math.sqrt(inputs.rim_stress / inputs.density)
    cases = {
        "open_cycle": abs(gained) > CLOSED_CYCLE_TOLERANCE,
        "rim_stress": wheel.rim_stress > inputs.rim_stress,
        "rim_thickness": wheel.rim_thickness >= 2 * (inputs.rim_radius - inputs.hub_radius),
    }
    cycle = {"change": "gains" if gained > 0 else "loses", "work": abs(gained), "closed": closed, "closed_coefficient": closed_coefficient}
    rim = {"wheel": wheel, "rim_speed": slowest, "possible_radius": slowest / inputs.speed}
    return sentences("flywheel", inputs, cases, **cycle, **rim)

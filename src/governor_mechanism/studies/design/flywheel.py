"""Design of a flywheel after Redtenbacher: energy between the extreme speeds, inertia, rim and arms; or the fluctuation of a given wheel.

It uses the closed forms only and does not round intermediate results. The numbers of the paper stand beside those recomputed; its seven
terms are recomputed twice, at the angles of 3 and 95 deg that it rounds to, and at the exact angles.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from governor_mechanism.closed_form import flywheel as formulas
from governor_mechanism.closed_form.flywheel_engine import (
    AirEngine,
    closing_area_ratio,
    closing_load_pressure,
    gas_torque,
    net_work,
    stored_work,
)
from governor_mechanism.closed_form.flywheel_equilibrium import Equilibrium, Fluctuation, bracket_terms, energy_fluctuation, find_equilibria
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column, format_columns
from governor_mechanism.studies.design.skeleton import (
    PRINTED_COLUMNS,
    Cause,
    Design,
    PrintedNumber,
    PrintedNumbers,
    format_rows,
    printed_numbers,
    require_valid,
    sentences,
)
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
    energy_ratio: float | None = optional(
        "number", meaning="mu, kinetic energy at mean speed over work stored", limits=(0.5, math.inf), open_ends="low"
    )
    coefficient: float | None = optional("ratio", meaning="(highest - lowest) / mean speed", limits=(0.0, 2.0), open_ends="high")
    inertia: float | None = optional("moment_of_inertia", meaning="moment of inertia of a given wheel")
    rim_radius: float = quantity("length", default=1.5, meaning="radius of the middle of the rim")
    rim_share: float = quantity("ratio", default=1.0, meaning="part of the inertia in the rim", limits=(0.0, 1.0))
    width_ratio: float = quantity("ratio", default=2.0, meaning="width of the rim over its thickness")
    density: float = quantity("density", default=7200.0, meaning="density of the rim")
    rim_stress: float = quantity("pressure", default=6e6, meaning="allowed hoop stress of the rim")
    arms: float = quantity("number", default=6.0, meaning="number of arms")
    hub_radius: float = quantity("length", default=0.15, meaning="radius of the hub")
    arm_stress: float = quantity("pressure", default=15e6, meaning="allowed bending stress of an arm")

    def engine(self) -> AirEngine:
        """Return the engine under its load."""
        dimensions = {one.name: getattr(self, one.name) for one in fields(AirEngine)}
        if self.load_pressure is not None:
            return AirEngine(**dimensions)
        # Any load serves to find the one that closes the cycle.
        return closed_cycle(AirEngine(**dimensions | {"load_pressure": self.atmospheric_pressure}))


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
        lowest, _ = _speed_limits(self.inputs, inertia, extremes.energy)
        work = -float(stored_work(engine, crank_angle=extremes.slowest_angle))
        return float(formulas.speed_after_work(inertia=inertia, start_speed=lowest, work=work))


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_flywheel(inputs: FlywheelInputs = PAPER_INPUTS) -> FlywheelDesign:
    """Design a flywheel by the procedure of the paper, or find the fluctuation of a given one."""
    require_valid("flywheel", inputs, alternatives=_contradictions)  # AirEngine validates the inputs of the engine
    engine = inputs.engine()
    extremes = energy_fluctuation(engine)
    closed = closed_cycle(engine)
    inertia = _inertia(inputs, extremes.energy)
    lowest, highest = _speed_limits(inputs, inertia, extremes.energy)
    closed_lowest, closed_highest = _speed_limits(inputs, inertia, energy_fluctuation(closed).energy)
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


def _speed_limits(inputs: FlywheelInputs, inertia: float, energy: float) -> tuple[float, float]:
    """Return the lowest and highest speed (rad/s) of a flywheel (kg m2) that stores a work (J) between them."""
    # The mean speed is the arithmetic mean, or the paper's, of the energies, unless a coefficient or an
    # inertia is given.
    has_mean_energy = inputs.coefficient is None and inputs.inertia is None
    low, high = formulas.speed_limits(inertia=inertia, energy=energy, mean_speed=inputs.speed, mean_energy=has_mean_energy)
    return float(low), float(high)


def _inertia(inputs: FlywheelInputs, energy: float) -> float:
    """Return the inertia (kg m2)."""
    if inputs.inertia is not None:
        return inputs.inertia
    stored = {"energy": energy, "mean_speed": inputs.speed}
    if inputs.coefficient is not None:
        return float(formulas.inertia_for_coefficient(**stored, coefficient=inputs.coefficient))
    ratio = DEFAULT_ENERGY_RATIO if inputs.energy_ratio is None else inputs.energy_ratio
    return float(formulas.inertia_for_energy_ratio(**stored, energy_ratio=ratio))


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
        rim_weight=mass * GRAVITY,
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


PAPER_ENGINE = PAPER_INPUTS.engine()
"""The engine of the paper's calculation."""

PRINTED_ANGLES = (math.radians(3.0), math.radians(95.0))
"""Angles of lowest and highest speed as the paper rounds them, rad."""

PRINTED_LOAD_CONSTANT = 0.25
"""The paper's rounding of 2 R / pi times the atmospheric pressure, in its numeric equations (61) to (63)."""

PRINTED_SUM = 0.1713
"""The paper's sum of the seven terms of the bracket."""

_POWER_FACTOR = 30 * 75
"""75 kgf m/s to a horsepower, and the stroke L = 30 V / n."""


@dataclass(frozen=True, kw_only=True)
class ComparedWheel:
    """A flywheel sized by a value of the bracket: inertia (kg m2), coefficient of speed fluctuation in the closed cycle, its excess."""

    sized_by: str
    bracket: float
    inertia: float
    coefficient: float
    excess: float


WHEEL_COLUMNS = (
    Column("sized_by", "flywheel sized by"),
    Column("bracket", "bracket", ".6g"),
    Column("inertia", "kg m2", ".6g"),
    Column("coefficient", "fluctuation", ".6g"),
    Column("excess", "times the allowed", ".5g"),
)


@dataclass(frozen=True, kw_only=True)
class PaperComparison(PrintedNumbers):
    """The paper's numbers in order, the terms of its bracket at the exact angles, and flywheels sized by each sum."""

    terms: tuple[PrintedNumber, ...]
    exact_terms: tuple[float, ...]
    exact_coefficient: float
    wheels: tuple[ComparedWheel, ...]

    derived = ("exact_sum", *PrintedNumbers.derived)

    @property
    def exact_sum(self) -> float:
        """Sum of the terms at the exact angles."""
        return sum(self.exact_terms)

    @property
    def exact_values(self) -> tuple[float, ...]:
        """The terms, their sum and the coefficient at the exact angles."""
        return (*self.exact_terms, self.exact_sum, self.exact_coefficient)

    @property
    def wrong_term(self) -> PrintedNumber:
        """The term from whose error the wrong sum follows."""
        return next(term for term in self.terms if term.cause is Cause.ERROR)

    def __str__(self) -> str:
        """Return tables of the numbers with the causes of the differences, of the terms, and of the flywheels."""
        tables = (
            format_columns(PRINTED_COLUMNS, self.numbers),
            format_rows("flywheel", "bracket", self, "lrrrl"),
            format_columns(WHEEL_COLUMNS, self.wheels),
        )
        return "\n\n".join([*tables, "proofs, and formulas that are not right: governor-mechanism errata --paper redtenbacher"])


def compare_with_paper() -> PaperComparison:
    """Return all numbers of the paper, recomputed, with the terms of the bracket and the flywheels that follow."""
    extremes = energy_fluctuation(PAPER_ENGINE)
    exact_terms = bracket_terms(PAPER_ENGINE, slowest_angle=extremes.slowest_angle, fastest_angle=extremes.fastest_angle)
    return PaperComparison(
        numbers=_compare_angles(),
        terms=_compare_terms(),
        exact_terms=exact_terms,
        exact_coefficient=_power_coefficient(sum(exact_terms)),
        wheels=tuple(_compare_wheels(sum(exact_terms))),
    )


def engine_of_printed_load() -> AirEngine:
    """Return the engine under a load whose 2 R / pi is 0.25 times the atmospheric pressure, as in the paper's numeric equations."""
    return replace(PAPER_ENGINE, load_pressure=PRINTED_LOAD_CONSTANT * math.pi / 2 * PAPER_ENGINE.atmospheric_pressure)


def _compare_angles() -> tuple[PrintedNumber, ...]:
    """Compare limits and roots; the roots are those of the numeric equations with their rounded load."""
    return printed_numbers(
        "flywheel",
        "angles",
        load_constant=2 / math.pi * PAPER_ENGINE.load_pressure / PAPER_ENGINE.atmospheric_pressure,
        limits=[math.degrees(angle) for angle in PAPER_ENGINE.interval_limits],
        roots=[math.degrees(root.angle) for root in find_equilibria(engine_of_printed_load())],
    )


def _compare_terms() -> tuple[PrintedNumber, ...]:
    """Compare the seven terms at the paper's angles, their sum and the coefficient of mu N / n in the energy of the flywheel."""
    terms = bracket_terms(PAPER_ENGINE, slowest_angle=PRINTED_ANGLES[0], fastest_angle=PRINTED_ANGLES[1])
    return printed_numbers("flywheel", "terms", terms=terms, sum=sum(terms), coefficient=_power_coefficient(sum(terms)))


def _power_coefficient(bracket: float) -> float:
    """Return the kinetic energy of the flywheel (kgf m) divided by mu N / n, with N in PS and n in rpm: 30 * 75 (p / R) B."""
    return _POWER_FACTOR * PAPER_ENGINE.supply_pressure / PAPER_ENGINE.load_pressure * bracket


def _compare_wheels(exact_bracket: float) -> Iterator[ComparedWheel]:
    """Compare how flywheels sized by each sum run under the load with which the cycle closes."""
    closed_energy = energy_fluctuation(closed_cycle(PAPER_ENGINE)).energy
    work = PAPER_ENGINE.full_pressure_work
    mean_speed = PAPER_INPUTS.speed
    allowed = float(formulas.coefficient_of_energy_ratio(energy_ratio=DEFAULT_ENERGY_RATIO))
    labels = ("paper's printed sum", "paper's formula, exact angles", "closed cycle")
    for label, bracket in zip(labels, (PRINTED_SUM, exact_bracket, closed_energy / work), strict=True):
        inertia = float(formulas.inertia_for_energy_ratio(energy=bracket * work, mean_speed=mean_speed, energy_ratio=DEFAULT_ENERGY_RATIO))
        lowest, highest = formulas.speed_limits(inertia=inertia, energy=closed_energy, mean_speed=mean_speed, mean_energy=True)
        coefficient = float(highest - lowest) / mean_speed
        yield ComparedWheel(sized_by=label, bracket=bracket, inertia=inertia, coefficient=coefficient, excess=coefficient / allowed)

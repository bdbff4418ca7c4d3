"""The numbers of Redtenbacher's calculation of a flywheel beside those recomputed, and flywheels sized by each sum."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.closed_form import flywheel as formulas
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.flywheel_equilibrium import bracket_terms, energy_fluctuation, find_equilibria
from governor_mechanism.model.results.result import Column, Recorded, format_columns
from governor_mechanism.studies.design.flywheel import DEFAULT_ENERGY_RATIO, PAPER_INPUTS, closed_cycle
from governor_mechanism.studies.design.skeleton import PRINTED_COLUMNS, Cause, PrintedNumber, select_deviations
from governor_mechanism.units.text_table import format_table

PAPER_ENGINE = PAPER_INPUTS.engine()
"""The engine of the paper's calculation."""

PRINTED_ANGLES = (math.radians(3.0), math.radians(95.0))
"""Angles of lowest and highest speed as the paper rounds them, rad."""

PRINTED_LOAD_CONSTANT = 0.25
"""The paper's rounding of 2 R / pi times the atmospheric pressure, in its numeric equations (61) to (63)."""

PRINTED_TERMS = (0.1430, 0.3743, -0.2714, -0.1910, 0.0693, 0.0984, -0.0513)
PRINTED_SUM, PRINTED_COEFFICIENT = 0.1713, 3854.0
"""The seven terms of the bracket, their sum, and the coefficient of mu N / n in the kinetic energy of the flywheel, kgf m."""

TERM_NAMES = (
    ("expansion (66)", Cause.ROUNDING, "it is 0.425 ln 1.4, of the ratio 1.397"),
    ("full pressure (66)", None, ""),
    ("back pressure (66)", Cause.ERROR, "r/p was taken as 0.5 instead of 1.5 / 4 = 0.375; this makes the flywheel 28 % too light"),
    ("air before the pump piston (65)", Cause.ROUNDING, "it is 0.2625 ln 2.07, of the ratio 2.072"),
    ("air left behind it (65)", Cause.SLIP, "it is 0.05 ln 4, without the travel at 3 deg"),
    ("atmosphere behind it (65)", None, ""),
    ("load (67)", Cause.ROUNDING, "perhaps 0.1 (1.66 - 0.05) / 3.14, in radians"),
)
"""Names of the terms, and why they are not right."""

_POWER_FACTOR = 30 * 75
"""75 kgf m/s to a horsepower, and the stroke L = 30 V / n."""


@dataclass(frozen=True, kw_only=True)
class ComparedWheel:
    """A flywheel sized by a value of the bracket: its inertia (kg m2), and how it runs in the closed cycle.

    coefficient is the coefficient of speed fluctuation there, excess its ratio to the allowed one.
    """

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
class PaperComparison(Recorded):
    """The paper's numbers in order, the terms of its bracket at the exact angles, and flywheels sized by each sum."""

    numbers: tuple[PrintedNumber, ...]
    terms: tuple[PrintedNumber, ...]
    exact_terms: tuple[float, ...]
    exact_coefficient: float
    wheels: tuple[ComparedWheel, ...]

    derived = ("exact_sum", "deviations=deviating_quantities")

    @property
    def exact_sum(self) -> float:
        """Sum of the terms at the exact angles."""
        return sum(self.exact_terms)

    @property
    def exact_values(self) -> tuple[float, ...]:
        """The terms, their sum and the coefficient at the exact angles."""
        return (*self.exact_terms, self.exact_sum, self.exact_coefficient)

    @property
    def deviations(self) -> tuple[PrintedNumber, ...]:
        """The numbers that are not right, in the paper's order."""
        return select_deviations((*self.numbers, *self.terms))

    @property
    def wrong_term(self) -> PrintedNumber:
        """The term from whose error the wrong sum follows."""
        return next(term for term in self.terms if term.cause is Cause.ERROR)

    @property
    def deviating_quantities(self) -> list[str]:
        """Names of those numbers."""
        return [number.quantity for number in self.deviations]

    def __str__(self) -> str:
        """Return tables of the numbers with the causes of the differences, of the terms, and of the flywheels."""
        rows = [
            (term.quantity, f"{term.printed:.6g}", f"{term.recomputed:.7g}", f"{value:.7g}", term.mark)
            for term, value in zip(self.terms, self.exact_values, strict=True)
        ]
        tables = (
            format_columns(PRINTED_COLUMNS, self.numbers),
            format_table(("bracket", "printed", "at 3 and 95 deg", "at exact angles", ""), rows, "lrrrl"),
            format_columns(WHEEL_COLUMNS, self.wheels),
        )
        return "\n\n".join([*tables, "proofs, and formulas that are not right: governor-mechanism errata --paper redtenbacher"])


def compare_with_paper() -> PaperComparison:
    """Return all numbers of the paper, recomputed, with the terms of the bracket and the flywheels that follow."""
    extremes = energy_fluctuation(PAPER_ENGINE)
    exact_terms = bracket_terms(PAPER_ENGINE, slowest_angle=extremes.slowest_angle, fastest_angle=extremes.fastest_angle)
    return PaperComparison(
        numbers=tuple(_compare_angles()),
        terms=tuple(_compare_terms()),
        exact_terms=exact_terms,
        exact_coefficient=_power_coefficient(sum(exact_terms)),
        wheels=tuple(_compare_wheels(sum(exact_terms))),
    )


def engine_of_printed_load() -> AirEngine:
    """Return the engine under a load whose 2 R / pi is 0.25 times the atmospheric pressure, as in the paper's numeric equations."""
    return replace(PAPER_ENGINE, load_pressure=PRINTED_LOAD_CONSTANT * math.pi / 2 * PAPER_ENGINE.atmospheric_pressure)


def _compare_angles() -> Iterator[PrintedNumber]:
    """Compare limits and roots; the roots are those of the numeric equations with their rounded load."""
    first, second, third = (math.degrees(angle) for angle in PAPER_ENGINE.interval_limits)
    constant = 2 / math.pi * PAPER_ENGINE.load_pressure / PAPER_ENGINE.atmospheric_pressure
    yield PrintedNumber("load constant 2 R / pi", "1", PRINTED_LOAD_CONSTANT, constant)
    yield PrintedNumber("end of the first interval", "deg", 45, first, Cause.ROUNDING, "cut off to the degree: 45 deg 34'")
    yield PrintedNumber("end of the second interval", "deg", 75.5, second)
    remark = "54 deg 54' is cut off to the half degree, 54 deg 30', and taken from 180 deg"
    yield PrintedNumber("end of the third interval", "deg", 125.5, third, Cause.ROUNDING, remark)
    for (equation, printed), root in zip((("(61)", 3), ("(63)", 95)), find_equilibria(engine_of_printed_load()), strict=True):
        yield PrintedNumber(f"root of {equation}", "deg", printed, math.degrees(root.angle))


def _compare_terms() -> Iterator[PrintedNumber]:
    """Compare the seven terms at the paper's angles, their sum and the coefficient."""
    terms = bracket_terms(PAPER_ENGINE, slowest_angle=PRINTED_ANGLES[0], fastest_angle=PRINTED_ANGLES[1])
    for (name, cause, remark), printed, term in zip(TERM_NAMES, PRINTED_TERMS, terms, strict=True):
        yield PrintedNumber(name, "1", printed, term, cause, remark)
    remark = "the printed terms add up, but the third is wrong"
    yield PrintedNumber("sum of the bracket", "1", PRINTED_SUM, sum(terms), Cause.CONSEQUENCE, remark)
    coefficient = _power_coefficient(sum(terms))
    yield PrintedNumber("coefficient of mu N / n", "kgf m", PRINTED_COEFFICIENT, coefficient, Cause.CONSEQUENCE, "follows from the sum")


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

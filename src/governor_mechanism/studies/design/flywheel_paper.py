"""The numbers of Redtenbacher's calculation of a flywheel beside those recomputed, and flywheels sized by each sum."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.closed_form import flywheel as formulas
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.flywheel_equilibrium import bracket_terms, energy_fluctuation, find_equilibria
from governor_mechanism.model.results.result import Column, format_columns
from governor_mechanism.studies.design.flywheel import DEFAULT_ENERGY_RATIO, PAPER_INPUTS, closed_cycle
from governor_mechanism.studies.design.skeleton import PRINTED_COLUMNS, Cause, PrintedNumber, PrintedNumbers, printed_numbers
from governor_mechanism.units.text_table import format_table

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

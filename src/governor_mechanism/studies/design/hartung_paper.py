"""The numbers that Dubois prints of his Hartung governor, against the results of his formulas.

Each number is recomputed from what the paper states just before it, so that an error is located where it was made.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.closed_form.hartung import design as formulas
from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.model.results.result import Recorded, format_columns
from governor_mechanism.studies.design.hartung import PAPER_INPUTS
from governor_mechanism.studies.printed_numbers import PRINTED_COLUMNS, Cause, PrintedNumber, select_deviations
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853
from governor_mechanism.units.places import in_unit

PAPER_SPEEDS = (21.363, 22.201)
"""204 and 212 rpm as the paper rounds them (rad/s)."""

SLIDE_RULE_TOLERANCE = 1.0
"""Tolerance of the table (kgf); the errors of the slide rule are within 0.66, the misprint is larger."""

PAPER_GOVERNOR = PAPER_INPUTS.governor(angle=math.radians(132), sleeve_arm=0.170)
"""The governor of the paper's calculations, with bell cranks of 132 deg."""

PRINTED_SPRING_FORCES = (
    (92.0, 173.8, 199.8),
    (100.0, 193.4, 210.4),
    (106.0, 208.5, 226.5),
    (114.0, 227.2, 247.2),
    (122.0, 246.8, 267.8),
    (130.0, 266.3, 288.3),
    (138.0, 286.0, 309.0),
    (144.0, 301.2, 325.2),
    (152.0, 319.8, 345.8),
)
"""Table 2 of the paper: radius (mm), and the astatic spring force (kgf) at each of the two speeds."""

COUNTER_EXAMPLE_FORCES = (189.0, 262.0, 335.0)
"""Static sleeve force (kgf) at low, middle and high position of Pohlhausen's no. 97, a Hartung governor with right angles."""

_Row = tuple[Any, ...]


@dataclass(frozen=True, kw_only=True)
class PaperComparison(Recorded):
    """The paper's numbers in order, its table of spring forces and the governor of its counter-example (forces in kgf)."""

    numbers: tuple[PrintedNumber, ...]
    table: tuple[PrintedNumber, ...]
    counter_example: tuple[PrintedNumber, ...]

    derived = ("deviations=deviating_quantities",)

    @property
    def deviations(self) -> tuple[PrintedNumber, ...]:
        """The numbers that are not right, in the paper's order."""
        return select_deviations((*self.numbers, *self.table, *self.counter_example))

    @property
    def deviating_quantities(self) -> list[str]:
        """Names of those numbers."""
        return [number.quantity for number in self.deviations]

    def __str__(self) -> str:
        """Return a table of the numbers, with the causes of the differences."""
        deviating = select_deviations(self.table)
        numbers = format_columns(PRINTED_COLUMNS, (*self.numbers, *deviating, *self.counter_example))
        agreement = f"table 2: {len(self.table) - len(deviating)} of {len(self.table)} spring forces agree with their formula"
        return f"{numbers}\n{agreement}\nproofs, and formulas that are not right: governor-mechanism errata --paper dubois"


def compare_with_paper() -> PaperComparison:
    """Return all numbers of the paper, recomputed."""
    numbers = (*_radii_and_speeds(), *_centrifugal_forces(), *_spring(), *_sleeve_forces())
    groups = {"numbers": numbers, "table": _spring_force_table(), "counter_example": _counter_example()}
    return PaperComparison(**{name: tuple(PrintedNumber(*row) for row in rows) for name, rows in groups.items()})


def _radii_and_speeds() -> Iterator[_Row]:
    inner, outer = (1e3 * float(closed.weight_radius(PAPER_GOVERNOR, lever_angle=math.radians(side))) for side in (15, -15))
    slow, fast = (speed**2 for speed in PAPER_SPEEDS)
    yield "radius of a weight at the inner end", "mm", 95, 15 + 77, Cause.MISPRINT, "the next lines use 92"
    yield "radius of the fulcrum", "mm", 122, 92 + 30
    yield "sagitta", "mm", 4, 115 * (1 - math.cos(math.radians(15)))
    yield "radius innermost", "mm", 192, inner, Cause.MISPRINT, "one digit too many; the table has 92"
    yield "radius outermost", "mm", 152, outer
    yield "slow speed squared", "1/s^2", 456.4, slow
    yield "fast speed squared", "1/s^2", 492.9, fast
    yield "the same, in C2", "1/s^2", 492.2, fast, Cause.MISPRINT, "it is 492.9 two lines above"


def _centrifugal_forces() -> Iterator[_Row]:
    mass = 45 / KILOGRAM_FORCE_1853
    angle = float(formulas.bell_crank_angle(weight_arm=115.0, middle_abscissa=106.0))
    arm = float(formulas.symmetric_sleeve_arm(fulcrum_radius=122.0, angle=math.radians(132), swing=math.radians(15)))
    yield "mass of a weight", "kgf s2/m", 4.58, mass, Cause.ROUNDING, "cut off, not rounded: 4.59"
    yield "centrifugal force C1", "kgf", 192, mass * PAPER_SPEEDS[0] ** 2 * 0.092
    yield "centrifugal force C2", "kgf", 344, mass * PAPER_SPEEDS[1] ** 2 * 0.152
    yield "abscissa y1", "mm", 76, float(formulas.spring_abscissa(inner_force=192.0, outer_force=344.0, stroke=60.0))
    yield "abscissa y0", "mm", 106, 76 + 30
    yield "tangent of the angle", "1", -0.92, math.tan(angle)
    remark = "the arc of 0.92 was added to 90 deg instead of taken from 180 deg; 132 deg is used"
    yield "angle of the bell crank", "deg", 133, math.degrees(angle), Cause.ERROR, remark
    yield "sleeve's arm b, at 132 deg", "mm", 170, arm


def _spring() -> Iterator[_Row]:
    section = 1e6 * float(formulas.section_modulus(wire=PAPER_INPUTS.wire))
    length = 6 * 0.2036 * 750_000 / (172 * 4**2)
    yield "rise of the spring force", "kgf", 172, 345.8 - 173.8
    yield "polar moment of the wire", "cm^4", 0.2036, 1e8 * float(formulas.polar_moment(wire=PAPER_INPUTS.wire))
    yield "length of the wire", "cm", 332, length, Cause.ROUNDING, "cut off, not rounded: 333"
    yield "turns", "1", 13, 332 / (math.pi * 8)
    yield "section modulus of the wire", "cm^3", 0.338, section, Cause.SLIP, "should be 0.339"
    yield "stress under 346 kgf", "kgf/cm^2", 4100, 346 * 4 / 0.338


def _sleeve_forces() -> Iterator[_Row]:
    static_force = closed.static_sleeve_force
    inner, outer = (
        float(static_force(PAPER_GOVERNOR, lever_angle=math.radians(side), spring_force=force * KILOGRAM_FORCE_1853)) / KILOGRAM_FORCE_1853
        for side, force in ((15, 173.8), (-15, 345.8))
    )
    low, high = (float(formulas.regulating_force(static_force=force)) for force in (inner, outer))
    steps = "computed from steps of three digits"
    yield "static force S, inner", "kgf", 460, inner, Cause.ROUNDING, steps
    yield "static force S, outer", "kgf", 503, outer, Cause.ROUNDING, steps
    yield "regulating force K, inner", "kgf", 18.4, low
    yield "regulating force K, outer", "kgf", 26.2, high, Cause.MISPRINT, "the next line has 20.2"
    change = 100 * (high - low) / (0.5 * (low + high))
    yield "its change over the stroke", "%", 10, change, Cause.ROUNDING, "2 / 20, of forces that differ by 1.74 kgf"


def _spring_force_table() -> Iterator[_Row]:
    for radius, *printed in PRINTED_SPRING_FORCES:
        lever_angle = math.asin((122 - radius) / 115)
        for rpm, speed, force in zip((204, 212), PAPER_SPEEDS, printed, strict=True):
            newtons = float(closed.astatic_spring_force(PAPER_GOVERNOR, lever_angle=lever_angle, spindle_speed=speed))
            row = f"spring force at {radius:g} mm, {rpm} rpm", "kgf", force, in_unit(newtons, "kgf")
            is_misprint = abs(force - in_unit(newtons, "kgf")) > SLIDE_RULE_TOLERANCE
            remark = "not on the curve of its neighbours; one digit wrong, 189.8 is meant"
            yield (*row, Cause.MISPRINT, remark) if is_misprint else row


def _counter_example() -> Iterator[_Row]:
    low, middle, high = (float(formulas.regulating_force(static_force=force)) for force in COUNTER_EXAMPLE_FORCES)
    yield "Pohlhausen's no. 97, K low", "kgf", 7.5, low, Cause.ROUNDING, "cut off, not rounded: 7.6"
    yield "Pohlhausen's no. 97, K middle", "kgf", 10.5, middle
    yield "Pohlhausen's no. 97, K high", "kgf", 13.4, high
    yield "Pohlhausen's no. 97, change of K", "%", 56, 100 * (13.4 - 7.5) / 10.5

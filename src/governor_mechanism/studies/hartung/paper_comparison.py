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
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.studies.hartung.inputs import KILOGRAM_FORCE, PAPER_INPUTS
from governor_mechanism.studies.printed_numbers import Cause, PrintedNumber, select_deviations
from governor_mechanism.units.text_table import format_table

PAPER_SPEEDS = (21.363, 22.201)
"""204 and 212 rpm as the paper rounds them (rad/s)."""

SLIDE_RULE_TOLERANCE = 1.0
"""Tolerance of the table (kgf); the errors of the slide rule are within 0.66, the misprint is larger."""

PAPER_GOVERNOR = PAPER_INPUTS.governor(angle=math.radians(132), sleeve_arm=0.170)
"""The governor of the paper's calculations, with bell cranks of 132 deg."""

PRINTED_RADII = (92.0, 100.0, 106.0, 114.0, 122.0, 130.0, 138.0, 144.0, 152.0)
PRINTED_LOW_FORCES = (173.8, 193.4, 208.5, 227.2, 246.8, 266.3, 286.0, 301.2, 319.8)
PRINTED_HIGH_FORCES = (199.8, 210.4, 226.5, 247.2, 267.8, 288.3, 309.0, 325.2, 345.8)
PRINTED_SPRING_FORCES = tuple(zip(PRINTED_RADII, PRINTED_LOW_FORCES, PRINTED_HIGH_FORCES, strict=True))
"""Table 2 of the paper: radius (mm), and the astatic spring force (kgf) at each of the two speeds."""

COUNTER_EXAMPLE_FORCES = (189.0, 262.0, 335.0)
"""Static sleeve force (kgf) at low, middle and high position of Pohlhausen's no. 97, a Hartung governor with right angles."""


@dataclass(frozen=True, kw_only=True)
class PaperComparison:
    """The paper's numbers in order, its table of spring forces and the governor of its counter-example (forces in kgf)."""

    numbers: tuple[PrintedNumber, ...]
    table: tuple[PrintedNumber, ...]
    counter_example: tuple[PrintedNumber, ...]

    @property
    def deviations(self) -> tuple[PrintedNumber, ...]:
        """The numbers that are not right, in the paper's order."""
        return select_deviations((*self.numbers, *self.table, *self.counter_example))

    def as_json(self) -> dict[str, Any]:
        """Return the comparison as plain values."""
        return plain_record(self, deviations=[number.quantity for number in self.deviations])

    def __str__(self) -> str:
        """Return a table of the numbers, with the causes of the differences."""
        deviating = select_deviations(self.table)
        rows = [number.cells for number in (*self.numbers, *deviating, *self.counter_example)]
        n_agreeing = len(self.table) - len(deviating)
        table = format_table(("quantity", "unit", "printed", "recomputed", ""), rows, "llrrl")
        agreement = f"table 2: {n_agreeing} of {len(self.table)} spring forces agree with their formula"
        return f"{table}\n{agreement}\nproofs, and formulas that are not right: governor-mechanism errata --paper dubois"


def compare_with_paper() -> PaperComparison:
    """Return all numbers of the paper, recomputed.

    Returns
    -------
    PaperComparison
        The numbers by section of the paper.
    """
    return PaperComparison(
        numbers=(*_compare_radii_and_speeds(), *_compare_centrifugal_forces(), *_compare_spring(), *_compare_sleeve_forces()),
        table=tuple(_compare_spring_force_table()),
        counter_example=tuple(_compare_counter_example()),
    )


def _compare_radii_and_speeds() -> Iterator[PrintedNumber]:
    radii = [1e3 * float(closed.weight_radius(PAPER_GOVERNOR, lever_angle=math.radians(side))) for side in (15, -15)]
    yield PrintedNumber("radius of a weight at the inner end", "mm", 95, 15 + 77, Cause.MISPRINT, "the next lines use 92")
    yield PrintedNumber("radius of the fulcrum", "mm", 122, 92 + 30)
    yield PrintedNumber("sagitta", "mm", 4, 115 * (1 - math.cos(math.radians(15))))
    yield PrintedNumber("radius innermost", "mm", 192, radii[0], Cause.MISPRINT, "one digit too many; the table has 92")
    yield PrintedNumber("radius outermost", "mm", 152, radii[1])
    squares = [speed**2 for speed in PAPER_SPEEDS]
    yield PrintedNumber("slow speed squared", "1/s^2", 456.4, squares[0])
    yield PrintedNumber("fast speed squared", "1/s^2", 492.9, squares[1])
    yield PrintedNumber("the same, in C2", "1/s^2", 492.2, squares[1], Cause.MISPRINT, "it is 492.9 two lines above")


def _compare_centrifugal_forces() -> Iterator[PrintedNumber]:
    mass = 45 / KILOGRAM_FORCE
    yield PrintedNumber("mass of a weight", "kgf s2/m", 4.58, mass, Cause.ROUNDING, "cut off, not rounded: 4.59")
    forces = [mass * speed**2 * x for speed, x in zip(PAPER_SPEEDS, (0.092, 0.152), strict=True)]
    yield PrintedNumber("centrifugal force C1", "kgf", 192, forces[0])
    yield PrintedNumber("centrifugal force C2", "kgf", 344, forces[1])
    yield PrintedNumber("abscissa y1", "mm", 76, float(formulas.spring_abscissa(inner_force=192.0, outer_force=344.0, stroke=60.0)))
    yield PrintedNumber("abscissa y0", "mm", 106, 76 + 30)
    angle = float(formulas.bell_crank_angle(weight_arm=115.0, middle_abscissa=106.0))
    yield PrintedNumber("tangent of the angle", "1", -0.92, math.tan(angle))
    remark = "the arc of 0.92 was added to 90 deg instead of taken from 180 deg; 132 deg is used"
    yield PrintedNumber("angle of the bell crank", "deg", 133, math.degrees(angle), Cause.ERROR, remark)
    arm = formulas.symmetric_sleeve_arm(fulcrum_radius=122.0, angle=math.radians(132), swing=math.radians(15))
    yield PrintedNumber("sleeve's arm b, at 132 deg", "mm", 170, float(arm))


def _compare_spring() -> Iterator[PrintedNumber]:
    rise = 345.8 - 173.8
    yield PrintedNumber("rise of the spring force", "kgf", 172, rise)
    moment = 1e8 * float(formulas.polar_moment(wire=PAPER_INPUTS.wire))
    yield PrintedNumber("polar moment of the wire", "cm^4", 0.2036, moment)
    length = 6 * 0.2036 * 750_000 / (172 * 4**2)
    yield PrintedNumber("length of the wire", "cm", 332, length, Cause.ROUNDING, "cut off, not rounded: 333")
    yield PrintedNumber("turns", "1", 13, 332 / (math.pi * 8))
    section = 1e6 * float(formulas.section_modulus(wire=PAPER_INPUTS.wire))
    yield PrintedNumber("section modulus of the wire", "cm^3", 0.338, section, Cause.SLIP, "should be 0.339")
    yield PrintedNumber("stress under 346 kgf", "kgf/cm^2", 4100, 346 * 4 / 0.338)


def _compare_sleeve_forces() -> Iterator[PrintedNumber]:
    static_forces, regulating_forces = [], []
    for side, force in ((15, 173.8), (-15, 345.8)):
        static_force = closed.static_sleeve_force(PAPER_GOVERNOR, lever_angle=math.radians(side), spring_force=force * KILOGRAM_FORCE)
        static_forces.append(float(static_force) / KILOGRAM_FORCE)
        regulating_forces.append(float(formulas.regulating_force(static_force=static_forces[-1])))
    steps = "computed from steps of three digits"
    yield PrintedNumber("static force S, inner", "kgf", 460, static_forces[0], Cause.ROUNDING, steps)
    yield PrintedNumber("static force S, outer", "kgf", 503, static_forces[1], Cause.ROUNDING, steps)
    yield PrintedNumber("regulating force K, inner", "kgf", 18.4, regulating_forces[0])
    remark = "the next line has 20.2"
    yield PrintedNumber("regulating force K, outer", "kgf", 26.2, regulating_forces[1], Cause.MISPRINT, remark)
    change = 100 * (regulating_forces[1] - regulating_forces[0]) / (0.5 * (regulating_forces[0] + regulating_forces[1]))
    remark = "2 / 20, of forces that differ by 1.74 kgf"
    yield PrintedNumber("its change over the stroke", "%", 10, change, Cause.ROUNDING, remark)


def _compare_spring_force_table() -> Iterator[PrintedNumber]:
    for radius, *printed in PRINTED_SPRING_FORCES:
        lever_angle = math.asin((122 - radius) / 115)
        for rpm, speed, force in zip((204, 212), PAPER_SPEEDS, printed, strict=True):
            force_in_newton = closed.astatic_spring_force(PAPER_GOVERNOR, lever_angle=lever_angle, spindle_speed=speed)
            recomputed = float(force_in_newton) / KILOGRAM_FORCE
            is_misprint = abs(force - recomputed) > SLIDE_RULE_TOLERANCE
            cause = Cause.MISPRINT if is_misprint else None
            remark = "not on the curve of its neighbours; one digit wrong, 189.8 is meant" if is_misprint else ""
            yield PrintedNumber(f"spring force at {radius:g} mm, {rpm} rpm", "kgf", force, recomputed, cause, remark)


def _compare_counter_example() -> Iterator[PrintedNumber]:
    low, middle, high = (float(formulas.regulating_force(static_force=force)) for force in COUNTER_EXAMPLE_FORCES)
    yield PrintedNumber("Pohlhausen's no. 97, K low", "kgf", 7.5, low, Cause.ROUNDING, "cut off, not rounded: 7.6")
    yield PrintedNumber("Pohlhausen's no. 97, K middle", "kgf", 10.5, middle)
    yield PrintedNumber("Pohlhausen's no. 97, K high", "kgf", 13.4, high)
    yield PrintedNumber("Pohlhausen's no. 97, change of K", "%", 56, 100 * (13.4 - 7.5) / 10.5)

"""Errata of Redtenbacher's theory of the flywheel.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equations (57) to (68).
"""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.numerics.roots import find_root
from governor_mechanism.papers.erratum import Erratum, Paper, make_number_erratum
from governor_mechanism.studies.design.flywheel import (
    PAPER_ENGINE,
    PRINTED_ANGLES,
    PRINTED_LOAD_CONSTANT,
    PaperComparison,
    compare_with_paper,
)
from governor_mechanism.studies.design.skeleton import Cause, PrintedNumber

COMMAND = "governor-mechanism design flywheel"
"""Prints every number of the paper beside the recomputed one, and simulates the flywheels."""

WRONG_PRESSURE_RATIO = 0.5
"""The r / p with which the printed third term agrees; by the paper's data it is 1.5 / 4."""

_TERMS = "numbers after (68), {} term of the bracket"

_number = partial(make_number_erratum, paper=Paper.REDTENBACHER, command=COMMAND)
FORMULA_COMMAND = "governor-mechanism errata --paper redtenbacher --no-figure"
"""Shows the formulas of the paper that are not right."""

_formula = partial(Erratum, paper=Paper.REDTENBACHER, command=FORMULA_COMMAND)


def list_redtenbacher_errata() -> Iterator[Erratum]:
    """Return the errata: the wrong term and what follows from it, then the formulas and the other numbers in the order of the text."""
    comparison = compare_with_paper()
    numbers = {number.quantity: number for number in (*comparison.numbers, *comparison.terms)}
    yield from _errors(numbers, comparison)
    yield _wrong_sign()
    yield from _lost_typefaces(numbers)
    yield from _rounded_limits(numbers)
    yield from _inaccurate_terms(numbers)


def _errors(numbers: dict[str, PrintedNumber], comparison: PaperComparison) -> Iterator[Erratum]:
    """Yield the wrong term, and what follows from it."""
    ratio = PAPER_ENGINE.back_pressure / PAPER_ENGINE.supply_pressure
    cosines = math.cos(PRINTED_ANGLES[0]) - math.cos(PRINTED_ANGLES[1])
    total = numbers["sum of the bracket"]
    coefficient = numbers["coefficient of mu N / n"]
    lacking = f"{100 * (1 - total.printed / total.recomputed):.0f} %"
    third = numbers["back pressure (66)"]
    slips = (total.printed - third.printed) - (total.recomputed - third.recomputed)
    yield _number(
        third,
        4,
        name="back-pressure",
        place=_TERMS.format("third"),
        proof=f"The term is (r/p) (cos 3 deg - cos 95 deg) / 2, subtracted, with r/p = 1.5/4 = {ratio:g}. "
        f"The printed number follows from r/p = {WRONG_PRESSURE_RATIO:g}, which gives "
        f"{-WRONG_PRESSURE_RATIO * cosines / 2:.4f}.",
        consequence=f"The sum of the bracket, and with it the flywheel, comes out {lacking} too small: the "
        f"third term takes off {third.recomputed - third.printed:.4f}, rounding and a small slip in other "
        f"terms add {slips:.4f}.",
    )
    yield _number(
        total,
        4,
        name="bracket",
        place="numbers after (68), sum of the bracket",
        proof="The seven printed terms add up to the printed sum, but the third is wrong, and four are rounded or inaccurate.",
        consequence="It follows from the third term. With the exact roots of (61) and (63) in place of 3 "
        f"and 95 deg the sum is {sum(comparison.exact_terms):.6f}.",
    )
    wheel = comparison.wheels[0]
    yield _number(
        coefficient,
        0,
        name="flywheel",
        place="last equation, kinetic energy of the flywheel over mu N/n",
        proof=f"30 x 75 x 4/0.4 times the right sum of the bracket; {comparison.exact_coefficient:.0f} with the exact angles.",
        consequence="It follows from the third term, through the sum. A flywheel by the printed number is "
        f"{lacking} too light: under the load that closes the cycle its speed fluctuates {wheel.excess:.2f} times as much as mu allows. "
        'The closing remark, that this kinetic energy is "bedeutend grösser" '
        "(considerably larger) than that of a steam engine's flywheel, is right, and of the right number even more true.",
    )


def _wrong_sign() -> Erratum:
    """Return the wrong sign of a formula."""
    plus, minus = (math.degrees(_root_of_first_balance(sign)) for sign in (1, -1))
    return _formula(
        name="sign-in-61",
        place="(61) with numbers",
        subject="pressure before the pump piston",
        cause=Cause.MISPRINT,
        printed="1.05 / (1.05 + (1 - cos phi) / 2)",
        right="1.05 / (1.05 - (1 - cos phi) / 2)",
        proof="(61) has the minus. The roots hardly differ: "
        f"{plus:.4f} deg with the plus, {minus:.4f} deg with the minus; 3 deg is printed.",
    )


def _lost_typefaces(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the formulas whose typefaces and brackets the copy may have lost."""
    yield _formula(
        name="balance-area",
        place="balance before (61)",
        subject="load in the balance of the first interval",
        cause=Cause.UNDECIDED,
        printed="(2/pi) R (pressure of the atmosphere) (L/l) / sin phi",
        right="(2/pi) R A (L/l) / sin phi",
        proof="By (60) the load at the crank is (2/pi) R A with the area A of the piston. The letters "
        "differ only in their typeface, Fraktur for the pressure, which the copy mixes elsewhere too.",
    )
    yield _formula(
        name="fifth-term-ratio",
        place="both equations that regroup the terms after (68), fifth term",
        subject="air left behind the pump piston",
        cause=Cause.UNDECIDED,
        printed="m (a L) / (A l)",
        right="m (a l) / (A L)",
        proof="(65) has a m l p, which divided by A p L is m (a l) / (A L). The copy confuses L, l and 1 "
        "elsewhere too; the numbers do not show it: L = l.",
    )
    expansion = numbers["expansion (66)"].recomputed
    initial = PAPER_ENGINE.cut_off + PAPER_ENGINE.clearance
    as_printed = PAPER_ENGINE.cut_off + PAPER_ENGINE.clearance * expansion / initial
    yield _formula(
        name="first-term-brackets",
        place=_TERMS.format("first"),
        subject="expansion, formula with numbers",
        cause=Cause.UNDECIDED,
        printed="0.375 + 0.05 ln(...)",
        right="(0.375 + 0.05) ln(...)",
        proof=f"Without the brackets it would be {as_printed:.4f}; the number beside it, 0.1430, is that of the formula with brackets.",
    )


def _root_of_first_balance(sign: float) -> float:
    """Return the root (rad) of (61) with the paper's numbers, with a sign in the last denominator: 1 as printed, -1 as derived."""

    def balance(angle: float) -> float:
        travel = (1 - math.cos(angle)) / 2
        return 2.5 + 0.2 / (0.05 + travel) - 1.05 / (1.05 + sign * travel) - PRINTED_LOAD_CONSTANT / math.sin(angle)

    return find_root(balance, math.radians(1.0), PAPER_ENGINE.interval_limits[0])


def _rounded_limits(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the limits that are cut off."""
    limit = numbers["end of the first interval"]
    minutes = 60 * (limit.recomputed - limit.printed)
    yield _number(
        limit,
        0,
        name="first-limit",
        place="(62) with numbers, lower limit",
        proof=f"1 - cos phi = 2 m (4 - 1) gives 45 deg {minutes:.0f}', cut off to the degree. There is no root near.",
    )
    yield _number(
        numbers["end of the third interval"],
        1,
        name="third-limit",
        place="(63) with numbers, upper limit 180 deg - (54 deg + 30')",
        proof="1 - cos phi = 2 (1 + m)(1 - 1/4) gives 180 deg - 54 deg 54', cut off to the half degree, to "
        "which the limit of 75 deg 30' beside it is rounded too. There is no root near.",
    )


def _inaccurate_terms(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the terms of the bracket that are computed from rounded steps, and one with a small slip."""
    term = PAPER_ENGINE.cut_off + PAPER_ENGINE.clearance
    yield _number(
        numbers["expansion (66)"],
        4,
        name="first-term",
        place=_TERMS.format("first"),
        proof="(0.375 + 0.05) ln((0.05 + (1 - cos 95 deg) / 2) / (0.05 + 0.375)). The printed number is "
        f"0.425 ln 1.4 = {term * math.log(1.4):.4f}: the ratio 1.397 is rounded.",
    )
    pump = (1 + PAPER_ENGINE.pump_clearance) / 4
    yield _number(
        numbers["air before the pump piston (65)"],
        4,
        name="fourth-term",
        place=_TERMS.format("fourth"),
        proof="(1.05 / 4) ln((1.1 + cos 3 deg) / (1.1 + cos 95 deg)), subtracted. The printed number is "
        f"0.2625 ln 2.07 = {pump * math.log(2.07):.4f}: the ratio 2.072 is rounded.",
    )
    yield _number(
        numbers["air left behind it (65)"],
        4,
        name="fifth-term",
        place=_TERMS.format("fifth"),
        proof=f"The printed number is 0.05 ln 4 = {PAPER_ENGINE.pump_clearance * math.log(4):.4f}: the travel at 3 deg is left out.",
    )
    yield _number(
        numbers["load (67)"],
        4,
        name="seventh-term",
        place=_TERMS.format("seventh"),
        proof="(0.4 / 4) (95 - 3) / 180, subtracted. The printed number is perhaps computed from angles in "
        f"radians with two decimals, 0.1 (1.66 - 0.05) / 3.14 = {0.1 * (1.66 - 0.05) / 3.14:.4f}.",
    )

"""Errata of Dubois' article on Hartung's governor.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.papers.erratum import Erratum, Paper, make_number_erratum
from governor_mechanism.studies.design.hartung import PAPER_INPUTS, build_hartung_layout, compare_with_paper
from governor_mechanism.studies.design.skeleton import Cause, PrintedNumber

COMMAND = "governor-mechanism design hartung"
"""Prints every number of the paper beside the recomputed one."""

USED_ANGLE_DEG = 132.0
"""Angle of the bell crank with which the paper goes on."""

MEANT_FORCE = "189.8"
"""Spring force, kgf, that table 2 means at 92 mm and 212 rpm: only the second digit of the printed number is wrong."""

_number = partial(make_number_erratum, paper=Paper.DUBOIS, command=COMMAND)
_formula = partial(Erratum, paper=Paper.DUBOIS, command="governor-mechanism errata --paper dubois --no-figure")


def list_dubois_errata() -> Iterator[Erratum]:
    """Return the errata: the wrong angle, then wrong digits, formulas whose exponents are lost, and rounded numbers."""
    comparison = compare_with_paper()
    numbers = {number.quantity: number for number in (*comparison.numbers, *comparison.table, *comparison.counter_example)}
    yield _wrong_angle(numbers)
    yield from _wrong_radii_and_speeds(numbers)
    yield from _wrong_forces(numbers)
    yield from _wrong_steps()
    yield from _lost_exponents(numbers)
    yield from _rounded_dimensions(numbers)
    yield from _rounded_forces(numbers)


def _wrong_angle(numbers: dict[str, PrintedNumber]) -> Erratum:
    """Return the wrong angle of the bell crank."""
    angle = numbers["angle of the bell crank"]
    arc, difference = 180 - angle.recomputed, angle.recomputed - angle.printed
    spreads = [100 * build_hartung_layout(PAPER_INPUTS, math.radians(one)).spread for one in (angle.recomputed, USED_ANGLE_DEG)]
    return _number(
        angle,
        0,
        name="bell-crank-angle",
        place="p. 618, tan gamma = -106/115",
        quotation="worauf man in den trigonometrischen Tabellen den Wert von γ findet zu γ = 133°. Weil γ "
        "= 133° eine ungerade Zahl ist, nehmen wir lieber für die nachfolgende Berechnung γ = 132°.",
        translation="for which the trigonometric tables give γ = 133°. Since γ = 133° is an odd number, we "
        "rather take γ = 132° for the calculation that follows.",
        proof=f"arctan(106/115) = {arc:.2f} deg must be taken from 180 deg; added to 90 deg it gives "
        f"{90 + arc:.2f} deg, which rounds to the printed 133 deg. That this is the cause is inferred; the "
        f"difference of {difference:.1f} deg is certain.",
        consequence="The article aims at a constant static sleeve force. With springs along the straight "
        f"line through both speeds it changes by {spreads[0]:.1f} % over the stroke with "
        f"{angle.recomputed:.2f} deg, by {spreads[1]:.1f} % with the {USED_ANGLE_DEG:g} deg that the paper "
        "uses.",
    )


def _wrong_radii_and_speeds(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the radii and the speed with a wrong digit."""
    yield _number(
        numbers["radius of a weight at the inner end"],
        0,
        name="rest-radius",
        place="p. 618, 15 mm + 77 mm",
        meant="92",
        proof="The sum is 92 mm, which the next lines use.",
    )
    yield _number(
        numbers["radius innermost"],
        0,
        name="inner-radius",
        subject="radius of a weight at the inner end",
        place="p. 618, 122 - 30",
        meant="92",
        proof="122 mm - 115 mm sin 15 deg; the paper goes on with 92 mm.",
    )
    yield _number(
        numbers["the same, in C2"],
        1,
        name="squared-speed",
        subject="square of the fast speed",
        place="p. 618, centrifugal force at the outer end",
        meant="492.9",
        proof="The square of 22.201/s, given as 492.9 a few lines above.",
    )


def _wrong_forces(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the forces with a wrong digit."""
    neighbours = [numbers[f"spring force at {radius} mm, 212 rpm"].printed for radius in (100, 106)]
    force = numbers["spring force at 92 mm, 212 rpm"]
    slopes = [(neighbours[0] - one) / 8 for one in (float(MEANT_FORCE), force.printed)] + [(neighbours[1] - neighbours[0]) / 6]
    yield _number(
        force,
        1,
        name="table-2",
        subject="spring force at 212 rpm",
        place="p. 619, table 2, 92 mm",
        meant=MEANT_FORCE,
        proof=f"With {MEANT_FORCE} the force rises by {slopes[0]:.2f} kgf/mm to the next radius, with the "
        f"printed {force.printed:g} by {slopes[1]:.2f} kgf/mm; in the next interval it is {slopes[2]:.2f} "
        "kgf/mm.",
    )
    yield _number(
        numbers["regulating force K, outer"],
        1,
        name="outer-regulating-force",
        place="p. 620, K in the outermost position",
        meant="20.2",
        proof="0.04 x 503 = 20.12; the next line has 20.2.",
    )


def _wrong_steps() -> Iterator[Erratum]:
    """Yield the steps of a calculation with a wrong digit or sign, whose results are right."""
    step = partial(_formula, cause=Cause.MISPRINT)
    yield step(
        name="inner-force-steps",
        place="p. 620, S in the innermost position",
        subject="steps to the static sleeve force",
        printed="2 (173.8 + 12.0) - 0.677 x 1.77; 2 x 85.8 x ...",
        right="2 (173.8 + 12.0) x 0.677 x 1.77; 2 x 185.8 x ...",
        proof="Only so the printed result, 445 + 15 = 460 kgf, follows.",
    )
    yield step(
        name="outer-force-steps",
        place="p. 620, S in the outermost position",
        subject="steps to the static sleeve force",
        printed="... + 5",
        right="... + 15",
        proof="The sleeve weighs 15 kgf, and the next line has 488 + 15 = 503 kgf.",
    )
    yield step(
        name="change-fraction",
        place="p. 620, change of the regulating force",
        subject="change over the mean",
        printed="2/10 = 1/10 = 10 %",
        right="2/20 = 1/10 = 10 %",
        proof="The change of 2 kgf is compared with a force of about 20 kgf.",
    )


def _lost_exponents(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the formulas whose exponents, brackets or factors the copy may have lost."""
    lost = partial(_formula, cause=Cause.UNDECIDED)
    yield lost(
        name="unit-of-squared-speed",
        place="p. 618, both centrifugal forces",
        subject="unit of the squared speeds",
        printed="s^2",
        right="s^-2",
        proof="The same squares have s^-2 a few lines above; only with it the product is a force. The copy "
        "may have lost the minus of the exponent.",
    )
    yield lost(
        name="polar-moment",
        place="p. 620, J_p with numbers",
        subject="polar moment of the wire",
        printed="3.1416 x 1.2 cm^4 / 32",
        right="3.1416 x (1.2 cm)^4 / 32",
        proof="The next step has 2.074 = 1.2^4, and the result, 0.2036 cm^4, is right "
        f"({numbers['polar moment of the wire'].recomputed:.5f} cm^4). The copy may have lost brackets.",
    )
    yield lost(
        name="wire-length-units",
        place="p. 620, L with numbers",
        subject="units in the length of the wire",
        printed="6 cm^4 x 750000 / (172 x 4 cm^2)",
        right="6 cm x 0.2036 cm^4 x 750000 / (172 x (4 cm)^2)",
        proof="Between one cm and the next the factor 0.2036 is lost, and brackets at the 4 cm; the next line is right.",
    )
    yield lost(
        name="section-modulus-power",
        place="p. 620, W_d with numbers",
        subject="section modulus of the wire",
        printed="3.1416 x 1.2 / 16",
        right="3.1416 x 1.2^3 / 16",
        proof="The next step has 1.728 = 1.2^3. The copy may have lost the exponent.",
    )


def _rounded_dimensions(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the mass and the dimensions of the spring that are cut off or a little wrong."""
    mass = numbers["mass of a weight"]
    yield _number(
        mass,
        2,
        name="mass",
        place="pp. 618 and 619, G/g",
        proof="45 / 9.81, cut off instead of rounded. With it the inner centrifugal force comes out at 192 "
        f"kgf, else at {numbers['centrifugal force C1'].recomputed:.1f} kgf.",
    )
    yield _number(
        numbers["length of the wire"],
        0,
        name="wire-length",
        place="p. 620, L",
        proof="6 x 0.2036 x 750000 / (172 x 16), cut off instead of rounded.",
    )
    yield _number(numbers["section modulus of the wire"], 3, name="section-modulus", place="p. 620, W_d", proof="3.1416 x 1.728 / 16.")


def _rounded_forces(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    """Yield the forces that are cut off or computed from rounded steps."""
    for side, spring, ratio in (("inner", 173.8 + 12.0, 1.77), ("outer", 345.8 - 12.0, 1.08)):
        yield _number(
            numbers[f"static force S, {side}"],
            0,
            name=f"{side}-force",
            place=f"p. 620, S in the {side}most position",
            proof=f"The formula without rounded steps; those of the paper give 2 x {spring:g} x 0.677 x "
            f"{ratio} + 15 = {2 * spring * 0.677 * ratio + 15:.1f}.",
        )
    yield _number(
        numbers["its change over the stroke"],
        0,
        name="change",
        subject="over the stroke",
        place="p. 620, change of the regulating force",
        proof="The difference of the regulating forces, rounded up to 2 kgf, over their mean, rounded up to 20 kgf.",
    )
    yield _number(
        numbers["Pohlhausen's no. 97, K low"],
        1,
        name="counter-example",
        subject="regulating force",
        place="p. 620, Pohlhausen's governor, lowest position",
        proof="0.04 x 189, cut off instead of rounded.",
    )

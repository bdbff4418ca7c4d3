"""Errata of Dubois' article on Hartung's governor.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.studies.errata.erratum import Category, Erratum, Paper, make_number_erratum
from governor_mechanism.studies.hartung.design import build_hartung_layout
from governor_mechanism.studies.hartung.inputs import PAPER_INPUTS
from governor_mechanism.studies.hartung.paper_comparison import PAPER_GOVERNOR, PaperComparison, compare_with_paper
from governor_mechanism.studies.printed_numbers import PrintedNumber

COMMAND = "governor-mechanism design hartung"
"""Prints every number of the paper beside the recomputed one."""

USED_ANGLE_DEG = 132.0
"""Angle of the bell crank with which the paper goes on."""

MEANT_FORCE = "189.8"
"""Spring force, kgf, that table 2 means at 92 mm and 212 rpm: only the second digit of the printed number is wrong."""

_number = partial(make_number_erratum, paper=Paper.DUBOIS, command=COMMAND)
_misprint = partial(_number, category=Category.MISPRINT)
_slip = partial(_number, category=Category.SLIP)
_formula = partial(Erratum, paper=Paper.DUBOIS, category=Category.MISPRINT, command=COMMAND)


def list_dubois_errata() -> Iterator[Erratum]:
    """Return the errata, the errors first.

    Yields
    ------
    Erratum
        The errata in the order of their weight, then of the text.
    """
    comparison = compare_with_paper()
    numbers = {number.quantity: number for number in (*comparison.numbers, *comparison.table, *comparison.counter_example)}
    yield from _errors(numbers)
    yield from _misprints_of_geometry(numbers)
    yield from _misprints_of_spring_and_force(numbers)
    yield from _slips(numbers, comparison)


def _errors(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    angle = numbers["angle of the bell crank"]
    arc, difference = 180 - angle.recomputed, angle.recomputed - angle.printed
    spreads = [100 * build_hartung_layout(PAPER_INPUTS, math.radians(one)).spread for one in (angle.recomputed, USED_ANGLE_DEG)]
    yield _number(
        angle,
        0,
        name="bell-crank-angle",
        place="p. 618, tan gamma = -106/115",
        category=Category.ERROR,
        quotation="worauf man in den trigonometrischen Tabellen den Wert von γ findet zu γ = 133°. Weil γ = 133° eine ungerade Zahl ist, "
        "nehmen wir lieber für die nachfolgende Berechnung γ = 132°.",
        translation="for which the trigonometric tables give γ = 133°. Since γ = 133° is an odd number, we rather take γ = 132° for the "
        "calculation that follows.",
        proof=f"arctan(106/115) = {arc:.2f} deg must be taken from 180 deg; added to 90 deg it gives {90 + arc:.2f} deg, "
        f"which rounds to the printed 133 deg. That this is the cause is inferred; the difference of {difference:.1f} deg is certain.",
        consequence="The article aims at a constant static sleeve force. With springs along the straight line through both speeds it "
        f"changes by {spreads[0]:.1f} % over the stroke with {angle.recomputed:.2f} deg, by {spreads[1]:.1f} % with the "
        f"{USED_ANGLE_DEG:g} deg that the paper uses.",
    )
    on_axis = 1e3 * PAPER_GOVERNOR.fulcrum_radius / math.sin(PAPER_GOVERNOR.angle)
    symmetric = numbers["sleeve's arm b, at 132 deg"].recomputed
    yield Erratum(
        paper=Paper.DUBOIS,
        name="sleeve-arm",
        place="pp. 618-619, choice of b, found graphically",
        subject="construction of the arm b",
        category=Category.ERROR,
        printed="the end of arm b is on the axis in the middle position",
        right=f"the ends of the stroke are symmetric about the axis (b = {symmetric:.2f} mm); on the axis it would need {on_axis:.2f} mm",
        unit="mm",
        right_value=symmetric,
        quotation="wollen wir b so wählen, daß in der Mittellage der Endpunkt des unteren Hebelarms des Winkelhebels in die Regulatorachse "
        "hineinfällt; daraus ergibt sich (graphisch) b zu b = 170 mm.",
        translation="we shall choose b so that in the middle position the end of the lower arm of the bell crank falls on the axis of the "
        "governor; this gives (graphically) b = 170 mm.",
        proof="The printed 170 mm is right for the stated aim, hangers that are symmetric about the axis at both ends of the stroke; it is "
        f"{symmetric:.2f} mm rounded. In the middle position the end is on the axis for b = 122 mm / sin {USED_ANGLE_DEG:g} deg.",
        consequence=f"Who repeats the construction as it is described gets an arm of {on_axis:.2f} mm, which misses the aim.",
        command=COMMAND,
    )


def _misprints_of_geometry(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    yield _misprint(
        numbers["radius of a weight at the inner end"],
        0,
        name="rest-radius",
        place="p. 618, 15 mm + 77 mm",
        meant="92",
        proof="The sum is 92 mm, which the next lines use.",
    )
    yield _misprint(
        numbers["radius innermost"],
        0,
        name="inner-radius",
        subject="radius of a weight at the inner end",
        place="p. 618, 122 - 30",
        meant="92",
        proof="122 mm - 115 mm sin 15 deg; the paper goes on with 92 mm.",
    )
    yield _misprint(
        numbers["the same, in C2"],
        1,
        name="squared-speed",
        subject="square of the fast speed",
        place="p. 618, centrifugal force at the outer end",
        meant="492.9",
        proof="The square of 22.201/s, given as 492.9 a few lines above.",
    )
    yield _formula(
        name="unit-of-squared-speed",
        place="p. 618, both centrifugal forces",
        subject="unit of the squared speeds",
        printed="s^2",
        right="s^-2",
        proof="The same squares have s^-2 a few lines above; only with it the product is a force.",
    )


def _misprints_of_spring_and_force(numbers: dict[str, PrintedNumber]) -> Iterator[Erratum]:
    neighbours = [numbers[f"spring force at {radius} mm, 212 rpm"].printed for radius in (100, 106)]
    force = numbers["spring force at 92 mm, 212 rpm"]
    slopes = [(neighbours[0] - one) / 8 for one in (float(MEANT_FORCE), force.printed)] + [(neighbours[1] - neighbours[0]) / 6]
    yield _misprint(
        force,
        1,
        name="table-2",
        subject="spring force at 212 rpm",
        place="p. 619, table 2, 92 mm",
        meant=MEANT_FORCE,
        proof=f"With {MEANT_FORCE} the force rises by {slopes[0]:.2f} kgf/mm to the next radius, with the printed {force.printed:g} by "
        f"{slopes[1]:.2f} kgf/mm; in the next interval it is {slopes[2]:.2f} kgf/mm.",
    )
    yield _formula(
        name="polar-moment",
        place="p. 620, J_p with numbers",
        subject="polar moment of the wire",
        printed="3.1416 x 1.2 cm^4 / 32",
        right="3.1416 x (1.2 cm)^4 / 32",
        proof="The next step has 2.074 = 1.2^4, and the result, 0.2036 cm^4, is right "
        f"({numbers['polar moment of the wire'].recomputed:.5f} cm^4).",
    )
    yield _formula(
        name="wire-length-units",
        place="p. 620, L with numbers",
        subject="units in the length of the wire",
        printed="6 cm^4 x 750000 / (172 x 4 cm^2)",
        right="6 cm x 0.2036 cm^4 x 750000 / (172 x (4 cm)^2)",
        proof="The factor J_p is left out, its unit is printed at the 6 cm, and the 4 cm lack their square; the next line is right.",
    )
    yield _formula(
        name="section-modulus-power",
        place="p. 620, W_d with numbers",
        subject="section modulus of the wire",
        printed="3.1416 x 1.2 / 16",
        right="3.1416 x 1.2^3 / 16",
        proof="The next step has 1.728 = 1.2^3.",
    )
    yield _formula(
        name="inner-force-steps",
        place="p. 620, S in the innermost position",
        subject="steps to the static sleeve force",
        printed="2 (173.8 + 12.0) - 0.677 x 1.77; 2 x 85.8 x ...",
        right="2 (173.8 + 12.0) x 0.677 x 1.77; 2 x 185.8 x ...",
        proof="Only so the printed result, 445 + 15 = 460 kgf, follows.",
    )
    yield _formula(
        name="outer-force-steps",
        place="p. 620, S in the outermost position",
        subject="steps to the static sleeve force",
        printed="... + 5",
        right="... + 15",
        proof="The sleeve weighs 15 kgf, and the next line has 488 + 15 = 503 kgf.",
    )
    yield _misprint(
        numbers["regulating force K, outer"],
        1,
        name="outer-regulating-force",
        place="p. 620, K in the outermost position",
        meant="20.2",
        proof="0.04 x 503 = 20.12; the next line has 20.2.",
    )
    yield _formula(
        name="change-fraction",
        place="p. 620, change of the regulating force",
        subject="change over the mean",
        printed="2/10 = 1/10 = 10 %",
        right="2/20 = 1/10 = 10 %",
        proof="The change of 2 kgf is compared with a force of about 20 kgf.",
    )


def _slips(numbers: dict[str, PrintedNumber], comparison: PaperComparison) -> Iterator[Erratum]:
    mass = numbers["mass of a weight"]
    yield _slip(
        mass,
        2,
        name="mass",
        place="pp. 618 and 619, G/g",
        proof="45 / 9.81, cut off instead of rounded. With it the inner centrifugal force comes out at 192 kgf, else at "
        f"{numbers['centrifugal force C1'].recomputed:.1f} kgf.",
    )
    # The misprint of the table is an erratum of its own.
    table = [number for number in comparison.table if not number.misprint]
    largest = max(table, key=lambda number: abs(number.printed - number.recomputed))
    yield _slip(
        largest,
        1,
        name="table-2-slips",
        place="p. 619, table 2",
        proof=f"The largest slip of the other {len(table)} forces of the table, by the formula for P with the angle from the radius.",
    )
    yield _slip(
        numbers["length of the wire"],
        0,
        name="wire-length",
        place="p. 620, L",
        proof="6 x 0.2036 x 750000 / (172 x 16), cut off instead of rounded.",
    )
    yield _slip(numbers["section modulus of the wire"], 3, name="section-modulus", place="p. 620, W_d", proof="3.1416 x 1.728 / 16.")
    steps = "The formula without rounded steps; the steps of the paper have three digits."
    yield _slip(numbers["static force S, inner"], 0, name="inner-force", place="p. 620, S in the innermost position", proof=steps)
    yield _slip(numbers["static force S, outer"], 0, name="outer-force", place="p. 620, S in the outermost position", proof=steps)
    yield _slip(
        numbers["its change over the stroke"],
        0,
        name="change",
        subject="over the stroke",
        place="p. 620, change of the regulating force",
        proof="The difference of the regulating forces, which the paper rounds up to 2 kgf, over their mean.",
    )
    yield _slip(
        numbers["Pohlhausen's no. 97, K low"],
        1,
        name="counter-example",
        subject="regulating force",
        place="p. 620, Pohlhausen's governor, lowest position",
        proof="0.04 x 189, cut off instead of rounded.",
    )

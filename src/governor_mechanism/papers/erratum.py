"""One erratum of a paper: what is printed, what is right, why, and the command that shows it; and those of Marks' construction.

References
----------
Müller-Melchiors, Dinglers Polytechnisches Journal 241 (1881), p. 161, prints the ratio 4 of rod and eccentric; other dimensions are ours.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.studies.design.skeleton import Cause, PrintedNumber
from governor_mechanism.units.quantities import format_value

N_MORE_DIGITS = 2
"""Digits that a recomputed number shows beyond those of the printed one."""


class Paper(StrEnum):
    """The papers, by the name under which each is known here."""

    REDTENBACHER = "redtenbacher"
    ZEHNDER = "zehnder"
    MARKS = "marks"
    DUBOIS = "dubois"


PAPER_REFERENCES = {
    Paper.REDTENBACHER: 'F. Redtenbacher, "Die Luftexpansions-Maschine", Mannheim 1853, chapter "Theorie des Schwungrades"',
    Paper.ZEHNDER: 'L. Zehnder, "Die gewöhnlichen Centrifugalregulatoren", Dinglers Polytechnisches Journal 225 (1877), pp. 1-14',
    Paper.MARKS: "Müller-Melchiors, \"W. D. Marks' Construction des Fehlergliedes im Zeuner'schen Schieberdiagramm\", "
    "Dinglers Polytechnisches Journal 241 (1881), p. 161",
    Paper.DUBOIS: 'Fr. Dubois, "Über eine wünschenswerte Berichtigung am Hartung-Regulator", '
    "Dinglers Polytechnisches Journal 327 (1912), pp. 618-620",
}
"""Author, title and place of each paper."""


CAUSE_MEANINGS = {
    Cause.ERROR: "a wrong argument or calculation of the author that leads to another machine or to a false conclusion",
    Cause.CONSEQUENCE: "a number computed from an error, or a statement by the same wrong argument",
    Cause.MISPRINT: "a wrong digit or sign in the text as it was read; the lines around it show the right one",
    Cause.SLIP: "a small mistake of the author that changes no conclusion",
    Cause.ROUNDING: "a number that was cut off, or computed from rounded steps",
    Cause.UNDECIDED: "a typeface, index, exponent, factor or bracket that may be lost in the copy only",
}
"""What each cause is."""

CAUSE_NOUNS = {
    Cause.ERROR: "error",
    Cause.CONSEQUENCE: "consequence",
    Cause.MISPRINT: "misprint",
    Cause.SLIP: "small slip",
    Cause.ROUNDING: "rounding",
    Cause.UNDECIDED: "undecided place",
}
"""What an erratum of each cause is called; several have an s."""


@dataclass(frozen=True, kw_only=True)
class Erratum:
    """An erratum.

    Attributes
    ----------
    paper
        The paper.
    name
        Name within the paper, which does not change.
    place
        Where it is printed: page, equation, or the passage as the paper names it.
    subject
        The quantity, formula or statement.
    cause
        Why it is not right.
    printed
        What is printed; a statement in translation.
    right
        What is right; for a misprinted number that which the paper means, and in brackets the recomputed one if it differs.
    proof
        Why, in one or two sentences.
    command
        Command of this package that shows it.
    consequence
        What follows from it, or what remains right; empty for what concerns only one place.
    quotation
        The words of the paper, in German, for a statement; else empty.
    translation
        The same in English.
    unit
        Unit of both numbers, the paper's; empty for a number without unit.
    printed_value
        The printed number; None for a formula or a statement.
    printed_digits
        Number of its digits after the decimal point.
    right_value
        The number recomputed, or that of a right statement; None if there is none.
    simulated
        What the simulation finds, in a sentence; empty if it was not asked for or does not concern the erratum.
    """

    paper: Paper
    name: str
    place: str
    subject: str
    cause: Cause
    printed: str
    right: str
    proof: str
    command: str
    consequence: str = ""
    quotation: str = ""
    translation: str = ""
    unit: str = ""
    printed_value: float | None = None
    printed_digits: int = 0
    right_value: float | None = None
    simulated: str = ""

    def reasons(self) -> str:
        """Return proof, consequence and what the simulation finds, as one text."""
        simulated = f"Simulation: {self.simulated}." if self.simulated else ""
        return " ".join(filter(None, (self.proof, self.consequence, simulated)))


def make_number_erratum(
    number: PrintedNumber,  # the number, printed and recomputed, with the cause of the difference
    digits: int,  # number of digits that the paper prints after the decimal point
    *,
    paper: Paper,
    name: str,
    place: str,
    proof: str,
    command: str,
    consequence: str = "",
    quotation: str = "",
    translation: str = "",
    subject: str = "",  # what the number is; the name of the quantity if empty
    # the number that the paper means, with the digits that it prints; empty if it means another or this is
    # not known
    meant: str = "",
) -> Erratum:
    """Return the erratum of a printed number; raise ValueError if the number has no cause to deviate: it is right then."""
    if number.cause is None:
        raise ValueError(f"{number.quantity} has no cause to deviate: it is no erratum")
    unit = "" if number.unit == "1" else number.unit
    recomputed = f"{number.recomputed:.{digits + N_MORE_DIGITS}f}"
    printed, right = (f"{text} {unit}".strip() for text in (f"{number.printed:.{digits}f}", meant or recomputed))
    if meant and float(meant) != float(recomputed):
        right += f" ({recomputed})"
    return Erratum(
        paper=paper,
        name=name,
        place=place,
        subject=subject or number.quantity,
        cause=number.cause,
        printed=printed,
        right=right,
        proof=proof,
        command=command,
        consequence=consequence,
        quotation=quotation,
        translation=translation,
        unit=unit,
        printed_value=float(number.printed),
        printed_digits=digits,
        right_value=float(number.recomputed),
    )


def check_paper(paper: str) -> Paper:
    """Return a paper by its name; raise MechanismError if there is no such paper."""
    if not isinstance(paper, str) or paper not in set(Paper):
        raise MechanismError(
            f"paper must be one of {', '.join(Paper)}; got {format_value(paper)}.{did_you_mean(paper, [one.value for one in Paper])}"
        )
    return Paper(paper)


def check_cause(cause: str) -> Cause:
    """Return a cause by its name; raise MechanismError if there is no such cause."""
    if not isinstance(cause, str) or cause not in set(Cause):
        hint = did_you_mean(cause, [one.value for one in Cause])
        raise MechanismError(f"cause must be one of {', '.join(Cause)}; got {format_value(cause)}.{hint}")
    return Cause(cause)


ECCENTRIC = Eccentric(radius=0.060, rod=0.240, advance=math.radians(30.0))
"""The eccentric of the shipped scene slide_valve_marks: l = 4 r, as on the plate of the paper."""

LAPS = {"outside_lap": 0.024, "inside_lap": 0.005}
"""Laps of that scene, m."""

COMMAND = "governor-mechanism run slide_valve_marks --no-film --verbose"
"""Prints the events of the simulated valve beside Zeuner's law."""

MIDDLE_COMMAND = "governor-mechanism run slide_valve_marks --set 'dimensions.setting=middle of extremes' --no-film --verbose"
"""Prints the leads of the valve set to the middle of its extremes."""

_erratum = partial(Erratum, paper=Paper.MARKS)


def list_marks_errata() -> Iterator[Erratum]:
    """Return the errata."""
    yield _ends_of_the_cylinder()
    yield _lost_square()
    yield _erratum(
        name="symbol",
        place="p. 161, Marks' transformation of the error term",
        subject="the letter xi",
        cause=Cause.UNDECIDED,
        printed="xi^2 = 2 l z + C, with the letter of the true displacement",
        right="xi_0^2 = 2 l z + C, with xi_0 = r sin(w + delta)",
        proof="The square of r sin(w + delta) is replaced, which the text itself calls the theoretical "
        "displacement. The copy may have lost an index.",
        command="governor-mechanism errata --paper marks --no-figure",
    )


def shift_of_event(event: str) -> float:
    """Return by how much the finite eccentric rod delays a valve event, with equal leads."""
    exact, theory = (event_angle(one, event=event, **LAPS) for one in (ECCENTRIC, replace(ECCENTRIC, rod=math.inf)))
    return math.degrees(math.remainder(exact - theory, math.tau))


def _ends_of_the_cylinder() -> Erratum:
    """Return the sentence on the two ends of the cylinder."""
    cut_off, release, compression = (shift_of_event(f"crank end {event}") for event in ("cut-off", "release", "compression"))
    other_compression = shift_of_event("head end compression")
    return _erratum(
        name="cylinder-ends",
        place="p. 161, on Fig. 1, effect at both ends of the cylinder",
        subject="compression where the error term shortens the fill",
        cause=Cause.ERROR,
        printed="it grows, as the pre-release does",
        right=f"it shrinks: it begins {compression:.2f} deg later; at the other end it grows, by {-other_compression:.2f} deg",
        unit="deg",
        right_value=compression,
        quotation="während für das der Achse abgewendete Cylinderende der Maximalausschlag die Compression "
        "und die Vorausströmung vergröſsert, die Voreinströmung und die Füllung verkleinert wird, findet "
        "für die Achsseite des Cylinders in allen Punkten das gerade Entgegengesetzte statt.",
        translation="while for the end of the cylinder away from the shaft the largest displacement, the "
        "compression and the pre-release grow, the pre-admission and the fill shrink, just the opposite "
        "takes place in all respects for the end at the shaft.",
        proof="At every event z is negative: the valve is nearer to the shaft than by the theory. An event "
        f"that the valve meets while moving toward the shaft comes earlier (cut-off {cut_off:+.2f} deg, "
        f"release {release:+.2f} deg), one that it meets while moving away later (admission, and "
        f"compression {compression:+.2f} deg): pre-release and compression change in opposite senses, "
        "whichever end is called the one away from the shaft.",
        consequence="The four other changes of the sentence go together as it says. With outside admission "
        "the end so described is the one at the shaft, not the one away from it. The paper says itself "
        "that the changes of the fill can be reversed.",
        command=COMMAND,
    )


def _lost_square() -> Erratum:
    """Return the square that z' lacks, which the statement on its signs follows."""
    r = ECCENTRIC.radius
    rod = ECCENTRIC.rod
    advance = ECCENTRIC.advance
    term = 1e3 * r**2 / (2 * rod)
    equal = term * math.cos(advance) ** 2
    first = term * math.cos(advance)
    second = term * math.cos(math.pi + advance)
    lead = 1e3 * (r * math.sin(advance) - LAPS["outside_lap"])
    return _erratum(
        name="lost-square",
        place="p. 161, z' of the valve set to the middle of its extremes",
        subject="error term z', and its signs at the dead centres",
        cause=Cause.SLIP,
        printed="z' = (r^2 / 2l) cos(w + delta), of opposite signs at w = 0 and 180 deg",
        right=f"z' = (r^2 / 2l) cos^2(w + delta), {equal:.3f} mm at both",
        unit="mm",
        right_value=equal,
        quotation="Dieser Ausdruck nimmt für ω = 0 und ω = 180 entgegengesetzt bezeichnete Werthe an, "
        "bedingt somit ungleiches lineares Voreilen",
        translation="This expression takes values of opposite sign for ω = 0 and ω = 180, thus causes unequal linear lead",
        proof="The displacement xi in the line before has the square. The statement on the signs holds for "
        f"z' without it ({first:.3f} and {second:.3f} mm), so that both come from one slip.",
        consequence="The conclusion, unequal leads, is right: at 180 deg the valve is on the other side, "
        f"and the same z' leaves leads of {lead - equal:.3f} and {lead + equal:.3f} mm in place of {lead:g} "
        "mm. Perhaps opposite effects on the two leads are meant.",
        command=MIDDLE_COMMAND,
    )

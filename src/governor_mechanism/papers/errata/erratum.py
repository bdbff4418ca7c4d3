"""One erratum of a paper: what is printed, what is right, why, and the command that shows it."""

from dataclasses import dataclass
from enum import StrEnum

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

"""The errata of all papers as one result, which prints as tables."""

import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.papers.errata.dubois import list_dubois_errata
from governor_mechanism.papers.errata.erratum import PAPER_REFERENCES, Erratum, Paper, check_cause, check_paper
from governor_mechanism.papers.errata.marks import list_marks_errata
from governor_mechanism.papers.errata.redtenbacher import list_redtenbacher_errata
from governor_mechanism.papers.errata.simulation import SIMULATIONS
from governor_mechanism.papers.errata.zehnder import list_zehnder_errata
from governor_mechanism.studies.printed_numbers import CAUSE_NOUNS, Cause
from governor_mechanism.units.short_repr import short_repr

TEXT_WIDTH = 130
"""Letters of a line of text."""


@dataclass(frozen=True, kw_only=True)
class Errata(Result):
    """Errata of one paper or of all.

    Attributes
    ----------
    errata
        The errata, by paper; in a paper by cause, in the order of the causes.
    """

    errata: tuple[Erratum, ...]

    __repr__ = short_repr

    figure_set = "papers.errata.drawings.errata_figures"
    record = ("counts", "errata=rows")
    columns = (
        Column("paper"),
        Column("name", "erratum"),
        *(Column(name) for name in ("place", "subject")),
        *(Column(name, name) for name in ("cause", "printed", "right")),
        *(Column(name) for name in ("proof", "command", "consequence", "quotation", "translation", "unit")),
        *(Column(name) for name in ("printed_value", "printed_digits", "right_value", "simulated")),
    )

    @property
    def rows(self) -> tuple[Erratum, ...]:
        """The errata, which are the rows of tables."""
        return self.errata

    @property
    def counts(self) -> dict[str, int]:
        """Number of errata by the name of the cause."""
        return {cause.value: number for cause, number in self.count_causes().items()}

    def __iter__(self) -> Iterator[Erratum]:
        """Return the errata in their order."""
        return iter(self.errata)

    def __len__(self) -> int:
        """Return the number of errata."""
        return len(self.errata)

    @property
    def papers(self) -> tuple[Paper, ...]:
        """The papers that have errata here, in their order."""
        return tuple(dict.fromkeys(erratum.paper for erratum in self))

    def select(self, paper: str, cause: str | None = None) -> tuple[Erratum, ...]:
        """Return the errata of a paper, of one cause or of all.

        Parameters
        ----------
        paper
            The paper, or its name.
        cause
            The cause, or its name; None for all.

        Returns
        -------
        tuple of Erratum
            The errata in their order.

        Raises
        ------
        MechanismError
            If there is no such paper or cause.
        """
        wanted = set(Cause) if cause is None else {check_cause(cause)}
        source = check_paper(paper)
        return tuple(one for one in self if one.paper is source and one.cause in wanted)

    def count(self, cause: str) -> int:
        """Return the number of errata of a cause.

        Parameters
        ----------
        cause
            The cause, or its name.

        Returns
        -------
        int
            The number.

        Raises
        ------
        MechanismError
            If there is no such cause.
        """
        wanted = check_cause(cause)
        return sum(erratum.cause is wanted for erratum in self)

    def count_causes(self) -> dict[Cause, int]:
        """Return the number of errata of every cause.

        Returns
        -------
        dict of Cause to int
            The numbers, in the order of the causes.
        """
        return {cause: self.count(cause) for cause in Cause}

    def describe_counts(self) -> str:
        """Return the counts of the causes that there are, in words.

        Returns
        -------
        str
            The counts, as "1 error, 8 misprints and 1 small slip".
        """
        counts = [(number, CAUSE_NOUNS[cause]) for cause, number in self.count_causes().items() if number]
        words = [f"{number} {noun}{'s' * (number > 1)}" for number, noun in counts]
        return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))

    def __str__(self) -> str:
        """Return for each paper a table of its errata, and below it the proof of each and the command that shows it."""
        last = f"{len(self)} errata: {self.describe_counts()}"
        return "\n\n".join([*(self._format_paper(paper) for paper in self.papers), last])

    def _format_paper(self, paper: Paper) -> str:
        errata = self.select(paper)
        table = format_columns(self.columns, errata)
        return "\n".join([PAPER_REFERENCES[paper], "", table, "", *map(_format_reasons, errata)])


def _format_reasons(erratum: Erratum) -> str:
    """Return proof, consequence and simulation of an erratum, and the command that shows it."""
    text = f"{erratum.reasons()} [{erratum.command}]"
    wrapping: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return textwrap.fill(f"{erratum.name} ({erratum.place}; {erratum.subject}): {text}", TEXT_WIDTH, subsequent_indent="    ", **wrapping)


LISTS: Mapping[Paper, Callable[[], Iterator[Erratum]]] = {
    Paper.REDTENBACHER: list_redtenbacher_errata,
    Paper.ZEHNDER: list_zehnder_errata,
    Paper.MARKS: list_marks_errata,
    Paper.DUBOIS: list_dubois_errata,
}
"""Function that recomputes the errata of a paper, by paper in the order of the years."""


def collect_errata(
    paper: str | None = None,  # name of a paper; None for all
    *,
    simulate: bool = False,  # whether to simulate the machines that show the main errors
) -> Errata:
    """Recompute the errata of a paper or of all, of each paper by cause, then in the order of its list."""
    papers = LISTS if paper is None else (check_paper(paper),)
    ranks = {cause: rank for rank, cause in enumerate(Cause)}
    errata = (erratum for one in papers for erratum in sorted(LISTS[one](), key=lambda erratum: ranks[erratum.cause]))
    return Errata(errata=tuple(_simulated(erratum) if simulate else erratum for erratum in errata))


def _simulated(erratum: Erratum) -> Erratum:
    """Return an erratum with what the simulation finds."""
    simulation = SIMULATIONS.get((erratum.paper, erratum.name))
    return erratum if simulation is None else replace(erratum, simulated=simulation())

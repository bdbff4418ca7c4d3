"""The errata of all papers."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from governor_mechanism.papers.errata.dubois import list_dubois_errata
from governor_mechanism.papers.errata.erratum import Erratum, Paper, check_paper
from governor_mechanism.papers.errata.marks import list_marks_errata
from governor_mechanism.papers.errata.redtenbacher import list_redtenbacher_errata
from governor_mechanism.papers.errata.results import Errata
from governor_mechanism.papers.errata.simulation import SIMULATIONS
from governor_mechanism.papers.errata.zehnder import list_zehnder_errata
from governor_mechanism.studies.printed_numbers import Cause

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
    """Recompute the errata of a paper or of all.

    Result: the errata, of each paper by cause, then in the order of its list. Raises MechanismError if there
    is no such paper.
    """
    papers = LISTS if paper is None else (check_paper(paper),)
    ranks = {cause: rank for rank, cause in enumerate(Cause)}
    errata = (erratum for one in papers for erratum in sorted(LISTS[one](), key=lambda erratum: ranks[erratum.cause]))
    return Errata(errata=tuple(_simulated(erratum) if simulate else erratum for erratum in errata))


def _simulated(erratum: Erratum) -> Erratum:
    """Return an erratum with what the simulation finds."""
    simulation = SIMULATIONS.get((erratum.paper, erratum.name))
    return erratum if simulation is None else replace(erratum, simulated=simulation())

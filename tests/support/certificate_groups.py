"""Groups of runs of the study of certificates, a machine and an engine each: what is required of them, and their file and tables."""

import csv
import gzip
import io
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TextIO, get_type_hints

import numpy as np

from certificate_checks import ENGINES, MAX_ERROR_RATIO, CertificateCheck
from governor_mechanism.model.results.records import Outcome
from study_machines import STUDY_MACHINES

STATEMENT_MARK, GROUPS_MARK = "study of certificates", "groups of the study"
"""What stands in the comments before the sentence and before the table of the study."""

COLUMNS = tuple(field.name for field in fields(CertificateCheck))
"""Columns of the file of the runs."""

MIN_SHARE_WITHIN = 0.99
"""Smallest share of runs with an error within their estimate."""

MIN_RUNS = 200
"""Smallest number of runs of a group."""

MAX_SHARE_UNJUDGED = 0.1
"""Largest share of runs that are set aside, and of those without a claim."""

MAX_MEDIANS = {"smooth": 20.0, "events": 60.0}
"""Largest median of estimate over error, by the kind of the scenes."""


# --- file of the runs --------------------------------------------------------------------------------------------------------


@contextmanager
def open_table(path: Path, mode: str) -> Iterator[TextIO]:
    """Open a CSV, compressed if its name ends in .gz, to be read ("r"), written ("w") or continued ("a")."""
    if path.suffix != ".gz":
        with path.open(mode, encoding="utf-8", newline="") as file:
            yield file
        return
    # Without name and time: equal rows make equal bytes. What is appended is a stream of its own, which readers join.
    with (
        path.open(f"{mode}b") as compressed,
        gzip.GzipFile(filename="", mode=f"{mode}b", fileobj=compressed, mtime=0) as binary,
        io.TextIOWrapper(binary, encoding="utf-8", newline="") as file,
    ):
        yield file


def save_checks(checks: Iterable[CertificateCheck], path: Path) -> None:
    """Write a file with a row for each check."""
    with open_table(path, "w") as file:
        csv.writer(file, lineterminator="\n").writerow(COLUMNS)
        write_rows(checks, file)


def append_checks(checks: Iterable[CertificateCheck], path: Path) -> None:
    """Add rows to a file."""
    with open_table(path, "a") as file:
        write_rows(checks, file)


def write_rows(checks: Iterable[CertificateCheck], file: TextIO) -> None:
    """Write a row for each check."""
    rows = ({name: format_cell(value) for name, value in asdict(one).items()} for one in checks)
    csv.DictWriter(file, COLUMNS, lineterminator="\n").writerows(rows)


def format_cell(value: object) -> object:
    """Return a number with four digits, which decide whatever is asked of it."""
    return f"{value:.4g}" if isinstance(value, float) else value


def load_checks(path: Path) -> list[CertificateCheck]:
    """Return the checks in a file."""
    types = get_type_hints(CertificateCheck)
    with open_table(path, "r") as file:
        return [CertificateCheck(**{name: types[name](row[name]) for name in COLUMNS}) for row in csv.DictReader(file)]


# --- groups ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Group:
    """Runs of a machine by an engine."""

    machine: str
    engine: str
    checks: tuple[CertificateCheck, ...]

    @property
    def judged(self) -> list[CertificateCheck]:
        """Runs whose true error is known."""
        return [one for one in self.checks if one.is_judged]

    @property
    def n_set_aside(self) -> int:
        """Number of runs whose references do not decide."""
        return sum(bool(one.set_aside) for one in self.checks)

    @property
    def n_without_claim(self) -> int:
        """Number of runs that were refused, took too long or crashed."""
        return sum(bool(one.failure) for one in self.checks)

    @property
    def share_within(self) -> float:
        """Share of judged runs with an error within their estimate."""
        return sum(one.is_within_estimate for one in self.judged) / max(len(self.judged), 1)

    @property
    def worst_ratio(self) -> float:
        """Largest ratio of error to estimate."""
        return max((one.least / one.estimate for one in self.judged), default=math.nan)

    def median(self, kind: str) -> float:
        """Return the median of estimate over error of the scenes of a kind; nan without any."""
        ratios = [one.overestimation for one in self.judged if one.kind == kind]
        return float(np.median(ratios)) if ratios else math.nan

    @property
    def failures(self) -> list[str]:
        """Requirements that the group does not meet."""
        found = []
        if self.share_within < MIN_SHARE_WITHIN:
            found.append("within estimate")
        if any(one.is_beyond_limit for one in self.judged):
            found.append(f"beyond {MAX_ERROR_RATIO:g} estimates")
        if any(one.claims_too_much for one in self.judged):
            found.append("DONE above the request")
        found += [f"median of {kind}" for kind, limit in MAX_MEDIANS.items() if self.median(kind) > limit]
        if any("crashed" in one.failure for one in self.checks):
            found.append("crashed")
        if self.n_set_aside > MAX_SHARE_UNJUDGED * len(self.checks):
            found.append("set aside")
        if self.n_without_claim > MAX_SHARE_UNJUDGED * len(self.checks):
            found.append("no claim")
        if len(self.checks) < MIN_RUNS:
            found.append("too few runs")
        return found


def group_checks(checks: Sequence[CertificateCheck]) -> list[Group]:
    """Return the groups of checks in the order of machines and engines."""
    keys = [(machine, engine) for machine in STUDY_MACHINES for engine in ENGINES]
    by_key: dict[tuple[str, str], list[CertificateCheck]] = {key: [] for key in keys}
    for one in checks:
        by_key[one.machine, one.engine].append(one)
    return [Group(*key, tuple(found)) for key, found in by_key.items() if found]


GROUP_COLUMNS = (
    "machine", "engine", "runs", "set aside", "no claim", "missed", "within estimate", "worst error / estimate",
    "DONE above request", "median, smooth", "median, events", "worst reading", "fails",
)  # fmt: skip
"""Columns of the table of groups. No claim: runs that were refused, took too long or crashed. Missed: ended ACCURACY_MISSED."""


def format_groups(groups: Sequence[Group]) -> str:
    """Return a table with a row for each machine and engine."""
    rows = [GROUP_COLUMNS, ("---",) * len(GROUP_COLUMNS)]
    for group in groups:
        judged = group.judged
        medians = [f"{group.median(kind):.1f}".replace("nan", "") for kind in MAX_MEDIANS]
        worst_reading = f"{max((one.reading_ratio for one in judged), default=math.nan):.2g}"
        counts = (
            len(group.checks),
            group.n_set_aside,
            group.n_without_claim,
            sum(one.outcome == Outcome.ACCURACY_MISSED.name for one in judged),
        )
        shares = (f"{100 * group.share_within:.1f} %", f"{group.worst_ratio:.2g}", sum(one.claims_too_much for one in judged))
        rows.append((group.machine, f"`{group.engine}`", *map(str, (*counts, *shares)), *medians, worst_reading, ", ".join(group.failures)))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def state_study(groups: Sequence[Group], readme: Path, page: Path) -> None:
    """Write the sentence on the study into the README, and it and the table of groups into a page of the documentation."""
    for path in (readme, page):
        replace_marked(path, STATEMENT_MARK, summarise(groups))
    replace_marked(page, GROUPS_MARK, f"\n\n{format_groups(groups)}\n\n")


def replace_marked(path: Path, mark: str, text: str) -> None:
    """Replace the text of a file between the comment of a mark and the next comment that ends it."""
    comment, end = f"<!-- {mark} -->", "<!-- end -->"
    before, found, rest = path.read_text(encoding="utf-8").partition(comment)
    _, found_end, after = rest.partition(end)
    if not (found and found_end):
        raise ValueError(f"{path} has no text between {comment} and {end}")
    path.write_text(f"{before}{comment}{text}{end}{after}", encoding="utf-8")


def summarise(groups: Sequence[Group]) -> str:
    """Return the sentence that README and documentation state."""
    judged = [one for group in groups for one in group.judged]
    machines, failing = {group.machine for group in groups}, [group for group in groups if group.failures]
    worst = max((group.worst_ratio for group in groups), default=math.nan)
    within = sum(one.is_within_estimate for one in judged)
    medians = [f"{np.median([one.overestimation for one in judged if one.kind == kind] or [math.nan]):.0f}" for kind in MAX_MEDIANS]
    return (
        f"Of {len(judged):,} runs of {len(machines)} machines, in {len(groups)} groups of a machine and an engine, "
        f"{100 * within / max(len(judged), 1):.2f} % have an error within their estimate, {sum(one.is_beyond_limit for one in judged)} "
        f"beyond three times it (worst {worst:.2g}), and {sum(one.claims_too_much for one in judged)} are DONE with an error above the "
        f"request; the median of estimate over error is {medians[0]} for smooth scenes and {medians[1]} with events. "
        f"{sum(group.n_set_aside for group in groups)} runs are set aside because references disagree. "
        + (f"{len(failing)} groups fail a requirement." if failing else "Each group meets all requirements.")
    )

"""A sweep on disk: a journal of finished rows while it runs; at its end a table (CSV) and a record (JSON).

The first line of the journal identifies the sweep, and so does the record: a sweep never continues another one.
"""

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.files.plain_values import plain_value, save_json, save_table
from governor_mechanism.files.results import package_versions
from governor_mechanism.studies.sweep.parameters import AxisGrid
from governor_mechanism.studies.sweep.results import Sweep, SweepRow

DISTRIBUTION_NAME = "governor-mechanism"

SETTING_LABELS = {"scene": "scene", "axes": "values of the keys", "quantities": "quantities", "package": "version of the package"}
"""Names in messages of the settings that distinguish two sweeps."""

RowWriter = Callable[[Iterable[SweepRow]], None]
"""Function that stores a chunk of rows."""


def journal_path(folder: Path, source: str) -> Path:
    """Return the path of the journal of a sweep.

    Parameters
    ----------
    folder
        Output folder.
    source
        Path of the scene file; empty for a scene without a file.

    Returns
    -------
    Path
        The journal, which exists while the sweep runs.
    """
    return folder / f"{Path(source).stem or 'scene'}_sweep.part"


class SweepFiles:
    """Files of one sweep in a folder, which is created. Raises MechanismError if the folder holds another sweep."""

    def __init__(self, folder: Path, source: str, grid: AxisGrid, settings: Mapping[str, Any]) -> None:
        if folder.exists() and not folder.is_dir():
            raise MechanismError(f"out: {folder} is a file; give the name of a folder")
        folder.mkdir(parents=True, exist_ok=True)
        self._journal_path = journal_path(folder, source)
        self._table_path = self._journal_path.with_suffix(".csv")
        self._record_path = self._journal_path.with_suffix(".json")
        # In the types of JSON: the identity is compared with one read from a file.
        self._identity: dict[str, Any] = plain_value({"package": package_versions()[DISTRIBUTION_NAME], **settings})
        self._n_quantities, self._n_axes, self._n_rows = len(settings["quantities"]), len(grid.axes), math.prod(grid.shape)
        self._refuse_other_sweep()

    def read_finished_rows(self) -> dict[int, SweepRow]:
        """Return the rows that are on disk, by index."""
        if self._record_path.exists() and self._table_path.exists():
            rows = _read_table_rows(self._table_path, self._n_axes, self._n_quantities)
            if len(rows) == self._n_rows:
                return rows
        if not self._journal_path.exists():
            return {}
        journal_rows = (_parse_journal_line(line, self._n_quantities) for line in self._journal_path.read_text("utf-8").split("\n")[1:])
        return {row.index: row for row in journal_rows if row is not None and 0 <= row.index < self._n_rows}

    @contextmanager
    def open_journal(self, rows: Iterable[SweepRow]) -> Iterator[RowWriter]:
        """Rewrite the journal with the given rows, without a half-written last line; yield a function that appends a chunk of rows."""
        with atomic_write(self._journal_path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(json.dumps({"sweep": self._identity}) + "\n" + _format_journal_lines(rows))
        with self._journal_path.open("a", encoding="utf-8", newline="\n") as stream:

            def append_rows(rows: Iterable[SweepRow]) -> None:
                stream.write(_format_journal_lines(rows))
                stream.flush()

            yield append_rows

    def write_results(self, sweep: Sweep) -> None:
        """Write table and record and delete the journal. The same sweep always gives the same files."""
        names = [f"{name} [{unit}]" if unit else name for name, unit in sweep.units.items()]
        rows = ([*sweep.values_at(row.index), *row.numbers_or_none, row.outcome, row.message] for row in sweep.rows)
        save_table([*names, "outcome", "message"], rows, self._table_path)
        summary = {"title": sweep.title, "units": sweep.units, "outcomes": sweep.outcomes, "notes": sweep.notes}
        save_json({"sweep": self._identity, **summary}, self._record_path)
        self._journal_path.unlink(missing_ok=True)

    def _refuse_other_sweep(self) -> None:
        hint = "choose another folder, or move the file"
        for path in (self._record_path, self._journal_path):
            if not path.exists():
                continue
            identity = _read_identity(path)
            if identity is None:
                raise MechanismError(f"out: {path} exists and is not the file of a sweep; {hint}")
            differing_settings = [SETTING_LABELS.get(key, key) for key in self._identity if identity.get(key) != self._identity[key]]
            if differing_settings:
                raise MechanismError(f"out: {path} belongs to another sweep (different {', '.join(differing_settings)}); {hint}")
        if self._table_path.exists() and not (self._record_path.exists() or self._journal_path.exists()):
            raise MechanismError(f"out: {self._table_path} exists, but the record of its sweep is missing; {hint}")


def _read_identity(path: Path) -> Mapping[str, Any] | None:
    text = path.read_text("utf-8", errors="replace")
    try:
        record = json.loads(text.partition("\n")[0] if path.suffix == ".part" else text)
        identity = record["sweep"]
    except (ValueError, TypeError, KeyError):
        return None
    return identity if isinstance(identity, Mapping) else None


def _format_journal_lines(rows: Iterable[SweepRow]) -> str:
    """Return one line per row; JSON writes the shortest digits that give the same float."""
    return "".join(json.dumps([row.index, row.numbers_or_none, row.outcome, row.message]) + "\n" for row in rows)


def _parse_journal_line(line: str, n_quantities: int) -> SweepRow | None:
    """Return the row of a line, or None for a half-written line."""
    try:
        index, numbers, outcome, message = json.loads(line)
        values = tuple(math.nan if number is None else float(number) for number in numbers)
    except (ValueError, TypeError):
        return None
    return SweepRow(index=index, numbers=values, outcome=outcome, message=message) if len(values) == n_quantities else None


def _read_table_rows(path: Path, n_axes: int, n_quantities: int) -> dict[int, SweepRow]:
    """Return the rows of a finished table, by index; none if it is incomplete."""
    with path.open(newline="", encoding="utf-8") as stream:
        lines = list(csv.reader(stream))[1:]
    try:
        return {
            index: SweepRow(
                index=index,
                numbers=tuple(float(cell) if cell else math.nan for cell in line[n_axes : n_axes + n_quantities]),
                outcome=line[n_axes + n_quantities],
                message=line[n_axes + n_quantities + 1],
            )
            for index, line in enumerate(lines)
        }
    except (ValueError, IndexError):
        return {}

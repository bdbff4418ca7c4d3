"""A sweep on disk: a journal of finished rows while it runs; at its end a table (CSV) and a record (JSON).

The first line of the journal identifies the sweep, and so does the record: a sweep never continues another one.
"""

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.files.plain_values import plain_value, save_json
from governor_mechanism.files.results import package_versions
from governor_mechanism.studies.sweep.parameters import AxisGrid
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.studies.sweep.rows import SweepRow, SweepRows

DISTRIBUTION_NAME = "governor-mechanism"

SETTING_LABELS = {"scene": "scene", "axes": "values of the keys", "quantities": "quantities", "package": "version of the package"}
"""Names in messages of the settings that distinguish two sweeps."""

RowWriter = Callable[[Sequence[SweepRow]], None]
"""Function that stores rows."""


def journal_path(
    folder: Path,
    source: str,  # path of the scene file; empty for a scene without a file
) -> Path:
    """Return the path of the journal of a sweep.

    Result: the journal, which exists while the sweep runs.
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

    def read_finished_rows(self) -> SweepRows:
        """Return the rows of the sweep, with those that are on disk."""
        rows = SweepRows(self._n_rows, self._n_quantities)
        if self._record_path.exists() and self._table_path.exists():
            with self._table_path.open(newline="", encoding="utf-8") as stream:
                lines = islice(csv.reader(stream), 1, None)
                rows.add(self._parse_rows([index, line[self._n_axes : -2], *line[-2:]] for index, line in enumerate(lines)))
            if rows.is_computed.all():
                return rows
            rows = SweepRows(self._n_rows, self._n_quantities)
        if self._journal_path.exists():
            with self._journal_path.open(encoding="utf-8") as stream:
                rows.add(self._parse_rows(map(_parse_json, islice(stream, 1, None))))
        return rows

    def _parse_rows(self, records: Iterable[Any]) -> Iterator[SweepRow]:
        """Yield the rows of records of index, numbers, outcome and message, without incomplete records, as of a half-written line."""
        for record in records:
            with suppress(ValueError, TypeError):
                index, cells, outcome, message = record
                numbers = tuple(math.nan if cell in (None, "") else float(cell) for cell in cells)
                if len(numbers) == self._n_quantities and 0 <= index < self._n_rows:
                    yield SweepRow(index=index, numbers=numbers, outcome=outcome, message=message)

    @contextmanager
    def open_journal(self, rows: SweepRows) -> Iterator[RowWriter]:
        """Rewrite the journal with the rows computed so far, without a half-written last line; yield a function that appends rows."""
        with atomic_write(self._journal_path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(json.dumps({"sweep": self._identity}) + "\n")
            stream.writelines(_format_journal_line(rows[index]) for index in np.flatnonzero(rows.is_computed).tolist())
        with self._journal_path.open("a", encoding="utf-8", newline="\n") as stream:

            def append_rows(new_rows: Sequence[SweepRow]) -> None:
                stream.write("".join(map(_format_journal_line, new_rows)))
                stream.flush()

            yield append_rows

    def write_results(self, sweep: Sweep) -> None:
        """Write table and record and delete the journal. The same sweep always gives the same files."""
        sweep.save_csv(self._table_path)
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


def count_journal_rows(path: Path) -> int:
    """Return the number of finished rows in a journal.

    Result: complete lines after the one that identifies the sweep.
    """
    with path.open("rb") as journal:
        return max(sum(line.endswith(b"\n") for line in journal) - 1, 0)


def _read_identity(path: Path) -> Mapping[str, Any] | None:
    with path.open(encoding="utf-8", errors="replace") as stream:
        text = stream.readline() if path.suffix == ".part" else stream.read()
    record = _parse_json(text)
    identity = record.get("sweep") if isinstance(record, Mapping) else None
    return identity if isinstance(identity, Mapping) else None


def _parse_json(text: str) -> Any:
    """Return the value of a JSON text, or None if it is incomplete."""
    with suppress(ValueError):
        return json.loads(text)
    return None


def _format_journal_line(row: SweepRow) -> str:
    """Return a row as a line; JSON writes the shortest digits that give the same float."""
    return json.dumps([row.index, row.numbers_or_none, row.outcome, row.message]) + "\n"

"""A sweep on disk: a journal of finished rows while it runs; at its end a table (CSV) and a record (JSON).

The first line of the journal identifies the sweep, and so does the record: a sweep never continues another one.
"""

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
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

RowWriter = Callable[[SweepRow], None]
"""Function that stores a row."""


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
            with self._table_path.open(newline="", encoding="utf-8") as stream:
                table = list(csv.reader(stream))[1:]
            rows = self._parse_rows([index, line[self._n_axes : -2], *line[-2:]] for index, line in enumerate(table))
            if len(rows) == self._n_rows:
                return rows
        if not self._journal_path.exists():
            return {}
        return self._parse_rows(map(_parse_json, self._journal_path.read_text("utf-8").split("\n")[1:]))

    def _parse_rows(self, records: Iterable[Any]) -> dict[int, SweepRow]:
        """Return the rows of records of index, numbers, outcome and message, without incomplete records, as of a half-written line."""
        rows = {}
        for record in records:
            with suppress(ValueError, TypeError):
                index, cells, outcome, message = record
                numbers = tuple(math.nan if cell in (None, "") else float(cell) for cell in cells)
                if len(numbers) == self._n_quantities and 0 <= index < self._n_rows:
                    rows[index] = SweepRow(index=index, numbers=numbers, outcome=outcome, message=message)
        return rows

    @contextmanager
    def open_journal(self, rows: Iterable[SweepRow]) -> Iterator[RowWriter]:
        """Rewrite the journal with the given rows, without a half-written last line; yield a function that appends a row."""
        with atomic_write(self._journal_path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            stream.writelines([json.dumps({"sweep": self._identity}) + "\n", *map(_format_journal_line, rows)])
        with self._journal_path.open("a", encoding="utf-8", newline="\n") as stream:

            def append_row(row: SweepRow) -> None:
                stream.write(_format_journal_line(row))
                stream.flush()

            yield append_row

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
    record = _parse_json(text.partition("\n")[0] if path.suffix == ".part" else text)
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

"""A sweep on disk: a journal of finished rows while it goes on, and at the end a table (CSV) and a record (JSON).

The journal's first line says which sweep it is of, so that none is continued as another; so does the record.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TextIO

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.sweep.parameters import Axis
from governor_mechanism.studies.sweep.quantities import Quantity
from governor_mechanism.studies.sweep.results import Row, Sweep

PACKAGE = "governor-mechanism"

SAID = {"scene": "scene", "axes": "values of keys", "quantities": "quantities", "package": "version of the package"}
"""How a message calls what tells two sweeps apart."""


def journal_path(folder: Path, source: str) -> Path:
    """Where the journal of a sweep of this scene is while the sweep goes on."""
    return folder / f"{Path(source).stem or 'scene'}_sweep.part"


class SweepFiles:
    """The files of one sweep in a folder, which is made. Raises MechanismError where it holds another sweep."""

    def __init__(
        self,
        folder: Path,
        scene: Scene,
        quantities: Sequence[Quantity],
        axes: Sequence[Axis],
        settings: Mapping[str, Any],
    ) -> None:
        if folder.exists() and not folder.is_dir():
            raise MechanismError(f"out: {folder} is a file; give the name of a folder")
        folder.mkdir(parents=True, exist_ok=True)
        self._part = journal_path(folder, scene.source)
        self._table = self._part.with_suffix(".csv")
        self._record = self._part.with_suffix(".json")
        # Through JSON and back, so that what is compared with a file is what a file would hold.
        self._identity: dict[str, Any] = json.loads(json.dumps({"package": _package(), **settings}))
        self._count = len(quantities)
        self._total = math.prod(len(axis.values) for axis in axes)
        self._keys = len(axes)
        self._stream: TextIO | None = None
        self._refuse_others()

    def kept(self) -> dict[int, Row]:
        """The rows that are on disk already, by index."""
        if self._record.exists() and self._table.exists():
            rows = _table_rows(self._table, self._keys, self._count)
            if len(rows) == self._total:
                return rows
        if not self._part.exists():
            return {}
        found = (_journal_row(line, self._count) for line in self._part.read_text("utf-8").split("\n")[1:])
        return {row.index: row for row in found if row is not None and 0 <= row.index < self._total}

    def open(self, rows: Iterable[Row]) -> None:
        """Begin the journal anew with the rows kept: what stood half written at its end is gone."""
        with written_beside(self._part) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(json.dumps({"sweep": self._identity}) + "\n" + _journal_lines(rows))
        self._stream = self._part.open("a", encoding="utf-8", newline="\n")

    def add(self, rows: Iterable[Row]) -> None:
        """Put a chunk of rows into the journal."""
        if self._stream is not None:
            self._stream.write(_journal_lines(rows))
            self._stream.flush()

    def close(self) -> None:
        """Let go of the journal."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def finish(self, sweep: Sweep) -> None:
        """Write table and record, the same for the same sweep however it came about, and drop the journal."""
        with written_beside(self._table) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            units = sweep.units
            names = [f"{name} [{units[name]}]" if units[name] else name for name in units]
            writer.writerow([*names, "outcome", "message"])
            for row in sweep.rows:
                numbers = [repr(number) if math.isfinite(number) else "" for number in row.numbers]
                values = [repr(v) if isinstance(v, float) else str(v) for v in sweep.values_at(row.index)]
                writer.writerow([*values, *numbers, row.outcome, row.message])
        told = {"title": sweep.title, "units": sweep.units, "outcomes": sweep.outcomes, "notes": list(sweep.notes)}
        with written_beside(self._record) as temporary:
            text = json.dumps({"sweep": self._identity, **told}, indent=2, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
        self._part.unlink(missing_ok=True)

    def _refuse_others(self) -> None:
        cure = "give another folder, or move it away"
        for path in (self._record, self._part):
            if not path.exists():
                continue
            there = _identity_in(path)
            if there is None:
                raise MechanismError(f"out: {path} is there, and tells of no sweep; {cure}")
            differ = [SAID.get(key, key) for key in self._identity if there.get(key) != self._identity[key]]
            if differ:
                raise MechanismError(f"out: {path} is of another sweep (other {', '.join(differ)}); {cure}")
        if self._table.exists() and not (self._record.exists() or self._part.exists()):
            raise MechanismError(f"out: {self._table} is there, and nothing tells of which sweep it is; {cure}")


def _package() -> str:
    try:
        return version(PACKAGE)
    except PackageNotFoundError:  # run from a source tree that was not installed
        return "not installed"


def _identity_in(path: Path) -> Mapping[str, Any] | None:
    text = path.read_text("utf-8", errors="replace")
    try:
        found = json.loads(text.partition("\n")[0] if path.suffix == ".part" else text)
        identity = found["sweep"]
    except (ValueError, TypeError, KeyError):
        return None
    return identity if isinstance(identity, Mapping) else None


def _journal_lines(rows: Iterable[Row]) -> str:
    """A line a row; JSON writes the shortest digits that give the same float again."""
    found = (
        [row.index, [number if math.isfinite(number) else None for number in row.numbers], row.outcome, row.message]
        for row in rows
    )
    return "".join(json.dumps(row) + "\n" for row in found)


def _journal_row(line: str, count: int) -> Row | None:
    """The row of a line; None where it was only half written."""
    try:
        index, numbers, outcome, message = json.loads(line)
        found = tuple(math.nan if number is None else float(number) for number in numbers)
    except (ValueError, TypeError):
        return None
    return Row(index=index, numbers=found, outcome=outcome, message=message) if len(found) == count else None


def _table_rows(path: Path, keys: int, count: int) -> dict[int, Row]:
    """The rows of a finished table; none where it is not whole."""
    with path.open(newline="", encoding="utf-8") as stream:
        lines = list(csv.reader(stream))[1:]
    try:
        return {
            index: Row(
                index=index,
                numbers=tuple(float(cell) if cell else math.nan for cell in line[keys : keys + count]),
                outcome=line[keys + count],
                message=line[keys + count + 1],
            )
            for index, line in enumerate(lines)
        }
    except (ValueError, IndexError):
        return {}

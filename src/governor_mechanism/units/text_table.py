"""Plain text tables for the terminal and for results as text."""

from collections.abc import Iterable, Sequence
from io import StringIO

COLUMN_GAP = 2
"""Spaces between two columns of a text table."""


def format_table(
    headers: Sequence[str],  # column headings; empty for a table without a heading line
    rows: Iterable[Sequence[str]],  # cells of each row, as many as there are columns
    # one letter per column, "l", "c" or "r"; the last letter also holds for all columns after it
    justify: str = "l",
) -> str:
    """Return a table as plain text without rules or colour, as wide as its cells need.

    Result: lines without trailing spaces, joined by newlines.
    """
    from rich.console import Console  # imported late: the command line starts without it
    from rich.table import Table
    from rich.text import Text

    cells = [[Text(cell) for cell in row] for row in rows]
    n_columns = len(headers) or max(map(len, cells), default=0)
    table = Table(box=None, show_header=bool(headers), pad_edge=False, padding=(0, COLUMN_GAP, 0, 0), header_style="")
    sides = {"l": "left", "c": "center", "r": "right"}
    for heading, side in zip(headers or [""] * n_columns, justify.ljust(n_columns, justify[-1]), strict=False):
        table.add_column(Text(heading), justify=sides[side], no_wrap=True)  # type: ignore[arg-type]
    for row in cells:
        table.add_row(*row)
    output = StringIO()
    # In a notebook rich would show the table at once instead of writing it.
    Console(file=output, width=100_000, color_system=None, force_terminal=False, force_jupyter=False).print(table)
    return "\n".join(line.rstrip() for line in output.getvalue().splitlines())

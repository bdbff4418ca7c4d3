"""Texts: tables of columns, texts with named places for quantities, and the short `repr` of results."""

import math
import re
import string
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from io import StringIO
from typing import Any, Final

from governor_mechanism.units.constants import HORSEPOWER_1901, KILOGRAM_FORCE_1853, RPM, TECHNICAL_ATMOSPHERE

COLUMN_GAP = 2
"""Spaces between two columns of a text table."""


def format_table(
    headers: Sequence[str],  # column headings; empty for a table without a heading line
    rows: Iterable[Sequence[str]],  # cells of each row, as many as there are columns
    # one letter per column, "l", "c" or "r"; the last letter also holds for all columns after it
    justify: str = "l",
) -> str:
    """Return a table as plain text without rules or colour, as wide as its cells need, without trailing spaces."""
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


_NUMBER_IN_SI: Final = {"mm": 1e3, "cm": 1e2, "cm^2": 1e4, "deg": math.degrees(1.0), "mJ": 1e3, "%": 1e2, "N": 1.0, "J": 1.0}
"""How many of a unit that is not larger than the SI unit make one of it: for most of them exact, unlike the reciprocal."""

_SIZES: Final = {
    "rpm": RPM,
    **dict.fromkeys(("kN", "kJ", "kW", "N/mm"), 1e3),
    **{"bar": 1e5, "MPa": 1e6, "GPa": 1e9},
    "PS": HORSEPOWER_1901,
    **{"kgf": KILOGRAM_FORCE_1853, "kgf/mm": 1e3 * KILOGRAM_FORCE_1853, "kgf/cm^2": TECHNICAL_ATMOSPHERE},
}
"""SI values of the other units."""

_SPECIFICATION: Final = re.compile(r"([^ /]*)(?:([ /])(.*))?")


def in_unit(
    value: Any,  # the quantity, SI
    unit: str,  # the unit, such as "mm" or "kgf"; "" for SI
) -> Any:
    """Return a quantity, or an array of quantities, in a unit of the papers or the workshop."""
    if not unit:
        return value
    return value * _NUMBER_IN_SI[unit] if unit in _NUMBER_IN_SI else value / _SIZES[unit]


class NoValueError(Exception):
    """A place names a quantity that is None."""


class Places(string.Formatter):
    """Format of texts with places that name the attributes of a record, such as "{travel.lift:.6g mm}".

    A blank before the unit writes it, a stroke does not: "{lift:.6g mm}" is "15 mm", and "{lift:.6g/mm}" is "15".
    """

    def get_value(self, key: int | str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
        """Return a value that is given by name, or the attribute of the record."""
        return kwargs[str(key)] if key in kwargs else getattr(args[0], str(key))

    def get_field(self, field_name: str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
        """Return what a place names; nothing has no attributes."""
        try:
            return super().get_field(field_name, args, kwargs)
        except AttributeError as missing:
            if missing.obj is None:
                raise NoValueError from None
            raise

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a quantity as text, in the unit of its place."""
        if value is None:
            raise NoValueError
        return format_in_unit(value, format_spec)


def format_in_unit(
    value: Any,  # the quantity, SI
    specification: str,  # format of the number and unit, as ".6g mm", or ".6g/mm" for the number alone
) -> str:
    """Return a quantity as text in a unit of the papers or the workshop."""
    number, separator, unit = _SPECIFICATION.fullmatch(specification).groups()  # type: ignore[union-attr]  # matches any text
    text = format(in_unit(value, unit or ""), number)
    return f"{text} {unit}" if separator == " " else text


def fill_places(text: str, record: object, places: Places | None = None, /, **values: object) -> str:
    """Return a text with its places filled, also from `values`, without lines that have a place whose value is None."""
    lines = list[str]()
    for line in text.splitlines():
        try:
            lines.append((places or Places()).vformat(line, (record,), values))
        except NoValueError:
            continue
    return "\n".join(lines)


MAX_REPR_LENGTH: Final = 300
"""Largest length of a short text, characters: about three lines of a terminal."""

MAX_SHOWN_ITEMS: Final = 4
"""Largest number of items of a list, an array or a table that are shown one by one."""


def short_repr(value: object) -> str:
    """Return the name of a dataclass and its fields as short text; `__repr__ = short_repr` makes it the representation of a class."""
    start, texts = f"{type(value).__name__}(", list[str]()
    shown = [field.name for field in fields(value) if field.repr]  # type: ignore[arg-type]  # any dataclass
    remaining = MAX_REPR_LENGTH - len(start) - len(", ...)")
    for name in shown:
        text = f"{name}={summarise(getattr(value, name))}"
        if len(text) + 2 > remaining:
            return f"{start}{', '.join([*texts, '...'])})"
        remaining -= len(text) + 2
        texts.append(text)
    return f"{start}{', '.join(texts)})"


def summarise(value: Any) -> str:
    """Return a value of a result as short text."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, str):
        return repr(value if len(value) <= 60 else f"{value[:57]}...")
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}(...)"
    if hasattr(value, "shape"):
        return _summarise_array(value)
    if isinstance(value, Mapping):
        return _summarise_mapping(value)
    if isinstance(value, Collection):
        opening, closing = ("[", "]") if isinstance(value, list) else ("(", ")")
        has_few = len(value) <= MAX_SHOWN_ITEMS
        return f"{opening}{', '.join(map(summarise, value))}{closing}" if has_few else f"<{len(value)} items>"
    return "..." if len(text := repr(value)) > 60 or " at 0x" in text else text


def _summarise_array(array: Any) -> str:
    """Return the items of a short array, or the shape and the range of a long one."""
    if array.ndim <= 1 and array.size <= MAX_SHOWN_ITEMS:
        return f"[{', '.join(f'{item:.6g}' if array.dtype.kind == 'f' else str(item) for item in array.ravel().tolist())}]"
    size = "x".join(map(str, array.shape))
    return f"<{size}: {array.min():.6g} to {array.max():.6g}>" if array.dtype.kind in "if" and array.size else f"<{size} {array.dtype}>"


def _summarise_mapping(table: Mapping[Any, Any]) -> str:
    """Return the names of a mapping, with their values if they are numbers."""
    names = list(table)[:MAX_SHOWN_ITEMS]
    texts = [f"{name}: {table[name]:.6g}" if isinstance(table[name], float) else str(name) for name in names]
    return f"{{{', '.join([*texts, '...'] if len(table) > len(names) else texts)}}}"

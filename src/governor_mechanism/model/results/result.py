"""What results have in common: columns declared once, from which texts, files and figures follow, and values by name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from governor_mechanism.errors import UnknownName, did_you_mean
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.types import DataFrame
from governor_mechanism.units.text_table import fill_places, format_in_unit, format_table, summarise

_Value = TypeVar("_Value")


class NamedValues(dict[str, _Value]):
    """Values by name; only the error of a missing name differs from a dictionary."""

    def __init__(
        self,
        noun: str,  # what a name stands for, in the singular, as "reading"
        values: Mapping[str, _Value],  # the values by name
    ) -> None:
        super().__init__(values)
        self.noun = noun

    def __repr__(self) -> str:
        """Return the names with the range of each array."""
        return f"{{{', '.join(f'{name!r}: {summarise(value)}' for name, value in self.items())}}}"

    def __missing__(self, name: object) -> _Value:
        """Raise UnknownName, which is a KeyError, with the nearest name."""
        known = ", ".join(self) if self else "none"
        raise UnknownName(f"no {self.noun} {name!r}; known are {known}.{did_you_mean(name, self)}")


def name_values(noun: str, values: Mapping[str, _Value]) -> NamedValues[_Value]:
    """Return values by name that answer an unknown name with the nearest one."""
    return values if isinstance(values, NamedValues) else NamedValues(noun, values)


@dataclass(frozen=True)
class Column:
    """A column of a result."""

    # name in JSON, CSV files and data frames, and the attribute of a row that holds the value; empty for a
    # column of the text alone
    key: str = ""
    heading: str | None = None  # heading in the text; None for a column that the text does not show
    # how the text shows a value: a format of the number with its unit, as ".6f/deg"; a text with places for
    # attributes of the row, as "{first:,} -> {last:,}", which is empty where a place has no value; or a
    # function of the row. The value itself if empty.
    cell: str | Callable[[Any], str] = ""
    unit: str = ""  # SI unit of the values, where it is stated
    # where a row has the value: an attribute, as "verdict.value", or a function of the row; the attribute
    # `key` if empty
    value: str | Callable[[Any], Any] = ""
    side: str = ""  # side to which cells are moved, "l" or "r"; by default "r" for a format of numbers
    in_table: bool = True  # whether CSV files and data frames have the column; not if its values are lists or tables
    in_json: bool = True  # whether JSON has the column

    def value_of(self, row: object) -> Any:
        """Return the value in a row."""
        return self.value(row) if callable(self.value) else attrgetter(self.value or self.key)(row)

    def cell_of(self, row: object) -> str:
        """Return the text of a row's cell; empty where there is no value."""
        if callable(self.cell):
            return self.cell(row)
        if "{" in self.cell:
            return fill_places(self.cell, row)
        value = self.value_of(row)
        return "" if value is None else format_in_unit(value, self.cell)

    @property
    def justify(self) -> str:
        """Side to which cells are moved."""
        return self.side or ("r" if isinstance(self.cell, str) and self.cell and "{" not in self.cell else "l")


def item_column(key: str, attribute: str, item: Any, **options: Any) -> Column:
    """Return a column whose values are items of an attribute, as those of "readings" by name; options are those of a column."""
    return Column(key, value=lambda row: attrgetter(attribute)(row)[item], **options)


def path_column(point: str, axis: str) -> Column:
    """Return the column of the coordinate x or y of a point, whose path (n, 2) is an item of "paths"."""
    return Column(f"{point}.{axis}", unit="m", value=lambda row: row.paths[point][:, "xy".index(axis)])


def format_columns(columns: Iterable[Column], rows: Iterable[object]) -> str:
    """Return rows as a text table of those columns that have a heading."""
    shown = [column for column in columns if column.heading is not None]
    cells = [[column.cell_of(row) for column in shown] for row in rows]
    return format_table([column.heading or "" for column in shown], cells, "".join(column.justify for column in shown))


def format_list(columns: Iterable[Column], record: object) -> str:
    """Return one record as a list of headings and cells, without those that are empty."""
    cells = [(column.heading or "", column.cell_of(record)) for column in columns]
    return format_table([], [row for row in cells if row[1]])


class Recorded:
    """A dataclass with JSON of its fields, but for those that its representation hides, and of some properties."""

    @property
    def record(self) -> Sequence[str]:
        """Names of what the JSON has, or "name=attribute", as "title=scene.title"; by default the fields. Most are class attributes."""
        return ()

    derived: ClassVar[tuple[str, ...]] = ()  # the same of what it has after the fields
    hidden: ClassVar[tuple[str, ...]] = ()  # names of fields that are not in it
    optional: ClassVar[tuple[str, ...]] = ()  # names of what is left out where it is empty

    def as_json(self) -> Mapping[str, Any]:
        """Return all numbers by name in SI as types of JSON: None for those that are not finite, pairs of real and imaginary part."""
        from governor_mechanism.files.results import record_result

        return record_result(self)


class Result(Recorded):
    """A result whose numbers can be written to files. Its class declares what texts, files and figures have.

    Attributes
    ----------
    columns
        Columns of the attribute `rows`, or else of arrays (n,) of the result. Without any, the table has the fields that are such arrays,
        or in one row all numbers, as "exact.rate" for the rate in "exact".
    index
        Name of the column by which a data frame is labelled; without one it counts the rows.
    attributes
        Names of what `attrs` of a data frame has beside the units, or "name=attribute".
    has_units_in_header
        Whether a CSV file names the unit in the heading of a column, "speed [rad/s]", and not in a comment above all.
    figure
        Module and function that draws the result, as "render.figures.sweep.sweep_figure"; without one, its columns are drawn.
    figure_set
        The same of the function that draws all figures of a result with several, by the ends of the names of their files.
    drawn
        Keys of the columns that a figure of columns has; by default all with numbers.
    data_files
        Endings of the files of its numbers that a command writes beside the figures: "csv", "json" or both.
    """

    attributes: ClassVar[tuple[str, ...]] = ()
    has_units_in_header: ClassVar[bool] = False
    figure: ClassVar[str] = ""
    figure_set: ClassVar[str] = ""
    data_files: ClassVar[tuple[str, ...]] = ()
    drawn: ClassVar[tuple[str, ...]] = ()

    @property
    def columns(self) -> Sequence[Column]:
        """The columns; a class attribute where they are the same for all results of the class."""
        return ()

    @property
    def index(self) -> str:
        """Name of the column by which a data frame is labelled; a class attribute like the columns."""
        return ""

    def values_of(self, column: Column) -> object:
        """Return the values of a column, one for each row or an array of the result."""
        rows = getattr(self, "rows", None)
        return column.value_of(self) if rows is None else [column.value_of(row) for row in rows]

    def __str__(self) -> str:
        """Return the columns as a text table, which is shortened; a single row as names and values."""
        from governor_mechanism.files.results import format_result

        return format_result(self)

    def to_dataframe(self) -> DataFrame:
        """Return the columns of the result as a table of pandas, SI; `attrs["units"]` has the units that are stated.

        Returns
        -------
        pandas.DataFrame
            The table; NaN where there is no number.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        from governor_mechanism.files.results import tabulate_result

        return tabulate_result(self)

    def save_json(self, path: str | os.PathLike[str]) -> Path:
        """Write all numbers as a JSON file."""
        from governor_mechanism.files.results import save_record

        return save_record(self, path)

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write the columns of `to_dataframe` as a CSV file, with the units that are stated."""
        from governor_mechanism.files.results import save_columns

        return save_columns(self, path)

    def plot(self) -> Figure:
        """Draw the result; a notebook shows the figure, and `save` writes it as PNG, SVG or PDF.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If the result has several figures, or a single row.
        """
        return self._draw()

    def figures(self) -> Mapping[str, Figure]:
        """Return all figures of the result by the ends of the names of their files."""
        from governor_mechanism.render.figure_files import draw_figures

        return draw_figures(self)

    def _draw(self, *options: Any) -> Figure:
        """Call the function that draws the result."""
        from governor_mechanism.render.figure_files import draw_result

        return draw_result(self, *options)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the text that is printed, or a row for each quantity."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

"""Formats of figures, and the files of a figure in the chosen ones. Nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.later_module import PACKAGE
from governor_mechanism.model.results.pictures import CommandOption, Figure, Theme
from governor_mechanism.units.quantities import format_value

if TYPE_CHECKING:  # numpy is slow to import
    from governor_mechanism.model.results.result import Result


COLUMNS_FIGURE = "render.figures.columns.columns_figure"
"""The function that draws a result whose class names no other."""


class FigureFormat(StrEnum):
    """Format of a figure's file. SVG and PDF hold vectors, and their texts as outlines."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


RESULTS_FOLDER = Path("results")
"""Folder of results for which no other is chosen."""


def figure_option(default: object, *described: Any) -> Any:
    """Declare a field of FigureFiles, with what `CommandOption` takes."""
    return field(default=default, metadata={"command": CommandOption(*described)})


@dataclass(frozen=True, kw_only=True)
class FigureFiles:
    """Where and how figures are written.

    Attributes
    ----------
    folder
        Folder of the files; it exists.
    formats
        Formats in which each figure is written.
    theme
        Their colours.
    drawn
        Whether figures are drawn; without them there are no formats.

    Raises
    ------
    MechanismError
        If there is no such format or theme.
    """

    folder: Path = figure_option(RESULTS_FOLDER, "Folder for the results.", "--out")
    formats: Sequence[str] = figure_option(
        (FigureFormat.PNG,), "Format of the figures. Repeatable. [png]", "--format", list[FigureFormat] | None
    )
    theme: str = figure_option(Theme.LIGHT, "Colours of figures and films; a film always has a ground.", "", Theme)
    drawn: bool = figure_option(True, "Draw no figure.", "--no-figure")

    def __post_init__(self) -> None:
        if not isinstance(self.formats, list | tuple):
            raise MechanismError(f"the formats of figures must be a list, as ['png']; got {format_value(self.formats)}")
        for one in self.formats:
            if not isinstance(one, str) or one not in set(FigureFormat):
                raise MechanismError(f"a figure's format must be one of {', '.join(FigureFormat)}; got {format_value(one)}")
        if not isinstance(self.theme, str) or self.theme not in set(Theme):
            raise MechanismError(f"a figure's theme must be one of {', '.join(Theme)}; got {format_value(self.theme)}")
        if not self.drawn:
            object.__setattr__(self, "formats", ())

    def save(self, figure: Figure, stem: str) -> list[Path]:
        """Write a figure in all formats."""
        return [figure.save(self.folder / f"{stem}.{one}", self.theme) for one in dict.fromkeys(self.formats)]

    def save_data(self, result: Result, stem: str) -> list[Path]:
        """Write the files of numbers that the class of a result names."""
        savers = {"csv": result.save_csv, "json": result.save_json}
        return [savers[kind](self.folder / f"{stem}.{kind}") for kind in result.data_files]

    def save_figures(self, result: Result, stem: str) -> list[Path]:
        """Write all figures of a result in all formats; draw nothing without formats."""
        figures = result.figures() if self.formats else {}
        return [path for end, figure in figures.items() for path in self.save(figure, f"{stem}{end}")]

    def save_all(self, result: Result, stem: str) -> list[Path]:
        """Write the files of numbers that the class of a result names, and all its figures."""
        return self.save_data(result, stem) + self.save_figures(result, stem)


def draw_result(
    result: Result,
    *options: Any,  # those of the function that draws it
) -> Figure:
    """Return the figure of a result: that which its class names, the only one of its set, or that of its columns."""
    if result.figure_set and not result.figure:
        figures = draw_figures(result)
        if len(figures) > 1:
            raise MechanismError(f"{type(result).__name__} has {len(figures)} figures; figures() returns them")
        return next(iter(figures.values()))
    figure: Figure = _find_function(result.figure or COLUMNS_FIGURE)(result, *options)
    return figure


def draw_figures(result: Result) -> Mapping[str, Figure]:
    """Return all figures of a result by the ends of the names of their files."""
    return _find_function(result.figure_set)(result) if result.figure_set else {"": draw_result(result)}


def _find_function(name: str) -> Any:
    """Return the function of a name "module.function" in the package."""
    module, _, function = name.rpartition(".")
    return getattr(import_module(f"{PACKAGE}.{module}"), function)

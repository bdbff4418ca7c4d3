"""Formats of figures, and the files of a figure in the chosen ones. Nothing heavy is imported here."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import Figure, Theme
from governor_mechanism.units.quantities import format_value


class FigureFormat(StrEnum):
    """Format of a figure's file. SVG and PDF hold vectors, and their texts as outlines."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


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

    Raises
    ------
    MechanismError
        If there is no such format or theme.
    """

    folder: Path
    formats: Sequence[str] = (FigureFormat.PNG,)
    theme: str = Theme.LIGHT

    def __post_init__(self) -> None:
        if not isinstance(self.formats, list | tuple):
            raise MechanismError(f"the formats of figures must be a list, as ['png']; got {format_value(self.formats)}")
        for one in self.formats:
            if not isinstance(one, str) or one not in set(FigureFormat):
                raise MechanismError(f"a figure's format must be one of {', '.join(FigureFormat)}; got {format_value(one)}")
        if not isinstance(self.theme, str) or self.theme not in set(Theme):
            raise MechanismError(f"a figure's theme must be one of {', '.join(Theme)}; got {format_value(self.theme)}")

    def save(self, figure: Figure, stem: str) -> list[Path]:
        """Write a figure in all formats."""
        return [figure.save(self.folder / f"{stem}.{one}", self.theme) for one in dict.fromkeys(self.formats)]

"""Pictures of a run: a figure, and the file of a film. A notebook shows both."""

import os
from base64 import b64encode
from dataclasses import dataclass
from enum import StrEnum
from html import escape
from pathlib import Path
from typing import Any, NamedTuple, Protocol

PAGE_HEIGHT = 760
"""Height of an interactive page in a notebook, CSS pixels: drawing, plots and controls without scrolling."""


class Theme(StrEnum):
    """Colours of a figure: light (its ground is white in SVG and PDF), dark, or without a ground."""

    LIGHT = "light"
    DARK = "dark"
    TRANSPARENT = "transparent"


class CommandOption(NamedTuple):
    """The option of a command that stands for a field of a record of options."""

    help: str = ""
    """Its text; a field without one has no option."""
    flag: str = ""
    """Its name, if that is not the name of the field."""
    type: Any = None
    """The type in which it is read, if that is not the type of the field."""


class Figure(Protocol):
    """A figure, which a notebook shows."""

    def save(self, path: str | os.PathLike[str], theme: str = "light") -> Path:
        """Write the figure as PNG, SVG or PDF, in the theme "light", "dark" or "transparent", and return its path."""


@dataclass(frozen=True)
class Film(os.PathLike[str]):
    """The file of a film, which a notebook shows. Functions that take a path take it too.

    Attributes
    ----------
    path
        Path of the file, which ends in .gif, .svg, .mp4, .webm or .html.
    """

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        """Return the film as HTML that holds the file itself, so that the notebook can be sent to others."""
        if not self.path.is_file():
            return f"<p>{escape(str(self.path))} is no longer there</p>"
        if self.path.suffix.lower() == ".html":
            page, style = escape(self.path.read_text(encoding="utf-8")), "width:100%;border:0"
            return f'<iframe srcdoc="{page}" title="{escape(self.path.stem)}" height="{PAGE_HEIGHT}" style="{style}"></iframe>'
        content = b64encode(self.path.read_bytes()).decode()
        kind = self.path.suffix.lower().removeprefix(".")
        if kind in ("mp4", "webm"):
            return f'<video controls loop autoplay muted src="data:video/{kind};base64,{content}"></video>'
        media_type = "svg+xml" if kind == "svg" else kind
        return f'<img src="data:image/{media_type};base64,{content}" alt="{escape(self.path.stem)}">'

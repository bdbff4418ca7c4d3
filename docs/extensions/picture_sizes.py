"""Sphinx extension: a picture is loaded when it comes into view, because films are large, and has its size, so that no page jumps."""

from __future__ import annotations

import re
from base64 import b64decode
from collections.abc import Callable
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

if TYPE_CHECKING:  # tests call `complete_pictures` without Sphinx
    from sphinx.application import Sphinx

PICTURE = re.compile(r'<img (?P<before>[^>]*?)src="(?P<source>[^"]+)"(?P<after>[^>]*)>')
SVG_SIZE = re.compile(r'viewBox="[\d.-]+ [\d.-]+ ([\d.]+) ([\d.]+)"')
HEAD = 2000
"""Number of characters of an SVG file that have its size."""


def complete_pictures(page: str, find_file: Callable[[str], Path | None]) -> str:
    """Return a page whose pictures have their sizes and are loaded when they come into view.

    Parameters
    ----------
    page
        HTML of the page.
    find_file
        Returns the file of a picture by its address in the page; None for a picture of another site.

    Returns
    -------
    str
        The page; what already has a width keeps it.
    """

    def complete(match: re.Match[str]) -> str:
        size = None if "width=" in match["before"] + match["after"] else _size_of(match["source"], find_file)
        attributes = f' width="{size[0]}" height="{size[1]}"' if size else ""
        lazy = "" if "loading=" in match[0] else ' loading="lazy"'
        return f'<img{lazy}{attributes} {match["before"]}src="{match["source"]}"{match["after"]}>'

    return PICTURE.sub(complete, page)


def _size_of(source: str, find_file: Callable[[str], Path | None]) -> tuple[int, int] | None:
    """Return the size of a picture that stands in a file or, as those of notebooks, in the page itself."""
    kind, _, data = source.partition(";base64,")
    if kind.startswith("data:image/"):
        with Image.open(BytesIO(b64decode(data))) as picture:
            return picture.size
    path = None if ":" in source else find_file(source)
    return measure(path) if path else None


@cache
def measure(path: Path) -> tuple[int, int] | None:
    """Return width and height of a picture in pixels; None for an SVG without them."""
    if path.suffix == ".svg":
        found = SVG_SIZE.search(path.read_text(encoding="utf-8")[:HEAD])
        return (round(float(found[1])), round(float(found[2]))) if found else None
    with Image.open(path) as picture:
        return picture.size


def _complete(app: Sphinx, page: str, template: str, context: dict[str, Any], *_: object) -> None:
    """Complete the pictures of a page: those that Sphinx copies, and those beside the interactive pages."""
    root = Path(app.srcdir)
    originals = {copied: root / original for original, (_, copied) in app.env.images.items()}

    def find_file(source: str) -> Path | None:
        name = Path(source).name
        path = originals.get(name, root / "_generated" / "site" / "pages" / name)
        return path if path.is_file() else None

    context["body"] = complete_pictures(context.get("body", ""), find_file)


def setup(app: Sphinx) -> dict[str, Any]:
    """Complete the pictures of every page."""
    app.connect("html-page-context", _complete)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

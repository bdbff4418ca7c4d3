"""Sphinx extension: writes the pages that follow from the code before Sphinx reads its sources.

Tables of the reference and the gallery go into docs/_generated/, from where the pages of docs/reference/ and docs/gallery.md include
them. The interactive pages of all scenes, and a picture of each, go into docs/_generated/site/pages/; they are made only where they are
missing, because their runs take a minute: `make clean` removes them.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)

STILL_SIZE = 480
"""Height of the picture of a scene, pixels, as of a film."""


def generated_texts() -> dict[str, str]:
    """Return the text of every generated page by its path in docs/_generated.

    Returns
    -------
    dict
        Markdown to be included, and the pages of the API in reStructuredText.
    """
    from generators.api import api_files, api_page
    from generators.catalogue import catalogue_page
    from generators.commands import commands_page
    from generators.effects_and_engines import effects_and_engines_page
    from generators.gallery import gallery_page
    from generators.readings import readings_page
    from generators.scene_file import scene_file_page

    pages = {
        "scene_file.md": scene_file_page(),
        "effects_and_engines.md": effects_and_engines_page(),
        "commands.md": commands_page(),
        "readings.md": readings_page(),
        "api.md": api_page(),
        "gallery.md": gallery_page(),
        "catalogue.md": catalogue_page(),
    }
    return pages | api_files()


def write_texts(folder: Path) -> None:
    """Write the pages whose text has changed, so that Sphinx reads only these again; remove pages of names that are gone.

    Parameters
    ----------
    folder
        Folder of the generated pages.
    """
    texts = generated_texts()
    for name, text in texts.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    for path in folder.glob("api/*/*.rst"):
        if path.relative_to(folder).as_posix() not in texts:
            path.unlink()


def make_interactive_pages(folder: Path) -> None:
    """Make the interactive page and the picture of every shipped scene that has none.

    Parameters
    ----------
    folder
        Folder of the pages.
    """
    from governor_mechanism.scenes.library import shipped_scenes

    folder.mkdir(parents=True, exist_ok=True)
    suffixes = ".html", ".png"
    missing = [(name, folder) for name in shipped_scenes() if not all((folder / f"{name}{suffix}").is_file() for suffix in suffixes)]
    if missing:
        logger.info("making %d interactive pages", len(missing))
        _make_pages(missing)


def _make_pages(scenes: Sequence[tuple[str, Path]]) -> None:
    """Make pages in several processes; the first page alone, so that kernels are compiled once."""
    first, *others = scenes
    _make_page(*first)
    with ProcessPoolExecutor(max_workers=min(os.cpu_count() or 1, 4)) as pool:
        list(pool.map(_make_page, *zip(*others, strict=True)) if others else ())


def _make_page(name: str, folder: Path) -> None:
    """Make the page of a scene, and the last frame of its film, which the gallery shows where there is no film."""
    import governor_mechanism as gm
    from governor_mechanism.render.film.painters import write_still

    run = gm.run(name)
    gm.film(run, folder / f"{name}.html")
    write_still(run, folder / f"{name}.png", size=STILL_SIZE)


def _generate(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "_generated"
    write_texts(folder)
    make_interactive_pages(folder / "site" / "pages")


def setup(app: Sphinx) -> dict[str, Any]:
    """Generate when the builder is ready, before the sources are read."""
    app.connect("builder-inited", _generate)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

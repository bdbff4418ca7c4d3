"""Sphinx extension: writes the pages that follow from the code before Sphinx reads its sources.

Tables of the reference and the gallery go into docs/_generated/, from where the pages of docs/reference/ and docs/gallery.md include
them. The interactive pages of all scenes, a small film and a poster of each go into docs/_generated/site/pages/. Because they take minutes,
they and the examples are made only where they are missing or made from other sources: docs/_generated/made_from/ keeps a digest of these.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import chain
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

from made_from import EXAMPLES, digest_drawing, digest_files, is_made_from, keep_digest

logger = logging.getLogger(__name__)

POSTER_QUALITY = 80
"""Of WebP: lines on paper show no fringes, at some 8 kB."""


def generated_texts() -> dict[str, str]:
    """Return the text of every generated page by its path in docs/_generated.

    Returns
    -------
    dict
        Markdown to be included, and the pages of the API in reStructuredText.
    """
    from generators.api import api_files, api_page
    from generators.catalogue import catalogue_page
    from generators.commands import commands_index, commands_pages
    from generators.effects_and_engines import effects_and_engines_page
    from generators.gallery import gallery_page, scene_pages
    from generators.readings import readings_page
    from generators.scene_file import scene_file_index, scene_file_pages

    pages = {
        "scene_file.md": scene_file_index(),
        "effects_and_engines.md": effects_and_engines_page(),
        "commands.md": commands_index(),
        "readings.md": readings_page(),
        "api.md": api_page(),
        "gallery.md": gallery_page(),
        "catalogue.md": catalogue_page(),
    }
    return pages | api_files() | scene_pages() | scene_file_pages() | commands_pages()


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
    patterns = ("api/*/*.rst", "scenes/*.md", "scene_file/*.md", "commands/*.md")
    for path in chain.from_iterable(map(folder.glob, patterns)):
        if path.relative_to(folder).as_posix() not in texts:
            path.unlink()


def make_interactive_pages(folder: Path) -> None:
    """Make the interactive page, the film and the poster of every shipped scene that has none, or those of other sources.

    Parameters
    ----------
    folder
        Folder of the pages.
    """
    from governor_mechanism.scenes.library import shipped_scenes

    folder.mkdir(parents=True, exist_ok=True)
    digests = {name: digest_drawing() + digest_files([path]) for name, path in shipped_scenes().items()}
    made = {name for name in digests if all((folder / f"{name}{suffix}").is_file() for suffix in (".html", ".gif", ".webp"))}
    missing = [(name, folder, digest) for name, digest in digests.items() if name not in made or not is_made_from(name, digest)]
    if missing:
        logger.info("making %d interactive pages", len(missing))
        _make_pages(missing)


def _make_pages(scenes: Sequence[tuple[str, Path, str]]) -> None:
    """Make pages in several processes; the first page alone, so that kernels are compiled once."""
    first, *others = scenes
    _make_page(*first)
    with ProcessPoolExecutor(max_workers=min(os.cpu_count() or 1, 4)) as pool:
        list(pool.map(_make_page, *zip(*others, strict=True)) if others else ())


def _make_page(name: str, folder: Path, digest: str) -> None:
    """Make page, film and poster of a scene, and keep the digest of its sources."""
    import governor_mechanism as gm
    from gallery import make_card_film, run_scene  # of docs/pictures

    gm.film(run_scene(name), folder / f"{name}.html")
    film, poster = make_card_film(name, folder)
    poster.save(film.with_suffix(".webp"), quality=POSTER_QUALITY)
    keep_digest(name, digest)


def make_question_pages(folder: Path) -> None:
    """Make the interactive pages of the questions that are missing or of other sources; their scenes are variants of shipped ones.

    Parameters
    ----------
    folder
        Folder of the pages.
    """
    from question_scenes import SCENES  # of docs/questions

    import governor_mechanism as gm

    for name, make_scene in SCENES.items():
        path = folder / f"{name}.html"
        if not path.is_file() or not is_made_from(name, digest_drawing()):
            gm.film(gm.run(make_scene()), path)
            keep_digest(name, digest_drawing())


def _generate(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "_generated"
    write_texts(folder)
    make_interactive_pages(folder / "site" / "pages")
    make_question_pages(folder / "site" / "pages")


def _finish(app: Sphinx, failure: Exception | None) -> None:
    if failure is None and app.builder.name == "html":
        keep_digest(EXAMPLES, digest_drawing())


def setup(app: Sphinx) -> dict[str, Any]:
    """Generate when the builder is ready, before the sources are read."""
    app.connect("builder-inited", _generate)
    app.connect("build-finished", _finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

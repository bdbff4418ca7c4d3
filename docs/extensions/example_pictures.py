"""What an example of docs/examples/ has written, for sphinx-gallery: pictures and interactive pages below its output.

Examples write into their own folder, as a reader's would into theirs; what they wrote is taken from there when they have run.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

SOURCES = {".py", ".rst"}
"""Endings of what belongs into the folder of an example."""
PICTURES = {".png", ".svg", ".gif"}

STILL = 0.35
"""Moment of a film that stands for it in the index, as a fraction of its frames: it has left its start."""


def collect_pictures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Return reStructuredText that shows what the last block of an example has written, and move that to the generated pages.

    Parameters
    ----------
    block
        The block.
    block_vars
        What sphinx-gallery knows of the example.
    gallery_conf
        Configuration of sphinx-gallery.

    Returns
    -------
    str
        A directive for each picture and page.
    """
    script = Path(block_vars["src_file"])
    root = Path(gallery_conf["src_dir"])
    title = script.stem.replace("_", " ")
    shown = [""]
    for path in _files_written(script.parent):
        if path.suffix in PICTURES:
            goal = Path(next(block_vars["image_path_iterator"])).with_suffix(path.suffix)
            shutil.move(path, goal)
            _write_still(goal)
            shown += [f".. image:: /{goal.relative_to(root).as_posix()}", f"   :alt: {path.stem} of the example: {title}", ""]
        elif path.suffix == ".html":
            goal = root / "_generated" / "site" / "pages" / f"example_{path.name}"
            goal.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(path, goal)
            frame = f'<iframe class="example" loading="lazy" src="../../../pages/{goal.name}" title="Interactive page: {title}"></iframe>'
            shown += [".. raw:: html", "", f"   {frame}", ""]
        elif path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    return "\n".join(shown) if len(shown) > 1 else ""


def _files_written(folder: Path) -> Iterator[Path]:
    """Yield what stands in the folder of an example beside the examples."""
    yield from (path for path in sorted(folder.iterdir()) if path.suffix not in SOURCES)


def _write_still(film: Path) -> None:
    """Write a frame of a film beside it, which the index takes: it would be some megabytes of films otherwise."""
    if film.suffix == ".gif":
        with Image.open(film) as frames:
            frames.seek(int(STILL * frames.n_frames))
            frames.convert("RGB").save(film.with_suffix(".png"))

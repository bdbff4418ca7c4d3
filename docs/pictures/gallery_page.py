"""Write the interactive page of every shipped scene, and an index of them, into renders/pages/.

Usage: make gallery-page
"""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.render.page.writer import make_gallery
from governor_mechanism.scenes.library import shipped_scenes

FOLDER = Path(__file__).parents[2] / "renders" / "pages"

MAX_PAGE_SIZE = 400_000
"""Largest size of a page, bytes: it loads at once also over a slow line."""


def main() -> None:
    """Write all pages and the index, and tell the largest page."""
    FOLDER.mkdir(exist_ok=True)
    runs, sizes = [], {}
    for name in shipped_scenes():
        run = gm.run(name)
        sizes[name] = gm.film(run, FOLDER / f"{name}.html").stat().st_size
        runs.append((name, run))
        print(f"{name}: {sizes[name] / 1000:.0f} kB")
    (FOLDER / "index.html").write_text(make_gallery(runs, "Mechanisms that once controlled machines"), encoding="utf-8")
    too_large = [name for name, size in sizes.items() if size > MAX_PAGE_SIZE]
    if too_large:
        raise SystemExit(f"larger than {MAX_PAGE_SIZE / 1000:g} kB: {', '.join(too_large)}")


if __name__ == "__main__":
    main()

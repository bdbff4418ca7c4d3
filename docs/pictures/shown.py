"""Bring what README and documentation show from renders/gallery/ into renders/, small enough to be tracked: `make pictures`.

A film that is too large is made again, smaller; figures have 256 colours if they look the same so. What the gallery lacks stays as it is.

Usage: python docs/pictures/shown.py
       python docs/pictures/shown.py porter watt_crossed    # the films or figures of these names alone
"""

from __future__ import annotations

import re
import shutil
import statistics
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence

from gallery import FOLDER, RENDERS, make_film

ROOT = RENDERS.parent

MAX_PICTURE_SIZE = 400_000
"""Largest size of a tracked picture, bytes: every clone has every version of it."""

LARGE_FIGURE_SIZE = 200_000
"""Size of a figure, bytes, above which it is kept in 256 colours whatever it shows."""
SEEN_CHANGE, MAX_CHANGED_SHARE = 12, 0.002
"""Change of a colour (of 255) that may be seen, and largest share of the pixels that change so, with which a smaller figure is kept in 256
colours: a drawing of lines looks the same in a third of the size, a map of colours would not."""

SMALLER_FILMS = (
    (25.0, 480),
    (25.0, 440),
    (20.0, 440),
    (50 / 3, 440),
    (100 / 7, 440),
    (12.5, 440),
    (10.0, 440),
    (25 / 3, 440),
    (20 / 3, 440),
    (100 / 17, 440),
    (20 / 3, 400),
)
"""Frame rate (1/s) and height (pixels) of smaller and smaller films. No film gets more frames than it has; in a lower one words overlap."""


def main() -> None:
    """Write the pictures that are shown, or those of the names on the command line."""
    for name in sorted(shown_pictures()):
        source, target = FOLDER / name, RENDERS / name
        if source.is_file() and (len(sys.argv) == 1 or source.stem in sys.argv[1:]):
            write = write_film if source.suffix == ".gif" else write_figure
            write(source, target)
            print(f"{name}: {target.stat().st_size / 1000:.0f} kB", flush=True)


def shown_pictures() -> set[str]:
    """Return the names of the pictures in renders/ that README and documentation show or link to."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "benchmarks" / "RESULTS.md"]
    pages += [path for path in (ROOT / "docs").rglob("*.md") if not {"_build", "_generated"} & set(path.relative_to(ROOT).parts)]
    text = "\n".join(path.read_text(encoding="utf-8") for path in pages)
    return set(re.findall(r"\((?:\.\./)*renders/([^)/]+\.(?:gif|png))\)", text))


def write_film(source: Path, target: Path) -> None:
    """Copy a film, or make it again with the first frame rate and height that make it small enough."""
    shutil.copyfile(source, target)
    own_rate = measure_frame_rate(source)
    for rate, height in dict.fromkeys((min(rate, own_rate), height) for rate, height in SMALLER_FILMS):
        if target.stat().st_size <= MAX_PICTURE_SIZE:
            return
        make_film(target.stem, target.parent, frames_per_second=rate, size=height)
    if target.stat().st_size > MAX_PICTURE_SIZE:
        raise SystemExit(f"{target.name} stays above {MAX_PICTURE_SIZE / 1000:g} kB")


def measure_frame_rate(path: Path) -> float:
    """Return the frame rate (1/s) of most frames of a GIF."""
    with Image.open(path) as film:
        durations = [float(frame.info["duration"]) for frame in ImageSequence.Iterator(film)]
    return 1000.0 / statistics.median(durations)


def write_figure(source: Path, target: Path) -> None:
    """Copy a figure, with few colours if it is large or looks the same so."""
    with Image.open(source) as image:
        whole = image.convert("RGB")
    few = whole.quantize(256, dither=Image.Dither.NONE)
    change = np.abs(np.asarray(few.convert("RGB"), int) - np.asarray(whole, int)).max(axis=2)
    if source.stat().st_size > LARGE_FIGURE_SIZE or np.mean(change > SEEN_CHANGE) <= MAX_CHANGED_SHARE:
        few.save(target, optimize=True)
    else:
        shutil.copyfile(source, target)


if __name__ == "__main__":
    main()

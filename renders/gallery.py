"""Render every shipped scene into this folder: the gallery that the README shows.

make gallery
"""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.library import shipped
from governor_mechanism.render.figures import readings_figure

FOLDER = Path(__file__).parent


def main() -> None:
    """Write a film, of four seconds at most of the run, and a figure of each scene."""
    for name in shipped():
        run = gm.run(name)
        run.raise_if_failed()
        gm.film(run, FOLDER / f"{name}.gif", stop=min(4.0, run.times[-1]))
        readings_figure(run, FOLDER / f"{name}.png")
        print(f"{name}: {run.message}")


if __name__ == "__main__":
    main()

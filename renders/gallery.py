"""Render every shipped scene into this folder: the gallery that the README shows.

make gallery
"""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.library import shipped
from governor_mechanism.render.characteristic import characteristic_figure
from governor_mechanism.render.figures import readings_figure
from governor_mechanism.render.parabolas import parabolas_figure

FOLDER = Path(__file__).parent

CHARACTERISTICS = {"porter": 40.0, "watt_improved": None, "parabolic": None}
"""Scenes whose speed curve is drawn, with the resistance (N) at the sleeve whose standing band is shaded."""


def main() -> None:
    """Write a film, of four seconds at most of the run, and a figure of each scene."""
    for name in shipped():
        run = gm.run(name)
        run.raise_if_failed()
        gm.film(run, FOLDER / f"{name}.gif", stop=min(4.0, run.times[-1]))
        readings_figure(run, FOLDER / f"{name}.png")
        print(f"{name}: {run.message}")
    for name, resistance in CHARACTERISTICS.items():
        scene = gm.load(name)
        curve = gm.speed_curve(scene, resistance=resistance)
        characteristic_figure(scene, curve, FOLDER / f"{name}_characteristic.png", gm.equilibria(scene))
    parabolas_figure(gm.load("watt_improved"), FOLDER / "watt_improved_parabolas.png")


if __name__ == "__main__":
    main()

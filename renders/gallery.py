"""Render every shipped scene into this folder: the gallery that the README shows.

make gallery
"""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.render.figures import regulation as figures
from governor_mechanism.render.figures.effect_ablation import effects_figure
from governor_mechanism.render.figures.parabolic.isochronous_plate import parabolas_figure
from governor_mechanism.render.figures.registry import machine_figures
from governor_mechanism.render.figures.speed_curve import characteristic_figure
from governor_mechanism.render.figures.time_series import readings_figure
from governor_mechanism.render.figures.work_precision import accuracy_figure
from governor_mechanism.scenes.library import shipped
from governor_mechanism.studies.regulation import registry as studies

FOLDER = Path(__file__).parent

SHOWN = {
    "watt_improved": (11.0, 16.0),
    "porter_dry_friction": (0.0, 12.0),
    "hartung_dubois": (0.0, 7.0),
    "hartung_right_angle": (0.0, 7.0),
}
"""The piece (s) of a scene that is filmed, where it is not the first four seconds."""

BRAKED = ("porter_twitch", "porter_twitch_braked"), ("without the brake", "with the oil brake")
"""Two scenes side by side, and what stands over them."""

BILLS = ("porter_dry_friction", "porter_heavy_rods")
"""Scenes whose effects are billed."""

PRICED = ("porter", "watt_improved", "hartung_dubois", "slide_valve_marks", "porter_dry_friction")
"""Scenes of which error is drawn against time."""

WANTED = 1e-6
"""The error that is marked there."""

CHARACTERISTICS = {"porter": 40.0, "watt_improved": None, "parabolic": None}
"""Scenes whose speed curve is drawn, with the resistance (N) at the sleeve whose standing band is shaded."""


def main() -> None:
    """Write a film, of four seconds at most of the run, and a figure of each scene."""
    for name in shipped():
        run = gm.run(name)
        run.raise_if_failed()
        start, stop = SHOWN.get(name, (0.0, min(4.0, run.times[-1])))
        gm.film(run, FOLDER / f"{name}.gif", start=start, stop=min(stop, run.times[-1]))
        readings_figure(run, FOLDER / f"{name}.png")
        machine_figures(run, FOLDER, name)
        print(f"{name}: {run.message}")
    for name, resistance in CHARACTERISTICS.items():
        scene = gm.load(name)
        curve = gm.speed_curve(scene, resistance=resistance)
        characteristic_figure(scene, curve, FOLDER / f"{name}_characteristic.png", gm.equilibria(scene))
    names, titles = BRAKED
    gm.film([gm.run(name) for name in names], FOLDER / "porter_twitch_pair.gif", titles=titles, stop=4.0)
    for name in BILLS:
        effects_figure(gm.effects_study(name), FOLDER / f"{name}_effects.png")
    _regulation()
    for name in PRICED:
        accuracy_figure(gm.accuracy_study(gm.load(name)), FOLDER / f"{name}_accuracy.png", WANTED)
    parabolas_figure(gm.load("watt_improved"), FOLDER / "watt_improved_parabolas.png")


def _regulation() -> None:
    """The studies of how a governor regulates."""
    figures.twitch_figure(studies.twitch(gm.load("porter_twitch"), studies.SHARES), FOLDER / "twitch.png")
    played = [studies.play_and_twitch(gm.load(name), studies.PLAYS) for name in ("porter_play", "watt_play")]
    figures.play_figure(played, FOLDER / "play.png")
    figures.settling_figure(studies.settling(gm.load("porter_load_step"), studies.BRAKES), FOLDER / "settling.png")
    figures.jump_figure(studies.jump(gm.load("watt_improved"), studies.RATES), FOLDER / "jump.png")


if __name__ == "__main__":
    main()

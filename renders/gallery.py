"""Render every shipped scene into this folder: the gallery that the README shows.

make gallery
"""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.render.figures import regulation as figures
from governor_mechanism.render.figures.effect_ablation import effect_ablation_figure
from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
from governor_mechanism.render.figures.registry import write_machine_figures
from governor_mechanism.render.figures.speed_curve import speed_curve_figure
from governor_mechanism.render.figures.time_series import readings_figure
from governor_mechanism.render.figures.work_precision import work_precision_figure
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.studies.regulation import registry as studies

FOLDER = Path(__file__).parent

SHOWN = {"watt_improved": (11.0, 16.0), "porter_dry_friction": (0.0, 12.0), "hartung_dubois": (0.0, 7.0), "hartung_right_angle": (0.0, 7.0)}
"""The piece (s) of a scene that is filmed, where it is not the first four seconds."""

BRAKED = ("porter_cyclic", "porter_cyclic_damped"), ("without the brake", "with the dashpot")
"""Two scenes side by side, and what stands over them."""

BILLS = ("porter_dry_friction", "porter_heavy_rods")
"""Scenes whose effects are billed."""

PRICED = ("porter", "watt_improved", "hartung_dubois", "slide_valve_marks", "porter_dry_friction")
"""Scenes of which error is drawn against time."""

WANTED = 1e-6
"""The error that is marked there."""

CHARACTERISTICS = {"porter": 40.0, "watt_improved": None, "parabolic": None}
"""Scenes whose speed curve is drawn, with the resistance (N) at the sleeve whose insensitivity band is shaded."""


def main() -> None:
    """Write a film, of four seconds at most of the run, and a figure of each scene."""
    for name in shipped_scenes():
        run = gm.run(name)
        run.raise_if_failed()
        start, stop = SHOWN.get(name, (0.0, min(4.0, run.times[-1])))
        gm.film(run, FOLDER / f"{name}.gif", start=start, stop=min(stop, run.times[-1]))
        readings_figure(run, FOLDER / f"{name}.png")
        write_machine_figures(run, FOLDER, name)
        print(f"{name}: {run.message}")
    for name, resistance in CHARACTERISTICS.items():
        scene = gm.load(name)
        curve = gm.speed_curve(scene, resistance=resistance)
        speed_curve_figure(scene, curve, FOLDER / f"{name}_characteristic.png", gm.equilibria(scene))
    names, titles = BRAKED
    gm.film([gm.run(name) for name in names], FOLDER / "porter_cyclic_pair.gif", titles=titles, stop=4.0)
    for name in BILLS:
        effect_ablation_figure(gm.effects_study(name), FOLDER / f"{name}_effects.png")
    _regulation()
    for name in PRICED:
        work_precision_figure(gm.accuracy_study(gm.load(name)), FOLDER / f"{name}_accuracy.png", WANTED)
    isochronous_figure(gm.load("watt_improved"), FOLDER / "watt_improved_parabolas.png")


def _regulation() -> None:
    """The studies of how a governor regulates."""
    figures.cyclic_figure(studies.study_cyclic_motion(gm.load("porter_cyclic"), studies.FLUCTUATION_RATIOS), FOLDER / "twitch.png")
    played = [studies.study_clearance(gm.load(name), studies.CLEARANCES) for name in ("porter_clearance", "watt_clearance")]
    figures.clearance_figure(played, FOLDER / "play.png")
    figures.settling_figure(studies.study_settling(gm.load("porter_load_step"), studies.DAMPING_COEFFICIENTS), FOLDER / "settling.png")
    figures.fold_jump_figure(studies.study_fold_jump(gm.load("watt_improved"), studies.RAMP_RATES), FOLDER / "jump.png")


if __name__ == "__main__":
    main()

"""Render every shipped scene into this folder: the gallery of the README.

Usage: make gallery
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import governor_mechanism as gm
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.figures import regulation as figures
from governor_mechanism.render.figures.effect_ablation import effect_ablation_figure
from governor_mechanism.render.figures.flywheel.design import draw_flywheel_plate
from governor_mechanism.render.figures.hartnell_design import hartnell_figure
from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
from governor_mechanism.render.figures.registry import write_machine_figures
from governor_mechanism.render.figures.speed_curve import speed_curve_figure
from governor_mechanism.render.figures.sweep import sweep_figure
from governor_mechanism.render.figures.time_series import readings_figure
from governor_mechanism.render.figures.valve_timing.valve_gears import valve_gears_figure
from governor_mechanism.render.figures.work_precision import work_precision_figure
from governor_mechanism.render.film.timing import find_loop_end, select_timing
from governor_mechanism.render.film.writer import DEFAULT_FRAME_RATE
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.studies.flywheel.paper_comparison import compare_with_paper
from governor_mechanism.studies.flywheel.simulation import simulate_wheels
from governor_mechanism.studies.regulation.cyclic_irregularity import CLEARANCES, FLUCTUATION_RATIOS, study_clearance, study_cyclic_motion
from governor_mechanism.studies.regulation.fold_jump import RAMP_RATES, study_fold_jump
from governor_mechanism.studies.regulation.settling_time import DAMPING_COEFFICIENTS, study_settling

FOLDER = Path(__file__).parent

MAX_FILM_SIZE = 700_000
"""Largest size of a film, bytes: a page with several of them still loads over a slow line."""

LONGEST_FILM, LONGEST_LOOP, SHORT_FILM = 8.0, 6.0, 4.0
"""Longest film (s) that is left as it is; of a longer one, a loop of up to the second time is shown if there is one, or else the third."""

MAGNIFIED: dict[str, Any] = {"exaggerate": 10.0}
"""Options of films whose sleeve moves by little more than a millimetre."""

FILM_OPTIONS: dict[str, dict[str, Any]] = {
    "watt_improved": {"slow_down": 1 / 7, "frames_per_second": 25.0},  # the whole loop, up and down
    "porter_dry_friction": {"stop": 12.0},
    "porter_cyclic": MAGNIFIED,
    "porter_cyclic_damped": MAGNIFIED,
    "haug_governor": {"stop": 6.0},
    "haug_governor_open": {"stop": 6.0},
    "watt_engine_hunting": {"stop": 8.0},
    "watt_engine_stable": {"stop": 8.0},
    # Before and after the load changes.
    **{name: {"stop": 60.0} for name in shipped_scenes() if name.startswith("governed_engine")},
    "governed_engine_watt_improved": {"stop": 36.0},
    "stephenson_reversing": {"slow_down": 1.0},  # the whole reversal
}
"""Options of the films of some scenes; an end is that of the run if this ends earlier."""

OUTSIDE_SCENE = "porter"
"""Scene that is also filmed from outside."""

DAMPING_PAIR = ("porter_cyclic", "porter_cyclic_damped"), ("without dashpot", "with dashpot")
"""Two scenes side by side, and their captions."""

ABLATION_SCENES = ("porter_dry_friction", "porter_heavy_rods")
"""Scenes of the effect-cost figures."""

WORK_PRECISION_SCENES = ("porter", "watt_improved", "hartung_dubois", "slide_valve_marks", "porter_dry_friction")
"""Scenes of the work-precision diagrams."""

REQUESTED_ERROR = 1e-6
"""Error marked in the work-precision diagrams."""

SWEEP_SCENE, SWEEP_DAMPING = "porter_dashpot", "200 N s/m"
SWEEP_KEYS = ("spindle.speed=90rpm:160rpm:36", "dimensions.sleeve_mass=5kg:40kg:36")
"""Scene of the sweep, its dashpot, and the varied keys."""

CHARACTERISTIC_SCENES = {"porter": 40.0, "watt_improved": None, "parabolic": None}
"""Scenes of the speed-curve figures, with the resistance (N) at the sleeve for the shaded insensitivity band."""


def main() -> None:
    """Write a film and the figures of each scene, and the figures of the studies."""
    films = []
    for name in shipped_scenes():
        run = gm.run(name)
        run.raise_if_failed()
        films.append(gm.film(run, FOLDER / f"{name}.gif", **choose_film_options(name, run)))
        if name == OUTSIDE_SCENE:
            options = choose_film_options(name, run, shows_rotation=True)
            films.append(gm.film(run, FOLDER / f"{name}_outside.gif", view="both", **options))
        readings_figure(run).save(FOLDER / f"{name}.png")
        write_machine_figures(run, FigureFiles(folder=FOLDER), name)
        print(f"{name}: {run.message}")
    for name, resistance in CHARACTERISTIC_SCENES.items():
        scene = gm.load(name)
        curve = gm.speed_curve(scene, resistance=resistance)
        speed_curve_figure(scene, curve, gm.equilibria(scene)).save(FOLDER / f"{name}_characteristic.png")
    names, titles = DAMPING_PAIR
    films.append(gm.film([gm.run(name) for name in names], FOLDER / "porter_cyclic_pair.gif", titles=titles, stop=SHORT_FILM, **MAGNIFIED))
    for name in ABLATION_SCENES:
        effect_ablation_figure(gm.effects_study(name)).save(FOLDER / f"{name}_effects.png")
    _write_regulation_figures()
    for name in WORK_PRECISION_SCENES:
        work_precision_figure(gm.accuracy_study(gm.load(name)), REQUESTED_ERROR).save(FOLDER / f"{name}_accuracy.png")
    swept_scene = gm.load(SWEEP_SCENE).replace({"effects.dashpot.sleeve": SWEEP_DAMPING})
    sweep_figure(gm.sweep(swept_scene, SWEEP_KEYS)).save(FOLDER / "sweep.png")
    valve_gears_figure(gm.valve_gears()).save(FOLDER / "valve_gears.png")
    isochronous_figure(gm.load("watt_improved")).save(FOLDER / "watt_improved_parabolas.png")
    hartnell_figure(gm.design_hartnell()).save(FOLDER / "hartnell_design.png")
    flywheel, comparison = gm.design_flywheel(), compare_with_paper()
    draw_flywheel_plate(flywheel, simulate_wheels(flywheel, comparison), comparison).save(FOLDER / "flywheel_design.png")
    too_large = [film.name for film in films if film.stat().st_size > MAX_FILM_SIZE]
    if too_large:
        raise SystemExit(f"larger than {MAX_FILM_SIZE / 1000:g} kB: {', '.join(too_large)}")


def choose_film_options(name: str, run: gm.Trajectory, *, shows_rotation: bool = False) -> dict[str, Any]:
    """Return the options of the film of a scene: those of the table, or its loop if the film of the whole run is too long."""
    last = float(run.times[-1])
    if name in FILM_OPTIONS:
        return {key: min(value, last) if key == "stop" else value for key, value in FILM_OPTIONS[name].items()}
    timing = select_timing((run,), None, None, None, None, DEFAULT_FRAME_RATE)
    start, stop = timing.time_span
    if (stop - start) * timing.slow_down <= LONGEST_FILM or timing.slow_down != 1.0:
        return {}
    loop_end = find_loop_end(run, (start, min(start + LONGEST_LOOP, last)), shows_rotation=shows_rotation)
    return {"stop": start + SHORT_FILM if loop_end is None else loop_end}


def _write_regulation_figures() -> None:
    """Write the figures of the regulation studies."""
    figures.cyclic_figure(study_cyclic_motion(gm.load("porter_cyclic"), FLUCTUATION_RATIOS)).save(FOLDER / "cyclic.png")
    clearance_studies = [study_clearance(gm.load(name), CLEARANCES) for name in ("porter_clearance", "watt_clearance")]
    figures.clearance_figure(clearance_studies).save(FOLDER / "clearance.png")
    figures.settling_figure(study_settling(gm.load("porter_load_step"), DAMPING_COEFFICIENTS)).save(FOLDER / "settling.png")
    figures.fold_jump_figure(study_fold_jump(gm.load("watt_improved"), RAMP_RATES)).save(FOLDER / "jump.png")


if __name__ == "__main__":
    main()

"""Make films and figures of all shipped scenes, and the figures of the studies, into renders/gallery/, which is not tracked.

Usage: make gallery
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

from PIL import Image, ImageSequence

import governor_mechanism as gm
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.figures.time_series import readings_figure
from governor_mechanism.render.film.timing import find_loop_end, select_timing
from governor_mechanism.render.film.writer import DEFAULT_FRAME_RATE
from governor_mechanism.render.results_folder import write_machine_figures
from governor_mechanism.scenes.library import shipped_scenes

RENDERS = Path(__file__).parents[2] / "renders"
FOLDER = RENDERS / "gallery"
POINTS = Path(__file__).parent / "points"

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

CARD_SIZE, CARD_FRAME_RATE = 320, 12.5
"""Width of the film of a card, pixels, and its height if it is not wider than high; and its frame rate: half that of a large one,
whose size is above all that of its frames."""
POSTER_MOMENT = 0.35
"""Moment of a poster as a fraction of the film: a mechanism has left its start and not yet come to its end."""

CATALOGUE_FILMS = ("jansen",)
"""Scenes of the catalogue with a film."""

OUTSIDE_FILM, OUTSIDE_SCENE = "porter_outside", "porter"
"""A film from outside too, and its scene."""

PAIR_FILM, PAIR_SCENES = "porter_cyclic_pair", {"porter_cyclic": "without dashpot", "porter_cyclic_damped": "with dashpot"}
"""A film of two scenes side by side, and their captions."""

STUDIES = (
    "equilibria porter --resistance '40 N' --range arm_angle=20deg:45deg",
    "equilibria watt_improved",
    "effects porter_dry_friction",
    "effects porter_heavy_rods",
    "accuracy porter",
    "accuracy watt_improved --for 1e-6",
    "accuracy hartung_dubois --for 1e-6",
    "accuracy slide_valve_marks --for 1e-6",
    "accuracy porter_dry_friction --for 1e-6",
    "sweep porter_dashpot --set effects.dashpot.sleeve='200 N s/m' --vary spindle.speed=90rpm:160rpm:36 "
    "--vary dimensions.sleeve_mass=5kg:40kg:36",
    "regulation cyclic",
    "regulation clearance",
    "regulation settling",
    "regulation jump",
    "regulation loop governed_engine --load-step 100%:50%",
    "regulation map governed_engine",
    "regulation rules",
    "valve-gears",
    "design hartnell",
    "design flywheel",
    "design governed-engine --power '20 PS' --speed 120rpm --droop 4%",
    "hard-cases",
    f"synthesise positions {shlex.quote(str(POINTS / 'gate.toml'))} --map",
    f"synthesise path {shlex.quote(str(POINTS / 'nine_points.csv'))} --closed",
)
"""Commands whose figures are shown."""


def main() -> None:
    """Write a film and the figures of each scene, and the figures of the studies."""
    FOLDER.mkdir(exist_ok=True)
    for name in shipped_scenes():
        run = run_scene(name)
        make_film(name, FOLDER)
        write_poster(name)
        readings_figure(run).save(FOLDER / f"{name}.png")
        write_machine_figures(run, FigureFiles(folder=FOLDER), name)
        print(f"{name}: {run.message}")
    for name in CATALOGUE_FILMS:
        make_film(name, FOLDER)
    make_film(OUTSIDE_FILM, FOLDER)
    make_film(PAIR_FILM, FOLDER)
    for command in STUDIES:
        write_study_figures(command)
    if too_large := [path.name for path in FOLDER.glob("*.gif") if path.stat().st_size > MAX_FILM_SIZE]:
        raise SystemExit(f"larger than {MAX_FILM_SIZE / 1000:g} kB: {', '.join(too_large)}")


def make_film(name: str, folder: Path, **smaller: Any) -> Path:
    """Write the film of a name into a folder: of a scene, or one of the other films; with further options that make it smaller."""
    if name == PAIR_FILM:
        runs = [run_scene(scene) for scene in PAIR_SCENES]
        options = {"titles": tuple(PAIR_SCENES.values()), "stop": SHORT_FILM, **MAGNIFIED}
        return gm.film(runs, folder / f"{name}.gif", **{**options, **smaller})
    is_outside = name == OUTSIDE_FILM
    run = run_scene(OUTSIDE_SCENE if is_outside else name)
    options = choose_film_options(name, run, shows_rotation=is_outside) | ({"view": "both"} if is_outside else {})
    return gm.film(run, folder / f"{name}.gif", **{**options, **smaller})


def make_card_film(name: str, folder: Path) -> tuple[Path, Image.Image]:
    """Write the film of the card of a scene into a folder, small and therefore without words, and return it with its poster."""
    run = run_scene(name)
    options = choose_film_options(name, run) | {"layout": "bare", "size": CARD_SIZE, "frames_per_second": CARD_FRAME_RATE}
    film = gm.film(run, folder / f"{name}.gif", **options)
    with Image.open(film) as frames:
        pictures = [frame.convert("RGB") for frame in ImageSequence.Iterator(frames)]
    return film, pictures[int(POSTER_MOMENT * len(pictures))]


def write_poster(name: str) -> None:
    """Write the poster of a scene."""
    with tempfile.TemporaryDirectory() as folder:
        make_card_film(name, Path(folder))[1].save(FOLDER / f"{name}_poster.png")


@lru_cache(maxsize=2)
def run_scene(name: str) -> gm.Trajectory:
    """Return the run of a shipped scene, which must not fail."""
    run = gm.run(name)
    run.raise_if_failed()
    return run


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


def write_study_figures(command: str) -> None:
    """Write the figures of a command, without its other files."""
    print(f"governor-mechanism {command}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "governor_mechanism.cli.main", *shlex.split(command), "--out", folder]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        for path in Path(folder).glob("*.png"):
            shutil.copyfile(path, FOLDER / path.name)


if __name__ == "__main__":
    main()

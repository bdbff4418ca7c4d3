"""The commands `run`, which simulates a scene, and `open`, which shows it in the browser; heavy imports are made when needed."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.api.runs import open as open_page
from governor_mechanism.cli import console
from governor_mechanism.cli.options import (
    Changes,
    SceneName,
    check_film,
    complete_scene,
    in_command_words,
    load_changed,
    refuse_idle_options,
    stem_of,
)
from governor_mechanism.model.results.pictures import FilmFormat, FilmOptions
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    from governor_mechanism.engines import Engine
    from governor_mechanism.model.results.trajectory import Trajectory
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.studies.valve_gears import ValveTiming


def run(
    scene: SceneName,
    changes: Changes = None,
    engine: console.EngineOfScene = "auto",
    accuracy: console.Accuracy = None,
    seconds: Annotated[str | None, typer.Option(help='Duration, for example "2 s"; by default the one of the scene.')] = None,
    max_steps: Annotated[int | None, typer.Option(min=1, help="Largest number of steps of one run of the engine.")] = None,
    film: Annotated[
        FilmFormat, typer.Option(help="File format of the film; mp4 and webm need the extra 'video', html is an interactive page.")
    ] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Write no film.")] = False,
    *,
    film_options: FilmOptions,
    title: Annotated[str | None, typer.Option(help="Title of film, figures and record; by default the one of the scene.")] = None,
    figures: FigureFiles,
    verbose: Annotated[bool, typer.Option("--verbose", help="Print final readings, events, losses, cost and valve timing too.")] = False,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    if as_json:
        refuse_idle_options("verbose", condition="with --json")
    duration = None if seconds is None else number_or_text(seconds)
    loaded = load_changed(scene, changes, run__duration=duration, title=title)
    kind = None if no_film else film.value
    if kind is not None:
        check_film([loaded], film_options, kind)
    if film_options.paths is not None:
        loaded = dataclasses.replace(loaded, run=dataclasses.replace(loaded.run, paths=film_options.paths))
    selected_engine = engine if max_steps is None else _limit_steps(engine, loaded, accuracy, max_steps)
    with console.show_status("simulating"):
        result = gm.run(loaded, engine=selected_engine, accuracy=accuracy)
    files = _write_results(result, figures, stem_of(loaded), kind, film_options)
    if not result.outcome.ok and not as_json:
        console.print_to_stderr(result.message)
    return _report(result, files, verbose=verbose, as_json=as_json)


def _limit_steps(name: str, scene: Scene, accuracy: float | None, max_steps: int) -> Engine:
    """Return the engine of a name with a limit of steps."""
    from governor_mechanism.engines import select_engine

    engine: Any = select_engine(scene.run.engine if name == "auto" else name, scene, accuracy)[0]
    limited: Engine = dataclasses.replace(engine, max_steps=max_steps)
    return limited


def _report(result: Trajectory, files: list[Path], *, verbose: bool, as_json: bool) -> console.CommandResult:
    """Return what the command prints: four lines, or all that is known of the run."""
    from governor_mechanism.files.results import format_run, summarise_in_lines

    valve_timing = _valve_timing_of(result.scene) if verbose or as_json else None
    values = {**({} if valve_timing is None else {"steam": valve_timing.as_json()}), "files": files}
    text: list[object] = [*summarise_in_lines(result), _format_files(files)]
    if verbose:
        timing = [] if valve_timing is None else [_format_gears(result.scene) or valve_timing]
        text = [format_run(result), *timing, _format_files(files)]
    return console.CommandResult(result, text=text, values=values, ok=result.outcome.ok)


def _valve_timing_of(scene: Scene) -> ValveTiming | None:
    """Return the timing of the valve of a scene, or None if it has no valve events."""
    if all(part.mechanism.valve is None for part in scene.parts):
        return None
    from governor_mechanism.observables.valve_motion import has_valve_events

    return gm.valve_timing(scene) if has_valve_events(scene) else None


def _format_gears(scene: Scene) -> str:
    """Return the valve events in several gears for a scene whose gear is reversed while it runs; empty for any other."""
    valve = scene.part.mechanism.valve
    if valve is None or valve.reverser is None or scene.part.mechanism.count_drivers() < 2 or not scene.document:
        return ""
    return gm.valve_gears([scene], 5).gears[0].format_events()


def _write_results(result: Trajectory, figures: FigureFiles, stem: str, film: str | None, film_options: FilmOptions) -> list[Path]:
    """Write all results of a run or none, with a progress bar for the film; nothing for a run that ends before its first reported time."""
    from governor_mechanism.render.results_folder import save_run

    if not len(result.times):
        return []
    with in_command_words(), console.show_progress_bar("film") if film else nullcontext() as progress:
        return list(
            save_run(
                result,
                figures.folder,
                name=stem,
                figures=bool(figures.formats),
                figure_formats=figures.formats,
                theme=figures.theme,
                film=film,
                film_options=film_options,
                progress=progress,
            )
        )


def _format_files(files: Sequence[Path]) -> str:
    """Return the files that were written, each folder once."""
    if not files:
        return "wrote no files"
    names: dict[Path, list[str]] = {}
    for path in files:
        names.setdefault(path.parent, []).append(path.name)
    return "wrote " + "; ".join(f"{', '.join(names_there)} in {folder}" for folder, names_there in names.items())


def open_scene(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE...",
            help="Scene files (TOML) or names of shipped scenes, up to four beside each other; without one, a list to choose from.",
            autocompletion=complete_scene,
        ),
    ] = None,
    changes: Changes = None,
    *,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page; 0 takes any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser; its address is printed anyway.")] = True,
) -> console.CommandResult:
    """Open a scene in the browser: drag its points, change its quantities, and see motion, readings and accuracy follow.

    Each change is answered by a certified run. The page is served to this machine alone, until Ctrl-C. What was made can be saved as
    a scene file, a film, a page or a table.
    """
    open_page(*(load_changed(scene, changes) for scene in scenes or ()), port=port, browser=browser)
    return console.CommandResult(text=[])

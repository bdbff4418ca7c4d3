"""The command `run`: simulate a scene and write its results.

Heavy imports are made when the command needs them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from contextlib import nullcontext
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console, film_options
from governor_mechanism.cli.changed_scene import Changes, load_changed
from governor_mechanism.cli.given_options import refuse_idle_options
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.film.options import FilmLayout, FilmView
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    from governor_mechanism.engines import Engine
    from governor_mechanism.model.results.trajectory import Trajectory
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.studies.valve_timing import ValveTiming

MIN_FILM_SIZE, MAX_FILM_SIZE = 320, 4320
"""Range of the height of a film, pixels: below, its words are not legible; above, it is larger than any screen."""


class FilmFormat(StrEnum):
    """File formats of a film."""

    GIF = "gif"
    MP4 = "mp4"
    WEBM = "webm"
    SVG = "svg"
    HTML = "html"


def run(
    scene: console.SceneName,
    changes: Changes = None,
    engine: Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of the scene.")] = "auto",
    accuracy: console.Accuracy = None,
    seconds: Annotated[str | None, typer.Option(help='Duration, for example "2 s"; by default the one of the scene.')] = None,
    max_steps: Annotated[int | None, typer.Option(min=1, help="Largest number of steps of one run of the engine.")] = None,
    film: Annotated[
        FilmFormat, typer.Option(help="File format of the film; mp4 and webm need the extra 'video', html is an interactive page.")
    ] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Write no film.")] = False,
    fps: Annotated[float | None, typer.Option(help="Frames per second of film, 1 to 50. [25; 12.5 for an engine room]")] = None,
    size: Annotated[
        str | None, typer.Option(help="Height of the film in pixels, as 720 (720p with --layout wide); its width follows. [480]")
    ] = None,
    layout: film_options.LayoutOption = FilmLayout.MACHINE_AND_PLOTS,
    readings: film_options.ReadingsOption = None,
    no_footer: film_options.NoFooterOption = False,
    labels: film_options.LabelsOption = False,
    forces: film_options.ForcesOption = False,
    traces: film_options.TracesOption = False,
    view: film_options.ViewOption = FilmView.PLANE,
    exaggerate: film_options.ExaggerateOption = 1.0,
    part: film_options.PartOption = None,
    start: film_options.StartOption = None,
    stop: film_options.StopOption = None,
    slow_down: film_options.SlowDownOption = None,
    title: Annotated[str | None, typer.Option(help="Title of film, figures and record; by default the one of the scene.")] = None,
    *,
    figures: FigureFiles,
    verbose: Annotated[bool, typer.Option("--verbose", help="Print final readings, events, losses, cost and valve timing too.")] = False,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    film_options.refuse_without_film(no_film=no_film, has_figure=bool(figures.formats))
    if as_json:
        refuse_idle_options("verbose", condition="with --json")
    chosen = film_options.gather_film_options(
        layout=layout,
        readings=readings,
        no_footer=no_footer,
        labels=labels,
        forces=forces,
        traces=traces,
        start=start,
        stop=stop,
        slow_down=slow_down,
        theme=figures.theme,
        view=view,
        exaggerate=exaggerate,
        part=part,
        is_page=film is FilmFormat.HTML,
    )
    frame_options = {"frames_per_second": fps} | ({} if size is None else {"size": parse_film_size(size)})
    if film in (FilmFormat.MP4, FilmFormat.WEBM) and not no_film:
        from governor_mechanism.render.film.writer import require_video_writer

        require_video_writer(f".{film}")
    duration = None if seconds is None else number_or_text(seconds)
    loaded = load_changed(scene, changes, run__duration=duration, title=title)
    if not no_film:
        film_options.check_film_options([loaded], chosen, fps, file_format=film.value)
    console.prepare_folder(figures.folder)
    selected_engine = engine if max_steps is None else _limit_steps(engine, loaded, accuracy, max_steps)
    with console.show_status("simulating"):
        result = gm.run(loaded, engine=selected_engine, accuracy=accuracy)
    files = _write_results(result, figures, Path(loaded.source).stem or "scene", None if no_film else film, {**frame_options, **chosen})
    if not result.outcome.ok and not as_json:
        console.print_to_stderr(result.message)
    return _report(result, files, verbose=verbose, as_json=as_json)


def parse_film_size(text: str) -> int:
    """Return the height of a film in pixels, written as 720, or as 720x720 for a square film.

    Parameters
    ----------
    text
        The text of the option.

    Returns
    -------
    int
        Height in pixels.

    Raises
    ------
    MechanismError
        If it is no number, out of range, or the width differs from the height.
    """
    width, cross, height = text.lower().partition("x")
    if not all(word.strip().isdecimal() for word in ((width, height) if cross else (width,))):
        raise MechanismError(f"--size {text!r} is not understood; write the height of the film in pixels, as --size 720")
    if cross and int(width) != int(height):
        hint = f"a film of one part is square, and one of several is as wide as they need; give the height, as --size {int(height)}"
        raise MechanismError(f"--size {text!r} has a width of its own; {hint}")
    if not MIN_FILM_SIZE <= int(width) <= MAX_FILM_SIZE:
        raise MechanismError(f"--size must lie between {MIN_FILM_SIZE} and {MAX_FILM_SIZE} pixels; found {int(width)}")
    return int(width)


def _limit_steps(name: str, scene: Scene, accuracy: float | None, max_steps: int) -> Engine:
    """Return the engine of a name with a limit of steps."""
    from governor_mechanism.engines import select_engine

    engine: Any = select_engine(scene.run.engine if name == "auto" else name, scene, accuracy)[0]
    limited: Engine = dataclasses.replace(engine, max_steps=max_steps)
    return limited


def _report(result: Trajectory, files: list[Path], *, verbose: bool, as_json: bool) -> console.CommandResult:
    """Return what the command prints: four lines, or all that is known of the run."""
    from governor_mechanism.cli.run_summary import format_files, format_run, summarise_in_lines
    from governor_mechanism.files.results import summarise_run

    valve_timing = _valve_timing_of(result.scene) if verbose or as_json else None
    values = {**summarise_run(result), **({} if valve_timing is None else {"steam": valve_timing.as_json()}), "files": files}
    text: list[object] = [*summarise_in_lines(result, files)]
    if verbose:
        timing = [] if valve_timing is None else [_format_gears(result.scene) or valve_timing]
        text = [format_run(result), *timing, format_files(files)]
    return console.CommandResult(text=text, values=values, ok=result.outcome.ok)


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


def _write_results(result: Trajectory, figures: FigureFiles, stem: str, film: FilmFormat | None, options: Mapping[str, Any]) -> list[Path]:
    """Write all results of a run or none, with a progress bar for the film; nothing for a run that ends before its first reported time."""
    from governor_mechanism.render.results_folder import save_run

    if not len(result.times):
        return []
    kind = None if film is None else film.value
    with film_options.in_command_words(), console.show_progress_bar("film") if film else nullcontext() as progress:
        return list(
            save_run(
                result,
                figures.folder,
                name=stem,
                figures=bool(figures.formats),
                figure_formats=figures.formats,
                theme=figures.theme,
                film=kind,
                film_options=options,
                progress=progress,
            )
        )

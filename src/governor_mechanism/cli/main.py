"""The command line: `models`, `compile`, `run`, `equilibria`, `crosscheck`, and the commands of `cli.studies` and `cli.design`.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import gc
import os
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.design import design
from governor_mechanism.cli.regulation import regulation_app
from governor_mechanism.cli.studies import accuracy, effects, hard_cases, sweep, valve_gears
from governor_mechanism.files.plain_values import finite_or_none

if TYPE_CHECKING:
    from governor_mechanism.cli.summary import EquilibriaReport
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.model.trajectory import Trajectory
    from governor_mechanism.statics.speed_curve import SpeedCurve
    from governor_mechanism.studies.valve_timing import ValveTiming

COLLECTION_THRESHOLD = 100_000
"""Number of new objects after which unreachable ones are searched for; what is imported stays, and searching it takes longer than a run."""

HELP = "Simulate, film and verify the mechanisms that once controlled machines."
app = typer.Typer(
    name="governor-mechanism", help=HELP, no_args_is_help=True, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False
)


class FilmFormat(StrEnum):
    """File formats of a film."""

    GIF = "gif"
    MP4 = "mp4"


def main() -> None:
    """Run the command line."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed; without this, a file of results would get its number
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    gc.set_threshold(COLLECTION_THRESHOLD)
    try:
        app()
    except console.CommandExit:
        raise
    except SystemExit as stop:
        if stop.code == console.EXIT_BAD_INPUT and "--json" in sys.argv:
            console.print_json({"outcome": "bad_input", "problems": ["the command line is not valid; see --help"]})
        raise
    except OSError as error:  # from the text of --help
        console.exit_without_output(error)
    except KeyboardInterrupt:  # before a command was reached
        console.print_to_stderr("interrupted")
        raise SystemExit(console.EXIT_INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        console.print_to_stdout(gm.__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Simulate, film and verify the mechanisms that once controlled machines."""


def models(as_json: console.AsJson = False) -> console.CommandResult:
    """List the shipped scenes, one per line."""
    from governor_mechanism.units.text_table import format_table

    scenes = gm.list_models()
    values = {"models": [{"name": name, "title": title} for name, title in scenes.items()]}
    return console.CommandResult(text=[format_table([], scenes.items())], values=values)


def compile_kernels(as_json: console.AsJson = False) -> console.CommandResult:
    """Compile all kernels into the cache, for images and clusters; else each is compiled when it is first needed."""
    compilation = gm.compile_kernels()
    return console.CommandResult(text=[compilation], values=compilation.as_json())


def run(
    scene: console.SceneName,
    engine: Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of the scene.")] = "auto",
    accuracy: console.Accuracy = None,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = console.RESULTS_FOLDER,
    film: Annotated[FilmFormat, typer.Option(help="File format of the film; mp4 needs the extra 'video'.")] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Write no film.")] = False,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    from governor_mechanism.cli.summary import format_run
    from governor_mechanism.files.results import summarise_run

    if film is FilmFormat.MP4 and not no_film:
        from governor_mechanism.render.film.writer import require_video_writer

        require_video_writer()
    console.prepare_folder(out)
    loaded_scene = gm.load(scene)
    valve_timing = _valve_timing_of(loaded_scene)
    with console.show_status("simulating"):
        result = gm.run(loaded_scene, engine=engine, accuracy=accuracy)
    files = _write_results(result, out, Path(result.scene.source).stem or "scene", None if no_film else film)
    text, values = [format_run(result)], summarise_run(result)
    if valve_timing is not None:
        text.append(_format_gears(loaded_scene) or str(valve_timing))
        values["steam"] = valve_timing.as_json()
    if not result.outcome.ok and not as_json:
        console.print_to_stderr(result.message)
    text.append("wrote " + ", ".join(map(str, files)))
    return console.CommandResult(text=text, values={**values, "files": files}, ok=result.outcome.ok)


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


def crosscheck(scene: console.SceneName, as_json: console.AsJson = False) -> console.CommandResult:
    """Compare the simulation of a scene with every closed form that applies. The exit status is 1 if one disagrees."""
    loaded_scene = gm.load(scene)
    with console.show_status("simulating"):
        report = gm.crosscheck(loaded_scene)
    names = ("quantity", "simulated", "expected", "difference", "allowed", "unit", "reason", "passed")
    measured = ("simulated", "expected", "difference")
    rows = [{name: finite_or_none(getattr(row, name)) if name in measured else getattr(row, name) for name in names} for row in report.rows]
    values = {"title": report.title, "against": report.against, "passed": report.passed, "rows": rows, "notes": report.notes}
    return console.CommandResult(text=[report], values=values, ok=report.passed)


def equilibria(
    scene: console.SceneName,
    speed: Annotated[
        str | None, typer.Option(help='Spindle speed, for example "6.4 rad/s" or "61 rpm"; by default the one of the scene.')
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Friction at a reading, for example "40 N": compute and draw the insensitivity band.')
    ] = None,
    against: Annotated[str, typer.Option(help="The reading of the sleeve, along which resistance and effort act.")] = "sleeve_lift",
    working_range: Annotated[
        str | None,
        typer.Option(
            "--range", help='Working range for the sensitiveness, "READING=LOW:HIGH"; by default that of the stops, or the whole travel.'
        ),
    ] = None,
    speed_change: Annotated[float | None, typer.Option(help="Relative change of speed for effort and power; by default 0.01.")] = None,
    linearise: Annotated[
        bool,
        typer.Option("--linearise", help="Instead: eigenvalues and modes with all dampers, about each equilibrium or steady rotation."),
    ] = False,
    limit: Annotated[str | None, typer.Option(help='Instead: the value of a key at which stability ends, "KEY=LOW:HIGH".')] = None,
    out: console.FigureFolder = console.RESULTS_FOLDER,
    no_figure: console.NoFigure = False,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find all equilibria at a speed and their stability; draw the speed curve and the controlling force."""
    from governor_mechanism.cli.summary import report_equilibria, report_linearisation
    from governor_mechanism.units.quantities import parse_quantity

    loaded_scene = gm.load(scene)
    spindle_speed = None if speed is None else parse_quantity(speed, "angular_speed", "--speed")
    if linearise or limit is not None:
        with console.show_status("linearising"):
            return report_linearisation(loaded_scene, spindle_speed, limit)
    console.prepare_folder(out)
    report = report_equilibria(loaded_scene, spindle_speed, resistance, against, working_range, speed_change)
    files = [] if no_figure or report.curve is None else _write_speed_curve_figures(report, report.curve, out)
    return console.CommandResult(text=[report.scene.title, *report.lines()], values=report.as_json(), files=files)


def _write_speed_curve_figures(report: EquilibriaReport, curve: SpeedCurve, out: Path) -> list[Path]:
    """Draw the speed curve, the controlling force if there are balls, and Zehnder's plate for the governors that it covers."""
    from governor_mechanism.render.figures.controlling_force import controlling_force_figure
    from governor_mechanism.render.figures.parabolic.isochronous_data import has_isochronous_parabolas
    from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
    from governor_mechanism.render.figures.speed_curve import speed_curve_figure

    scene, stem = report.scene, Path(report.scene.source).stem
    points = [equilibrium for equilibrium, _ in report.points]
    files = [speed_curve_figure(scene, curve, points).save_png(out / f"{stem}_characteristic.png")]
    forces = report.controlling_force.curve if report.controlling_force else None
    if forces is not None:
        files.append(controlling_force_figure(scene, forces, points).save_png(out / f"{stem}_controlling_force.png"))
    if has_isochronous_parabolas(scene):
        files.append(isochronous_figure(scene).save_png(out / f"{stem}_parabolas.png"))
    return files


def _write_results(result: Trajectory, out: Path, stem: str, film: FilmFormat | None) -> list[Path]:
    """Write all results of a run or none: if one cannot be written, the results of an earlier run stay unchanged."""
    from governor_mechanism.files.atomic_write import write_all_or_none
    from governor_mechanism.files.results import save_csv, save_netcdf, save_summary
    from governor_mechanism.render.figures.registry import write_machine_figures
    from governor_mechanism.render.figures.time_series import readings_figure

    written = []
    writers = {"csv": save_csv, "nc": save_netcdf, "png": lambda run, path: readings_figure(run).save_png(path), "json": save_summary}
    with write_all_or_none():
        if film is not None and len(result.times) > 1:
            with console.show_progress_bar("film") as progress:
                written.append(gm.film(result, out / f"{stem}.{film.value}", progress=progress))
        written += write_machine_figures(result, out, stem)
        for kind, write in writers.items():
            path = out / f"{stem}.{kind}"
            write(result, path)
            written.append(path)
    return written


for command in (models, run, crosscheck, equilibria, accuracy, effects, sweep, hard_cases, valve_gears):
    app.command(short_help=console.first_sentence(command))(console.guarded_command(command))
# Inputs of a design may be options of their own; `design` answers a misspelt one.
_ANY_OPTIONS = {"allow_extra_args": True, "ignore_unknown_options": True}
app.command(short_help=console.first_sentence(design), context_settings=_ANY_OPTIONS)(console.guarded_command(design))
app.command("compile", short_help=console.first_sentence(compile_kernels))(console.guarded_command(compile_kernels))
app.add_typer(regulation_app, name="regulation")


if __name__ == "__main__":
    main()

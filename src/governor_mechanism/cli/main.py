"""The command line: `models`, `run`, `equilibria`, `crosscheck`, `design`, and the commands of `cli.studies`.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.cli.console import (
    EXIT_BAD_INPUT,
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_OK,
    CommandExit,
    finite_or_none,
    guarded_command,
    print_json,
    print_to_stderr,
    show_progress_bar,
    show_status,
)
from governor_mechanism.cli.design import design
from governor_mechanism.cli.options import RESULTS_FOLDER, AsJson, FigureFolder, NoFigure, SceneName, prepare_folder
from governor_mechanism.cli.studies import accuracy, effects, regulation, sweep
from governor_mechanism.errors import MechanismError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from governor_mechanism.model.scene import Scene
    from governor_mechanism.model.trajectory import Trajectory
    from governor_mechanism.statics.equilibria import Equilibrium
    from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve

app = typer.Typer(
    name="governor-mechanism",
    help="Simulate, film and verify the mechanisms that once controlled machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


class FilmFormat(StrEnum):
    """File formats of a film."""

    GIF = "gif"
    MP4 = "mp4"


def main() -> None:
    """Run the command line."""
    try:
        app()
    except CommandExit:
        raise
    except SystemExit as stop:
        if stop.code == EXIT_BAD_INPUT and "--json" in sys.argv:
            print_json({"outcome": "bad_input", "problems": ["the command line is not valid; see --help"]})
        raise
    except KeyboardInterrupt:  # before a command was reached
        print_to_stderr("interrupted")
        raise SystemExit(EXIT_INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        from governor_mechanism import __version__

        print(__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Simulate, film and verify the mechanisms that once controlled machines."""


@app.command()
@guarded_command
def models(as_json: AsJson = False) -> int:
    """List the shipped scenes, one per line."""
    from governor_mechanism.scenes.library import read_scene_title, shipped_scenes
    from governor_mechanism.units.text_table import format_table

    scenes = {name: read_scene_title(path) for name, path in shipped_scenes().items()}
    if as_json:
        print_json({"models": [{"name": name, "title": title} for name, title in scenes.items()]})
        return EXIT_OK
    print(format_table([], scenes.items()))
    return EXIT_OK


@app.command()
@guarded_command
def run(
    scene: SceneName,
    engine: Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of the scene.")] = "auto",
    accuracy: Annotated[
        float | None, typer.Option(help="Accuracy relative to the scale of each reading; by default the one of the scene.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = RESULTS_FOLDER,
    film: Annotated[FilmFormat, typer.Option(help="File format of the film; mp4 needs the extra 'video'.")] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Write no film.")] = False,
    as_json: AsJson = False,
) -> int:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    import governor_mechanism as gm
    from governor_mechanism.files.results import summarise_run
    from governor_mechanism.machines.slide_valve import SlideValve

    if film is FilmFormat.MP4 and not no_film:
        from governor_mechanism.render.film.writer import require_video_writer

        require_video_writer()
    prepare_folder(out)
    loaded_scene = gm.load(scene)
    with show_status("simulating"):
        result = gm.run(loaded_scene, engine=engine, accuracy=accuracy)
    stem = Path(result.scene.source).stem or "scene"
    files = _write_results(result, out, stem, None if no_film else film)
    has_valve = len(loaded_scene.parts) == 1 and loaded_scene.part.machine == SlideValve.name
    valve_timing = gm.valve_timing(loaded_scene) if has_valve else None
    if as_json:
        valve_timing_json = {} if valve_timing is None else {"steam": valve_timing.as_json()}
        print_json({**summarise_run(result), **valve_timing_json, "files": [str(path) for path in files]})
    else:
        from governor_mechanism.cli.summary import format_run

        print(format_run(result))
        if valve_timing is not None:
            print(valve_timing)
        print("wrote " + ", ".join(str(path) for path in files))
        if not result.outcome.ok:
            print_to_stderr(result.message)
    return EXIT_OK if result.outcome.ok else EXIT_FAILED


@app.command()
@guarded_command
def crosscheck(scene: SceneName, as_json: AsJson = False) -> int:
    """Compare the simulation of a scene with every closed form that applies. The exit status is 1 if one disagrees."""
    import governor_mechanism as gm

    loaded_scene = gm.load(scene)
    with show_status("simulating"):
        report = gm.crosscheck(loaded_scene)
    if as_json:
        rows = [
            {
                "quantity": row.quantity,
                "simulated": finite_or_none(row.simulated),
                "expected": finite_or_none(row.expected),
                "difference": finite_or_none(row.difference),
                "allowed": row.allowed,
                "unit": row.unit,
                "reason": row.reason,
                "passed": row.passed,
            }
            for row in report.rows
        ]
        print_json({"title": report.title, "against": report.against, "passed": report.passed, "rows": rows, "notes": list(report.notes)})
    else:
        print(report)
    return EXIT_OK if report.passed else EXIT_FAILED


@app.command()
@guarded_command
def equilibria(
    scene: SceneName,
    speed: Annotated[
        str | None, typer.Option(help='Spindle speed, for example "6.4 rad/s" or "61 rpm"; by default the one of the scene.')
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Friction at a reading, for example "40 N": compute and draw the insensitivity band.')
    ] = None,
    against: Annotated[str, typer.Option(help="The reading along which the resistance acts.")] = "sleeve_lift",
    linearise: Annotated[
        bool,
        typer.Option("--linearise", help="Instead: eigenvalues and modes with all dampers, about each equilibrium or steady rotation."),
    ] = False,
    limit: Annotated[str | None, typer.Option(help='Instead: the value of a key at which stability ends, "KEY=LOW:HIGH".')] = None,
    out: FigureFolder = RESULTS_FOLDER,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Find all equilibria at a speed and their stability; draw the speed curve."""
    import governor_mechanism as gm
    from governor_mechanism.cli.summary import equilibria_as_json, format_equilibria
    from governor_mechanism.statics.equilibria import has_damping
    from governor_mechanism.statics.equilibrium_speed import has_equilibrium_speed
    from governor_mechanism.units.quantities import parse_quantity

    loaded_scene = gm.load(scene)
    spindle_speed = None if speed is None else parse_quantity(speed, "angular_speed", "--speed")
    if linearise or limit is not None:
        from governor_mechanism.cli.linearisation import report_linearisation

        with show_status("linearising"):
            text, report = report_linearisation(loaded_scene, spindle_speed, limit)
        if as_json:
            print_json(report)
        else:
            print(text)
        return EXIT_OK
    prepare_folder(out)
    resistance_value = None if resistance is None else _parse_resistance(loaded_scene, resistance, against)
    equilibrium_points = gm.equilibria(loaded_scene, spindle_speed)
    curve = gm.speed_curve(loaded_scene, resistance=resistance_value, against=against) if has_equilibrium_speed(loaded_scene) else None
    bands = (
        []
        if resistance_value is None
        else [_compute_insensitivity_band(loaded_scene, equilibrium, resistance_value, against) for equilibrium in equilibrium_points]
    )
    files = [] if no_figure or curve is None else _write_speed_curve_figures(loaded_scene, curve, equilibrium_points, out)
    if as_json:
        report = {
            "coordinate": loaded_scene.part.mechanism.coordinate,
            "undamped": has_damping(loaded_scene),
            **equilibria_as_json(equilibrium_points, curve, bands),
        }
        print_json({**report, "files": [str(path) for path in files]})
    else:
        lines = [
            loaded_scene.title,
            *format_equilibria(loaded_scene, equilibrium_points, curve, bands),
            *(f"wrote {path}" for path in files),
        ]
        print("\n".join(lines))
    return EXIT_OK


def _parse_resistance(scene: Scene, text: str, against: str) -> float:
    from governor_mechanism.statics.equilibrium_speed import require_equilibrium_speed
    from governor_mechanism.units.quantities import parse_quantity

    require_equilibrium_speed(scene)
    quantities = {reading.name: reading.quantity for reading in scene.part.mechanism.readings}
    if against not in quantities:
        raise MechanismError(
            f"--resistance acts along a reading, and there is no reading {against!r}; choose one with --against: {list(quantities)}"
        )
    return parse_quantity(text, "torque" if quantities[against] == "angle" else "force", "--resistance")


def _compute_insensitivity_band(scene: Scene, equilibrium: Equilibrium, resistance_value: float, against: str) -> InsensitivityBand | str:
    """Return the insensitivity band at an equilibrium, or the reason why there is none."""
    import governor_mechanism as gm

    try:
        return gm.insensitivity_band(scene, [equilibrium.coordinate], resistance_value, against)
    except MechanismError as error:
        return error.problems[0]


def _write_speed_curve_figures(scene: Scene, curve: SpeedCurve, equilibrium_points: Sequence[Equilibrium], out: Path) -> list[Path]:
    """Draw the speed curve, and Zehnder's plate for the governors that it covers."""
    from governor_mechanism.render.figures.parabolic.isochronous_data import has_isochronous_parabolas
    from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
    from governor_mechanism.render.figures.speed_curve import speed_curve_figure

    stem = Path(scene.source).stem
    files = [speed_curve_figure(scene, curve, out / f"{stem}_characteristic.png", equilibrium_points)]
    if has_isochronous_parabolas(scene):
        files.append(isochronous_figure(scene, out / f"{stem}_parabolas.png"))
    return files


for command in (accuracy, effects, regulation, sweep, design):
    app.command()(command)


def _write_results(result: Trajectory, out: Path, stem: str, film: FilmFormat | None) -> list[Path]:
    """Write all results of a run: first the film, which takes longest, last the record.

    If the film is interrupted, the results of an earlier run stay unchanged; a record proves that all results are complete.
    """
    import governor_mechanism as gm
    from governor_mechanism.files.results import save_csv, save_json, save_netcdf
    from governor_mechanism.render.figures.registry import write_machine_figures
    from governor_mechanism.render.figures.time_series import readings_figure

    written = []
    if film is not None and len(result.times) > 1:
        with show_progress_bar("film") as progress:
            written.append(gm.film(result, out / f"{stem}.{film.value}", progress=progress))
    written += write_machine_figures(result, out, stem)
    writers = {"csv": save_csv, "nc": save_netcdf, "png": readings_figure, "json": save_json}
    for kind, write in writers.items():
        path = out / f"{stem}.{kind}"
        write(result, path)
        written.append(path)
    return written


if __name__ == "__main__":
    main()

"""The command line: `models`, `run`, `equilibria`, `crosscheck`, `design`, and the studies of `cli_studies`.

Heavy imports wait until a command needs them.
"""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.cli.console import (
    BAD_INPUT,
    FAILED,
    INTERRUPTED,
    OK,
    Answered,
    guarded_command,
    number,
    print_json,
    progress_bar,
    say,
    working,
)
from governor_mechanism.cli.design import design
from governor_mechanism.cli.options import RESULTS, AsJson, FigureFolder, NoFigure, SceneName, prepare_folder
from governor_mechanism.cli.studies import accuracy, effects, regulation, sweep
from governor_mechanism.errors import MechanismError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from governor_mechanism.model.scene import Scene
    from governor_mechanism.model.trajectory import Trajectory
    from governor_mechanism.statics.equilibria import Equilibrium
    from governor_mechanism.statics.speed_curve import SpeedCurve, StandingBand

app = typer.Typer(
    name="governor-mechanism",
    help="Simulate, film and cross-check the mechanisms that once controlled machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


class FilmFormat(StrEnum):
    """How a run is filmed."""

    GIF = "gif"
    MP4 = "mp4"


def main() -> None:
    """Entry point of the command."""
    try:
        app()
    except Answered:
        raise
    except SystemExit as stop:
        if stop.code == BAD_INPUT and "--json" in sys.argv:
            print_json({"outcome": "bad_input", "problems": ["the command's words are off; see --help"]})
        raise
    except KeyboardInterrupt:  # before a command was reached
        say("interrupted")
        raise SystemExit(INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        from governor_mechanism import __version__

        print(__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Simulate, film and cross-check the mechanisms that once controlled machines."""


@app.command()
@guarded_command
def models(as_json: AsJson = False) -> int:
    """List the shipped scenes, one line each."""
    from governor_mechanism.scenes.library import shipped, title_of

    scenes = {name: title_of(path) for name, path in shipped().items()}
    if as_json:
        print_json({"models": [{"name": name, "title": title} for name, title in scenes.items()]})
        return OK
    width = max(map(len, scenes))
    for name, title in scenes.items():
        print(f"{name:<{width}}  {title}")
    return OK


@app.command()
@guarded_command
def run(
    scene: SceneName,
    engine: Annotated[str, typer.Option(help="auto, or the name of an engine; the scene's own if left out.")] = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Relative to each reading's scale; the scene's own.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = RESULTS,
    film: Annotated[FilmFormat, typer.Option(help="Kind of film; mp4 needs the extra 'video'.")] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Leave the film out.")] = False,
    as_json: AsJson = False,
) -> int:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    import governor_mechanism as gm
    from governor_mechanism.files.results import summary
    from governor_mechanism.machines.slide_valve import SlideValve

    if film is FilmFormat.MP4 and not no_film:
        from governor_mechanism.render.film.writer import require_video_writer

        require_video_writer()
    prepare_folder(out)
    opened = gm.load(scene)
    with working("simulating"):
        result = gm.run(opened, engine=engine, accuracy=accuracy)
    stem = Path(result.scene.source).stem or "scene"
    files = _write(result, out, stem, None if no_film else film)
    steam = gm.valve_events(opened) if opened.part.machine == SlideValve.name else None
    if as_json:
        more = {} if steam is None else {"steam": steam.as_json()}
        print_json({**summary(result), **more, "files": [str(path) for path in files]})
    else:
        from governor_mechanism.cli.summary import describe

        print(describe(result))
        if steam is not None:
            print(steam)
        print("wrote " + ", ".join(str(path) for path in files))
        if not result.outcome.ok:
            say(result.message)
    return OK if result.outcome.ok else FAILED


@app.command()
@guarded_command
def crosscheck(scene: SceneName, as_json: AsJson = False) -> int:
    """Compare the simulation of a scene with every closed form that applies; exit status 1 when one does not agree."""
    import governor_mechanism as gm

    opened = gm.load(scene)
    with working("simulating"):
        report = gm.crosscheck(opened)
    if as_json:
        rows = [
            {
                "quantity": row.quantity,
                "simulated": number(row.simulated),
                "expected": number(row.expected),
                "difference": number(row.difference),
                "allowed": row.allowed,
                "unit": row.unit,
                "reason": row.reason,
                "passed": row.passed,
            }
            for row in report.rows
        ]
        print_json(
            {
                "title": report.title,
                "against": report.against,
                "passed": report.passed,
                "rows": rows,
                "notes": list(report.notes),
            }
        )
    else:
        print(report)
    return OK if report.passed else FAILED


@app.command()
@guarded_command
def equilibria(
    scene: SceneName,
    speed: Annotated[
        str | None, typer.Option(help='Of the spindle, as "6.4 rad/s" or "61 rpm"; the scene\'s own.')
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Friction that holds it, as "40 N": draw the standing band.')
    ] = None,
    against: Annotated[str, typer.Option(help="The reading at which the resistance acts.")] = "sleeve_lift",
    out: FigureFolder = RESULTS,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Find every position of rest at a speed, with its stability; draw the characteristic, speed against travel."""
    import governor_mechanism as gm
    from governor_mechanism.cli.summary import describe_rests, rests_as_json
    from governor_mechanism.statics.equilibrium_speed import balances
    from governor_mechanism.units.quantities import parse

    prepare_folder(out)
    opened = gm.load(scene)
    wanted = None if speed is None else parse(speed, "angular_speed", "--speed")
    hold = None if resistance is None else _resistance(opened, resistance, against)
    found = gm.equilibria(opened, wanted)
    curve = gm.speed_curve(opened, resistance=hold, against=against) if balances(opened) else None
    bands = [] if hold is None else [_band(opened, rest, hold, against) for rest in found]
    files = [] if no_figure or curve is None else _characteristics(opened, curve, found, out)
    if as_json:
        told = {"coordinate": opened.part.mechanism.coordinate, **rests_as_json(found, curve, bands)}
        print_json({**told, "files": [str(path) for path in files]})
    else:
        lines = [opened.title, *describe_rests(opened, found, curve, bands), *(f"wrote {path}" for path in files)]
        print("\n".join(lines))
    return OK


def _resistance(scene: Scene, text: str, against: str) -> float:
    from governor_mechanism.statics.equilibrium_speed import require_turning
    from governor_mechanism.units.quantities import parse

    require_turning(scene)
    quantities = {reading.name: reading.quantity for reading in scene.part.mechanism.readings}
    if against not in quantities:
        raise MechanismError(
            f"--resistance acts at a reading, and there is no {against!r}; name one by --against: {list(quantities)}"
        )
    return parse(text, "torque" if quantities[against] == "angle" else "force", "--resistance")


def _band(scene: Scene, rest: Equilibrium, hold: float, against: str) -> StandingBand | str:
    """The standing band at a position of rest, or why there is none."""
    import governor_mechanism as gm

    try:
        return gm.standing_band(scene, [rest.coordinate], hold, against)
    except MechanismError as error:
        return error.problems[0]


def _characteristics(scene: Scene, curve: SpeedCurve, found: Sequence[Equilibrium], out: Path) -> list[Path]:
    """The characteristic, and Zehnder's plate for the governors it speaks of."""
    from governor_mechanism.render.figures.parabolic.isochronous_plate import has_parabolas, parabolas_figure
    from governor_mechanism.render.figures.speed_curve import characteristic_figure

    stem = Path(scene.source).stem
    files = [characteristic_figure(scene, curve, out / f"{stem}_characteristic.png", found)]
    if has_parabolas(scene):
        files.append(parabolas_figure(scene, out / f"{stem}_parabolas.png"))
    return files


for command in (accuracy, effects, regulation, sweep, design):
    app.command()(command)


def _write(result: Trajectory, out: Path, stem: str, film: FilmFormat | None) -> list[Path]:
    """Write every result: the film, which takes longest, first, and the record last.

    Interrupted in the film, the results of an earlier run stay as they were; where a record stands, all is complete.
    """
    import governor_mechanism as gm
    from governor_mechanism.files.results import save_csv, save_json, save_netcdf
    from governor_mechanism.render.figures.registry import machine_figures
    from governor_mechanism.render.figures.time_series import readings_figure

    written = []
    if film is not None and len(result.times) > 1:
        with progress_bar("film") as progress:
            written.append(gm.film(result, out / f"{stem}.{film.value}", progress=progress))
    written += machine_figures(result, out, stem)
    writers = {"csv": save_csv, "nc": save_netcdf, "png": readings_figure, "json": save_json}
    for kind, write in writers.items():
        path = out / f"{stem}.{kind}"
        write(result, path)
        written.append(path)
    return written


if __name__ == "__main__":
    main()

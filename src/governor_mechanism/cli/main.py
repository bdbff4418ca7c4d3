"""The command line: `compile`, `equilibria`, `crosscheck`, and the commands of the other files of this folder.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import gc
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.changed_scene import Changes, load_changed
from governor_mechanism.cli.compare import compare
from governor_mechanism.cli.crosscheck import crosscheck
from governor_mechanism.cli.design import design
from governor_mechanism.cli.errata import errata
from governor_mechanism.cli.given_options import refuse_idle_options
from governor_mechanism.cli.regulation import regulation_app
from governor_mechanism.cli.run import run
from governor_mechanism.cli.scenes import catalogue, describe, init, models, schema
from governor_mechanism.cli.strict_command import add_command
from governor_mechanism.cli.studies import accuracy, effects, hard_cases, sweep, valve_gears
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.cli.summary import EquilibriaReport
    from governor_mechanism.statics.speed_curve import SpeedCurve

COLLECTION_THRESHOLD = 100_000
"""Number of new objects after which unreachable ones are searched for; what is imported stays, and searching it takes longer than a run."""

HELP = "Simulate, film and verify the mechanisms that once controlled machines."
app = typer.Typer(name="governor-mechanism", help=HELP, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)


def main() -> None:
    """Run the command line."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed; without this, a file of results would get its number
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):  # its encoding may lack a character; results and messages matter more than that
            stream.reconfigure(errors="replace")
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


def equilibria(
    scene: console.SceneName,
    changes: Changes = None,
    speed: Annotated[
        str | None, typer.Option(help='Spindle speed, for example "6.4 rad/s" or "61 rpm"; by default the one of the scene.')
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Friction at a reading, for example "40 N": compute and draw the insensitivity band.')
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="The reading of the sleeve, along which resistance and effort act. [sleeve_lift]")
    ] = None,
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
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find all equilibria at a speed and their stability; draw the speed curve and the controlling force."""
    from governor_mechanism.cli.summary import report_equilibria, report_linearisation
    from governor_mechanism.units.quantities import number_or_text, parse_quantity

    _refuse_idle(linearise=linearise, limit=limit)
    loaded_scene = load_changed(scene, changes)
    spindle_speed = None if speed is None else parse_quantity(number_or_text(speed), "angular_speed", "--speed")
    if linearise or limit is not None:
        with console.show_status("linearising"):
            return report_linearisation(loaded_scene, spindle_speed, limit)
    console.prepare_folder(figures.folder)
    report = report_equilibria(loaded_scene, spindle_speed, resistance, against, working_range, speed_change)
    files = _write_speed_curve_figures(report, report.curve, figures) if figures.formats and report.curve else []
    return console.CommandResult(text=[report.scene.title, *report.lines()], values=report.as_json(), files=files)


def _refuse_idle(*, linearise: bool, limit: str | None) -> None:
    """Raise MechanismError for options that do nothing beside others."""
    if linearise or limit is not None:
        mode = "--limit" if limit is not None else "--linearise"
        idle = ("resistance", "against", "working_range", "speed_change", "out", "figure_formats", "theme")
        refuse_idle_options(*(("speed", "linearise") if limit is not None else ()), *idle, condition=f"with {mode}")


def _write_speed_curve_figures(report: EquilibriaReport, curve: SpeedCurve, figures: FigureFiles) -> list[Path]:
    """Draw the speed curve, the controlling force if there are balls, and Zehnder's plate for the governors that it covers."""
    from governor_mechanism.render.figures.controlling_force import controlling_force_figure
    from governor_mechanism.render.figures.parabolic.isochronous_data import has_isochronous_parabolas
    from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
    from governor_mechanism.render.figures.speed_curve import speed_curve_figure

    scene, stem = report.scene, Path(report.scene.source).stem
    points = [equilibrium for equilibrium, _ in report.points]
    files = figures.save(speed_curve_figure(scene, curve, points), f"{stem}_characteristic")
    forces = report.controlling_force.curve if report.controlling_force else None
    if forces is not None:
        files += figures.save(controlling_force_figure(scene, forces, points), f"{stem}_controlling_force")
    if has_isochronous_parabolas(scene):
        files += figures.save(isochronous_figure(scene), f"{stem}_parabolas")
    return files


for command in (
    models,
    catalogue,
    init,
    describe,
    schema,
    run,
    compare,
    crosscheck,
    equilibria,
    accuracy,
    effects,
    sweep,
    hard_cases,
    valve_gears,
    errata,
):
    add_command(app, command)
# Inputs of a design may be options of their own; `design` answers a misspelt one.
_ANY_OPTIONS = {"allow_extra_args": True, "ignore_unknown_options": True}
add_command(app, design, context_settings=_ANY_OPTIONS)
app.add_typer(regulation_app, name="regulation")


if __name__ == "__main__":
    main()

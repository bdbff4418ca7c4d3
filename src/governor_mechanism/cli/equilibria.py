"""The command `equilibria`: equilibria, linearised equations, limits of stability; heavy imports are made when it needs them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, parse_range, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text, parse_quantity

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene


def equilibria(
    scene: SceneName,
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
    from governor_mechanism.studies.equilibrium_report import DEFAULT_SLEEVE, report_equilibria

    _refuse_idle(linearise=linearise, limit=limit)
    loaded_scene = load_changed(scene, changes)
    spindle_speed = None if speed is None else parse_quantity(number_or_text(speed), "angular_speed", "--speed")
    if linearise or limit is not None:
        with console.show_status("linearising"):
            return report_linearisation(loaded_scene, spindle_speed, limit)
    report = report_equilibria(
        loaded_scene,
        spindle_speed,
        resistance=None if resistance is None else _parse_resistance(loaded_scene, resistance, against or DEFAULT_SLEEVE),
        against=against,
        between=None if working_range is None else parse_range(working_range),
        speed_change=speed_change,
    )
    return console.CommandResult(report, files=figures.save_all(report, stem_of(report.scene)))


def _refuse_idle(*, linearise: bool, limit: str | None) -> None:
    """Raise MechanismError for options that do nothing beside others."""
    if linearise or limit is not None:
        mode = "--limit" if limit is not None else "--linearise"
        idle = ("resistance", "against", "working_range", "speed_change", "folder", "formats", "theme")
        refuse_idle_options(*(("speed", "linearise") if limit is not None else ()), *idle, condition=f"with {mode}")


def _parse_resistance(scene: Scene, text: str, against: str) -> float:
    """Return a resistance along a reading of the part that turns with a spindle, N or N m."""
    from governor_mechanism.engines.rotating_part import rotating_part_alone
    from governor_mechanism.statics.equilibrium_speed import require_equilibrium_speed

    rotating_part = rotating_part_alone(scene)
    require_equilibrium_speed(rotating_part)
    quantities = {reading.name: reading.quantity for reading in rotating_part.part.mechanism.readings}
    if against not in quantities:
        raise MechanismError(
            f"--resistance acts along a reading, and there is no reading {against!r}; choose one with --against: {list(quantities)}"
        )
    return parse_quantity(text, "torque" if quantities[against] == "angle" else "force", "--resistance")


def report_linearisation(
    scene: Scene,
    spindle_speed: float | None,  # speed of the spindle, rad/s; that of the scene if None
    limit: str | None,  # key and range as "KEY=LOW:HIGH" for a limit of stability, or None
) -> console.CommandResult:
    """Return what `equilibria --linearise` and `--limit` print."""
    from governor_mechanism.studies.equilibrium_report import LinearisationReport, report_linearisations

    if limit is None:
        return console.CommandResult(report_linearisations(scene, spindle_speed))
    key, low, high = _parse_limit(limit)
    found = gm.stability_limit(scene, key, low, high)
    return console.CommandResult(LinearisationReport(title=scene.title, linearisations=(found.linearisation,), limit=found))


def _parse_limit(text: str) -> tuple[str, str | float, str | float]:
    key, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and key.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--limit {text!r} is not understood; write "KEY=LOW:HIGH", as in "effects.dashpot.sleeve=0:100"')
    return key.strip(), number_or_text(low), number_or_text(high)

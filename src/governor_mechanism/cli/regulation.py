"""The commands `equilibria` and `regulation ...`: how a governor regulates; heavy imports are made when one needs them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, Final

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
    from governor_mechanism.engines.initial_state import rotating_part_alone
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


StudiedScene = Annotated[str, typer.Argument(metavar="[SCENE]", help="A scene file or a shipped scene; by default the one of the study.")]

STUDIES: Final = {
    "cyclic": "Find the amplitude of the cyclic sleeve motion against the speed fluctuation.",
    "clearance": "Find the amplitude of the cyclic sleeve motion against the clearance.",
    "settling": "Find the settling time against the damping.",
    "jump": "Find the delay of the jump at a fold against the ramp rate of the speed.",
}
"""What --help says of each study of one governor, by its name."""


def _make_command(name: str) -> Callable[..., console.CommandResult]:
    """Return the command of a study of one governor."""

    def study(scene: StudiedScene = "", *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
        from governor_mechanism.studies.regulation.governor_studies import study_governors

        with console.show_status("running"):
            result = study_governors(name, [gm.load(scene)] if scene else None)
            return console.CommandResult(result, files=figures.save_all(result, name))

    study.__doc__ = STUDIES[name]
    return study


def loop(
    scene: SceneName,
    changes: Changes = None,
    load_step: Annotated[
        str, typer.Option(help='The load before and after the change, in parts of load.rated_torque, for example "100%:50%".')
    ] = "100%:50%",
    at: Annotated[str | None, typer.Option(help='The time of the change, for example "6 s". [a tenth of the duration]')] = None,
    ramp: Annotated[str, typer.Option(help='How long the change lasts, for example "3 s"; 0 is a step.')] = "0 s",
    engine: console.EngineOfScene = "auto",
    accuracy: console.Accuracy = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Change the load of a governed engine: droop, overshoot, settling time, and whether it hunts.

    The run starts in the equilibrium under the first load. The exit status is 1 if the speed does not settle.
    """
    loaded = load_changed(scene, changes)
    with console.show_status("simulating"):
        times: dict[str, Any] = {"at": None if at is None else number_or_text(at), "ramp": number_or_text(ramp)}
        study = gm.load_change_study(loaded, load_step, **times, engine=engine, accuracy=accuracy)
    files = figures.save_all(study, f"{stem_of(loaded)}_loop")
    return console.CommandResult(study, text=[study.title, study], files=files, ok=study.ok)


def stability_map(
    scene: SceneName,
    changes: Changes = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(help="The values of a key, key=first:last:count; twice. [inertia of the flywheel and dashpot on the sleeve]"),
    ] = None,
    border_points: Annotated[int, typer.Option(help="Number of points at which the border is located by simulation; 0 for none.")] = 8,
    workers: console.Workers = 2,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Map where a governed engine is stable and where it hunts, over two parameters.

    By eigenvalues with the mean torque, with Vyshnegradskii's limit over them, and by the simulated border under the cyclic torque.
    """
    loaded = load_changed(scene, changes)
    with console.show_progress_bar("map") as progress:
        study = gm.stability_map(loaded, vary or (), border_points=border_points, workers=workers, progress=progress)
    return console.CommandResult(study, text=[study.title, study], files=figures.save_all(study, f"{stem_of(loaded)}_map"))


def rules(*, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Test the papers' rules about governing on the simulated engine: what each says, what the simulation shows, and whether it holds."""
    with console.show_progress_bar("rules") as progress:
        study = gm.paper_rules(progress)
    return console.CommandResult(study, files=figures.save_all(study, "paper_rules"))


regulation_app = typer.Typer(help="Study how a governor regulates.", no_args_is_help=True, rich_markup_mode=None)
for command in (loop, rules):
    console.add_command(regulation_app, command)
for study_name in STUDIES:
    console.add_command(regulation_app, _make_command(study_name), study_name)
console.add_command(regulation_app, stability_map, "map")

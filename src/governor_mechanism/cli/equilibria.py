"""The commands `equilibria`: equilibria, linearised equations, limits of stability; and `regulation ...`: how a governor regulates.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, parse_range, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text, parse_quantity

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.statics.linearisation import Linearisation, StabilityLimit
    from governor_mechanism.types import FloatArray


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
    console.prepare_folder(figures.folder)
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
        idle = ("resistance", "against", "working_range", "speed_change", "out", "figure_formats", "theme")
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
    """Return what `equilibria --linearise` and `--limit` print: lines for the terminal, and the same in SI."""
    if limit is not None:
        key, low, high = _parse_limit(limit)
        result = gm.stability_limit(scene, key, low, high)
        limit_values = {name: value for name, value in result.as_json().items() if name != "linearisation"}
        values = {"limit": limit_values, "linearisations": [_values_of(result.linearisation)]}
        return console.CommandResult(text=[scene.title, _format_limit(result), result.linearisation], values=values)
    linearisations = _linearise_all(scene, spindle_speed)
    return console.CommandResult(text=[scene.title, *linearisations], values={"linearisations": [*map(_values_of, linearisations)]})


def _linearise_all(scene: Scene, spindle_speed: float | None) -> Sequence[Linearisation | str]:
    """Linearise about each equilibrium, or give the reason why not; about the state nearest to the start if no equilibria are known."""
    from governor_mechanism.model.part import Spindle
    from governor_mechanism.statics.linearisation import last_spindle_speed
    from governor_mechanism.studies.equilibrium_report import result_or_reason

    if len(scene.parts) > 1 or not isinstance(scene.spindle, Spindle):
        return [gm.linearise(scene, spindle_speed)]
    points = result_or_reason(gm.equilibria, scene, last_spindle_speed(scene) if spindle_speed is None else spindle_speed)
    if isinstance(points, str):
        return [gm.linearise(scene, spindle_speed)]
    results = [result_or_reason(gm.linearise, scene, spindle_speed, at=point) for point in points]
    if all(isinstance(one, str) for one in results):
        raise MechanismError(*dict.fromkeys(map(str, results)))
    return results


def _parse_limit(text: str) -> tuple[str, str | float, str | float]:
    key, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and key.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--limit {text!r} is not understood; write "KEY=LOW:HIGH", as in "effects.dashpot.sleeve=0:100"')
    return key.strip(), number_or_text(low), number_or_text(high)


def _format_limit(limit: StabilityLimit[Linearisation]) -> str:
    from governor_mechanism.statics.first_order_system import Onset

    value = f"{limit.value:.10g} {limit.unit}".strip()
    side = "below" if limit.stable_below else "above"
    if not limit.frequency:
        return f"{limit.key}: stable {side} {value}; at the limit the motion diverges without oscillation"
    onset = {
        Onset.SOFT: "soft (their amplitude grows from zero)",
        Onset.HARD: "hard (large disturbances lead to large oscillations on the stable side too)",
        Onset.UNKNOWN: "not determined",
    }[limit.onset]
    return f"{limit.key}: stable {side} {value}; oscillations of {limit.frequency:.6g} rad/s begin there, onset {onset}"


def _values_of(linearisation: Linearisation | str) -> object:
    """Return what is printed of linearised equations, or the reason why there are none."""
    if isinstance(linearisation, str):
        return linearisation
    record = linearisation.as_json()
    shown = {name: value for name, value in record.items() if name not in ("state_names", "eigenvalues")}
    return {"states": record["state_names"], **shown}


StudiedScene = Annotated[str, typer.Argument(metavar="[SCENE]", help="A scene file or a shipped scene; by default the one of the study.")]


def cyclic(scene: StudiedScene = "", *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Find the amplitude of the cyclic sleeve motion against the speed fluctuation."""
    from governor_mechanism.studies.regulation.cyclic_irregularity import FLUCTUATION_RATIOS, study_cyclic_motion

    return _study("cyclic", [scene or "porter_cyclic"], study_cyclic_motion, FLUCTUATION_RATIOS, figures)


def clearance(scene: StudiedScene = "", *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Find the amplitude of the cyclic sleeve motion against the clearance."""
    from governor_mechanism.studies.regulation.cyclic_irregularity import CLEARANCES, study_clearance

    scenes = [scene] if scene else ["porter_clearance", "watt_clearance"]
    return _study("clearance", scenes, study_clearance, CLEARANCES, figures)


def settling(scene: StudiedScene = "", *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Find the settling time against the damping."""
    from governor_mechanism.studies.regulation.speed_changes import DAMPING_COEFFICIENTS, study_settling

    return _study("settling", [scene or "porter_load_step"], study_settling, DAMPING_COEFFICIENTS, figures)


def jump(scene: StudiedScene = "", *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Find the delay of the jump at a fold against the ramp rate of the speed."""
    from governor_mechanism.studies.regulation.speed_changes import RAMP_RATES, study_fold_jump

    return _study("jump", [scene or "watt_improved"], study_fold_jump, RAMP_RATES, figures)


def _study(
    name: str, scenes: Sequence[str], make_study: Callable[..., Any], values: FloatArray, figures: FigureFiles
) -> console.CommandResult:
    """Make a study of the governor of each scene, and draw all results in one figure."""
    from governor_mechanism.engines.rotating_part import rotating_part_alone

    console.prepare_folder(figures.folder)
    with console.show_status("running"):
        results = [make_study(rotating_part_alone(gm.load(scene)), values) for scene in scenes]
        files = figures.save(results[0].plot(*results[1:]), name) if figures.formats else []
    conclusions = [result.conclusion for result in results]
    record = {"study": name, "conclusions": conclusions, "results": [result.as_json() for result in results]}
    return console.CommandResult(text=conclusions, values=record, files=files)


def loop(
    scene: SceneName,
    changes: Changes = None,
    load_step: Annotated[
        str, typer.Option(help='The load before and after the change, in parts of load.rated_torque, for example "100%:50%".')
    ] = "100%:50%",
    at: Annotated[str | None, typer.Option(help='The time of the change, for example "6 s". [a tenth of the duration]')] = None,
    ramp: Annotated[str, typer.Option(help='How long the change lasts, for example "3 s"; 0 is a step.')] = "0 s",
    engine: Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of the scene.")] = "auto",
    accuracy: console.Accuracy = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Change the load of a governed engine: droop, overshoot, settling time, and whether it hunts.

    The run starts in the equilibrium under the first load. The exit status is 1 if the speed does not settle.
    """
    console.prepare_folder(figures.folder)
    loaded = load_changed(scene, changes)
    with console.show_status("simulating"):
        times: dict[str, Any] = {"at": None if at is None else number_or_text(at), "ramp": number_or_text(ramp)}
        study = gm.load_change_study(loaded, load_step, **times, engine=engine, accuracy=accuracy)
    stem = f"{stem_of(loaded)}_loop"
    files = [study.save_json(figures.folder / f"{stem}.json")]
    return console.CommandResult(study, text=[study.title, study], files=files + figures.save_all(study, stem), ok=study.ok)


def stability_map(
    scene: SceneName,
    changes: Changes = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(help="The values of a key, key=first:last:count; twice. [inertia of the flywheel and dashpot on the sleeve]"),
    ] = None,
    border_points: Annotated[int, typer.Option(help="Number of points at which the border is located by simulation; 0 for none.")] = 8,
    workers: Annotated[int, typer.Option(help="Largest number of processes. The result does not depend on it.")] = 2,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Map where a governed engine is stable and where it hunts, over two parameters.

    By eigenvalues with the mean torque, with Vyshnegradskii's limit over them, and by the simulated border under the cyclic torque.
    """
    console.prepare_folder(figures.folder)
    loaded = load_changed(scene, changes)
    with console.show_progress_bar("map") as progress:
        study = gm.stability_map(loaded, vary or (), border_points=border_points, workers=workers, progress=progress)
    stem = f"{stem_of(loaded)}_map"
    files = [study.save_json(figures.folder / f"{stem}.json")]
    return console.CommandResult(study, text=[study.title, study], files=files + figures.save_all(study, stem))


def rules(*, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Test the papers' rules about governing on the simulated engine: what each says, what the simulation shows, and whether it holds."""
    console.prepare_folder(figures.folder)
    with console.show_progress_bar("rules") as progress:
        study = gm.paper_rules(progress)
    files = [study.save_json(figures.folder / "paper_rules.json")]
    return console.CommandResult(study, files=files + figures.save_all(study, "paper_rules"))


regulation_app = typer.Typer(help="Study how a governor regulates.", no_args_is_help=True, rich_markup_mode=None)
for command in (loop, rules, cyclic, clearance, settling, jump):
    console.add_command(regulation_app, command)
console.add_command(regulation_app, stability_map, "map")

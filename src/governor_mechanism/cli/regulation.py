"""The commands `regulation ...`: how a governor regulates; heavy imports are made when one needs them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Final

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, stem_of
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

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

"""The commands `regulation ...`: how a governor regulates, with one or many runs each.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, stem_of
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    from governor_mechanism.types import FloatArray

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

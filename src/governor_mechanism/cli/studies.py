"""The commands that run a scene many times: `accuracy`, `effects`, `regulation`, `sweep`.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli.console import CommandResult, print_to_stderr, show_progress_bar, show_status
from governor_mechanism.cli.options import RESULTS_FOLDER, Accuracy, AsJson, FigureFolder, NoFigure, SceneName, prepare_folder

if TYPE_CHECKING:
    from governor_mechanism.types import FloatArray


def accuracy(
    scene: SceneName,
    wanted: Annotated[
        float | None, typer.Option("--for", help="Print the fastest setting for this error, relative to the scale of each reading.")
    ] = None,
    longest: Annotated[float, typer.Option(help="Maximum time of one setting in seconds; the reference may take longer.")] = 1.0,
    out: FigureFolder = RESULTS_FOLDER,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> CommandResult:
    """Measure error and time of every engine at every setting; write a figure, a table (CSV) and a record (JSON)."""
    from governor_mechanism.studies.work_precision.results import validate_target_error

    if wanted is not None:
        validate_target_error(wanted)
    prepare_folder(out)
    loaded_scene = gm.load(scene)
    with show_progress_bar("accuracy") as progress:
        study = gm.accuracy_study(loaded_scene, longest, progress)
    stem = f"{Path(loaded_scene.source).stem or 'scene'}_accuracy"
    files = [study.save_csv(out / f"{stem}.csv"), study.save_json(out / f"{stem}.json")]
    is_measurable = wanted is None or wanted >= study.reference.resolvable_error
    is_reached = wanted is None or (is_measurable and study.cheapest_for(wanted) is not None)
    advice = None if wanted is None else study.advice(wanted) if is_measurable else study.unresolvable_message(wanted)
    if not no_figure:
        from governor_mechanism.render.figures.work_precision import work_precision_figure

        files.append(work_precision_figure(study, wanted if is_measurable else None).save_png(out / f"{stem}.png"))
    request = {} if wanted is None else {"for": wanted, "advice": advice, "reached": is_reached}
    return CommandResult(text=[study, *([advice] if advice else [])], values={**study.as_json(), **request}, files=files, ok=is_reached)


def effects(
    scene: SceneName,
    engine: Annotated[str, typer.Option(help="The engine of all runs.")] = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Accuracy relative to the scale of each reading.")] = None,
    out: FigureFolder = RESULTS_FOLDER,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> CommandResult:
    """Show what each effect of a scene changes, what it costs, and which effects can be left out."""
    prepare_folder(out)
    loaded_scene = gm.load(scene)
    with show_progress_bar("effects") as progress:
        study = gm.effects_study(loaded_scene, engine, accuracy, progress)
    files = []
    if not no_figure:
        from governor_mechanism.render.figures.effect_ablation import effect_ablation_figure

        files.append(effect_ablation_figure(study).save_png(out / f"{Path(loaded_scene.source).stem or 'scene'}_effects.png"))
    return CommandResult(text=[study], values=study.as_json(), files=files)


class RegulationStudy(StrEnum):
    """Studies of the regulation by a governor."""

    CYCLIC = "cyclic"
    CLEARANCE = "clearance"
    SETTLING = "settling"
    JUMP = "jump"


def regulation(
    study: Annotated[RegulationStudy, typer.Argument(help="The study to make.")],
    scene: Annotated[
        str, typer.Argument(help="A scene file or the name of a shipped scene; by default the shipped scene of the study.")
    ] = "",
    out: FigureFolder = RESULTS_FOLDER,
    as_json: AsJson = False,
) -> CommandResult:
    """Study how a governor regulates, with many runs each.

    cyclic: amplitude of the cyclic sleeve motion against the speed fluctuation. clearance: the same against the clearance.
    settling: settling time against the damping. jump: delay of the jump at a fold against the ramp rate of the speed.
    """
    from governor_mechanism.engines.rotating_part import rotating_part_alone
    from governor_mechanism.render.figures import regulation as figures
    from governor_mechanism.studies.regulation import cyclic_irregularity as cyclic
    from governor_mechanism.studies.regulation import fold_jump, settling_time

    # By study: its default scenes, its function, the values of its curve, and its figure, of all results if there are several scenes.
    studies: dict[RegulationStudy, tuple[Sequence[str], Callable[..., Any], FloatArray, Callable[..., Any]]] = {
        RegulationStudy.CYCLIC: (["porter_cyclic"], cyclic.study_cyclic_motion, cyclic.FLUCTUATION_RATIOS, figures.cyclic_figure),
        RegulationStudy.CLEARANCE: (
            ["porter_clearance", "watt_clearance"],
            cyclic.study_clearance,
            cyclic.CLEARANCES,
            figures.clearance_figure,
        ),
        RegulationStudy.SETTLING: (
            ["porter_load_step"],
            settling_time.study_settling,
            settling_time.DAMPING_COEFFICIENTS,
            figures.settling_figure,
        ),
        RegulationStudy.JUMP: (["watt_improved"], fold_jump.study_fold_jump, fold_jump.RAMP_RATES, figures.fold_jump_figure),
    }
    prepare_folder(out)
    path = out / f"{study.value}.png"
    default_scenes, make_study, values, draw_figure = studies[study]
    with show_status("running"):
        results = [make_study(rotating_part_alone(gm.load(name)), values) for name in ([scene] if scene else default_scenes)]
        draw_figure(results if len(default_scenes) > 1 else results[0]).save_png(path)
    conclusions = [result.conclusion for result in results]
    return CommandResult(text=conclusions, values={"study": study, "conclusions": conclusions}, files=[path])


def sweep(
    scene: SceneName,
    vary: Annotated[
        list[str],
        typer.Option(
            help="The values of a key: key=first:last:count or key=value,value,..., for example dimensions.arm=200mm:400mm:50. Repeatable."
        ),
    ],
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            help='A number to take from each run: "max arm_angle", "rate of arm_angle", "duration", ... Repeatable. [leading coordinate]'
        ),
    ] = None,
    engine: Annotated[str, typer.Option(help="The engine of all rows; auto uses the engine of the scene.")] = "auto",
    accuracy: Accuracy = None,
    certify: Annotated[bool, typer.Option("--certify", help="Estimate the error of every run.")] = False,
    workers: Annotated[int, typer.Option(help="Number of processes. The result does not depend on it.")] = 1,
    out: Annotated[
        Path, typer.Option(help="Folder for table, record and figure. An interrupted sweep continues from there.")
    ] = RESULTS_FOLDER,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> CommandResult:
    """Run a scene at a grid or list of values of its keys. The same command continues an interrupted sweep."""
    from governor_mechanism.studies.sweep.checkpoint import journal_path

    prepare_folder(out)
    loaded = gm.load(scene)
    journal_file = journal_path(out, loaded.source)
    rows = _ProgressCounter()
    try:
        with show_progress_bar("sweep") as rows.bar:
            result = gm.sweep(
                loaded, vary, quantity or None, engine=engine, accuracy=accuracy, certify=certify, workers=workers, out=out, progress=rows
            )
    except KeyboardInterrupt:
        if journal_file.exists():
            print_to_stderr(f"{rows.done} of {rows.total} rows are in {journal_file}; the same command continues from there")
        raise
    files = [journal_file.with_suffix(kind) for kind in (".csv", ".json")]
    if not no_figure:
        from governor_mechanism.render.figures.sweep import sweep_figure

        files.append(sweep_figure(result).save_png(journal_file.with_suffix(".png")))
    return CommandResult(text=[result], values=result.as_json(), files=files, ok=result.ok)


class _ProgressCounter:
    """Progress callback that passes the counts on to a progress bar, if there is one, and stores them."""

    def __init__(self) -> None:
        self.done = self.total = 0
        self.bar: Callable[[int, int], None] | None = None

    def __call__(self, done: int, total: int) -> None:
        self.done, self.total = done, total
        if self.bar is not None:
            self.bar(done, total)

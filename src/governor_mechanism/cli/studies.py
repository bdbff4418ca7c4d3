"""The commands that run a scene many times: `accuracy`, `effects`, `regulation`, `sweep`.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli.console import CommandResult, print_to_stderr, show_progress_bar, show_status
from governor_mechanism.cli.options import RESULTS_FOLDER, Accuracy, AsJson, FigureFolder, NoFigure, SceneName, prepare_folder


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

        files.append(work_precision_figure(study, out / f"{stem}.png", wanted if is_measurable else None))
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

        files.append(effect_ablation_figure(study, out / f"{Path(loaded_scene.source).stem or 'scene'}_effects.png"))
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
) -> CommandResult:
    """Study how a governor regulates, with many runs each.

    cyclic: amplitude of the cyclic sleeve motion against the speed fluctuation. clearance: the same against the clearance.
    settling: settling time against the damping. jump: delay of the jump at a fold against the ramp rate of the speed.
    """
    from governor_mechanism.engines.rotating_part import rotating_part_alone
    from governor_mechanism.render.figures import regulation as figures
    from governor_mechanism.studies.regulation.cyclic_irregularity import (
        CLEARANCES,
        FLUCTUATION_RATIOS,
        study_clearance,
        study_cyclic_motion,
    )
    from governor_mechanism.studies.regulation.fold_jump import RAMP_RATES, study_fold_jump
    from governor_mechanism.studies.regulation.settling_time import DAMPING_COEFFICIENTS, study_settling

    prepare_folder(out)
    path = out / f"{study.value}.png"
    with show_status("running"):
        match study:
            case RegulationStudy.CYCLIC:
                cyclic_study = study_cyclic_motion(rotating_part_alone(gm.load(scene or "porter_cyclic")), FLUCTUATION_RATIOS)
                figures.cyclic_figure(cyclic_study, path)
                conclusion = (
                    f"cyclic sleeve motion from a speed fluctuation of {cyclic_study.threshold:.6g} insensitivity bands; "
                    f"the band is {cyclic_study.insensitivity_band:.6g}"
                )
            case RegulationStudy.CLEARANCE:
                names = [scene] if scene else ["porter_clearance", "watt_clearance"]
                clearance_studies = [study_clearance(rotating_part_alone(gm.load(name)), CLEARANCES) for name in names]
                figures.clearance_figure(clearance_studies, path)
                conclusion = "\n".join(f"{one.title}: {one.conclusion}" for one in clearance_studies)
            case RegulationStudy.SETTLING:
                settling_study = study_settling(rotating_part_alone(gm.load(scene or "porter_load_step")), DAMPING_COEFFICIENTS)
                figures.settling_figure(settling_study, path)
                conclusion = f"shortest settling time {settling_study.best[1]:.4g} s with a dashpot of {settling_study.best[0]:.4g} N s/m"
            case RegulationStudy.JUMP:
                fold_jump_study = study_fold_jump(rotating_part_alone(gm.load(scene or "watt_improved")), RAMP_RATES)
                figures.fold_jump_figure(fold_jump_study, path)
                conclusion = (
                    f"falls below {fold_jump_study.fold_speed:.6g} rad/s with a delay of order rate^"
                    f"{fold_jump_study.falling_exponent.value:.4f} +- {fold_jump_study.falling_exponent.standard_error:.1g}, "
                    f"jumps above {fold_jump_study.stop_speed:.6g} rad/s"
                )
    return CommandResult(text=[conclusion], values={}, files=[path])


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

        files.append(sweep_figure(result, journal_file.with_suffix(".png")))
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

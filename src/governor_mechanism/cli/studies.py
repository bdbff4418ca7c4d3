"""The commands of the studies: `accuracy`, `effects`, `sweep`, `hard-cases`, `valve-gears`, `errata`; they import late."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, stem_of
from governor_mechanism.render.figure_files import FigureFiles


def accuracy(
    scene: SceneName,
    changes: Changes = None,
    wanted: Annotated[
        float | None, typer.Option("--for", help="Print the fastest setting for this error, relative to the scale of each reading.")
    ] = None,
    longest: Annotated[float, typer.Option(help="Maximum time of one setting in seconds; the reference may take longer.")] = 1.0,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Measure error and time of every engine at every setting; write a figure, a table (CSV) and a record (JSON)."""
    from governor_mechanism.studies.work_precision_results import validate_target_error

    if wanted is not None:
        validate_target_error(wanted)
    loaded_scene = load_changed(scene, changes)
    with console.show_progress_bar("accuracy") as progress:
        study = gm.accuracy_study(loaded_scene, longest, progress)
    stem = f"{stem_of(loaded_scene)}_accuracy"
    files = figures.save_data(study, stem)
    is_measurable = wanted is None or wanted >= study.reference.resolvable_error
    is_reached = wanted is None or (is_measurable and study.cheapest_for(wanted) is not None)
    advice = None if wanted is None else study.advice(wanted) if is_measurable else study.unresolvable_message(wanted)
    if figures.formats:
        files += figures.save(study.plot(wanted if is_measurable else None), stem)
    values = {} if wanted is None else {"for": wanted, "advice": advice, "reached": is_reached}
    return console.CommandResult(study, text=[study, *([advice] if advice else [])], values=values, files=files, ok=is_reached)


def effects(
    scene: SceneName,
    changes: Changes = None,
    engine: console.EngineOfRuns = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Accuracy relative to the scale of each reading.")] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Show what each effect of a scene changes, what it costs, and which effects can be left out."""
    loaded_scene = load_changed(scene, changes)
    with console.show_progress_bar("effects") as progress:
        study = gm.effects_study(loaded_scene, engine, accuracy, progress)
    return console.CommandResult(study, files=figures.save_all(study, f"{stem_of(loaded_scene)}_effects"))


def sweep(
    scene: SceneName,
    vary: Annotated[
        list[str],
        typer.Option(
            help="The values of a key: key=first:last:count or key=value,value,..., for example dimensions.arm=200mm:400mm:50. Repeatable."
        ),
    ],
    changes: Changes = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            help='A number to take from each run: "settled arm_angle", "amplitude of ...", "frequency of ...", "mean ...", '
            '"max rate of ...", "duration", ... Repeatable. [what characterises the motion; printed with the reason]'
        ),
    ] = None,
    engine: Annotated[str, typer.Option(help="The engine of all rows; auto uses the engine of the scene.")] = "auto",
    accuracy: console.Accuracy = None,
    certify: Annotated[bool, typer.Option("--certify", help="Estimate the error of every run.")] = False,
    workers: console.Workers = 1,
    cluster: Annotated[
        str | None, typer.Option(help="Address of the scheduler of a cluster (dask.distributed) that computes the rows: tcp://host:8786.")
    ] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Run a scene at a grid or list of values of its keys. The same command continues an interrupted sweep.

    Words before a reading: final, min, max, span, mean, settled, amplitude of, frequency of; of an angle that turns also mean speed of and
    speed fluctuation of. A row that leaves the range, does not settle or does not oscillate is a result, and counted. The exit status is 0
    if every row has a result, and 1 if a row cannot be run, misses its accuracy or fails.
    """
    from governor_mechanism.studies.sweep.run import count_journal_rows, journal_path

    loaded = load_changed(scene, changes)
    journal_file = journal_path(figures.folder, loaded.source)
    n_rows = 0
    try:
        with console.show_progress_bar("sweep") as show_progress:

            def report(done: int, total: int) -> None:
                nonlocal n_rows
                n_rows = total
                if show_progress is not None:
                    show_progress(done, total)

            where: dict[str, Any] = {"workers": workers, "cluster": cluster, "out": figures.folder, "progress": report}
            result = gm.sweep(loaded, vary, quantity or None, engine=engine, accuracy=accuracy, certify=certify, **where)
    except KeyboardInterrupt:
        if journal_file.exists():
            n_kept = count_journal_rows(journal_file)  # an interruption may come between a row and its report
            console.print_to_stderr(f"{n_kept} of {n_rows} rows are in {journal_file}; the same command continues from there")
        raise
    files = [journal_file.with_suffix(kind) for kind in (".csv", ".json")]
    return console.CommandResult(result, files=files + figures.save_all(result, journal_file.stem), ok=result.ok)


def hard_cases(
    case: Annotated[list[str] | None, typer.Option(help="The name of a case, for example dead-centre. Repeatable. [all cases]")] = None,
    short: Annotated[bool, typer.Option("--short", help="Run only a few values of each case.")] = False,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Run the hard cases by every engine over their hard parameters; write a figure per case, a table (CSV) and a record (JSON).

    It takes some ten minutes, and some minutes with --short.

    A run passes if its true error is within its error estimate, or if it ends with an outcome that the case names.
    """
    with console.show_progress_bar("hard cases") as progress:
        report = gm.hard_cases(case or (), short, progress)
    files = figures.save_data(report, "hard_cases") + figures.save_figures(report, "hard_case")
    return console.CommandResult(report, files=files, ok=report.ok)


def valve_gears(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="Scenes whose [valve] names a reverser. [the shipped valve gears]")
    ] = None,
    count: Annotated[int, typer.Option(help="Number of positions from full forward to full back gear.")] = 41,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Compare valve gears: lead, cut-off and travel over the range of the gear; print a table, write a figure and a record (JSON)."""
    with console.show_status("reversing"):
        study = gm.valve_gears(scenes or (), count)
    return console.CommandResult(study, files=figures.save_all(study, "valve_gears"))


class PaperChoice(StrEnum):
    """The papers, as `--paper` takes them; a test compares them with those of the study, which is slow to import."""

    REDTENBACHER = "redtenbacher"
    ZEHNDER = "zehnder"
    MARKS = "marks"
    DUBOIS = "dubois"


def errata(
    paper: Annotated[PaperChoice | None, typer.Option(help="Only the errata of this paper. [all four]")] = None,
    simulate: Annotated[bool, typer.Option("--simulate", help="Also simulate the machines that show the main errors.")] = False,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """List what is not right in the papers, by cause: what is printed and right, why, and what command shows it.

    Every right value is recomputed by the closed forms. Draws one figure for the main error of each paper.
    """
    with console.show_status("simulating" if simulate else "recomputing"):
        result = gm.errata(paper, simulate=simulate)
    with console.show_status("drawing"):
        return console.CommandResult(result, files=figures.save_all(result, "errata"))

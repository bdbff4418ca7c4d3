"""The commands `compare`, several scenes in one table, one figure and one film, and `crosscheck`, a scene against closed forms or a kernel.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import (
    Changes,
    SceneName,
    check_film,
    complete_scene,
    in_command_words,
    load_changed,
    parse_range,
    refuse_idle_options,
    stem_of,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.film_options import FilmOptions
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    from governor_mechanism.studies.comparison import Comparison
    from governor_mechanism.verification.report import CheckReport


_OF_ONE_SCENE = re.compile(r"\s*([0-9]{1,9}):(.*)", re.DOTALL)
"""An assignment for one scene, with its number from 1."""

STEM = "comparison"
"""Start of the names of the files."""


class SideBySideFormat(StrEnum):
    """File formats of a film of several runs."""

    GIF = "gif"
    MP4 = "mp4"
    WEBM = "webm"


def compare(
    scenes: Annotated[
        list[str],
        typer.Argument(metavar="SCENE...", help="Two to six scene files, or names of shipped scenes.", autocompletion=complete_scene),
    ],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="[N:]KEY=VALUE",
            help='Another value of a key of all scenes, as "run.duration=2 s", or of the N-th alone, as '
            '"2:dimensions.arm=320 mm"; nothing after = leaves the key out. Repeatable.',
        ),
    ] = None,
    engine: Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of each scene.")] = "auto",
    accuracy: console.Accuracy = None,
    seconds: Annotated[str | None, typer.Option(help='Duration of all runs, for example "2 s"; by default that of each scene.')] = None,
    resistance: Annotated[str | None, typer.Option(help='Friction at the sleeve, for example "40 N", for the insensitivity.')] = None,
    working_range: Annotated[
        str | None,
        typer.Option("--range", help='Working range, "READING=LOW:HIGH"; by default that of the stops, or else what each run covers.'),
    ] = None,
    film: Annotated[
        SideBySideFormat, typer.Option(help="File format of the film; mp4 and webm need the extra 'video'.")
    ] = SideBySideFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Write no film.")] = False,
    *,
    film_options: FilmOptions,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Compare governors, or any scenes: one table, one figure and one film of all side by side.

    Of governors the table has the equilibrium at the speed of the spindle, its frequency and damping, effort, insensitivity, sensitiveness
    and work capacity; of all scenes, the last, lowest and highest values of the readings that at least two share.
    """
    duration = None if seconds is None else number_or_text(seconds)
    changes_of_each = split_changes(changes or (), len(scenes))
    loaded = [_load(scene, own, duration) for scene, own in zip(scenes, changes_of_each, strict=True)]
    if changes:
        _require_different(scenes, loaded)
        loaded = [_with_own_title(scene, own, loaded) for scene, own in zip(loaded, changes_of_each, strict=True)]
    if not no_film:
        check_film(loaded, film_options, film.value)
    console.prepare_folder(figures.folder)
    between = None if working_range is None else parse_range(working_range)
    with console.show_status("simulating"):
        comparison = gm.compare(*loaded, engine=engine, accuracy=accuracy, resistance=resistance, between=between)
    with console.show_status("drawing"):
        files = figures.save_all(comparison, STEM)
    files += [] if no_film else _write_film(comparison, figures.folder / f"{STEM}.{film.value}", film_options)
    is_ok = all(run.outcome.ok for run in comparison.runs)
    text = [comparison, *_describe_changes(comparison.names, changes_of_each)]
    return console.CommandResult(comparison, text=text, files=files, ok=is_ok)


def split_changes(changes: Sequence[str], n_scenes: int) -> list[list[str]]:
    """Return the assignments KEY=VALUE for each scene: "2:KEY=VALUE" is for the second alone, and one without a number for all."""
    of_each: list[list[str]] = [[] for _ in range(n_scenes)]
    for change in changes:
        numbered = _OF_ONE_SCENE.fullmatch(change)
        if numbered and not 1 <= int(numbered[1]) <= n_scenes:
            raise MechanismError(f"--set {change} is for scene {numbered[1]}, and the scenes are numbered from 1 to {n_scenes}")
        for number, own in enumerate(of_each, start=1):
            if not numbered:
                own.append(change)
            elif number == int(numbered[1]):
                own.append(numbered[2])
    return of_each


def _require_different(names: Sequence[str], scenes: Sequence[gm.Scene]) -> None:
    """Raise MechanismError if two scenes are equal, so that changes of them show nothing."""
    for second, scene in enumerate(scenes):
        if scene in scenes[:second]:
            first = scenes.index(scene)
            raise MechanismError(
                f"scenes {first + 1} and {second + 1} are both {names[second]} with the same changes, so that their columns "
                f'would be equal; change one of them alone, as in --set "{second + 1}:dimensions.arm=320 mm"'
            )


def _with_own_title(scene: gm.Scene, own: Sequence[str], scenes: Sequence[gm.Scene]) -> gm.Scene:
    """Return a scene whose title names its changes, if others have the same title."""
    if not own or [one.title for one in scenes].count(scene.title) == 1:
        return scene
    pairs = [change.partition("=") for change in own]  # a value may be an expression, which begins with a further sign of equality
    named = [f"{key.strip().rpartition('.')[2].replace('_', ' ')} {value.strip()}" for key, _, value in pairs]
    return replace(scene, title=", ".join([scene.title, *named]))


def _describe_changes(names: Sequence[str], changes_of_each: Sequence[Sequence[str]]) -> list[str]:
    """Return a line for each scene whose changes not all scenes have."""
    if all(own == changes_of_each[0] for own in changes_of_each):
        return []
    return [f"{name}: {', '.join(own)}" for name, own in zip(names, changes_of_each, strict=True) if own]


def _load(scene: str, changes: Sequence[str], duration: float | str | None) -> gm.Scene:
    """Load a scene with its changes; a problem says which of the scenes has it."""
    try:
        return load_changed(scene, changes, run__duration=duration)
    except MechanismError as error:
        raise MechanismError(*(problem if scene in problem else f"{scene}: {problem}" for problem in error.problems)) from None


def _write_film(comparison: Comparison, path: Path, options: FilmOptions) -> list[Path]:
    """Write the film of the runs that have reported times; none if nothing moves in time."""
    from governor_mechanism.render.film.writer import write_film

    shown = [(run, name) for run, name in zip(comparison.runs, comparison.names, strict=True) if len(run.times) > 1]
    if not shown:
        return []
    runs = [run for run, _ in shown]
    titles = [run.scene.title for run in runs] if len(runs) > 1 else None
    with in_command_words(), console.show_progress_bar("film") as progress:
        return [write_film(runs, path, options, titles=titles, progress=progress)]


_FIGURE_OPTIONS = ("out", "figure_formats", "theme")
"""Options that say where and how the record and the figure of a kernel are written."""


def crosscheck(
    scene: SceneName,
    changes: Changes = None,
    kernel: Annotated[
        str | None, typer.Option(help="A function of your own, FILE.py:FUNCTION or MODULE:FUNCTION, to compare with the simulation.")
    ] = None,
    quantity: Annotated[str, typer.Option(help="What the kernel returns; --list prints all quantities.")] = "equilibrium_speed",
    over: Annotated[
        list[str] | None,
        typer.Option(
            help="Values of an input: NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE, as arm_angle=15deg:45deg:25. Repeatable: a grid."
        ),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(help="Values of a key of the scene, as dimensions.arm=200mm:400mm:5; with --random its limits. Repeatable."),
    ] = None,
    random: Annotated[int | None, typer.Option(help="Number of random samples between the limits of --over and --vary.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of the random samples.")] = 0,
    names: Annotated[
        list[str] | None,
        typer.Option("--map", help='Name of an argument: THEIRS=OURS, with a unit if it is not SI, "alpha=arm_angle in deg". Repeatable.'),
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Unit of the kernel's result, as rpm; SI without it.")] = None,
    allowed: Annotated[float | None, typer.Option(help="Relative tolerance of the kernel; by default 1e-6.")] = None,
    show_list: Annotated[
        bool, typer.Option("--list", help="Print the quantities of the scene with their inputs, arguments and units, and compare nothing.")
    ] = False,
    junit: Annotated[Path | None, typer.Option(help="Write a JUnit file for continuous integration.")] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Compare a scene with its closed forms, or with a kernel of your own. The exit status is 1 if one disagrees."""
    _refuse_idle(has_kernel=kernel is not None, is_random=random is not None, shows_list=show_list)
    loaded_scene = load_changed(scene, changes)
    if show_list:
        from governor_mechanism.verification.user_kernel.comparison import list_quantities

        return console.CommandResult(list_quantities(loaded_scene))
    if kernel is None:
        with console.show_status("simulating"):
            report = gm.crosscheck(loaded_scene)
        return console.CommandResult(report, files=_write_junit(report, junit) or None, ok=report.passed)
    from governor_mechanism.verification.user_kernel.function import load_kernel

    console.prepare_folder(figures.folder)
    function = load_kernel(kernel)
    with console.show_status("simulating"):
        kernel_report = gm.crosscheck(
            loaded_scene,
            function,
            quantity,
            _parse_pairs(over, "--over", "arm_angle=15deg:45deg:25"),
            allowed,
            names=_parse_pairs(names, "--map", '"alpha=arm_angle in deg"'),
            unit=unit,
            vary=vary or None,
            random=random,
            seed=seed,
        )
    name = re.sub(r"\W+", "_", f"{kernel_report.quantity}_{kernel.rpartition(':')[2]}")
    stem = f"{stem_of(loaded_scene)}_{name}"
    files = [kernel_report.save_json(figures.folder / f"{stem}.json")]
    if len(kernel_report.rows) > 1:  # a single comparison has no curve
        files += figures.save_all(kernel_report, stem)
    return console.CommandResult(kernel_report, files=files + _write_junit(kernel_report, junit), ok=kernel_report.passed)


def _refuse_idle(*, has_kernel: bool, is_random: bool, shows_list: bool) -> None:
    """Raise MechanismError for options that do nothing beside others, or without them."""
    kernel_options = ("quantity", "over", "vary", "random", "seed", "names", "unit", "allowed", *_FIGURE_OPTIONS)
    if shows_list:
        refuse_idle_options("kernel", *kernel_options, "junit", condition="with --list")
    elif not has_kernel:
        refuse_idle_options(*kernel_options, condition="without --kernel FILE.py:FUNCTION")
    elif not is_random:
        refuse_idle_options("seed", condition="without --random")


def _parse_pairs(pairs: Sequence[str] | None, option: str, example: str) -> dict[str, str]:
    """Return the texts after the equals sign by the names before it; raise MechanismError for anything else."""
    parsed: dict[str, str] = {}
    for pair in pairs or ():
        name, separator, text = (part.strip() for part in pair.partition("="))
        if not (name and separator and text):
            raise MechanismError(f"{option} {pair!r} is not understood; write it as {option} {example}")
        if name in parsed:
            raise MechanismError(f"{option} gives {name!r} twice; give all its values at once")
        parsed[name] = text
    return parsed


def _write_junit(report: CheckReport, path: Path | None) -> list[Path]:
    if path is None:
        return []
    from governor_mechanism.verification.report import save_junit

    return [save_junit(report, path)]

"""The command `compare`: several scenes in one table, one figure and one film; heavy imports are made when it needs them."""

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
from governor_mechanism.cli.options import check_film, complete_scene, in_command_words, load_changed, parse_range
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import FilmOptions
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    pass

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
    between = None if working_range is None else parse_range(working_range)
    with console.show_status("simulating"):
        comparison = gm.compare(*loaded, engine=engine, accuracy=accuracy, resistance=resistance, between=between)
    with console.show_status("drawing"):
        files = figures.save_all(comparison, STEM)
    if not no_film and comparison.moving_runs:  # else nothing moves in time
        files += film_side_by_side(comparison.moving_runs, figures.folder / f"{STEM}.{film.value}", film_options)
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


def film_side_by_side(runs: Sequence[gm.Trajectory], path: Path, options: FilmOptions, titles: Sequence[str] | None = None) -> list[Path]:
    """Write the film of several runs, with a progress bar."""
    with in_command_words(), console.show_progress_bar("film") as progress:
        return [gm.film(runs, path, titles=titles, progress=progress, **vars(options))]

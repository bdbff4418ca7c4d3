"""The command `crosscheck`: a scene against closed forms or a user's function; heavy imports are made when it needs them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.verification.report import CheckReport

_FIGURE_OPTIONS = ("folder", "formats", "theme")
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
        from governor_mechanism.verification.user_kernel_comparison import list_quantities

        return console.CommandResult(list_quantities(loaded_scene))
    if kernel is None:
        with console.show_status("simulating"):
            report = gm.crosscheck(loaded_scene)
        return console.CommandResult(report, files=_write_junit(report, junit) or None, ok=report.passed)
    from governor_mechanism.verification.user_kernel import load_kernel

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
    # a single comparison has no curve
    files = figures.save_all(kernel_report, stem) if len(kernel_report.rows) > 1 else figures.save_data(kernel_report, stem)
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

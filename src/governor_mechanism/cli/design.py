"""The command `design`: governor design by the procedure of a paper. Heavy imports are made when it is called."""

from __future__ import annotations

import dataclasses
import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.cli.console import CommandResult, print_to_stderr, show_status
from governor_mechanism.cli.options import RESULTS_FOLDER, AsJson, FigureFolder, NoFigure, prepare_folder

if TYPE_CHECKING:
    from governor_mechanism.studies.hartung.design import HartungDesign


class DesignTarget(StrEnum):
    """Machines that can be designed."""

    HARTUNG = "hartung"


def design(
    machine: Annotated[DesignTarget, typer.Argument(help="The machine to design.")],
    changes: Annotated[
        list[str] | None, typer.Option("--with", help='An input that replaces the one of the paper, for example "wire=14 mm". Repeatable.')
    ] = None,
    out: FigureFolder = RESULTS_FOLDER,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> CommandResult:
    """Design a governor by the procedure of its paper: bell cranks, springs, stress and sleeve force.

    Writes figures and a scene file that can be run. With the inputs of the paper, the printed numbers are compared with the
    recomputed ones and misprints are marked.
    """
    from governor_mechanism.studies.hartung.design import design_hartung
    from governor_mechanism.studies.hartung.inputs import PAPER_INPUTS, parse_inputs
    from governor_mechanism.studies.hartung.paper_comparison import compare_with_paper

    prepare_folder(out)
    inputs = parse_inputs(changes or ())
    is_paper_design = inputs == PAPER_INPUTS
    with show_status("designing"):
        hartung_design = design_hartung(inputs)
        files = [_write_scene(hartung_design, out)]
        if not no_figure:
            files += _write_figures(hartung_design, out, is_paper_design=is_paper_design)
    values: dict[str, object] = {"machine": machine.value, "design": hartung_design.as_json()}
    text = hartung_design.summary_lines()
    if is_paper_design:
        comparison = compare_with_paper()
        values["paper"] = comparison.as_json()
        text = [f"{comparison}\n", *text]
    if as_json:
        for warning in hartung_design.warnings:  # the text output contains them
            print_to_stderr(warning)
    return CommandResult(text=text, values=values, files=files)


def _write_scene(hartung_design: HartungDesign, out: Path) -> Path:
    from governor_mechanism.files.atomic_write import atomic_write
    from governor_mechanism.studies.hartung.scene_export import export_scene_document, format_scene_toml

    comment = "A Hartung governor, designed by the procedure of Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620."
    path = out / "hartung_design.toml"
    with atomic_write(path) as temporary:
        temporary.write_text(format_scene_toml(export_scene_document(hartung_design), comment), encoding="utf-8")
    return path


def _write_figures(hartung_design: HartungDesign, out: Path, *, is_paper_design: bool) -> list[Path]:
    """Draw the spring lines and the spread of the sleeve force; with the inputs of the paper, its spring lines at 132 deg."""
    from governor_mechanism.render.figures.hartung.design import sleeve_force_figure, spring_lines_figure
    from governor_mechanism.studies.hartung.design import design_hartung

    drawn_design = hartung_design
    if is_paper_design:
        drawn_design = design_hartung(dataclasses.replace(hartung_design.inputs, angle=math.radians(132), sleeve_arm=0.170))
    return [
        spring_lines_figure(drawn_design, with_printed_points=is_paper_design).save_png(out / "hartung_spring_lines.png"),
        sleeve_force_figure(hartung_design).save_png(out / "hartung_sleeve_force.png"),
    ]

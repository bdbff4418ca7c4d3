"""The command `design`: a governor laid out as its paper does it. Heavy imports wait until it is called."""

from __future__ import annotations

import dataclasses
import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.cli.console import OK, guarded_command, print_json, say, working
from governor_mechanism.cli.options import RESULTS, AsJson, FigureFolder, NoFigure, prepare_folder

if TYPE_CHECKING:
    from governor_mechanism.studies.hartung.design import HartungDesign


class Designed(StrEnum):
    """What can be designed."""

    HARTUNG = "hartung"


@guarded_command
def design(
    machine: Annotated[Designed, typer.Argument(help="What to design.")],
    changes: Annotated[
        list[str] | None,
        typer.Option("--with", help='An input of your own, as "wire=14 mm"; repeatable; the paper\'s if left out.'),
    ] = None,
    out: FigureFolder = RESULTS,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Lay out a governor as its paper does: bell cranks, springs, stress, sleeve force; figures and a scene to run.

    With the paper's own inputs its numbers stand beside the recomputed ones, misprints marked.
    """
    from governor_mechanism.studies.hartung.design import PAPERS, design_hartung
    from governor_mechanism.studies.hartung.inputs import inputs_from
    from governor_mechanism.studies.hartung.paper_comparison import dubois

    prepare_folder(out)
    inputs = inputs_from(changes or ())
    papers = inputs == PAPERS
    with working("designing"):
        made = design_hartung(inputs)
        files = [_scene(made, out), *([] if no_figure else _figures(made, out, papers=papers))]
    if as_json:
        for warning in made.warnings:  # the table has them
            say(warning)
        told = {"machine": machine.value, "design": made.as_json(), "files": [str(path) for path in files]}
        print_json(told | ({"paper": dubois().as_json()} if papers else {}))
        return OK
    print("\n".join([*([f"{dubois()}\n"] if papers else []), *made.lines(), *(f"wrote {path}" for path in files)]))
    return OK


def _scene(made: HartungDesign, out: Path) -> Path:
    from governor_mechanism.files.atomic_write import written_beside
    from governor_mechanism.studies.hartung.scene_export import scene_of, scene_text

    remark = "A Hartung governor, designed after Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620."
    path = out / "hartung_design.toml"
    with written_beside(path) as temporary:
        temporary.write_text(scene_text(scene_of(made), remark), encoding="utf-8")
    return path


def _figures(made: HartungDesign, out: Path, *, papers: bool) -> list[Path]:
    """The spring lines, of the paper's inputs those that it draws, at 132 deg; and how even the sleeve force is."""
    from governor_mechanism.render.figures.hartung.design import sleeve_force_figure, spring_lines_figure
    from governor_mechanism.studies.hartung.design import design_hartung

    drawn = made
    if papers:
        drawn = design_hartung(dataclasses.replace(made.inputs, angle=math.radians(132), sleeve_arm=0.170))
    return [
        spring_lines_figure(drawn, out / "hartung_spring_lines.png", printed=papers),
        sleeve_force_figure(made, out / "hartung_sleeve_force.png"),
    ]

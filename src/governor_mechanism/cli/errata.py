"""The command `errata`: what recomputing and simulating the four papers has found.

Heavy imports are made when the command needs them.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.render.figure_files import FigureFiles


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
    console.prepare_folder(figures.folder)
    with console.show_status("simulating" if simulate else "recomputing"):
        result = gm.errata(paper, simulate=simulate)
    files = []
    if figures.formats:
        from governor_mechanism.papers.errata.drawings import draw_erratum

        with console.show_status("drawing"):
            files = [path for one in result.papers for path in figures.save(draw_erratum(one), f"errata_{one}")]
    return console.CommandResult(text=[result], values=result.as_json(), files=files)

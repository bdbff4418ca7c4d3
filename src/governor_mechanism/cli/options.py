"""Arguments and options that several commands share, and the output folder."""

from pathlib import Path
from typing import Annotated

import typer

from governor_mechanism.errors import MechanismError

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object to standard output, and nothing else.")]
Accuracy = Annotated[float | None, typer.Option(help="Accuracy relative to the scale of each reading; by default the one of the scene.")]
FigureFolder = Annotated[Path, typer.Option(help="Folder for the figures.")]
NoFigure = Annotated[bool, typer.Option("--no-figure", help="Draw no figure.")]

RESULTS_FOLDER = Path("results")
"""Folder for all results without the option --out."""


def prepare_folder(out: Path) -> None:
    """Create the output folder; raise MechanismError if a file has its name."""
    if out.exists() and not out.is_dir():
        raise MechanismError(f"--out {out} is a file; give the name of a folder")
    out.mkdir(parents=True, exist_ok=True)

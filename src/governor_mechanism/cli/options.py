"""What several commands share: their arguments and options, and the folder for results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from governor_mechanism.errors import MechanismError

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A TOML file, or the name of a shipped scene.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output and nothing else there.")]
FigureFolder = Annotated[Path, typer.Option(help="Folder for what is drawn.")]
NoFigure = Annotated[bool, typer.Option("--no-figure", help="Draw nothing.")]

RESULTS_FOLDER = Path("results")
"""Where everything is written unless --out says otherwise."""


def prepare_folder(out: Path) -> None:
    """Make the folder. Raises MechanismError where a file has its name."""
    if out.exists() and not out.is_dir():
        raise MechanismError(f"--out {out} is a file; give the name of a folder")
    out.mkdir(parents=True, exist_ok=True)

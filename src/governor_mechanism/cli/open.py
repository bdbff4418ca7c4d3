"""The command `open`: a mechanism under the hand, in the browser."""

from __future__ import annotations

from typing import Annotated

import typer

from governor_mechanism.api.live import open as open_page
from governor_mechanism.cli import console
from governor_mechanism.cli.scene_arguments import Changes, complete_scene, load_changed


def open_scene(
    scene: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENE",
            help="A scene file (TOML), or the name of a shipped scene; without one, a list to choose from.",
            autocompletion=complete_scene,
        ),
    ] = None,
    changes: Changes = None,
    *,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page; 0 takes any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser; its address is printed anyway.")] = True,
) -> console.CommandResult:
    """Open a scene in the browser: drag its points, change its quantities, and see motion, readings and accuracy follow.

    Each change is answered by a certified run. The page is served to this machine alone, until Ctrl-C. What was made can be saved as
    a scene file, a film, a page or a table.
    """
    open_page(None if scene is None else load_changed(scene, changes), port=port, browser=browser)
    return console.CommandResult(text=[])

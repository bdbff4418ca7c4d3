"""The commands about scenes: `models`, `catalogue`, `init`, `describe`, `assemblies`, `schema`.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.scene_arguments import Changes, SceneName, complete_machine, load_changed
from governor_mechanism.files.plain_values import format_json
from governor_mechanism.render.figure_files import FigureFiles


def models(as_json: console.AsJson = False) -> console.CommandResult:
    """List the shipped scenes, one per line: name, machine and title. With --json, dimensions and effects too."""
    from governor_mechanism.scenes.library import list_contents
    from governor_mechanism.units.text_table import format_table

    contents = list_contents()
    rows = [(name, ", ".join(one.machines), one.title) for name, one in contents.items()]
    values = {"models": [{"name": name, **one.as_json()} for name, one in contents.items()]}
    return console.CommandResult(text=[format_table([], rows)], values=values)


def catalogue(
    family: Annotated[str | None, typer.Option(help="One family alone, as straight-lines, curves, walkers or drives.")] = None,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """List the classic mechanisms, one per line: name, family, title and the law that each proves. With --json, sources and dimensions."""
    from governor_mechanism.scenes.library import list_catalogue_entries
    from governor_mechanism.units.text_table import format_table

    entries = list_catalogue_entries(family)
    rows = [(name, one.family, one.title, one.law) for name, one in entries.items()]
    values = {"catalogue": [{"name": name, **one.as_json()} for name, one in entries.items()]}
    return console.CommandResult(text=[format_table([], rows)], values=values)


def init(
    machine: Annotated[
        str,
        typer.Argument(
            metavar="MACHINE",
            help='A machine, "custom", "governed-engine", or a classic mechanism of `catalogue`.',
            autocompletion=complete_machine,
        ),
    ],
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Print a scene file to begin with: what the machine needs, and, commented out, what it may have. As `init MACHINE > mine.toml`."""
    from governor_mechanism.scenes.template import scene_template

    text = scene_template(machine)
    return console.CommandResult(text=[text.rstrip("\n")], values={"machine": machine, "text": text})


def describe(scene: SceneName, changes: Changes = None, as_json: console.AsJson = False) -> console.CommandResult:
    """Describe a scene: dimensions, effects, readings with units, degrees of freedom, loads, couplings, events, and what engines say."""
    from governor_mechanism.scenes.description import describe_scene

    return console.CommandResult(describe_scene(load_changed(scene, changes)))


def assemblies(
    scene: SceneName, changes: Changes = None, *, figures: FigureFiles, as_json: console.AsJson = False
) -> console.CommandResult:
    """List all ways in which the joints of a mechanism close at its drives and start values, with their numbers; draw them on one sheet.

    `assembly = 2` in the scene file, or --set assembly=2, takes the second.
    """
    console.prepare_folder(figures.folder)
    loaded = load_changed(scene, changes)
    with console.show_status("closing the joints"):
        result = gm.assemblies(loaded)
    files = figures.save(result.plot(), f"{Path(loaded.source).stem or 'scene'}_assemblies") if figures.formats else []
    return console.CommandResult(result, files=files)


def schema(as_json: console.AsJson = False) -> console.CommandResult:
    """Print the JSON Schema of scene files, for editors: as `schema > scene.schema.json`, named by `#:schema` in a scene file."""
    from governor_mechanism.scenes.json_schema import scene_schema

    values = scene_schema()
    return console.CommandResult(text=[format_json(values)], values=values)

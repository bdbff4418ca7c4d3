"""The commands about scenes: `models`, `catalogue`, `init`, `describe`, `assemblies`, `kinematics`, `schema`; they import late."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Annotated, Final

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, complete_machine, load_changed, stem_of
from governor_mechanism.files.writing import format_json
from governor_mechanism.render.figure_files import FigureFiles


def models(as_json: console.AsJson = False) -> console.CommandResult:
    """List the shipped scenes by family: name and title. With --json, machines, dimensions and effects too."""
    from governor_mechanism.scenes.library import SCENE_FAMILIES, list_contents

    contents = list_contents()
    groups = {family: [(name, one.title) for name, one in contents.items() if one.family == family] for family in SCENE_FAMILIES}
    values = {"models": [{"name": name, **vars(one)} for name, one in contents.items()]}
    return console.CommandResult(text=[_format_groups(groups)], values=values)


LINE_WIDTH: Final = 80
"""Width of the lists of scenes in letters: the least of a terminal."""


def _format_groups(groups: Mapping[str, Sequence[tuple[str, str]]]) -> str:
    """Return names and what they are, group by group, in lines that every terminal shows; no word is broken."""
    width = max(len(name) for rows in groups.values() for name, _ in rows) + 4
    lines: list[str] = []
    for heading, rows in groups.items():
        lines += ["", f"{heading}:"]
        for name, text in rows:
            first, *others = textwrap.wrap(text, LINE_WIDTH - width, break_long_words=False, break_on_hyphens=False)
            lines += [f"{f'  {name}'.ljust(width)}{first}", *(f"{' ' * width}{line}" for line in others)]
    return "\n".join(lines[1:])


def catalogue(
    family: Annotated[str | None, typer.Option(help="One family alone, as straight-lines, curves, walkers or drives.")] = None,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """List the classic mechanisms by family: name, title and the law that each proves. With --json, sources and dimensions."""
    from governor_mechanism.scenes.library import list_catalogue_entries

    entries = list_catalogue_entries(family)
    families = dict.fromkeys(one.family for one in entries.values())
    groups = {one: [(name, f"{entry.title}: {entry.law}") for name, entry in entries.items() if entry.family == one] for one in families}
    values = {"catalogue": [{"name": name, **vars(one)} for name, one in entries.items()]}
    return console.CommandResult(text=[_format_groups(groups)], values=values)


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
    loaded = load_changed(scene, changes)
    with console.show_status("closing the joints"):
        result = gm.assemblies(loaded)
    return console.CommandResult(result, files=figures.save_all(result, f"{stem_of(loaded)}_assemblies"))


def kinematics(
    scene: SceneName,
    changes: Changes = None,
    over: Annotated[
        str | None, typer.Option(help='The reading that drives the mechanism, or "time". [the driven angle, or the leading coordinate]')
    ] = None,
    readings: Annotated[
        list[str] | None,
        typer.Option(
            "--reading",
            help='A reading, as "velocity.foot", "curvature.foot", "transmission_angle.coupler", "instantaneous_centre.coupler.ground" or '
            '"mechanical_advantage.crank_angle.rocker_angle". Repeatable. [points, transmission angles and a mechanical advantage]',
        ),
    ] = None,
    rate: Annotated[str, typer.Option(help='Rate of the driving reading, as "60 rpm" or "0.1 m/s".')] = "1",
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Analyse a mechanism over its drive, without forces: print a table and facts, write a figure, a table (CSV) and a record (JSON).

    The facts: mobility with Grübler's count, Grashof's class of four-bars, dead centres, toggles, and time ratios of strokes. The drive
    goes through a whole turn, or through its travel.
    """
    from governor_mechanism.studies.kinematics import default_readings
    from governor_mechanism.units.quantities import number_or_text

    loaded = load_changed(scene, changes)
    with console.show_status("moving the mechanism"):
        result = gm.kinematics(loaded, over, rate=number_or_text(rate), readings=readings or default_readings(loaded, over))
        text = str(result)
    return console.CommandResult(result, text=[text], files=figures.save_all(result, f"{stem_of(loaded)}_kinematics"))


def schema(as_json: console.AsJson = False) -> console.CommandResult:
    """Print the JSON Schema of scene files, for editors: as `schema > scene.schema.json`, named by `#:schema` in a scene file."""
    from governor_mechanism.scenes.json_schema import scene_schema

    values = scene_schema()
    return console.CommandResult(text=[format_json(values)], values=values)

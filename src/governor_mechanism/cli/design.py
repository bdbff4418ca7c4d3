"""The command `design`: machines designed by the procedures of their papers.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from governor_mechanism.cli import console
from governor_mechanism.cli.options import remember_options
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.studies.design.skeleton import Design

_OPTIONS = ("--with", "--out", "--no-figure", "--format", "--theme", "--json", "--help")
"""Options of the command, for a misspelt one."""


class DesignTarget(StrEnum):
    """Machines that can be designed."""

    HARTUNG = "hartung"
    FLYWHEEL = "flywheel"
    GOVERNED_ENGINE = "governed-engine"
    PENDULUM = "pendulum"
    HARTNELL = "hartnell"


def design(
    context: typer.Context,
    machine: Annotated[DesignTarget, typer.Argument(help="The machine to design.")],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--with", help='An input that replaces the one of the paper, for example "wire=14 mm"; also --wire "14 mm". Repeatable.'
        ),
    ] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Design a machine by the procedure of its paper.

    hartung: bell cranks, springs, stress and sleeve force of a governor, and a scene file that can be run. flywheel: energy, inertia, rim
    and arms of the flywheel of an air-expansion engine for an allowed energy_ratio or coefficient of speed fluctuation, or the fluctuation
    of a given inertia; load_pressure=closing takes the load with which the cycle closes. The flywheel is then simulated, and a scene file
    written.

    governed-engine: cylinder, flywheel, Porter governor, throttle rod and dashpot for a power, a speed and a droop. The engine is then
    simulated while its load falls to the half, and a scene file written: --power "20 PS" --speed "120 rpm" --droop 4%.

    pendulum: masses, arms, suspension and limits of speed of a Porter, Watt or improved Watt governor by Zehnder's steps I to VIII. Statics
    and a run of the scene that is written stand beside the wanted numbers: --kind watt --lowest-speed "60 rpm" --highest-speed "63 rpm".

    hartnell: the spring of a Hartnell governor for two speeds, by the textbooks' formula and by exact statics, beside the simulated speeds
    at both ends of the lift, and a scene file: --lowest-speed "290 rpm" --highest-speed "310 rpm" --lift "15 mm".

    Every input may be given as an option of its name. Writes figures. With the inputs of the paper, the printed numbers are compared with
    the recomputed ones, and where they differ the cause is named.
    """
    from governor_mechanism.studies.design.simulated import PROCEDURES, DesignReport

    console.prepare_folder(figures.folder)
    procedure = PROCEDURES[machine.value]
    inputs = _replace_inputs(procedure.inputs, changes or (), parse_input_options(context.args))
    with console.show_status("designing"):
        designed = procedure.design(inputs)
    paper = procedure.compare() if procedure.compare and inputs == procedure.inputs else None
    with console.show_status("simulating"):
        simulated = procedure.simulate(designed, paper) if procedure.simulate else None
    report = DesignReport(machine=machine.value, design=designed, simulated=simulated, paper=paper)
    files = [_write_scene(designed, figures.folder)]
    with console.show_status("drawing"):
        files += figures.save_all(report, "")
    if as_json:
        for warning in designed.warnings:  # the text output contains them
            console.print_to_stderr(warning)
    return console.CommandResult(report, files=files, ok=report.ok)


def _write_scene(designed: Design, folder: Path) -> Path:
    """Write the scene file of a design, and return its path."""
    from governor_mechanism.files.writing import atomic_write
    from governor_mechanism.scenes.changed_document import format_scene_toml
    from governor_mechanism.studies.design.skeleton import scene_comment

    path = folder / f"{designed.machine}_design.toml"
    with atomic_write(path) as temporary:
        temporary.write_text(format_scene_toml(designed.scene_document, scene_comment(designed.machine)), encoding="utf-8")
    return path


def _replace_inputs(defaults: Any, assignments: Sequence[str], options: Mapping[str, str]) -> Any:
    """Return the default inputs with those of --with, and of the options with the names of inputs, in their place."""
    from governor_mechanism.studies.design.skeleton import option_of, parse_assignments

    names = options if assignments else [one.name for one in dataclasses.fields(defaults)]
    remember_options({name: option_of(name) for name in names})
    return parse_assignments(defaults, assignments, options)


def parse_input_options(words: Sequence[str]) -> dict[str, str]:
    """Return the values of options that are no options of the command, by the names of inputs: "--ball-mass 5kg" or "--ball_mass=5kg"."""
    from governor_mechanism.errors import MechanismError, did_you_mean

    values: dict[str, str] = {}
    remaining = iter(words)
    for word in remaining:
        option, sign, value = word.partition("=")
        if not option.startswith("--") or option == "--":
            raise MechanismError(f'{word!r} belongs to no option; a value with blanks stands in quotes, as --power "20 PS"')
        name = option[2:].replace("-", "_")
        text = value if sign else next(remaining, None)
        if text is None or (not sign and text.startswith("--")):
            raise MechanismError(f"{option} has no value; an input has one: {option} VALUE.{did_you_mean(option, _OPTIONS)}")
        if name in values:
            raise MechanismError(f"{option} is given twice; give it once")
        values[name] = text
    return values

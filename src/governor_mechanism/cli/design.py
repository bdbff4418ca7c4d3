"""The command `design`: machines designed by the procedures of their papers; heavy imports are made when it needs them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Final

import typer

from governor_mechanism.cli import console
from governor_mechanism.cli.options import remember_options
from governor_mechanism.render.figure_files import FigureFiles

_OPTIONS = ("--with", "--out", "--no-figure", "--format", "--theme", "--json", "--help")
"""Options of the command, for a misspelt one."""


DESIGNS: Final = {
    "hartung": """Design bell cranks, springs and sleeve of a Hartung governor, with stress and sleeve force.

    The angle of the bell cranks gives a sleeve force that stays the same over the stroke; the springs are wound from wire.
    """,
    "flywheel": """Design the flywheel of an air-expansion engine: energy, inertia, rim and arms.

    For an allowed energy_ratio or coefficient of speed fluctuation, or the fluctuation of a given inertia; --load-pressure closing takes
    the load with which the cycle closes. The flywheel is then simulated.
    """,
    "governed-engine": """Design an engine with its governor: cylinder, flywheel, Porter governor, throttle rod and dashpot.

    For a power, a speed and a droop, as --power "20 PS" --speed "120 rpm" --droop 4%. The engine is then simulated while its load falls to
    the half.
    """,
    "pendulum": """Design a Porter, Watt or improved Watt governor by Zehnder's steps I to VIII.

    Masses, arms, suspension and limits of speed of the governor, as for --kind watt. Statics and a run stand beside the wanted numbers.
    """,
    "hartnell": """Design the spring of a Hartnell governor for two speeds, by the textbooks' formula and by exact statics.

    Beside them stand the speeds that are simulated at both ends of the lift.
    """,
}
"""What --help says of each design, by the name of its procedure."""

_SHARED_HELP: Final = """

    Every input of the list below is an option. A scene file is written that can be run, and figures. With the inputs of the paper, the
    printed numbers are compared with the recomputed ones, and where they differ the cause is named.
    """

Changes = Annotated[
    list[str] | None,
    typer.Option("--with", help='An input that replaces the default, for example "wire=14 mm"; also --wire "14 mm". Repeatable.'),
]


class DesignCommand(console.StrictCommand):
    """The command of a design, whose --help lists the inputs with units and symbols."""

    def list_inputs(self) -> list[tuple[str, str]]:
        """Return the option of each input with its unit, and its meaning with its default."""
        from governor_mechanism.studies.design.simulated import PROCEDURES
        from governor_mechanism.units.fields import describe_inputs

        return describe_inputs(PROCEDURES[str(self.name)].inputs)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the inputs below the options."""
        with formatter.section("Inputs"):
            formatter.write_dl(self.list_inputs())


def _make_command(machine: str) -> Callable[..., console.CommandResult]:
    """Return the command that designs a machine."""

    def design(
        context: typer.Context, changes: Changes = None, *, figures: FigureFiles, as_json: console.AsJson = False
    ) -> console.CommandResult:
        return _design(machine, context, changes, figures, as_json=as_json)

    design.__doc__ = DESIGNS[machine].rstrip() + _SHARED_HELP
    return design


def _design(
    machine: str, context: typer.Context, changes: Sequence[str] | None, figures: FigureFiles, *, as_json: bool
) -> console.CommandResult:
    """Design a machine, simulate it, compare it with its paper, and write the scene and the figures."""
    from governor_mechanism.studies.design.simulated import PROCEDURES, report_design

    procedure = PROCEDURES[machine]
    inputs = _replace_inputs(procedure.inputs, changes or (), parse_input_options(context.args))
    with console.show_status("designing"):
        designed = procedure.design(inputs)
    with console.show_status("simulating"):
        report = report_design(designed)
    files = [designed.save_scene(figures.folder / f"{designed.machine}_design.toml")]
    with console.show_status("drawing"):
        files += figures.save_all(report, "")
    if as_json:
        for warning in designed.warnings:  # the text output contains them
            console.print_to_stderr(warning)
    return console.CommandResult(report, files=files, ok=report.ok)


def _replace_inputs(defaults: Any, assignments: Sequence[str], options: Mapping[str, str]) -> Any:
    """Return the default inputs with those of --with, and of the options with the names of inputs, in their place."""
    from governor_mechanism.units.fields import option_of, parse_assignments

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


design_app = typer.Typer(help="Design a machine by the procedure of its paper.", no_args_is_help=True, rich_markup_mode=None)
for target in DESIGNS:
    # Inputs of a design may be options of their own; the command answers a misspelt one.
    settings = {"allow_extra_args": True, "ignore_unknown_options": True}
    console.add_command(design_app, _make_command(target), name=target, command_class=DesignCommand, context_settings=settings)

"""The command line: the commands of the other files of this folder, in one application."""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.compare import compare
from governor_mechanism.cli.crosscheck import crosscheck
from governor_mechanism.cli.design import design_app
from governor_mechanism.cli.fitting import fit, optimise, sensitivities, synthesis_app
from governor_mechanism.cli.regulation import equilibria, regulation_app
from governor_mechanism.cli.run import open_scene, run
from governor_mechanism.cli.scenes import assemblies, catalogue, describe, init, kinematics, models, schema
from governor_mechanism.cli.studies import accuracy, effects, errata, hard_cases, sweep, valve_gears

COLLECTION_THRESHOLD = 500_000
"""Number of new objects after which unreachable ones are searched for: twice those of a run with its film. What is imported stays, and
searching it takes longer than a run."""

MAX_SHORT_HELP = 300
"""Letters of what --help says of a command: its first sentences, whole."""

HELP = "Simulate, film and verify the mechanisms that once controlled machines."

COMMAND_GROUPS: Final[Mapping[str, Mapping[str, Callable[..., console.CommandResult] | typer.Typer]]] = {
    "Find and write scenes": {"models": models, "catalogue": catalogue, "init": init, "describe": describe, "schema": schema},
    "Make": {"run": run, "open": open_scene, "compare": compare},
    "Study a mechanism": {
        "assemblies": assemblies,
        "kinematics": kinematics,
        "equilibria": equilibria,
        "effects": effects,
        "valve-gears": valve_gears,
        "regulation": regulation_app,
    },
    "Study many runs": {"sweep": sweep, "sensitivities": sensitivities, "fit": fit},
    "Find dimensions": {"optimise": optimise, "synthesise": synthesis_app, "design": design_app},
    "Verify": {"crosscheck": crosscheck, "accuracy": accuracy, "hard-cases": hard_cases, "errata": errata},
}
"""The commands, by what they are for."""


class GroupedCommands(TyperGroup):
    """The application, whose --help lists its commands by what they are for."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands of each group under its heading."""
        for heading, names in COMMAND_GROUPS.items():
            with formatter.section(heading):
                formatter.write_dl([(name, self.commands[name].get_short_help_str(MAX_SHORT_HELP)) for name in names])


app = typer.Typer(
    name="governor-mechanism", cls=GroupedCommands, help=HELP, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)


def main() -> None:
    """Run the command line."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed; without this, a file of results would get its number
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):  # its encoding may lack a character; results and messages matter more than that
            stream.reconfigure(errors="replace")
    gc.set_threshold(COLLECTION_THRESHOLD)
    atexit.register(gc.freeze)  # at the end all memory is given back; to search it first would take a tenth of a run
    try:
        app()
    except console.CommandExit:
        raise
    except SystemExit as stop:
        if stop.code == console.EXIT_BAD_INPUT and "--json" in sys.argv:
            console.print_json({"outcome": "bad_input", "problems": ["the command line is not valid; see --help"]})
        raise
    except OSError as error:  # from the text of --help
        console.exit_without_output(error)
    except KeyboardInterrupt:  # before a command was reached
        console.print_to_stderr("interrupted")
        raise SystemExit(console.EXIT_INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        console.print_to_stdout(gm.__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Simulate, film and verify the mechanisms that once controlled machines."""


for commands in COMMAND_GROUPS.values():
    for name, command in commands.items():
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
        else:
            console.add_command(app, command, name=name)


if __name__ == "__main__":
    main()

"""The command line: the commands of the other files of this folder, in one application."""

from __future__ import annotations

import gc
import io
import os
import sys
from typing import Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.compare import compare
from governor_mechanism.cli.crosscheck import crosscheck
from governor_mechanism.cli.design import design
from governor_mechanism.cli.equilibria import equilibria
from governor_mechanism.cli.fitting import fit, sensitivities
from governor_mechanism.cli.regulation import regulation_app
from governor_mechanism.cli.run import open_scene, run
from governor_mechanism.cli.scenes import assemblies, catalogue, describe, init, kinematics, models, schema
from governor_mechanism.cli.studies import accuracy, effects, errata, hard_cases, sweep, valve_gears
from governor_mechanism.cli.synthesis import synthesis_app

COLLECTION_THRESHOLD = 100_000
"""Number of new objects after which unreachable ones are searched for; what is imported stays, and searching it takes longer than a run."""

HELP = "Simulate, film and verify the mechanisms that once controlled machines."
app = typer.Typer(name="governor-mechanism", help=HELP, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)


def main() -> None:
    """Run the command line."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed; without this, a file of results would get its number
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):  # its encoding may lack a character; results and messages matter more than that
            stream.reconfigure(errors="replace")
    gc.set_threshold(COLLECTION_THRESHOLD)
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


for command in (
    models,
    catalogue,
    init,
    describe,
    assemblies,
    kinematics,
    schema,
    run,
    compare,
    crosscheck,
    equilibria,
    accuracy,
    effects,
    sweep,
    sensitivities,
    fit,
    hard_cases,
    valve_gears,
    errata,
):
    console.add_command(app, command)
console.add_command(app, open_scene, name="open")
# Inputs of a design may be options of their own; `design` answers a misspelt one.
_ANY_OPTIONS = {"allow_extra_args": True, "ignore_unknown_options": True}
console.add_command(app, design, context_settings=_ANY_OPTIONS)
app.add_typer(regulation_app, name="regulation")
app.add_typer(synthesis_app, name="synthesise")


if __name__ == "__main__":
    main()

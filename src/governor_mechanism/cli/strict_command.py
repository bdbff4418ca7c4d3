"""The class of all commands: an option with one value is given once, and no value is empty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import typer
from typer.core import TyperCommand

from governor_mechanism.cli import console
from governor_mechanism.cli.given_options import remember_options


class StrictCommand(TyperCommand):
    """A command that refuses what the parser of the command line would drop, or take for the current folder, without a word."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words of the command line; end the command if an option is given twice or a value is empty."""
        if ctx.resilient_parsing:  # a shell completes words
            return super().parse_args(ctx, args)
        values, _, given = self.make_parser(ctx).parse_args(args=list(args))
        options = [one for one in given if one.param_type_name == "option"]
        problems = [*_find_repetitions(options), *_find_empty_values(given, values)]
        is_answered = any(one.is_eager for one in options)  # --help, whatever else is given
        if problems and not is_answered:
            raise console.CommandExit(console.report_problems(problems, as_json="--json" in args))
        remember_options({one.name: one.opts[0] for one in options})
        return super().parse_args(ctx, args)


def _find_repetitions(options: Sequence[Any]) -> Iterator[str]:
    """Yield one sentence for each option that is given twice and counts once."""
    for name, count in Counter(one.opts[0] for one in options if not one.multiple).items():
        if count > 1:
            yield f"{name} is given {'twice' if count == 2 else f'{count} times'}, and counts once; give it once"


def _find_empty_values(given: Sequence[Any], values: dict[str, Any]) -> Iterator[str]:
    """Yield one sentence for each argument or option with a value without a letter."""
    for parameter in dict.fromkeys(given):
        value = values.get(parameter.name)
        texts = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(text, str) and not text.strip() for text in texts):
            name = parameter.opts[0] if parameter.param_type_name == "option" else (parameter.metavar or parameter.name.upper())
            yield f"{name} is empty; give a value, or leave it out"


def add_command(app: typer.Typer, command: Callable[..., console.CommandResult], name: str | None = None, **settings: Any) -> None:
    """Add a command to an application, by default under the name of its function."""
    app.command(name, cls=StrictCommand, short_help=console.first_sentence(command), **settings)(console.guarded_command(command))

"""Reference of the command line: every command with its usage, arguments and options, from the typer application."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import typer

from generators.markdown import code, escape, table
from generators.splitting import navigation_of, split_sections, write_pages
from governor_mechanism.cli.main import app

PROGRAM = "governor-mechanism"

OPTION = re.compile(r"(?<![\w`-])--[a-z][a-z-]*")
"""An option in a sentence."""
TYPES = {"str": "TEXT", "float": "NUMBER", "int": "INTEGER", "path": "PATH"}
"""What an option takes, by the name that typer shows."""


FOLDER, HOME = "commands", "reference/commands.md"
"""Folder of the pages of the commands, and the page that leads to them."""


def commands_index() -> str:
    """Return the list of the pages, from the folder docs/reference."""
    first, *others = split_sections(commands_text())
    listed = re.sub(r"\]\(#([\w-]+)\)", rf"](../_generated/{FOLDER}/\1.md)", first.text)
    return f"{listed}\n{navigation_of(others, FOLDER)}"


def commands_pages() -> dict[str, str]:
    """Return the page of each command by its path, from the folder of generated pages."""
    _, *others = split_sections(commands_text())
    return write_pages(others, FOLDER, HOME)


def commands_text() -> str:
    """Return all sections: the list of the commands, and each of them."""
    commands = [*list_commands()]
    rows = ([f"[{code(name)}](#{name.replace(' ', '-')})", _sentence(command.get_short_help_str(limit=300))] for name, command in commands)
    exits = (
        "The exit status is 0 for success, 1 if a check fails or a run ends early, 2 for a mistake in a scene or an option, and 130 after "
        "Ctrl-C. Every command has `--help`."
    )
    return "\n".join(["## All commands", "", table(("command", "what it does"), rows), exits, "", *(_section(*one) for one in commands)])


def list_commands() -> Iterator[tuple[str, Any]]:
    """Yield every command with its name, that of a group in front."""
    yield from _walk(typer.main.get_command(app), "")


def _walk(group: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from _walk(command, f"{prefix}{name} ")
        else:
            yield f"{prefix}{name}", command


def _section(name: str, command: Any) -> str:
    """Return the section of a command."""
    context = command.context_class(command, info_name=f"{PROGRAM} {name}")
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    records = [one.get_help_record(context) for one in command.params if one.param_type_name == "option"]
    first, *others = [
        OPTION.sub(r"`\g<0>`", " ".join(paragraph.split())) for paragraph in (command.help or "").split("\f")[0].split("\n\n")
    ]
    usage = f"{context.command_path} {' '.join(command.collect_usage_pieces(context))}".replace("{", "").replace("}", "")
    lines = [f"## {name}", first, f"```text\n{usage}\n```", *others]
    if arguments:
        rows = ([code(str(one.metavar or one.name)), _sentence(one.help or "")] for one in arguments)
        lines.append(table(("argument", "meaning"), rows))
    if any(records):
        lines.append(table(("option", "default", "meaning"), map(_option_row, filter(None, records))))
    if hasattr(command, "list_inputs"):
        lines.append(table(("input", "default", "meaning"), map(_option_row, command.list_inputs())))
    return "\n\n".join(line.strip() for line in lines if line) + "\n"


def _sentence(text: str) -> str:
    """Return a sentence of --help with its options as code; two hyphens would become a dash."""
    return "".join(part if k % 2 else OPTION.sub(r"`\g<0>`", escape(part)) for k, part in enumerate(re.split(r"(`[^`]*`)", text)))


def _option_row(record: tuple[str, str]) -> list[str]:
    """Return spelling, default and meaning of an option, from what --help shows of it."""
    spelling, text = record
    default = re.search(r"\s*\[default: (.*?)\]", text)
    plain = re.sub(r"\s*\[(default: .*?|required)\]", "", text)
    words = re.sub(r"<(?:list\[)?([^<>]*?)\]?>", lambda match: TYPES.get(match.group(1).removesuffix(" range"), match.group(1)), spelling)
    return [code(" ".join(words.split())), code(default.group(1)) if default else "", _sentence(plain)]

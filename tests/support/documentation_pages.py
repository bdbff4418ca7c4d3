"""The pages that people read, and the code in them."""

import importlib.util
import re
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import typer

from governor_mechanism.cli.main import app

ROOT = Path(__file__).parents[2]
MADE = {"_build", "_generated"}
PAGES = [ROOT / "README.md", *sorted(path for path in (ROOT / "docs").rglob("*.md") if not MADE & set(path.parts))]


@dataclass(frozen=True)
class Snippet:
    """A piece of code of a page; its place names it in the report of a test."""

    code: str
    place: str


def snippets(language: str) -> list[Snippet]:
    """Return all code in fences of exactly that language, or of that language and "long"."""
    return [snippet for page in PAGES for snippet in snippets_of(page, language)]


def load_script(path: Path) -> ModuleType:
    """Return a script of the repository as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    script = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = script
    spec.loader.exec_module(script)
    return script


def snippets_of(page: Path, language: str) -> list[Snippet]:
    text = page.read_text(encoding="utf-8")
    return [
        Snippet(match[1], f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, match.start()) + 1}")
        for match in re.finditer(rf"^```{language}(?: \S+\.toml)?\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    ]


def named_scenes(page: Path) -> dict[str, str]:
    """Return the scenes of a page whose fences name a file, by that name: what the reader writes into it."""
    text = page.read_text(encoding="utf-8")
    return dict(re.findall(r"^```toml (\S+\.toml)\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE))


def commands(page: Path, language: str) -> list[tuple[list[str], str]]:
    """Return the arguments of each command of a page, and the file it is to write ("" for none)."""
    found = []
    for line in "".join(snippet.code for snippet in snippets_of(page, language)).splitlines():
        words, _, target = line.partition(" > ")
        command, *arguments = shlex.split(words, comments=True)
        if command != "governor-mechanism":
            raise ValueError(f"{page.name}: {line!r} is no command of this package")
        found.append((arguments, target.strip()))
    return found


def check_options(arguments: list[str]) -> None:
    """Raise an error of the command line if a command or an option is unknown, or an argument is missing."""
    command = typer.main.get_command(app)
    context = command.make_context("governor-mechanism", list(arguments))
    while hasattr(command, "resolve_command"):
        _, command, rest = command.resolve_command(context, [*context._protected_args, *context.args])
        context = command.make_context(command.name, rest, parent=context)

"""The lines between the layers: imports point one way, and the two witnesses never meet."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "governor_mechanism"

# Lower ranks know nothing of higher ones. Modules of one rank do not import each other, but for those of one package.
RANKS = [
    {"errors"},
    {"units", "files"},
    {"programs", "curves"},
    {"effects"},
    {"joints"},
    {"loads"},
    {"mechanism"},
    {"scene"},
    {"trajectory"},
    {"machines", "closed_form", "equations"},
    {"reading_values"},
    {"reading_models"},
    {"reading_custom_values"},
    {"reading_custom_models"},
    {"reading_custom_bodies"},
    {"reading_custom_joints"},
    {"reading_custom"},
    {"reading_acting"},
    {"reading_effects"},
    {"reading_checks", "reading_file"},
    {"reading"},
    {"library"},
    {"speeds"},
    {"characteristic"},
    {"resting"},
    {"statics", "driven", "outputs"},
    {"porting"},
    {"engines"},
    {"checking", "studies"},
    {"render", "saving"},
    {"__init__"},
    {"console"},
    {"telling"},
    {"cli_options"},
    {"cli_studies", "cli_design"},
    {"cli"},
]
RANK = {name: rank for rank, names in enumerate(RANKS) for name in names}

ONLY = {
    "pymunk": {"engines/chipmunk"},
    "matplotlib": {"render"},
    "PIL": {"render"},
    "imageio": {"render"},
    "pint": {"units.py"},
    "typer": {"cli.py", "cli_options.py", "cli_studies.py", "cli_design.py"},
    "joblib": {"studies"},
}


def modules():
    return sorted(SOURCE.rglob("*.py"))


def layer(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imported(path: Path) -> set[str]:
    """Every module named in any form of import, wherever it stands; imports for type checkers alone left out."""
    names: set[str] = set()
    package = ["governor_mechanism", *path.relative_to(SOURCE).with_suffix("").parts[:-1]]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for guard in ast.walk(tree):
        if isinstance(guard, ast.If) and "TYPE_CHECKING" in ast.unparse(guard.test):
            guard.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, [base, node.module]))
            names |= {f"{module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            names |= {str(argument.value) for argument in node.args if isinstance(argument, ast.Constant)}
    return names


def ours(path: Path) -> set[str]:
    inside = [name.split(".") for name in imported(path) if name.split(".")[0] == "governor_mechanism"]
    return {parts[1] if len(parts) > 1 and parts[1] in RANK else "__init__" for parts in inside}


def test_every_module_has_a_rank():
    assert {layer(path) for path in modules()} <= set(RANK)


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_point_one_way(path):
    for other in ours(path):
        assert RANK[other] < RANK[layer(path)] or other == layer(path), f"{path}: must not import {other}"


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(SOURCE)))
def test_the_two_witnesses_never_meet(path):
    if layer(path) == "closed_form":
        assert ours(path) <= {"errors", "closed_form"}
    elif layer(path) not in {"checking", "studies", "render", "console", "cli", "cli_studies", "__init__"}:
        assert "closed_form" not in ours(path)


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(SOURCE)))
def test_heavy_packages_stay_where_they_belong(path):
    for name in imported(path):
        homes = ONLY.get(name.split(".")[0])
        where = str(path.relative_to(SOURCE))
        inside = homes is None or any(where == home or where.startswith(f"{home}/") for home in homes)
        assert inside, f"{where}: must not import {name}"


def test_the_command_answers_help_without_the_heavy_packages():
    code = (
        "import sys, governor_mechanism, governor_mechanism.cli\n"
        "heavy = ('numpy', 'scipy', 'pymunk', 'matplotlib', 'pint', 'pydantic')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_the_project_does_not_read_what_lies_beside_it():
    root = SOURCE.parents[1]
    for path in [*root.glob("src/**/*.py"), *root.glob("tests/**/*.py"), *root.glob("models/*.toml")]:
        if path != Path(__file__):
            assert "../shared" not in path.read_text(encoding="utf-8")

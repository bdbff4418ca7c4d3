"""CONTRIBUTING.md names what is there: paths, folders of the package, targets of make."""

import re

import pytest

from documentation_pages import ROOT

PACKAGE = ROOT / "src" / "governor_mechanism"
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
CODE = re.findall(r"(?<!`)`([^`\n]+)`(?!`)", TEXT)
MADE = ("dist/", "docs/_build/", "kernel_build/built/")
"""Beginnings of paths that commands make."""

PATHS = sorted({code for code in CODE if re.fullmatch(r"[\w.<>/-]+(/|\.(py|pyi|toml|md|txt|json))", code) and not code.startswith(MADE)})


def exists(path):
    """Return whether there is such a path from the root or the package, or, without a folder, a file of the package; <name> is any."""
    pattern = path.rstrip("/").replace("<name>", "*")
    depths = [pattern] if "/" in path else [pattern, f"**/{pattern}"]
    return any(any(place.glob(depth)) for place in (ROOT, PACKAGE) for depth in depths)


@pytest.mark.parametrize("path", PATHS)
def test_a_named_path_exists(path):
    assert exists(path)


def test_a_path_that_is_not_there_is_noticed():
    assert len(PATHS) > 50
    assert not exists("studies/errata/")
    assert not exists("nothing.py")
    assert not exists("machines/<name>.rs")


def test_the_layout_lists_the_folders_of_the_package():
    layout = TEXT.partition("## Package layout")[2].partition("\n- ")[0]
    listed = {word for line in re.findall(r"^ {4}(\S.*?)(?:  |$)", layout, flags=re.MULTILINE) for word in line.split()}
    names = {f"{path.name}/" for path in PACKAGE.iterdir() if path.is_dir() and not path.name.startswith("_")}
    assert {name for name in listed if name.endswith("/")} == names
    assert all(exists(name) for name in listed)


def test_the_targets_of_make_are_there():
    named = set(re.findall(r"(?:^ {4}|`)make ([\w-]+(?: [\w-]+)*?)(?=[ `]*(?:#|`|$))", TEXT, flags=re.MULTILINE))
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert len(named) > 15
    assert {target for words in named for target in words.split()} <= targets

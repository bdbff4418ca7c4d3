"""Reference of the Python API: a page for each public name, in reStructuredText for autodoc, and the table of them."""

from __future__ import annotations

import inspect
from enum import Enum

import governor_mechanism as gm
from generators.markdown import code, escape, table

FOLDERS = {"functions": "Functions", "classes": "Classes and types", "errors": "Errors"}
"""Folder of the pages of each group, and its heading."""

ALIASES = {
    "FloatArray": "array of floats",
    "InputValues": "values of an input: numbers, or text with units",
    "QuantityValues": "quantities in a list or an array: numbers in SI, or texts with units",
    "Objective": "quantity by its rule or name, or a function of a run, or of a scene if its parameter is called scene",
    "PointSource": "points: the path of a CSV or TOML file, or rows of numbers in SI or texts with units",
    "Progress": "function that is called with the progress",
    "SceneSource": "scene, path of a scene file, or name of a shipped scene",
}
"""What the public names that are neither classes nor functions stand for."""


def group_of(name: str) -> str:
    """Return the folder of a public name."""
    one = getattr(gm, name)
    if inspect.isclass(one):
        return "errors" if issubclass(one, Exception) else "classes"
    return "functions" if inspect.isfunction(one) else "classes"


def api_page() -> str:
    """Return the sections of the page, from the folder docs/reference."""
    names = {folder: [name for name in gm.__all__ if group_of(name) == folder] for folder in FOLDERS}
    sections = []
    for folder, heading in FOLDERS.items():
        rows = ([f"[{code(name)}](../_generated/api/{folder}/{name}.rst)", escape(summary_of(name))] for name in names[folder])
        sections += [f"## {heading}", "", table(("name", "what it is"), rows)]
    return "\n".join(sections)


def summary_of(name: str) -> str:
    """Return what a public name is, in one sentence."""
    if name in ALIASES:
        return f"{ALIASES[name][:1].upper()}{ALIASES[name][1:]}."
    return " ".join((inspect.getdoc(getattr(gm, name)) or "").split("\n\n")[0].split())


def name_page(name: str) -> str:
    """Return the page of a public name, in reStructuredText."""
    title = f"{name}\n{'=' * len(name)}\n\n"
    if name in ALIASES:
        return f"{title}.. py:data:: governor_mechanism.{name}\n\n   {summary_of(name)}\n"
    one = getattr(gm, name)
    if inspect.isfunction(one):
        examples = f".. minigallery:: governor_mechanism.{name}\n   :add-heading: Examples\n"
        return f"{title}.. autofunction:: governor_mechanism.{name}\n\n{examples}"
    options = "   :members:\n   :inherited-members: object, Exception, BaseException, tuple, str, int, ABC, Protocol, Enum\n"
    options += "   :undoc-members:\n" if issubclass(one, Enum) else ""  # the members of an enumeration have no docstrings
    return f"{title}.. autoclass:: governor_mechanism.{name}\n{options}"


def api_files() -> dict[str, str]:
    """Return the text of every page by its path, from the folder of generated pages."""
    return {f"api/{group_of(name)}/{name}.rst": name_page(name) for name in gm.__all__}

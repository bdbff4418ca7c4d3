"""Sphinx extension: references of annotations to classes.

Annotations name classes by the module that defines them. A public class is found under `governor_mechanism`; a class of the package that
is not public, or of another package, is shown without a link, because nothing is looked up in the network. A name of the package that does
not exist stays a warning.
"""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any, Final

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.domains.python import PythonDomain
from sphinx.environment import BuildEnvironment

PACKAGE: Final = "governor_mechanism"

_ARRAY: Final = re.compile(r"~?numpy\.ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?numpy\.dtype\[(~?[\w.]+)\]\]")
"""What the annotation of an array reads when it is evaluated."""
_HIDDEN_COLON: Final = "\ue000"
"""Character of private use, which no docstring has."""


def find_public_name(target: str) -> str | None:
    """Return the public name of a class.

    Parameters
    ----------
    target
        Full name with the module that defines the class, or a bare name.

    Returns
    -------
    str or None
        The name under the package; empty for what exists and is not public; None for what does not exist.
    """
    import governor_mechanism as gm

    name = target.rpartition(".")[2]
    if name in gm.__all__ and target in (name, f"gm.{name}"):
        return name
    if not target.startswith(f"{PACKAGE}."):
        return ""
    one = _find_object(target)
    if one is None:
        return None
    return next((public for public in gm.__all__ if getattr(gm, public) is one), "")


def _find_object(target: str) -> Any:
    """Return an object by its full name, or None."""
    module, _, name = target.rpartition(".")
    try:
        return getattr(import_module(module), name, None)
    except ImportError:
        owner = _find_object(module) if "." in module else None
        return getattr(owner, name, None)


def _resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, shown: nodes.Element) -> nodes.Node | None:
    """Return the link to a public class, or the text without a link."""
    if node.get("refdomain") != "py":
        return None
    name = find_public_name(node["reftarget"])
    if not name:
        return None if name is None else shown
    text = nodes.literal("", name) if isinstance(shown, nodes.literal) else nodes.Text(name)
    place = env.domains["py"]
    return place.resolve_xref(env, node["refdoc"], app.builder, "obj", f"{PACKAGE}.{name}", node, nodes.inline("", "", text))


def _name_arrays(text: str) -> str:
    """Return the text of an annotation with the public name of arrays of floats, and other arrays without their shape."""
    return _ARRAY.sub(lambda match: f"~{PACKAGE}.FloatArray" if match[1].endswith("float64") else f"~numpy.ndarray[{match[1]}]", text)


def _name_arrays_of_parameters(app: Sphinx, *_: object) -> None:
    """Shorten the annotations that autodoc adds to the descriptions of parameters."""
    for shown in app.env.current_document.autodoc_annotations.values():
        shown.update({name: _name_arrays(text) for name, text in shown.items()})


def _hide_colons(app: Sphinx, what: str, name: str, one: object, options: object, lines: list[str]) -> None:
    """Replace the colons of a property: napoleon would take what precedes the first one for its type."""
    if what == "property":
        lines[:] = [line.replace(": ", f"{_HIDDEN_COLON} ") for line in lines]


def _finish_docstring(app: Sphinx, what: str, name: str, one: object, options: object, lines: list[str]) -> None:
    """Show colons again, and shorten the annotations that napoleon adds to the attributes of a class."""
    lines[:] = [_name_arrays(line).replace(_HIDDEN_COLON, ":") for line in lines]


def setup(app: Sphinx) -> dict[str, Any]:
    """Resolve what Sphinx does not find, and name arrays and fields as numpydoc does."""
    for field in PythonDomain.directives["class"].doc_field_types:
        field.label = "Attributes" if field.name == "variable" else field.label
    app.connect("missing-reference", _resolve)
    app.connect("object-description-transform", _name_arrays_of_parameters, priority=400)  # before they are written
    app.connect("autodoc-process-docstring", _hide_colons, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", _finish_docstring, priority=600)  # after napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}

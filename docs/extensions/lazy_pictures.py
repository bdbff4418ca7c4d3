"""Sphinx extension: a picture is loaded when it comes into view, because the films of the gallery are some 25 MB together."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx


def _load_lazily(app: Sphinx, page: str, template: str, context: dict[str, Any], *_: object) -> None:
    context["body"] = context.get("body", "").replace("<img ", '<img loading="lazy" ')


def setup(app: Sphinx) -> dict[str, Any]:
    """Mark the pictures of every page."""
    app.connect("html-page-context", _load_lazily)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

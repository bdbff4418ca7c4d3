"""The catalogue: every classic mechanism with its dimensions, the law that it proves, and its source, family after family."""

from __future__ import annotations

from generators.markdown import code, escape, sentence, table
from governor_mechanism.model.part import FAMILIES
from governor_mechanism.scenes.library import CatalogueEntry, list_catalogue_entries

HEADING = ("scene", "mechanism", "law", "dimensions", "source")


def catalogue_page() -> str:
    """Return the sections of the page."""
    return "\n".join(filter(None, map(_section, FAMILIES)))


def _section(family: str) -> str:
    """Return the table of a family; empty if no mechanism belongs to it."""
    entries = list_catalogue_entries(family)
    rows = [_row(name, entry) for name, entry in entries.items()]
    return f"## {sentence(family.replace('-', ' ')).rstrip('.')}\n\n{table(HEADING, rows)}" if rows else ""


def _row(name: str, entry: CatalogueEntry) -> list[str]:
    dimensions = ", ".join(map(code, entry.dimensions))
    return [code(name), escape(entry.title), escape(sentence(entry.law)), dimensions, escape(entry.source)]

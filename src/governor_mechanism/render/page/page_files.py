"""Templates, styles and scripts of pages, which stand beside this module."""

from importlib import resources


def read_page_file(name: str) -> str:
    """Return the text of a file of this folder."""
    return resources.files("governor_mechanism.render.page").joinpath(name).read_text(encoding="utf-8")

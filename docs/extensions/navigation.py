"""Sphinx extension: the navigation follows the links of the index pages.

Index pages are plain Markdown, which also reads well where the repository is browsed. Each gets a hidden table of contents: the pages of
its folder in the order of its links, then the others by name. For the same reason pages link to the scripts of examples; on the site these
links lead to the pages that are made of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # tests call `list_entries` without Sphinx
    from sphinx.application import Sphinx

SUFFIXES = (".md", ".ipynb")
"""Endings of pages."""
LISTED = re.compile(r"^(?:- |\| )\[[^]]*\]\(([^)\s]+)\)", re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
"""Links with which items of lists and rows of tables begin, and all: a link of a sentence does not change their order."""
EXAMPLE = re.compile(r"\]\(((?:\.\./)*)examples/(?:([\w/]+)\.py)?\)")
"""Link to the script of an example, or to the folder of all of them."""
MADE = "_generated/"
"""Begin of the addresses of pages that other extensions write."""


def list_entries(index: Path, text: str, root: Path) -> list[str]:
    """Return the entries of the table of contents of an index page.

    Parameters
    ----------
    index
        The index page.
    text
        Its text.
    root
        Folder of the documentation.

    Returns
    -------
    list of str
        Names of pages, and NAME/index for a folder, relative to the folder of the index page.
    """
    own = _names_beside(index)
    targets = [target.partition("#")[0] for line in (LISTED, LINK) for target in line.findall(text)]
    linked = [str(Path(target).with_suffix("").as_posix()) for target in targets if _is_own_page(index, target, root)]
    return list(dict.fromkeys([*(entry for entry in linked if entry != "index"), *sorted(own)]))


def link_made_examples(text: str) -> str:
    """Return the text of a page with links to the pages of examples in the place of those to their scripts.

    Parameters
    ----------
    text
        The text in Markdown.

    Returns
    -------
    str
        The text.
    """
    return EXAMPLE.sub(lambda link: f"]({link[1]}{MADE}examples/{link[2] or 'index'}.rst)", text)


def _link_made_examples(app: Sphinx, name: str, content: list[str]) -> None:
    """Let the links of a page to examples lead to their pages."""
    if (Path(app.srcdir) / f"{name}.md").is_file():
        content[0] = link_made_examples(content[0])


def _is_own_page(index: Path, target: str, root: Path) -> bool:
    """Return whether a link leads to a page of this part: beside the index page, to another index page below it, or to a page of none."""
    if target.startswith(MADE) and index.parent == root:
        return True
    page = (index.parent / target).resolve()
    if page.suffix not in SUFFIXES or not page.is_file() or not page.is_relative_to(root):
        return False
    return (
        page.parent == index.parent
        or (page.stem == "index" and page.parent.parent == index.parent)
        or not (page.parent / "index.md").exists()
    )


def _names_beside(index: Path) -> Iterator[str]:
    """Yield the pages beside an index page, and the index pages of the folders beside it."""
    for path in index.parent.iterdir():
        if path.suffix in SUFFIXES and path.stem not in ("index", "README"):
            yield path.stem
        elif (path / "index.md").is_file() and not path.name.startswith("_"):
            yield f"{path.name}/index"


def _add_contents(app: Sphinx, name: str, content: list[str]) -> None:
    """Append the hidden table of contents to an index page."""
    root = Path(app.srcdir)
    if name.rpartition("/")[2] != "index" or not (root / f"{name}.md").is_file():  # sphinx-gallery writes that of its pages
        return
    entries = list_entries(root / f"{name}.md", content[0], root)
    content[0] += "\n\n" + "\n".join(["```{toctree}", ":hidden:", "", *entries, "```", ""])


def setup(app: Sphinx) -> dict[str, Any]:
    """Change links and add tables of contents when a page is read."""
    app.connect("source-read", _link_made_examples, priority=400)
    app.connect("source-read", _add_contents)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

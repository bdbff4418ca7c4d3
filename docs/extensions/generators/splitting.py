"""A long generated text as one page for each of its sections, and an index of them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from generators.markdown import anchor, table

HEADING = re.compile(r"^(#{2,}) (.+)$", re.MULTILINE)
LINK = re.compile(r"\]\(([\w/.]*)(?:#([\w-]+))?\)")


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a text, which becomes a page.

    Attributes
    ----------
    heading
        Its heading.
    level
        Level of the heading in the text.
    text
        What stands below it, with the headings of deeper levels that stay on its page.
    """

    heading: str
    level: int
    text: str

    @property
    def name(self) -> str:
        """Name of the page."""
        return anchor(self.heading)

    @property
    def anchors(self) -> list[str]:
        """Anchors that the page has."""
        return [self.name, *(anchor(heading) for _, heading in HEADING.findall(self.text))]

    @property
    def summary(self) -> str:
        """First sentence of the section; empty where it begins with a table."""
        first = self.text.strip().partition("\n\n")[0]
        return "" if first.startswith(("|", "#", "`")) else re.split(r"(?<=\.) ", re.sub(r":$", ".", first.replace("\n", " ")))[0]


def split_sections(text: str, deeper: Collection[str] = ()) -> Iterator[Section]:
    """Yield the sections of a text.

    Parameters
    ----------
    text
        Markdown whose sections begin at level 2.
    deeper
        Headings of sections whose own sections, of level 3, become pages too.
    """
    marks = [*HEADING.finditer(text)]
    parent = ""
    starts = []
    for mark in marks:
        level = len(mark[1])
        parent = mark[2] if level == 2 else parent
        if level == 2 or (level == 3 and parent in deeper):
            starts.append(mark)
    for mark, following in zip(starts, [*starts[1:], None], strict=True):
        end = following.start() if following else len(text)
        yield Section(heading=mark[2], level=len(mark[1]), text=text[mark.end() : end])


def write_pages(sections: Collection[Section], folder: str, home: str) -> dict[str, str]:
    """Return the page of each section by its path, with links that lead where they led.

    Parameters
    ----------
    sections
        The sections.
    folder
        Folder of the pages in that of all generated ones.
    home
        Page from which links of the text count, from the folder docs.
    """
    page_of = {name: section.name for section in sections for name in section.anchors}

    def lead(match: re.Match[str]) -> str:
        target, part = match[1], match[2]
        if not target or f"reference/{target}" == home:
            page = page_of.get(part or "", "")
            return f"]({page}.md#{part})" if page else f"](../../{home})"
        return f"](../../reference/{target}{f'#{part}' if part else ''})"

    return {
        f"{folder}/{section.name}.md": "\n".join([f"# {section.heading}", LINK.sub(lead, _promote(section))]) + "\n" for section in sections
    }


def _promote(section: Section) -> str:
    """Return the text of a section with its headings below one of level 1."""
    return HEADING.sub(lambda match: f"{match[1][section.level - 1 :]} {match[2]}", section.text)


def index_of(sections: Collection[Section], folder: str, heading: str) -> str:
    """Return a table that leads to the pages of sections, and adds them to the navigation."""
    rows = ([f"[{section.heading}](../_generated/{folder}/{section.name}.md)", section.summary] for section in sections)
    return "\n".join([table((heading, "what it is"), rows), navigation_of(sections, folder)])


def navigation_of(sections: Collection[Section], folder: str) -> str:
    """Return the hidden table of contents of pages."""
    entries = [f"/_generated/{folder}/{section.name}" for section in sections]
    return "\n".join(["```{toctree}", ":hidden:", "", *entries, "```", ""])

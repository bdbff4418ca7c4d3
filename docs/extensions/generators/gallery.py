"""The gallery: every shipped scene with its film or a picture, its description, its command and its interactive page."""

from __future__ import annotations

import html
from collections import defaultdict
from pathlib import Path

from generators.markdown import escape
from governor_mechanism.render.page.gallery import GROUPS, find_group
from governor_mechanism.render.page.writer import read_caption
from governor_mechanism.scenes.library import load_scene, shipped_scenes

FILM_FOLDERS = ("../renders/gallery", "../renders")
"""Folders with films, from docs/: those of `make gallery`, and the tracked ones, which other pages show."""
DOCS = Path(__file__).parents[2]


def gallery_page() -> str:
    """Return the sections of the page, from the folder docs."""
    groups: defaultdict[str, list[str]] = defaultdict(list)
    for name in shipped_scenes():
        scene = load_scene(name)
        groups[find_group(scene)].append(_card(name, scene.title, read_caption(scene)))
    return "\n".join(f"## {group}\n\n" + "\n".join(groups[group]) for group in GROUPS if group in groups)


def scenes_without_description() -> list[str]:
    """Return the names of the scenes whose file has no comment at its head."""
    return [name for name in shipped_scenes() if not read_caption(load_scene(name))]


def _card(name: str, title: str, caption: str) -> str:
    """Return the card of a scene."""
    frame = f'<iframe loading="lazy" src="pages/{name}.html" title="Interactive page: {html.escape(title)}"></iframe>'
    page = f"<details><summary>Interactive page</summary>{frame}</details>"
    link = f'<a href="pages/{name}.html">Open it alone</a>'
    return (
        "\n\n".join([f"### {title}", show_scene(name, title), caption, f"```text\ngovernor-mechanism run {name}\n```", page, link]) + "\n"
    )


def show_scene(name: str, title: str) -> str:
    """Return the film of a scene if there is one, or else the picture that is made with its interactive page."""
    for folder in FILM_FOLDERS:
        if (DOCS / folder / f"{name}.gif").is_file():
            return f"![Film of the scene {name}: {escape(title)}]({folder}/{name}.gif)"
    return f'<img src="pages/{name}.png" alt="The end of the scene {name}: {html.escape(title)}">'

"""The gallery: a card for every shipped scene, and a page of each with its film, commands, scene file and interactive page."""

from __future__ import annotations

import html
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

from gallery import FILM_OPTIONS  # of docs/pictures
from generators.markdown import escape
from governor_mechanism.model.part import FreeSpindle, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.page.writer import GROUPS, find_group, read_caption
from governor_mechanism.scenes.library import load_scene, shipped_scenes

FILM_FOLDERS = ("../renders/gallery", "../renders")
"""Folders with large films, from docs/: those of `make gallery`, and the tracked ones, which other pages show."""
DOCS = Path(__file__).parents[2]

COMMON_EFFECTS = {"gravity", "centrifugal"}
"""Effects that tell nothing apart."""
OWN_MECHANISM = "mechanism of one's own"
EQUILIBRIA, VALVE_EVENTS, REGULATION, LINKAGE = "equilibria, speed curve", "valve events", "load changes, stability", "kinematics"
"""Studies that answer what one asks of a scene."""


def gallery_page() -> str:
    """Return the choices and the cards, as HTML in Markdown, from the folder docs."""
    scenes = {name: load_scene(name) for name in shipped_scenes()}
    groups: defaultdict[str, list[str]] = defaultdict(list)
    for name, scene in scenes.items():
        groups[find_group(scene)].append(_card(name, scene))
    sections = [f'## {group}\n\n<div class="cards">\n{"".join(groups[group])}</div>\n' for group in GROUPS if group in groups]
    return "\n".join([_choices(scenes.values()), *sections])


def scene_pages() -> dict[str, str]:
    """Return the page of every scene by its path, from the folder of generated pages."""
    return {f"scenes/{name}.md": _scene_page(name, load_scene(name)) for name in shipped_scenes()}


def scenes_without_description() -> list[str]:
    """Return the names of the scenes whose file has no comment at its head."""
    return [name for name in shipped_scenes() if not read_caption(load_scene(name))]


def list_machines(scene: Scene) -> list[str]:
    """Return the machines of a scene in words."""
    return sorted({OWN_MECHANISM if part.machine == "custom" else part.machine.replace("_", " ") for part in scene.parts})


def list_effects(scene: Scene) -> list[str]:
    """Return what a scene models besides gravity and the turning plane, in words."""
    return sorted({word for part in scene.parts for word in _effects_of(part)})


def _effects_of(part: Part) -> Iterable[str]:
    yield from (effect.key.replace("_", " ") for effect in (*part.effects, *part.output_effects) if effect.key not in COMMON_EFFECTS)
    if part.mechanism.outlines:
        yield "contact"
    if part.turns and isinstance(part.spindle, FreeSpindle):
        yield "free spindle"


def list_studies(scene: Scene) -> list[str]:
    """Return the studies that answer what one asks of a scene."""
    kind = find_group(scene)
    return [
        *([EQUILIBRIA] if any(part.turns for part in scene.parts) else []),
        *([VALVE_EVENTS] if any(part.mechanism.valve for part in scene.parts) else []),
        *([REGULATION] if kind == "Governed engines" else []),
        *([LINKAGE] if kind == "Linkages" else []),
    ]


FILTERS = {"machine": list_machines, "effect": list_effects, "study": list_studies}
"""What a reader chooses by, and what a scene has of it."""


def _choices(scenes: Iterable[Scene]) -> str:
    """Return a list of choices for each filter, and the count of the scenes that are shown."""
    scenes = list(scenes)
    lists = []
    for name, of_scene in FILTERS.items():
        values = sorted({value for scene in scenes for value in of_scene(scene)})
        options = "".join(f"<option>{html.escape(value)}</option>" for value in values)
        lists.append(f'<label>{name} <select data-filter="{name}"><option value="">all</option>{options}</select></label>')
    count = f'<output aria-live="polite">{len(scenes)} scenes</output>'
    return f'<form class="choices">{"".join(lists)}{count}</form>\n<script defer src="_static/gallery.js"></script>\n'


def _card(name: str, scene: Scene) -> str:
    """Return the card of a scene."""
    title = html.escape(scene.title)
    data = " ".join(f'data-{key}="{html.escape("|".join(of_scene(scene)))}"' for key, of_scene in FILTERS.items())
    page = f"_generated/scenes/{name}.html"
    poster = f'<img src="pages/{name}.webp" alt="">'
    if magnified := _magnification_note(name):
        poster += f'<span class="note">{magnified}</span>'
    command = f'<div class="highlight-text notranslate"><div class="highlight"><pre>governor-mechanism open {name}</pre></div></div>'
    lines = [
        f'<article class="scene" id="scene-{name}" {data}>',
        f'<button type="button" data-film="pages/{name}.gif" aria-pressed="false" aria-label="Film: {title}">{poster}</button>',
        f'<h3><a href="{page}">{title}</a></h3>',
        f"<p>{html.escape(read_caption(scene))}</p>",
        command,
        f'<p class="links"><a href="{page}#scene-file">Scene file</a> <a href="pages/{name}.html">Interactive page</a></p>',
        "</article>",
    ]
    return "\n".join(lines) + "\n"


def _magnification_note(name: str) -> str:
    """Return what the small film of a scene, which has no words, cannot say of itself; nothing if its motion is true."""
    magnification = FILM_OPTIONS.get(name, {}).get("exaggerate")
    return f"motion magnified {magnification:g} ×" if magnification else ""


def _scene_page(name: str, scene: Scene) -> str:
    """Return the page of a scene."""
    title = html.escape(scene.title)
    sections: Mapping[str, str] = {
        "Commands": f"```text\ngovernor-mechanism open {name}\ngovernor-mechanism run {name}\ngovernor-mechanism describe {name}\n```",
        "Scene file": f"Copied into `mine.toml`, it runs by `governor-mechanism run mine.toml`.\n\n"
        f"```{{literalinclude}} ../../../models/{name}.toml\n:language: toml\n```",
        "Interactive page": f'<iframe class="example" loading="lazy" src="../../pages/{name}.html" title="{title}"></iframe>',
    }
    text = [f"---\norphan: true\n---\n\n# {scene.title}", show_scene(name, scene.title), escape(read_caption(scene))]
    return "\n\n".join([*text, *(f"## {heading}\n\n{body}" for heading, body in sections.items())]) + "\n"


def show_scene(name: str, title: str) -> str:
    """Return the large film of a scene if there is one, or else the small one of its card, for the page of the scene."""
    for folder in FILM_FOLDERS:
        if (DOCS / folder / f"{name}.gif").is_file():
            return f"![Film of the scene {name}: {escape(title)}](../../{folder}/{name}.gif)"
    film = f'<img src="../../pages/{name}.gif" alt="Film of the scene {name}: {html.escape(title)}">'
    return "\n\n".join([film, *([f"*{note}*"] if (note := _magnification_note(name)) else [])])

"""The live page: that of a recorded run, with a panel of what may be changed; and the list of scenes to begin with."""

from collections.abc import Sequence
from html import escape
from string import Template
from typing import Final, Literal
from urllib.parse import quote

from governor_mechanism.live.describing import show_whole_run
from governor_mechanism.live.session import Session
from governor_mechanism.render.page.page_data import collect_data
from governor_mechanism.render.page.writer import fill_page, read_page_file
from governor_mechanism.render.style import ROLE_STYLES, colour_rules
from governor_mechanism.scenes.library import list_catalogue_entries, list_contents

CONNECTIONS: Final = "; connect-src 'self'"
"""What the page may ask beside its own text: the web socket of its server."""

SCRIPTS: Final = (
    "saving",
    "inspection",
    "locks",
    "ghost",
    "address",
    "voice",
    "panel",
    "results",
    "grips",
    "motion",
    "choices",
    "connection",
)
"""Files of the script in `render/page/script/live`, in their order; what connects the page comes last."""

LINKS: Final = {"server": ("server", CONNECTIONS), "notebook": ("frame", "")}
"""The file of the script that carries messages, and what the page may ask beside its own text, by where the page is shown."""


def make_live_page(session: Session, place: Literal["server", "notebook"] = "server") -> str:
    """Return the page of the last run of a session."""
    link, connections = LINKS[place]
    shown, slow_down = show_whole_run(session.run)
    return fill_page(
        session.run,
        collect_data(shown, slow_down),
        shown.times,
        roles=set(ROLE_STYLES),  # a change may show shapes that the first run does not have
        last_script="\n".join(read_page_file(f"script/live/{name}.js") for name in (link, *SCRIPTS)),
        connections=connections,
    )


def make_list_page() -> str:
    """Return the list of the shipped scenes and of the catalogue, with links to their pages."""
    families = {"Machines": [(name, one.title) for name, one in list_contents().items()]}
    for name, entry in list_catalogue_entries(None).items():
        families.setdefault(entry.family.replace("-", " ").capitalize(), []).append((name, entry.title))
    sections = "".join(f"<h2>{escape(family)}</h2><ul>{''.join(map(_item, scenes))}</ul>" for family, scenes in families.items())
    style = f"{colour_rules()}\n{read_page_file('page.css')}"
    return Template(read_page_file("scenes.html")).substitute(style=style, sections=sections)


def make_beside_page(names: Sequence[str]) -> str:
    """Return a page with the pages of several scenes beside each other."""
    frames = "".join(f'<iframe src="{"../" * (len(names) + 1)}{quote(name)}/" title="{escape(name)}"></iframe>' for name in names)
    return Template(read_page_file("beside.html")).substitute(style=colour_rules(), frames=frames, title=escape(" and ".join(names)))


def _item(scene: tuple[str, str]) -> str:
    name, title = scene
    return f'<li><a href="{escape(name)}/">{escape(title)}</a> <small>{escape(name)}</small></li>'

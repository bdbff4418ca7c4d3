"""The gallery: an index of the pages of several scenes, with a picture, the title, a paragraph and the command of each."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import chain
from string import Template

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.machines.engine_room.arrangement import ENGINE_MACHINE, find_governed_engine
from governor_mechanism.render.page import writer
from governor_mechanism.render.page.views import PageView, Picture, show_run
from governor_mechanism.render.page.writer import read_page_file
from governor_mechanism.render.style import class_of, colour_rules, role_rules


def draw_poster(view: PageView) -> str:
    """Return the drawing of a view at its first sample as an SVG element."""
    picture, stroke = view.picture, view.stroke
    width, height = picture.size
    shapes = chain(view.static_shapes, view.shapes_at(0))
    elements = "".join(_draw_shapes(picture, shapes))
    return (
        f'<svg viewBox="{-stroke:.0f} {-stroke:.0f} {width + 2 * stroke:.0f} {height + 2 * stroke:.0f}" style="--stroke:{stroke:.2f}"'
        f' aria-hidden="true">{elements}</svg>'
    )


def _draw_shapes(picture: Picture, shapes: Iterable[DrawnShape]) -> Iterator[str]:
    """Yield the elements of shapes, without those that are hidden."""
    for shape in shapes:
        name = class_of(shape.role)
        match shape:
            case Circle(_, x, y, radius):
                if radius > 0.0:
                    (cx, cy), r = _place(picture, [(x, y)])[0], round(radius * picture.scale)
                    yield f'<circle class="{name}" cx="{cx}" cy="{cy}" r="{r}"/>'
            case Polygon(_, points):
                if points:
                    yield f'<path class="{name}" d="{_path(picture, points)}Z"/>'
            case Lines(_, lines):
                path = "".join(_path(picture, line) for line in lines if len(line))
                if path:
                    yield f'<path class="{name} lines" d="{path}"/>'
            case TextShape(_, x, y, text, _):
                tx, ty = _place(picture, [(x, y)])[0]
                yield f'<text class="{name} text" x="{tx}" y="{ty}">{escape(text)}</text>'


def _place(picture: Picture, points: Sequence[Vec2]) -> list[tuple[int, int]]:
    """Return points in whole units of the picture."""
    return [(int(x), int(y)) for x, y in np.rint(picture.place(np.array(points)))]


def _path(picture: Picture, points: Sequence[Vec2]) -> str:
    """Return an open path."""
    return "M" + "L".join(f"{x} {y}" for x, y in _place(picture, points))


POSTER_MOMENT = 0.35
"""Moment of the picture, as a fraction of the run: a mechanism has left its start and not yet come to its end."""
GROUPS = ("Governors", "Governed engines", "Engines and flywheels", "Valve gears", "Linkages")
"""Headings of the gallery, in their order."""


@dataclass(frozen=True, kw_only=True)
class _Card:
    """What the gallery shows of a scene: its HTML, and the roles of its shapes."""

    group: str
    content: str
    roles: frozenset[str]


def make_gallery(
    # name of each scene, which is that of its page without .html, and its run
    runs: Sequence[tuple[str, Trajectory]],
    heading: str,
) -> str:
    """Return the index of pages as an HTML document; the names of the pages are relative to its folder."""
    cards = [_make_card(name, run) for name, run in runs]
    groups: defaultdict[str, list[str]] = defaultdict(list)
    for card in cards:
        groups[card.group].append(card.content)
    sections = [f"<section><h2>{group}</h2><ul>{''.join(groups[group])}</ul></section>" for group in GROUPS if group in groups]
    roles = set(chain.from_iterable(card.roles for card in cards))
    return Template(read_page_file("gallery.html")).substitute(
        heading=escape(heading),
        style="\n".join([colour_rules(), role_rules(roles), read_page_file("page.css"), read_page_file("gallery.css")]),
        sections="\n".join(sections),
    )


def _make_card(name: str, run: Trajectory) -> _Card:
    """Return the card of a scene."""
    start, stop = float(run.times[0]), float(run.times[-1])
    shown = show_run(run, None, (start, stop), np.array([start + POSTER_MOMENT * (stop - start)]), 1.0)
    views = [view for view in shown.views if view.has_plane]
    roles = frozenset(shape.role for view in views for shape in (*view.static_shapes, *view.shapes_at(0)))
    content = (
        f'<li><a href="{escape(name)}.html">{"".join(map(draw_poster, views))}<h3>{escape(run.scene.title)}</h3></a>'
        f"<p>{escape(writer.read_caption(run.scene))}</p>"
        f"<code>governor-mechanism run {escape(name)} <span>--film html</span></code></li>"
    )
    return _Card(group=find_group(run.scene), content=content, roles=roles)


def find_group(scene: Scene) -> str:
    """Return the heading under which a scene stands."""
    if find_governed_engine(scene):
        return "Governed engines"
    if any(part.mechanism.valve for part in scene.parts):
        return "Valve gears"
    if any(part.turns for part in scene.parts):
        return "Governors"
    return "Engines and flywheels" if any(part.machine == ENGINE_MACHINE for part in scene.parts) else "Linkages"

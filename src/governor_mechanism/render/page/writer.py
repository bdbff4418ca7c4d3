"""Runs as interactive HTML files, which need neither a network nor a server: a page of one, and an index of the pages of several scenes."""

import json
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from itertools import chain
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.pictures import FilmLayer
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.machines.engine_room.arrangement import ENGINE_MACHINE, find_governed_engine
from governor_mechanism.render.page.page_data import collect_data, roles_of
from governor_mechanism.render.page.views import PICTURE_SIZE, PageView, Picture, show_run
from governor_mechanism.render.shown_readings import format_closing_lines, format_name
from governor_mechanism.render.style import class_of, colour_rules, role_rules, series_rules
from governor_mechanism.scenes.description import describe_scene
from governor_mechanism.types import FloatArray


def read_page_file(name: str) -> str:
    """Return the text of a file of this folder."""
    return resources.files("governor_mechanism.render.page").joinpath(name).read_text(encoding="utf-8")


_SCHEMA_MARK = "#:"
"""Start of a comment for editors, which is no text."""
_CLOSING_LINE_LENGTH = 400
MAX_NAMED_EVENTS = 6
"""Largest number of events that are listed one by one."""


def read_caption(scene: Scene) -> str:
    """Return the comment at the head of the scene file: what the mechanism is, and where it is from. Empty without a file or a comment."""
    path = Path(scene.source)
    if not scene.source or not path.is_file():
        return ""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith(_SCHEMA_MARK):
            lines.append(line.lstrip("# ").rstrip())
    return " ".join(filter(None, lines))


def list_effects(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield name and parameters of each effect, force element, coupling and load of a scene."""
    description = describe_scene(scene)
    for part in description.parts:
        prefix = f"{format_name(part.name)}: " if len(description.parts) > 1 else ""
        if part.spindle:
            yield f"{prefix}spindle", part.spindle.removeprefix("spindle ")
        for effect in part.effects:
            yield f"{prefix}{format_name(effect.name)}", effect.text or "acts on all bodies"
    names = {coupling.name for coupling in description.couplings}
    elements = [element for element in description.force_elements if element.name not in names]
    for element in (*elements, *description.couplings):
        yield format_name(element.name), f"{element.kind}, {element.text}" if element.text else element.kind


def list_dimensions(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield name and value of each dimension that is given."""
    description = describe_scene(scene)
    for part in description.parts:
        prefix = f"{format_name(part.name)}: " if len(description.parts) > 1 else ""
        for dimension in part.dimensions:
            if dimension.value is not None:
                yield f"{prefix}{format_name(dimension.name)}", dimension.text


def describe_accuracy(run: Trajectory, times: FloatArray) -> list[tuple[str, str]]:
    """Return what is known of the accuracy of a run and of its drawing at sample times (n,) s, and what it cost."""
    cost = run.cost
    lines, _ = format_closing_lines(run, _CLOSING_LINE_LENGTH)
    runs = f"{cost.runs} runs, " if cost.runs > 1 else ""
    rows = [
        ("engine", f"{cost.engine}{f': {cost.reason}' if cost.reason else ''}"),
        ("accuracy", "; ".join(lines) + ", relative to the scale of each reading" * (run.error_estimate is not None)),
        ("cost", f"{runs}{cost.steps} steps, {1e3 * cost.wall_time:.3g} ms"),
        ("outcome", run.message),
        ("drawing", _describe_drawing(times)),
    ]
    if run.events:
        rows.append(("events", "; ".join(map(str, run.events[:MAX_NAMED_EVENTS])) + _rest(len(run.events) - MAX_NAMED_EVENTS)))
    return rows


def _describe_drawing(times: FloatArray) -> str:
    """Return how the drawing follows the run."""
    rounding = f"positions rounded to 1/{PICTURE_SIZE} of the picture"
    if len(times) < 2:
        return f"one moment; {rounding}"
    step = 1e3 * float(times[1] - times[0])
    return f"{len(times)} moments, {step:.3g} ms apart, with a cubic between them; {rounding}"


def _rest(count: int) -> str:
    """Return how many more there are."""
    return f"; and {count} more" if count > 0 else ""


SAMPLE_RATE = 30.0
"""Samples per second of the film in which the page plays at first."""
MAX_ROTATION = 0.4
"""Largest rotation of a body between samples, rad: a cubic through samples of a circle then deviates by 1/4000 of its radius."""
MIN_SAMPLES, MAX_SAMPLES = 60, 3000
"""Range of the number of samples; the upper bound keeps the file small."""


def choose_sample_times(run: Trajectory, time_span: Vec2, slow_down: float, least: int = MIN_SAMPLES) -> FloatArray:
    """Return the sample times (n,) s of the shown part of a run whose seconds take `slow_down` seconds of film."""
    start, stop = time_span
    duration = stop - start
    if duration <= 0.0:
        return np.array([start])
    count = max(SAMPLE_RATE * slow_down * duration, _fastest_rotation(run) * duration / MAX_ROTATION, least)
    return np.linspace(start, stop, min(math.ceil(count), MAX_SAMPLES) + 1)


def _fastest_rotation(run: Trajectory) -> float:
    """Return the largest angular speed of a body or a spindle, rad/s."""
    speeds = [run.velocities[..., 2], *(values for name, values in run.readings.items() if name.endswith("spindle_speed"))]
    return max(float(np.abs(speed).max(initial=0.0)) for speed in speeds)


SCRIPTS = ("decoding", "geometry", "drawing", "outside", "forces", "plots", "player", "dragging", "page")
"""Files of the script, in their order; what begins the page comes last."""
MAX_TRUE_TIME_DURATION = 100.0
"""Longest run (s) that a page shows in true time at first: one can go on in it at any time, and it keeps 30 moments a second."""


def write_page(
    run: Trajectory,
    path: Path,
    *,
    part: str | None,  # name of the part to show; all parts if None
    paths: Sequence[str] | None,  # names of the points whose paths are drawn; those of the scene if None
    layers: Sequence[FilmLayer] = (),  # what is drawn of the motion
    time_span: Vec2,  # start and end of the shown part of the run, s
    slow_down: float,  # seconds of film per second of the run, at first
) -> Path:
    """Write a run as one interactive HTML file; raise MechanismError if there is no such part, or the file cannot be written."""
    text = make_page(run, part=part, paths=paths, layers=layers, time_span=time_span, slow_down=slow_down)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def make_page(
    run: Trajectory,
    *,
    part: str | None,
    paths: Sequence[str] | None = None,
    layers: Sequence[FilmLayer] = (),
    time_span: Vec2,
    slow_down: float,
) -> str:
    """Return a run as one interactive HTML document; the arguments are those of `write_page`."""
    times = choose_sample_times(run, time_span, slow_down)
    data = collect_data(show_run(run, part, time_span, times, slow_down, paths, layers), slow_down)
    return fill_page(run, data, times, roles=roles_of(data), last_script=read_page_file("script/start.js"))


def fill_page(
    run: Trajectory,
    data: dict[str, Any],  # data of the page, from collect_data
    times: FloatArray,  # times of its samples; shape (n,), s
    *,
    roles: set[str],  # roles of shapes that have a rule of style
    last_script: str,  # what begins the page
    connections: str = "",  # what else its policy allows
) -> str:
    """Return an HTML document that shows a run."""
    dimensions = _format_list(list_dimensions(run.scene))
    return Template(read_page_file("page.html")).substitute(
        title=escape(run.scene.title),
        caption=escape(read_caption(run.scene)),
        connections=connections,
        style="\n".join([colour_rules(), role_rules(roles), series_rules(), read_page_file("page.css")]),
        effects=_format_list(list_effects(run.scene)) or "<p>The scene lists no effect: the motion is prescribed.</p>",
        dimensions=dimensions,
        no_dimensions="" if dimensions else " hidden",
        accuracy=_format_list(describe_accuracy(run, times)),
        data=_embed_json(data),
        script="\n".join([*(read_page_file(f"script/{name}.js") for name in SCRIPTS), last_script]),
    )


def _format_list(rows: Any) -> str:
    """Return names and texts as an HTML list of terms; empty without any."""
    items = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(raise_exponents(text))}</dd></div>" for name, text in rows)
    return f"<dl>{items}</dl>" if items else ""


def raise_exponents(text: str) -> str:
    """Return a text with raised exponents of units."""
    return text.replace("^2", "²").replace("^3", "³")


def _embed_json(data: dict[str, Any]) -> str:
    """Return data as JSON that may stand in a script element: no text in it can end the element."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


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
        f"<p>{escape(read_caption(run.scene))}</p>"
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

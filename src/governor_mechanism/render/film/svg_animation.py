"""Animated SVG of a film, for browsers and images (SMIL): the static frame, and outlines that move, turn or change over it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from io import StringIO
from itertools import accumulate, groupby
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.text import Text

from governor_mechanism.model.results.pictures import FilmOptionError
from governor_mechanism.render.film.frame_canvas import FRAME_DPI, FrameCanvas
from governor_mechanism.render.film.moving_parts import CachedNumber, CurvePanel, ShapePanel
from governor_mechanism.render.geometry.primitives import Lines, Vec2
from governor_mechanism.render.geometry.recording import RecordedShape, record_parts
from governor_mechanism.types import BoolArray, FloatArray

MAX_FILE_SIZE = 2_000_000
"""Largest file, bytes: a larger one plays haltingly, and a GIF is smaller."""
TOLERANCE = 0.3
"""Largest distance of an outline from its place, in points: below a third of a pixel."""
NUMBERS_PER_SECOND = 5.0
"""Changes of a number, 1/s: faster ones cannot be read."""
_POINTS_PER_PIXEL = 72.0 / FRAME_DPI


def write_animation(
    path: FilePath,
    canvas: FrameCanvas,
    duration: float,  # duration of the film, s
    n_frames: int,  # number of its frames, at equal times from the start to the end
) -> None:
    """Write the frames of a canvas as an animated drawing that repeats."""
    writer = _Writer(canvas, duration, n_frames)
    width, height = (round(float(inches) * FRAME_DPI) for inches in canvas.figure.get_size_inches())
    background = re.sub(r'width="[^"]*pt" height="[^"]*pt"', f'width="{width}" height="{height}"', _draw_background(canvas), count=1)
    elements = "\n".join(writer.elements())
    text = background.replace("</svg>", f"<g>\n{elements}\n</g>\n</svg>")
    if len(text) > MAX_FILE_SIZE:
        raise FilmOptionError(
            "too much moves for an animated drawing: it would have {found:.1f} MB, and the largest allowed is {most:g} MB; "
            "show less by {start} and {stop}, or a {layout} without plots, or {use_gif}",
            found=len(text) / 1e6,
            most=MAX_FILE_SIZE / 1e6,
        )
    path.write_text(text, encoding="utf-8")


def _draw_background(canvas: FrameCanvas) -> str:
    """Return what does not move as SVG in points, with words as outlines."""
    hidden: list[Any] = [moving.artist for panel in canvas.panels for moving in panel.artists if not isinstance(moving.artist, Text)]
    hidden += [counter.artist for counter in canvas.counters]
    for artist in hidden:
        artist.set_visible(False)
    file = StringIO()
    # The salt gives equal drawings equal names of their parts, and so equal files.
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "film"}):
        canvas.figure.savefig(file, format="svg", facecolor=canvas.figure.get_facecolor(), metadata={"Date": None, "Creator": None})
    for artist in hidden:
        artist.set_visible(True)
    return re.sub(r"(?s)^.*?(?=<svg)|<metadata>.*?</metadata>|<!--.*?-->", "", file.getvalue())


class _Writer:
    """Elements of all that moves; positions in points, y down."""

    def __init__(self, canvas: FrameCanvas, duration: float, n_frames: int) -> None:
        self._canvas = canvas
        self._n_frames = n_frames
        self._duration = duration
        self._height = float(canvas.figure.get_size_inches()[1]) * 72
        self._timing = f'dur="{duration:g}s" repeatCount="indefinite"'

    def elements(self) -> Iterator[str]:
        """Yield the elements, back to front."""
        for number, panel in enumerate(self._canvas.panels):
            if isinstance(panel, CurvePanel):
                yield from self._curves(panel, f"passed{number}")
                continue
            if isinstance(panel, ShapePanel):
                yield from self._drawing(panel)
        for counter in self._canvas.counters:
            yield from self._number(counter)

    def _place(self, artist: Any, vertices: FloatArray) -> FloatArray:
        """Return vertices (n, 2) of an artist in points."""
        pixels = artist.get_transform().transform(vertices) if len(vertices) else np.empty((0, 2))
        return np.column_stack([pixels[:, 0] * _POINTS_PER_PIXEL, self._height - pixels[:, 1] * _POINTS_PER_PIXEL])

    def _drawing(self, panel: ShapePanel) -> Iterator[str]:
        """Yield the shapes of a drawing; what moves as a whole is a group that moves and turns."""
        artists = [moving.artist for moving in panel.artists]
        styles = {(group[0].role, isinstance(group[0], Lines)): artist for group, artist in zip(panel.groups, artists, strict=True)}
        drawn = next((artist for artist in artists if not isinstance(artist, Text)), None)
        if drawn is None:
            return
        (x, y), (unit_x, _) = self._place(drawn, np.array([[0.0, 0.0], [1.0, 0.0]])).tolist()
        scale = unit_x - x
        recorded = (_with_axes(shape, TOLERANCE / scale) for shape in record_parts(panel.parts, range(self._n_frames)))
        for _, group in groupby(recorded, key=lambda shape: id(shape.poses)):
            shapes = list(group)
            poses = shapes[0].poses
            if poses is None:
                yield "".join(self._styled(shapes, styles, (x, y), scale))
                continue
            reach = scale * max(float(np.hypot(shape.points[..., 0], shape.points[..., 1]).max(initial=0.0)) for shape in shapes)
            places = np.column_stack([x + scale * poses[:, 0], y - scale * poses[:, 1]])
            yield self._moving(places, -poses[:, 2], reach, "".join(self._styled(shapes, styles, (0.0, 0.0), scale)))

    def _styled(self, shapes: Sequence[RecordedShape], styles: dict[tuple[str, bool], Any], origin: Vec2, scale: float) -> Iterator[str]:
        """Yield shapes in axes with an origin and a scale, in points; neighbours of one style share it."""
        for (role, is_line), group in groupby(shapes, key=lambda shape: (shape.role, shape.kind == "lines")):
            outlines = "".join(self._outline(shape, origin, scale) for shape in group if shape.kind != "text")
            yield f"<g {_style(styles[role, is_line])}>{outlines}</g>" if outlines else ""

    def _outline(self, shape: RecordedShape, origin: Vec2, scale: float) -> str:
        """Return a shape in axes with an origin and a scale, in points."""
        if shape.changing:
            straighten = _straighten if shape.kind == "lines" else np.asarray
            scaled = ([straighten(_scaled(line, origin, scale)) for line in lines] for lines in shape.changing)
            return self._changing([" ".join(map(_describe_path, lines)) for lines in scaled])
        points = _scaled(shape.points, origin, scale)
        visibility = "" if shape.visible.all() else self._visibility(shape.visible)
        if shape.kind == "circle":
            x, y = points[0, 0].tolist()
            circle = f'cx="{x:.1f}" cy="{y:.1f}" r="{scale * float(shape.radii.max()):.2f}"'
            return f"<circle {circle}>{visibility}</circle>" if visibility else f"<circle {circle}/>"
        data = _describe_shape(points[0], shape)
        if float(np.abs(points - points[0]).max()) > TOLERANCE:
            keys = key_frames(points.reshape(len(points), -1))
            values = ";".join(_describe_shape(points[k], shape) for k in keys)
            visibility += f'<animate attributeName="d" values="{values}" {self._times(keys)}/>'
        return f'<path d="{data}">{visibility}</path>' if visibility else f'<path d="{data}"/>'

    def _moving(self, places: FloatArray, angles: FloatArray, reach: float, elements: str) -> str:
        """Return elements in axes with places (f, 2), in points, and clockwise angles (f,), rad; they reach so far from the origin."""
        degrees = np.degrees(angles)
        if reach * float(np.ptp(angles)) > TOLERANCE:
            keys = key_frames(reach * angles[:, None])
            values = ";".join(f"{angle:.1f}" for angle in degrees[keys].tolist())
            turn = f'<animateTransform attributeName="transform" type="rotate" values="{values}" {self._times(keys)}/>'
            elements = f"<g>{turn}{elements}</g>"
        elif abs(float(angles[0])) * reach > TOLERANCE:
            elements = f'<g transform="rotate({degrees[0]:.1f})">{elements}</g>'
        move, (x, y) = "", places[0].tolist()
        if float(np.abs(places - places[0]).max()) > TOLERANCE:
            keys = key_frames(places)
            values = ";".join(f"{a:.1f} {b:.1f}" for a, b in places[keys].tolist())
            move = f'<animateTransform attributeName="transform" type="translate" values="{values}" {self._times(keys)}/>'
        return f'<g transform="translate({x:.1f} {y:.1f})">{move}{elements}</g>'

    def _changing(self, texts: Sequence[str]) -> str:
        """Return outlines whose number of points changes from frame to frame: one after the other."""
        groups = [next(group) for _, group in groupby(range(len(texts)), key=texts.__getitem__)]
        values = ";".join(texts[k] or "M0 0" for k in groups)
        animation = f'<animate attributeName="d" calcMode="discrete" values="{values}" {self._discrete_times(groups)}/>'
        return f'<path d="{texts[0]}">{animation}</path>'

    def _visibility(self, visible: BoolArray) -> str:
        """Return the animation of what is visible (f,) in some frames only."""
        groups = [next(group) for _, group in groupby(range(len(visible)), key=visible.__getitem__)]
        values = ";".join("visible" if visible[k] else "hidden" for k in groups)
        return f'<animate attributeName="visibility" calcMode="discrete" values="{values}" {self._discrete_times(groups)}/>'

    def _discrete_times(self, frames: Sequence[int]) -> str:
        """Return the attributes that show each of some frames from half a step before it on."""
        times = ";".join(f"{max((k - 0.5) / (self._n_frames - 1), 0.0):.4f}".rstrip("0").rstrip(".") for k in frames)
        return f'keyTimes="{times}" {self._timing}'

    def _curves(self, panel: CurvePanel, name: str) -> Iterator[str]:
        """Yield curves that are revealed from left to right, and their dots."""
        line: Any = panel.artists[0].artist
        (left, bottom), (right, top) = line.axes.bbox.get_points() * _POINTS_PER_PIXEL
        box = f'x="{left:.1f}" y="{self._height - top - 9:.1f}" height="{top - bottom + 18:.1f}"'
        reveal = f'<animate attributeName="width" values="0;{right - left:.1f}" {self._timing}/>'
        yield f'<clipPath id="{name}"><rect {box} width="0">{reveal}</rect></clipPath>'
        for position, points in enumerate(panel.curves):
            curve, dot = (moving.artist for moving in panel.artists[2 * position : 2 * position + 2])
            data = _describe_path(_straighten(self._place(curve, points)))
            yield f'<path clip-path="url(#{name})" {_style(curve)} d="{data}"/>'
            ends = [panel.paths_at(k)[2 * position + 1] for k in range(self._n_frames)]
            if all(end is not None and len(np.asarray(end.vertices)) for end in ends):
                track = self._place(dot, np.array([np.asarray(end.vertices)[0] for end in ends if end is not None]))
                yield self._dot(dot, track)

    def _dot(self, dot: Any, track: FloatArray) -> str:
        """Return a dot that follows a track (f, 2)."""
        keys = key_frames(track)
        animations = "".join(
            f'<animate attributeName="{name}" values="{";".join(f"{value:.1f}" for value in column[keys].tolist())}" {self._times(keys)}/>'
            for name, column in zip(("cx", "cy"), track.T, strict=True)
        )
        colours = f'fill="{to_hex(dot.get_markerfacecolor())}" stroke="{to_hex(dot.get_markeredgecolor())}"'
        x, y = track[0].tolist()
        radius, width = dot.get_markersize() / 2, dot.get_markeredgewidth()
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.2f}" {colours} stroke-width="{width:.2f}">{animations}</circle>'

    def _number(self, counter: CachedNumber) -> Iterator[str]:
        """Yield a number: one text for each value that is shown."""
        text = counter.artist
        x, y = self._place(text, np.array([text.get_position()]))[0].tolist()
        size = float(text.get_fontsize())
        family = f'font-family="DejaVu Sans, Verdana, sans-serif" font-size="{size:.1f}" font-weight="{text.get_fontweight()}"'
        yield f'<g {family} fill="{to_hex(text.get_color())}" text-anchor="end">'
        step = max(round((self._n_frames - 1) / max(self._duration * NUMBERS_PER_SECOND, 1.0)), 1)
        # A third of the height below the middle is the base line of digits.
        place = f'x="{x:.1f}" y="{y + 0.36 * size:.1f}"'
        shown = [next(group) for _, group in groupby(range(0, self._n_frames, step), key=counter.texts.__getitem__)]
        for k, following in zip(shown, [*shown[1:], self._n_frames], strict=True):
            begin, end = (min(frame / self._n_frames, 1.0) for frame in (k, following))
            # Between its first and last moment it is visible.
            states = [*([] if k == 0 else [("hidden", 0.0)]), ("visible", begin), *([] if end >= 1.0 else [("hidden", end)])]
            values = ";".join(state for state, _ in states)
            times = ";".join(f"{time:.4f}" for _, time in states)
            animation = f'<animate attributeName="visibility" calcMode="discrete" values="{values}" keyTimes="{times}" {self._timing}/>'
            animation = animation if len(states) > 1 else ""
            hidden = "" if k == 0 else ' visibility="hidden"'
            yield f"<text {place}{hidden}>{escape(counter.texts[k])}{animation}</text>"
        yield "</g>"

    def _times(self, keys: Sequence[int]) -> str:
        """Return the attributes that say when the values of key frames hold."""
        times = ";".join(f"{k / (self._n_frames - 1):.4f}".rstrip("0").rstrip(".") for k in keys)
        return f'keyTimes="{times}" {self._timing}'


def _with_axes(shape: RecordedShape, tolerance: float) -> RecordedShape:
    """Return a shape with axes of its own if it is a circle whose place in its axes changes by more than a tolerance (m)."""
    if shape.kind != "circle" or not float(np.abs(shape.points - shape.points[:1]).max(initial=0.0)) > tolerance:
        return shape
    return replace(shape, poses=np.pad(shape.placed_points()[:, 0], ((0, 0), (0, 1))), points=np.zeros((1, 1, 2)))


def _scaled(points: FloatArray, origin: Vec2, scale: float) -> FloatArray:
    """Return points (..., 2) of a drawing in axes with an origin and a scale, in points, y down."""
    scaled: FloatArray = origin + points * (scale, -scale)
    return scaled


def _describe_shape(points: FloatArray, shape: RecordedShape) -> str:
    """Return an outline (n, 2) as the data of an SVG path."""
    if shape.kind == "polygon":
        return _describe_path(points) + "Z"
    ends = accumulate(shape.outline)
    return " ".join(_describe_path(points[end - length : end]) for end, length in zip(ends, shape.outline, strict=True) if length)


def _describe_path(points: FloatArray) -> str:
    """Return a line (n, 2) as the data of an SVG path, with one decimal."""
    places = [f"{x:g} {y:g}" for x, y in (np.round(points, 1) + 0.0).tolist()]
    return f"M{places[0]}L{' '.join(places[1:])}" if len(places) > 1 else f"M{places[0]}" if places else ""


def key_frames(track: FloatArray) -> list[int]:
    """Return the frames between which a track (f, m), in points, is straight within the tolerance."""
    kept, pending = {0, len(track) - 1}, [(0, len(track) - 1)]
    while pending:
        first, last = pending.pop()
        if last - first < 2:
            continue
        share = (np.arange(first + 1, last) - first)[:, None] / (last - first)
        straight = track[first] + share * (track[last] - track[first])
        distances = np.abs(track[first + 1 : last] - straight).max(axis=1)
        worst = int(distances.argmax())
        if distances[worst] > TOLERANCE:
            middle = first + 1 + worst
            kept.add(middle)
            pending += [(first, middle), (middle, last)]
    return sorted(kept)


def _straighten(points: FloatArray) -> FloatArray:
    """Return the points (n, 2) that suffice for a line."""
    return points[key_points(points)] if len(points) > 2 else points


def key_points(points: FloatArray) -> list[int]:
    """Return which points (n, 2) of a line suffice: all others lie on the lines between these within the tolerance."""
    kept, pending = {0, len(points) - 1}, [(0, len(points) - 1)]
    while pending:
        first, last = pending.pop()
        if last - first < 2:
            continue
        chord = points[last] - points[first]
        offsets = points[first + 1 : last] - points[first]
        squared = float(chord @ chord)
        shares = np.clip(offsets @ chord / squared, 0.0, 1.0) if squared else np.zeros(len(offsets))
        distances = np.hypot(*(offsets - shares[:, None] * chord).T)
        worst = int(distances.argmax())
        if distances[worst] > TOLERANCE:
            middle = first + 1 + worst
            kept.add(middle)
            pending += [(first, middle), (middle, last)]
    return sorted(kept)


def _style(artist: Any) -> str:
    """Return the attributes of the colours and lines of an artist."""
    if isinstance(artist, Line2D):
        dashes = [length for length in artist._unscaled_dash_pattern[1] or ()]  # type: ignore[attr-defined]
        scaled = " ".join(f"{length * artist.get_linewidth():.2f}" for length in dashes)
        dash = f' stroke-dasharray="{scaled}"' if scaled else ""
        return f'fill="none" stroke="{to_hex(artist.get_color())}" stroke-width="{artist.get_linewidth():.2f}"{dash}'
    paints = " ".join(_paint(name, colour) for name, colour in (("fill", artist.get_facecolor()), ("stroke", artist.get_edgecolor())))
    return f'{paints} stroke-width="{artist.get_linewidth():.2f}" stroke-linejoin="round"'


def _paint(name: str, colour: tuple[float, float, float, float]) -> str:
    """Return the attributes of a colour, "fill" or "stroke", with its opacity."""
    opacity = float(colour[3])
    if opacity == 0.0:
        return f'{name}="none"'
    return f'{name}="{to_hex(colour)}"' + ("" if opacity == 1.0 else f' {name}-opacity="{opacity:g}"')

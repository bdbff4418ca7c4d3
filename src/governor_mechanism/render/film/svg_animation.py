"""Animated SVG of a film: the static frame as matplotlib draws it, and over it outlines that move, turn or change along key frames.

One file without scripts, which browsers also play as an image of a page (SMIL).
"""

import re
from collections.abc import Iterator, Sequence
from html import escape
from io import StringIO
from itertools import groupby
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.text import Text

from governor_mechanism.model.results.film_options import FilmOptionError
from governor_mechanism.render.film.frame_canvas import FRAME_DPI, FrameCanvas
from governor_mechanism.render.film.moving_parts import CachedNumber, CurvePanel
from governor_mechanism.render.film.svg_tracks import TOLERANCE, describe_path, find_rigid_motion, key_frames, split_path
from governor_mechanism.types import FloatArray

MAX_FILE_SIZE = 2_000_000
"""Largest file, bytes: a larger one plays haltingly, and a GIF is smaller."""
NUMBERS_PER_SECOND = 5.0
"""Changes of a number, 1/s: faster ones cannot be read."""
_POINTS_PER_PIXEL = 72.0 / FRAME_DPI


def write_animation(path: FilePath, canvas: FrameCanvas, duration: float, n_frames: int) -> None:
    """Write the frames of a canvas as an animated drawing that repeats.

    Parameters
    ----------
    path
        The file.
    canvas
        The canvas of one run.
    duration
        Duration of the film, s.
    n_frames
        Number of its frames, at equal times from the start to the end.

    Raises
    ------
    MechanismError
        If so much moves that the file would be too large.
    """
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
        self._canvas, self._n_frames, self._duration = canvas, n_frames, duration
        self._height = float(canvas.figure.get_size_inches()[1]) * 72
        self._timing = f'dur="{duration:g}s" repeatCount="indefinite"'

    def elements(self) -> Iterator[str]:
        """Yield the elements, back to front."""
        for number, panel in enumerate(self._canvas.panels):
            if isinstance(panel, CurvePanel):
                yield from self._curves(panel, f"passed{number}")
                continue
            frames = [panel.paths_at(k) for k in range(self._n_frames)]
            for position, moving in enumerate(panel.artists):
                paths = [frame[position] for frame in frames]
                if not isinstance(moving.artist, Text):
                    yield from self._outlines(moving.artist, [path for path in paths if path is not None])
        for counter in self._canvas.counters:
            yield from self._number(counter)

    def _place(self, artist: Any, vertices: FloatArray) -> FloatArray:
        """Return vertices (n, 2) of an artist in points."""
        pixels = artist.get_transform().transform(vertices) if len(vertices) else np.empty((0, 2))
        return np.column_stack([pixels[:, 0] * _POINTS_PER_PIXEL, self._height - pixels[:, 1] * _POINTS_PER_PIXEL])

    def _outlines(self, artist: Any, paths: Sequence[Path]) -> Iterator[str]:
        """Yield the outlines of an artist, in one group with its colours."""
        parts = [list(split_path(path)) for path in paths]
        counts = {tuple(len(np.asarray(one.vertices)) for one in part) for part in parts}
        yield f"<g {_style(artist)}>"
        if len(counts) == 1:
            for k in range(len(parts[0])):
                frames = np.array([self._place(artist, np.asarray(part[k].vertices)) for part in parts])
                yield self._moving(frames, parts[0][k].codes)
        else:
            yield self._changing([[(self._place(artist, np.asarray(one.vertices)), one.codes) for one in part] for part in parts])
        yield "</g>"

    def _moving(self, frames: FloatArray, codes: Any) -> str:
        """Return an outline with points (f, n, 2)."""
        data = describe_path(frames[0], codes)
        if float(np.abs(frames - frames[0]).max()) <= TOLERANCE:
            return f'<path d="{data}"/>'
        rigid = find_rigid_motion(frames)
        if rigid is None:
            keys = key_frames(frames.reshape(len(frames), -1))
            values = ";".join(describe_path(frames[k], codes) for k in keys)
            return f'<path d="{data}"><animate attributeName="d" values="{values}" {self._times(keys)}/></path>'
        radius = float(np.hypot(*rigid.outline.T).max())
        turned = np.radians(rigid.angles)[:, None] * radius
        has_turned = bool(np.ptp(turned) > TOLERANCE)
        keys = key_frames(np.column_stack([rigid.centres, turned]))
        shape = f'<path d="{describe_path(rigid.outline, codes)}">{self._turn(rigid.angles, keys) if has_turned else ""}</path>'
        x, y = rigid.centres[0].tolist()
        places = ";".join(f"{a:.1f} {b:.1f}" for a, b in rigid.centres[keys].tolist())
        move = f'<animateTransform attributeName="transform" type="translate" values="{places}" {self._times(keys)}/>'
        return f'<g transform="translate({x:.1f} {y:.1f})">{move}{shape}</g>'

    def _turn(self, angles: FloatArray, keys: list[int]) -> str:
        values = ";".join(f"{angle:.1f}" for angle in angles[keys].tolist())
        return f'<animateTransform attributeName="transform" type="rotate" values="{values}" {self._times(keys)}/>'

    def _changing(self, frames: Sequence[Sequence[tuple[FloatArray, Any]]]) -> str:
        """Return outlines whose number of points changes from frame to frame: one after the other."""
        texts = [
            " ".join(describe_path(_straighten(points) if codes is None else points, codes) for points, codes in one) for one in frames
        ]
        groups = [next(group) for _, group in groupby(range(len(texts)), key=texts.__getitem__)]
        # Each is shown from half a step before its frame on.
        times = ";".join(f"{max((k - 0.5) / (len(texts) - 1), 0.0):.4f}".rstrip("0").rstrip(".") for k in groups)
        values = ";".join(texts[k] or "M0 0" for k in groups)
        animation = f'<animate attributeName="d" calcMode="discrete" values="{values}" keyTimes="{times}" {self._timing}/>'
        return f'<path d="{texts[0]}">{animation}</path>'

    def _curves(self, panel: CurvePanel, name: str) -> Iterator[str]:
        """Yield curves that are revealed from left to right, and their dots."""
        line: Any = panel.artists[0].artist
        (left, bottom), (right, top) = line.axes.bbox.get_points() * _POINTS_PER_PIXEL
        box = f'x="{left:.1f}" y="{self._height - top - 9:.1f}" height="{top - bottom + 18:.1f}"'
        reveal = f'<animate attributeName="width" values="0;{right - left:.1f}" {self._timing}/>'
        yield f'<clipPath id="{name}"><rect {box} width="0">{reveal}</rect></clipPath>'
        for position, points in enumerate(panel.curves):
            curve, dot = (moving.artist for moving in panel.artists[2 * position : 2 * position + 2])
            data = describe_path(_straighten(self._place(curve, points)), None)
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
            values, times = ";".join(state for state, _ in states), ";".join(f"{time:.4f}" for _, time in states)
            animation = f'<animate attributeName="visibility" calcMode="discrete" values="{values}" keyTimes="{times}" {self._timing}/>'
            animation = animation if len(states) > 1 else ""
            hidden = "" if k == 0 else ' visibility="hidden"'
            yield f"<text {place}{hidden}>{escape(counter.texts[k])}{animation}</text>"
        yield "</g>"

    def _times(self, keys: Sequence[int]) -> str:
        """Return the attributes that say when the values of key frames hold."""
        times = ";".join(f"{k / (self._n_frames - 1):.4f}".rstrip("0").rstrip(".") for k in keys)
        return f'keyTimes="{times}" {self._timing}'


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
        chord, offsets = points[last] - points[first], points[first + 1 : last] - points[first]
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
    fill = "none" if artist.get_facecolor()[3] == 0.0 else to_hex(artist.get_facecolor())
    return f'fill="{fill}" stroke="{to_hex(artist.get_edgecolor())}" stroke-width="{artist.get_linewidth():.2f}" stroke-linejoin="round"'

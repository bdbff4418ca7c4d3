"""Moving parts of a frame: panels of artists, plots of readings, and numbers whose characters are drawn once and then copied."""

import math
import string
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.patches import Polygon as PolygonPatch
from matplotlib.path import Path
from matplotlib.text import Text

from governor_mechanism.render.artists import artist_paths, group_shapes, path_of, path_points
from governor_mechanism.render.figures.page import plain_labels
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Frame, own_shapes, shapes_of
from governor_mechanism.render.geometry.primitives import SMALL_TEXT, DrawnShape, PoseTuple, Vec2
from governor_mechanism.render.plot_panels import PanelCurve, PlotPanel
from governor_mechanism.render.range_bands import RangeBand
from governor_mechanism.render.shown_readings import choose_ticks
from governor_mechanism.render.style import MUTED, PAPER, RULE, parse_rgb
from governor_mechanism.types import FloatArray

DrawCall = Callable[[Path], None]
"""One call of a renderer, with any path."""


class MovingArtist:
    """A line, a patch or a text; what it draws besides its path stays the same.

    Parameters
    ----------
    artist
        Line or patch with affine transforms, or any artist that does not change.
    """

    def __init__(self, artist: Artist) -> None:
        self.artist = artist
        self._draw_calls: list[DrawCall] = []

    def move(self, path: Path | None) -> None:
        """Set the path of the artist; None for an artist without one."""
        if isinstance(self.artist, PathPatch) and path is not None:
            self.artist.set_path(path)
        elif isinstance(self.artist, Line2D) and path is not None:
            self.artist.set_data(*np.asarray(path.vertices).T)

    def draw(self, renderer: Any, path: Path | None) -> None:
        """Draw the artist with a path."""
        if path is None or not self._draw_calls:
            self.move(path)
            self._draw_calls = []
            recorder: Any = _RecordingRenderer(renderer, self._draw_calls)
            self.artist.draw(recorder)
        else:
            for draw_call in self._draw_calls:
                draw_call(path)


class _RecordingRenderer:
    """Hands everything on to a renderer, and keeps the calls that draw a path."""

    def __init__(self, renderer: Any, draw_calls: list[DrawCall]) -> None:
        self._renderer, self._draw_calls = renderer, draw_calls

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the renderer."""
        return getattr(self._renderer, name)

    def draw_path(self, context: Any, path: Path, transform: Any, face: Any = None) -> None:
        """Draw a path, and keep the call."""
        self._record(lambda one: self._renderer.draw_path(context, one, transform, face), path)

    def draw_markers(self, context: Any, marker: Path, marker_transform: Any, path: Path, transform: Any, face: Any = None) -> None:
        """Draw a marker at each point of a path, and keep the call."""
        self._record(lambda one: self._renderer.draw_markers(context, marker, marker_transform, one, transform, face), path)

    def _record(self, draw_call: DrawCall, path: Path) -> None:
        draw_call(path)
        self._draw_calls.append(draw_call)


@dataclass(frozen=True)
class Panel:
    """The moving artists on one pair of axes, and their paths at frame k; None for an artist that has none."""

    artists: Sequence[MovingArtist]
    paths_at: Callable[[int], Sequence[Path | None]]

    def update(self, k: int) -> None:
        """Move the artists to frame k."""
        for artist, path in zip(self.artists, self.paths_at(k), strict=True):
            artist.move(path)

    def draw(self, renderer: Any, k: int) -> None:
        """Draw frame k."""
        for artist, path in zip(self.artists, self.paths_at(k), strict=True):
            artist.draw(renderer, path)


class PartPaths:
    """Paths (m) of the artists of parts of a drawing at frame k, one for each group of shapes.

    Most shapes keep their form: their points are moved all at once, in place, and their paths are good until the next call.
    """

    def __init__(self, parts: Sequence[DrawnPart]) -> None:
        self._parts = parts
        owned = [(number, shape) for number, part in enumerate(parts) for shape in own_shapes(part, 0)]
        numbers = iter([number for number, _ in owned])
        self._paths: list[Path | None] = []
        points = [np.empty((0, 2))]
        owners = [np.empty(0, dtype=np.intp)]
        group_numbers = list[int]()
        rigid: list[int] = []
        for group in group_shapes([shape for _, shape in owned]):
            own = [next(numbers) for _ in group]
            (path,) = artist_paths(group)
            keeps_form = path is not None and all(isinstance(parts[number], Attached) for number in own)
            group_numbers += [-1 if keeps_form else len(self._paths)] * len(group)
            if keeps_form and path is not None:
                rigid.append(len(self._paths))
                points.append(np.asarray(path.vertices))
                counts = [len(np.asarray(one.vertices)) for shape in group for one in artist_paths([shape]) if one is not None]
                owners.append(np.repeat(own, counts))
            self._paths.append(path)
        self._points, self._owners = np.concatenate(points), np.concatenate(owners)  # in the axes of the parts, and the numbers of these
        self._placed = self._points.copy()
        for position, (start, end) in zip(rigid, pairwise(accumulate(map(len, points))), strict=True):
            former = self._paths[position]
            self._paths[position] = Path(self._placed[start:end], None if former is None else former.codes)
        # What changes its form, and shares an artist with it.
        changing = {number for (number, _), group in zip(owned, group_numbers, strict=True) if group >= 0}
        self._changing_parts = [parts[number] for number in sorted(changing)]
        self._changing_groups = [group for (number, _), group in zip(owned, group_numbers, strict=True) if number in changing]

    def __call__(self, k: int) -> Sequence[Path | None]:
        """Return the paths at frame k."""
        x0, y0, angle = self._axes_at(k).T
        cosines, sines = (np.cos(angle), np.sin(angle))
        x, y = self._points.T
        owners = self._owners
        self._placed[:, 0] = x0[owners] + cosines[owners] * x - sines[owners] * y
        self._placed[:, 1] = y0[owners] + sines[owners] * x + cosines[owners] * y
        changed: dict[int, list[DrawnShape]] = {}
        for group, shape in zip(self._changing_groups, shapes_of(self._changing_parts, k), strict=True):
            changed.setdefault(group, []).append(shape)
        for group, shapes in changed.items():
            former = self._paths[group] if group >= 0 else None
            if former is None:
                continue
            points = path_points(shapes)
            vertices = np.asarray(former.vertices)
            if len(points) == len(vertices):
                vertices[:] = points  # faster than a new path
            else:
                self._paths[group] = path_of(shapes)
        return self._paths

    def _axes_at(self, k: int) -> FloatArray:
        """Return the axes (n, 3) of the parts at frame k; of one that is not shown they are nowhere."""
        poses: dict[Frame, PoseTuple] = {}
        rows = []
        for part in self._parts:
            if part.frame not in poses:
                poses[part.frame] = part.frame(k)
            rows.append(poses[part.frame] if isinstance(part, Flexible) or part.is_shown(k) else _NOWHERE)
        return np.array(rows, dtype=float).reshape(-1, 3)


_NOWHERE: PoseTuple = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class ShapePanel(Panel):
    """A panel of a drawing with some parts, whose moments are the numbers of the frames; `groups` are the shapes of its artists."""

    parts: Sequence[DrawnPart]
    groups: Sequence[Sequence[DrawnShape]]


@dataclass(frozen=True)
class SortedPanel(ShapePanel):
    """A panel whose artists are drawn in another order at every frame, the furthest first."""

    order_at: Callable[[int], Sequence[int]]

    def draw(self, renderer: Any, k: int) -> None:
        """Draw frame k."""
        paths = self.paths_at(k)
        for number in self.order_at(k):
            self.artists[number].draw(renderer, paths[number])


@dataclass(frozen=True)
class CurvePanel(Panel):
    """A plot whose artists are a line and a dot for each of its `curves`, points (n, 2) in data units.

    The line ends at the dot, or for a curve that has one of the `bands`, is its mean.
    """

    curves: Sequence[FloatArray]
    bands: Sequence[RangeBand]


def _style_axes(axes: Axes, time_span: Vec2, points_per_pixel: float) -> None:
    """Style the axes: thin spines, faint grid lines."""
    axes.spines[:].set_linewidth(0.8 * points_per_pixel)
    axes.set_xticks(time_span, labels=[f"{time_span[0]:.4g}", f"{time_span[1]:.4g} s"])
    pixel = points_per_pixel
    axes.tick_params(length=3 * pixel, width=0.8 * pixel, pad=2 * pixel, labelsize=SMALL_TEXT * pixel)
    axes.grid(axis="y", color=RULE, linewidth=0.7 * points_per_pixel)
    axes.set_axisbelow(True)
    # The time labels stay within the width of the plot, so that they never leave the frame.
    first, last = axes.get_xticklabels()
    first.set_horizontalalignment("left")
    last.set_horizontalalignment("right")


def plot_panel(axes: Axes, panel: PlotPanel, frame_data: FrameData, points_per_pixel: float, *, has_time_labels: bool) -> CurvePanel:
    """Return the moving artists of a panel, its first curve in front, with all points up to frame k.

    The whole curves are pale behind, so that also the first frame shows them. A curve whose oscillations are too narrow to be resolved is
    a pale band with its mean, if the panel may have bands. Only the lowest of several plots on a common time axis has time labels.
    """
    start, end = frame_data.time_span
    axes.set_xlim(start, max(end, start + 1e-9))
    axes.set_ylim(*panel.limits)
    ticks = choose_ticks(panel.limits)
    axes.set_yticks(ticks, labels=plain_labels(ticks, panel.limits))
    _style_axes(axes, frame_data.time_span, points_per_pixel)
    if not has_time_labels:
        axes.set_xticklabels([])
    for mark in panel.marks:
        axes.axvline(mark, color=MUTED, linewidth=0.8 * points_per_pixel, dashes=(3.0, 2.0), zorder=1)
    width = CURVE_WIDTH * points_per_pixel
    artists = []
    tracks = []
    bands = []
    of_curves = panel.find_bands(axes.bbox.width, axes.bbox.height, width * float(axes.figure.dpi) / 72)
    for curve, band in reversed(list(zip(panel.curves, of_curves, strict=True))):
        samples: FloatArray = np.column_stack([curve.times, curve.values])
        if band is not None:
            _add_band(axes, band, curve)
            bands.append(band)
            if curve.has_own_mean:
                continue
        points = _thin_out(samples) if band is None else np.column_stack([band.mean_times, band.means])
        axes.add_line(Line2D(*points.T, color=pale_colour(curve.colour), linewidth=width, solid_joinstyle="round", zorder=2.5))
        line = Line2D([], [], color=curve.colour, linewidth=width, solid_joinstyle="round", zorder=3)
        dot = Line2D([], [], color=curve.colour, marker="o", markersize=5 * points_per_pixel, clip_on=False, zorder=4)
        dot.set(markeredgecolor=PAPER, markeredgewidth=0.8 * points_per_pixel)
        artists += [MovingArtist(axes.add_line(one)) for one in (line, dot)]
        tracks.append(_Track(points=points, dots=samples[:0] if curve.has_own_mean else samples))

    def paths_at(k: int) -> list[Path | None]:
        return [Path(points) for track in tracks for points in track.points_at(float(frame_data.times[k]))]

    return CurvePanel(artists, paths_at, [track.points for track in tracks], bands)


@dataclass(frozen=True, kw_only=True)
class _Track:
    """Points (n, 2) of a line that grows with time, and those (m, 2) of its dot, which need not lie on it."""

    points: FloatArray
    dots: FloatArray

    def points_at(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Return the points of the line and of the dot at a time, s."""
        before = self.points[: int(np.searchsorted(self.points[:, 0], time))]
        is_within = [len(one) > 0 and bool(one[0, 0] <= time <= one[-1, 0]) for one in (self.points, self.dots)]
        end, dot = (
            np.array([[time, np.interp(time, *one.T)]]) if shown else one[:0]
            for one, shown in zip((self.points, self.dots), is_within, strict=True)
        )
        return np.concatenate([before, end]), dot


def _add_band(axes: Axes, band: RangeBand, curve: PanelCurve) -> None:
    """Fill the band of a curve. That of a curve with a mean of its own has its colour, which is light."""
    outline = np.column_stack([np.concatenate([band.times, band.times[::-1]]), np.concatenate([band.low, band.high[::-1]])])
    colour = curve.colour if curve.has_own_mean else pale_colour(curve.colour)
    axes.add_patch(PolygonPatch(outline, closed=True, facecolor=colour, linewidth=0, zorder=2.4))


CURVE_WIDTH = 1.4
"""Width of a curve, pixels of a 480-pixel frame."""
PALE_SHARE = 0.35
"""Share of its colour in the pale copy of a curve; the rest is paper."""
THIN_COLUMNS = 250
"""Number of columns of a plot of which each keeps its first, lowest, highest and last point: more than a plot has pixels at 480."""


def pale_colour(colour: str) -> str:
    """Return a colour blended with that of the paper."""
    parts = (PALE_SHARE * one + (1.0 - PALE_SHARE) * paper for one, paper in zip(parse_rgb(colour), parse_rgb(PAPER), strict=True))
    return "#" + "".join(f"{round(part):02x}" for part in parts)


def _thin_out(points: FloatArray) -> FloatArray:
    """Return the points (m, 2) that a curve through points (n, 2) needs to look the same."""
    if len(points) <= 4 * THIN_COLUMNS:
        return points
    edges = np.searchsorted(points[:, 0], np.linspace(points[0, 0], points[-1, 0], THIN_COLUMNS + 1))
    edges[-1] = len(points)
    kept = {0, len(points) - 1}
    for first, end in pairwise(edges.tolist()):
        if end > first:
            values = points[first:end, 1]
            kept |= {first, end - 1, first + int(values.argmin()), first + int(values.argmax())}
    return points[sorted(kept)]


_HALF_NUMBER_HEIGHT = 0.6
"""Half height of the pixels of a number relative to its size: all of a digit, and nothing of the descenders in a line above."""


class CachedNumber:
    """Right-aligned text with one value per frame; `update` changes the artist, `blit` only copies pixels after `cache_glyphs`."""

    def __init__(self, artist: Text, texts: Sequence[str]) -> None:
        self.artist = artist
        # A minus sign is as wide as a digit; a hyphen is not.
        self.texts = [text.replace("-", "\N{MINUS SIGN}") for text in texts]
        self._glyphs: dict[str, RgbaPixels] = {}
        self._right_edge = self._top_edge = 0

    def update(self, k: int) -> None:
        """Set the text of frame k."""
        self.artist.set_text(self.texts[k])

    def cache_glyphs(self, canvas: Any) -> None:
        """Store the pixels of every character that occurs; the Agg canvas must show only the static background."""
        text, renderer = self.artist, canvas.get_renderer()
        background = canvas.copy_from_bbox(canvas.figure.bbox)
        buffer = np.asarray(canvas.buffer_rgba())
        position, to_pixels = text.get_position(), text.get_transform()
        right, middle = to_pixels.transform(position)
        half_height = round(_HALF_NUMBER_HEIGHT * float(text.get_fontsize()) * canvas.figure.dpi / 72)
        self._right_edge, self._top_edge = round(right), int(buffer.shape[0] - middle) - half_height
        text.set_horizontalalignment("center")
        longest = max(map(len, self.texts))
        characters = sorted(set("".join(self.texts)))
        digit_width = self._glyph_width("0")  # all digits of a font are as wide
        for character in characters:
            width = digit_width if character in string.digits else self._glyph_width(character)
            # Within the place of the number, where there is nothing else.
            left = self._right_edge - min(3, longest) * width
            text.set(text=character, position=to_pixels.inverted().transform((left + width / 2, middle)))
            canvas.restore_region(background)
            text.draw(renderer)
            rows = slice(self._top_edge, self._top_edge + 2 * half_height)
            self._glyphs[character] = buffer[rows, left : left + width].copy()
        text.set(position=position, horizontalalignment="right")
        canvas.restore_region(background)

    def _glyph_width(self, character: str) -> int:
        """Return the advance of a character in whole pixels, at least the width of its ink."""
        widths = []
        for count in (1, 2):
            self.artist.set_text(count * character)
            widths.append(float(self.artist.get_window_extent().width))
        return max(round(widths[1] - widths[0]), math.ceil(widths[0]))

    def blit(self, pixels: RgbaPixels, k: int) -> None:
        """Copy the text of frame k into a frame (size, size, 4)."""
        right = self._right_edge
        for character in reversed(self.texts[k]):
            patch = self._glyphs[character]
            height, width = patch.shape[:2]
            pixels[self._top_edge : self._top_edge + height, right - width : right] = patch
            right -= width

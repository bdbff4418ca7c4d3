"""The look: colours (Okabe-Ito, distinguishable without colour vision), strokes, and matplotlib artists for shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.text import Text as Words
from numpy.typing import NDArray

from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon, Shape, Text

PAPER, INK, QUIET, RULE = "#fbfaf5", "#20262c", "#6a727a", "#d3d3cb"
BLUE, VERMILLION, GREEN, SKY = "#0072b2", "#d55e00", "#009e73", "#56b4e9"
STEEL, BRIGHT, IRON = "#c3ccd4", "#e9edf0", "#87929c"
GREEN_EDGES = ("#46b897", "#97d5c1")
"""Green thinned by paper: green edges are too few for a palette to be chosen by them."""
SERIES = (BLUE, VERMILLION, GREEN, "#7a3600")
SERIF, SANS = "STIXGeneral", "DejaVu Sans"


@dataclass(frozen=True)
class Style:
    """Fill and stroke of a role; `width` in pixels of a 480-pixel picture."""

    fill: str = "none"
    stroke: str = INK
    width: float = 1.0
    dashes: tuple[float, ...] = ()


STYLES = {
    "axis": Style(stroke=QUIET, width=0.7, dashes=(10.0, 3.0, 2.0, 3.0)),
    "spindle": Style(fill=BRIGHT, width=0.9),
    "spindle shade": Style(stroke=IRON, width=1.2),
    "frame": Style(fill=IRON, width=1.0),
    "bearing": Style(fill=PAPER, width=0.9),
    "hatching": Style(stroke=INK, width=0.6),
    "guide": Style(stroke=QUIET, width=0.9, dashes=(5.0, 3.0)),
    "leader": Style(stroke=RULE, width=0.7),
    "scale": Style(stroke=QUIET, width=0.8),
    "arm": Style(fill=STEEL, width=0.9),
    "link": Style(fill=BRIGHT, width=0.9),
    "ball": Style(fill=BLUE, stroke="#00436a", width=1.2),
    "ball shine": Style(stroke="#7db9dc", width=1.1),
    "sleeve": Style(fill="#eb9a5e", stroke="#7a3600", width=1.0),
    "engraving": Style(stroke="#a8581c", width=0.8),
    "pointer": Style(fill=VERMILLION, stroke=VERMILLION, width=0.3),
    "plate": Style(fill=STEEL, width=0.9),
    "frame plate": Style(fill=BRIGHT, stroke=QUIET, width=0.8),
    "slot": Style(fill=PAPER, width=0.9),
    "wall": Style(width=0.9),
    "block": Style(fill="#eb9a5e", stroke="#7a3600", width=1.0),
    "wheel": Style(fill=STEEL, width=1.0),
    "wheel web": Style(fill=BRIGHT, width=0.6),
    "spoke": Style(stroke=IRON, width=2.0),
    "marked spoke": Style(stroke=BLUE, width=3.0),
    "rack": Style(fill=STEEL, width=1.0),
    "tooth": Style(width=1.0),
    "spring": Style(stroke="#00436a", width=1.5),
    "damper": Style(width=1.4),
    "drum": Style(fill=IRON, width=1.0),
    "eye": Style(fill=INK, width=0.3),
    "tracer": Style(fill=GREEN, stroke=GREEN, width=0.3),
    "force": Style(fill=VERMILLION, stroke=VERMILLION, width=2.2),
    "drive": Style(fill=PAPER, stroke=VERMILLION, width=1.8),
    "pivot": Style(fill=PAPER, width=1.0),
    "rod": Style(fill=STEEL, width=0.9),
    "eyelet": Style(fill=BRIGHT, width=0.9),
    "struck": Style(fill=VERMILLION, width=0.9),
    "lens": Style(fill=PAPER, stroke=QUIET, width=0.8),
    "bracket": Style(fill=BRIGHT, stroke=QUIET, width=0.8),
    "stop": Style(fill=PAPER, width=1.0),
    "stop hatching": Style(width=0.6),
    "seat": Style(fill=IRON, width=0.9),
    "dashpot": Style(fill=BRIGHT, width=1.0),
    "bore": Style(fill=PAPER, stroke=PAPER, width=0.3),
    "oil": Style(fill="#9fcbe6", stroke="#9fcbe6", width=0.3),
    "piston": Style(fill=IRON, width=0.9),
    "piston rod": Style(fill=STEEL, width=0.8),
    "shoe": Style(fill=IRON, width=0.9),
    "held shoe": Style(fill=VERMILLION, stroke="#7a3600", width=0.9),
    "casting": Style(fill=STEEL, width=0.9),
    "casting hatching": Style(stroke=IRON, width=0.5),
    "live steam": Style(fill="#f4bd94", stroke="#f4bd94", width=0.3),
    "expanding steam": Style(fill="#fae3d0", stroke="#fae3d0", width=0.3),
    "spent steam": Style(fill="#d5e8f3", stroke="#d5e8f3", width=0.3),
    "pressed steam": Style(fill="#e4ddd2", stroke="#e4ddd2", width=0.3),
    "bore edge": Style(width=0.9),
    "valve": Style(fill="#7d8fa0", width=1.0),
    "valve cavity": Style(fill="#d5e8f3", width=0.8),
    "rim": Style(width=1.0),
    "division": Style(stroke=QUIET, width=0.5),
    "lap circle": Style(stroke=QUIET, width=0.8),
    "valve circle": Style(width=0.8),
    "crank end curve": Style(stroke=BLUE, width=1.6),
    "head end curve": Style(stroke=VERMILLION, width=1.6),
    "crank end chord": Style(stroke=BLUE, width=4.0),
    "head end chord": Style(stroke=VERMILLION, width=4.0),
    "crank end mark": Style(fill=BLUE, stroke=PAPER, width=0.8),
    "head end mark": Style(fill=VERMILLION, stroke=PAPER, width=0.8),
    "projection": Style(stroke=GREEN, width=0.9, dashes=(4.0, 2.5)),
    "crank web": Style(fill=BRIGHT, width=0.8),
    "eccentric": Style(fill="#eb9a5e", stroke="#7a3600", width=0.8),
    "small rod": Style(stroke=INK, width=1.8),
    "eccentric rod": Style(stroke="#7a3600", width=1.6),
    "burst": Style(stroke=VERMILLION, width=1.6),
    "weight bore": Style(fill="#e9edf0", stroke="#00436a", width=0.9),
    "coil": Style(stroke=STEEL, width=3.0),
    "coil edge": Style(stroke=INK, width=4.6),
    "coil behind": Style(stroke=IRON, width=2.4),
    "trace": Style(stroke="#9fcbe6", width=1.6),
    "ring": Style(stroke=RULE, width=3.0),
    "sweep": Style(stroke=GREEN, width=3.0),
    "plan arm": Style(width=2.0),
    "hand": Style(stroke=GREEN, width=1.0),
    "hub": Style(fill=PAPER, width=0.8),
    "mark": Style(fill=PAPER, stroke=PAPER, width=0.1),
}

COLOURS = tuple(
    dict.fromkeys(
        colour
        for colour in (
            PAPER,
            INK,
            QUIET,
            RULE,
            *SERIES,
            *GREEN_EDGES,
            *(c for s in STYLES.values() for c in (s.fill, s.stroke)),
        )
        if colour != "none"
    )
)


def rgb(colour: str) -> tuple[int, int, int]:
    """'#rrggbb' as three numbers 0..255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


class Brush:
    """Turns shapes into artists on axes that measure in metres, and moves those artists later.

    Circles that follow one another in one role share an artist, and so do lines: drawing an artist costs more than its
    shape. `pixel` is the number of points that a pixel of a 480-pixel picture has.
    """

    def __init__(self, axes: Axes, pixel: float, *, layer: float = 2) -> None:
        self._axes = axes
        self._pixel = pixel
        self._layer = layer

    def paint(self, shapes: Sequence[Shape]) -> list[Artist]:
        """The artists, back to front."""
        artists = [self._artist(group) for group in _groups(shapes)]
        for order, artist in enumerate(artists):
            artist.set_zorder(self._layer + order / 1000)
            self._axes.add_artist(artist)
        return artists

    def move(self, artists: Sequence[Artist], shapes: Sequence[Shape]) -> None:
        """Give the artists of `paint` the places of these shapes: as many, of the same kinds and roles."""
        for artist, group in zip(artists, _groups(shapes), strict=True):
            if isinstance(artist, PathPatch):
                artist.set_path(_path(group))
            elif isinstance(artist, Line2D):
                artist.set_data(*_strokes(group))

    def _artist(self, group: Sequence[Shape]) -> Artist:
        style = STYLES[group[0].role]
        width = style.width * self._pixel
        match group[0]:
            case Text(_, x, y, words, _):
                size = 8.5 * self._pixel
                return Words(x, y, words, color=style.stroke, fontsize=size, fontfamily=SANS, va="center")
            case Lines():
                line = Line2D(*_strokes(group), color=style.stroke, linewidth=width, solid_capstyle="butt")
                if style.dashes:
                    line.set_dashes([length * self._pixel / width for length in style.dashes])
                return line
            case _:
                return PathPatch(
                    _path(group), facecolor=style.fill, edgecolor=style.stroke, linewidth=width, joinstyle="round"
                )


def _groups(shapes: Sequence[Shape]) -> list[list[Shape]]:
    groups: list[list[Shape]] = []
    for shape in shapes:
        last = groups[-1][0] if groups else None
        alike = last is not None and type(shape) is type(last) and shape.role == last.role
        if alike and isinstance(shape, Circle | Lines):
            groups[-1].append(shape)
        else:
            groups.append([shape])
    return groups


def _strokes(group: Sequence[Shape]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x and y (m) of all strokes in one row, parted by NaN."""
    lines = (line for shape in group if isinstance(shape, Lines) for line in shape.lines)
    table = np.array([point for line in lines for point in (*line, (np.nan, np.nan))], dtype=float).reshape(-1, 2)
    return table[:, 0], table[:, 1]


_CIRCLE = Path.unit_circle()


def _path(group: Sequence[Shape]) -> Path:
    circles = [(shape.radius, shape.x, shape.y) for shape in group if isinstance(shape, Circle)]
    if circles:
        vertices = np.concatenate([np.asarray(_CIRCLE.vertices) * radius + (x, y) for radius, x, y in circles])
        return Path(vertices, np.tile(np.asarray(_CIRCLE.codes), len(circles)))
    points = [point for shape in group if isinstance(shape, Polygon) for point in (*shape.points, *shape.points[:1])]
    if not points:
        return Path(np.empty((0, 2)))
    codes = np.full(len(points), Path.LINETO)
    codes[0], codes[-1] = Path.MOVETO, Path.CLOSEPOLY
    return Path(np.array(points), codes)

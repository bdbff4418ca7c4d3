"""Style of the drawings: colours (distinguishable without colour vision) in each theme, strokes, and matplotlib artists for shapes."""

from collections.abc import Callable, Iterator, Sequence
from colorsys import hls_to_rgb, rgb_to_hls
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text
from matplotlib.text import Text as Words
from numpy.typing import NDArray

from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape

PAPER, INK, MUTED, RULE = "#fbfaf5", "#20262c", "#6a727a", "#d3d3cb"
BLUE, VERMILLION, GREEN, SKY = "#1371d5", "#b9500a", "#05582f", "#56b4e9"
STEEL, LIGHT_STEEL, IRON = "#c3ccd4", "#e9edf0", "#87929c"
GREEN_EDGES = ("#4a8566", "#99b9a6")
"""Green blended with the paper colour: green edges are too rare for a palette to be chosen from them."""
PURPLE = "#2d133e"
SERIES_COLOURS = (BLUE, VERMILLION, GREEN, PURPLE)
"""Colours of curves: each is legible as text, and no two look alike without colour vision."""
DARK_COLOURS: Final[dict[str, str]] = {
    PAPER: "#14181c",
    INK: "#dfe3e6",
    MUTED: "#98a2ab",
    RULE: "#353c43",
    "#00436a": "#a9d6f2",
    "#7db9dc": "#d3eaf8",
    "#9fcbe6": "#3f7799",
    "#d5e8f3": "#24404f",
    "#eb9a5e": "#b9662b",
    "#7a3600": "#f0b588",
    "#f4bd94": "#8a4f26",
    "#fbe0bf": "#55402c",
    "#cdc5b8": "#5a5347",
    "#c3ccd4": "#5b6670",
    "#e9edf0": "#39424a",
    "#87929c": "#7d8891",
    "#7d8fa0": "#8b9dae",
}
"""Colours on a dark ground that are chosen by hand, by those of the films."""
SERIF_FONT, SANS_FONT = "STIXGeneral", "DejaVu Sans"


@dataclass(frozen=True)
class ShapeStyle:
    """Fill and stroke of a role; `width` and `dashes` in pixels of a 480-pixel frame, `opacity` of the fill from 0 to 1.

    A fill that is not opaque has no stroke: its edge is a shape of its own.
    """

    fill: str = "none"
    stroke: str = INK
    width: float = 1.0
    dashes: tuple[float, ...] = ()
    opacity: float = 1.0


_STYLES = {
    "axis": ShapeStyle(stroke=MUTED, width=0.7, dashes=(10.0, 3.0, 2.0, 3.0)),
    "spindle, link, eyelet": ShapeStyle(fill=LIGHT_STEEL, width=0.9),
    "spindle shade": ShapeStyle(stroke=IRON, width=1.2),
    "frame, drum": ShapeStyle(fill=IRON, width=1.0),
    "bearing, slot": ShapeStyle(fill=PAPER, width=0.9),
    "hatching, bearing hatching, stop hatching": ShapeStyle(width=0.6),
    "guide": ShapeStyle(stroke=MUTED, width=0.9, dashes=(5.0, 3.0)),
    "leader": ShapeStyle(stroke=RULE, width=0.7),
    "scale, lap circle": ShapeStyle(stroke=MUTED, width=0.8),
    "arm, plate, rod, casting": ShapeStyle(fill=STEEL, width=0.9),
    "plate web": ShapeStyle(fill=STEEL, stroke="none", opacity=0.3),
    "plate rim": ShapeStyle(fill=STEEL, stroke=STEEL, width=0.3),
    "plate edge": ShapeStyle(width=0.9),
    "ball": ShapeStyle(fill=BLUE, stroke="#00436a", width=1.2),
    "ball shine": ShapeStyle(stroke="#7db9dc", width=1.1),
    "sleeve, block": ShapeStyle(fill="#eb9a5e", stroke="#7a3600", width=1.0),
    "engraving": ShapeStyle(stroke="#a8581c", width=0.8),
    "pointer": ShapeStyle(fill=VERMILLION, stroke=VERMILLION, width=0.3),
    "frame plate, bracket": ShapeStyle(fill=LIGHT_STEEL, stroke=MUTED, width=0.8),
    "wall, bore edge": ShapeStyle(width=0.9),
    "wheel, rack": ShapeStyle(fill=STEEL, width=1.0),
    "wheel web": ShapeStyle(fill=LIGHT_STEEL, width=0.6),
    "spoke": ShapeStyle(stroke=IRON, width=2.0),
    "marked spoke": ShapeStyle(stroke=BLUE, width=3.0),
    "tooth, rim": ShapeStyle(width=1.0),
    "spring": ShapeStyle(stroke="#00436a", width=1.5),
    "damper": ShapeStyle(width=1.4),
    "eye": ShapeStyle(fill=INK, width=0.3),
    "tracer": ShapeStyle(fill=GREEN, stroke=GREEN, width=0.3),
    "force": ShapeStyle(fill=VERMILLION, stroke=VERMILLION, width=2.2),
    "reaction": ShapeStyle(fill=BLUE, stroke=BLUE, width=2.0),
    "weight force": ShapeStyle(fill=INK, stroke=INK, width=1.6),
    "centrifugal force": ShapeStyle(fill=VERMILLION, stroke=VERMILLION, width=1.8),
    "spring force": ShapeStyle(fill=GREEN, stroke=GREEN, width=1.8),
    "damping force": ShapeStyle(fill=MUTED, stroke=MUTED, width=1.6),
    "reaction force": ShapeStyle(fill="#7a3600", stroke="#7a3600", width=1.8),
    "velocity": ShapeStyle(fill=BLUE, stroke=BLUE, width=1.8),
    "acceleration": ShapeStyle(fill=VERMILLION, stroke=VERMILLION, width=1.8),
    "instantaneous centre": ShapeStyle(stroke=GREEN, width=1.5),
    "rotation": ShapeStyle(fill=GREEN, stroke=GREEN, width=1.3),
    "label line": ShapeStyle(stroke=MUTED, width=0.7),
    "path": ShapeStyle(stroke="#9fcbe6", width=1.4),
    "angle ray": ShapeStyle(stroke=MUTED, width=0.7, dashes=(4.0, 2.5)),
    "angle arc": ShapeStyle(stroke=BLUE, width=1.1),
    "letter": ShapeStyle(stroke=BLUE, width=1.2),
    "throttle lever, throttle post, gearing wheel": ShapeStyle(fill=STEEL, width=0.9),
    "throttle rod, throttle strap, gearing shaft": ShapeStyle(fill=LIGHT_STEEL, width=0.9),
    "throttle pipe": ShapeStyle(fill=IRON, width=0.9),
    "throttle bore": ShapeStyle(fill="#d5e8f3", stroke="#d5e8f3", width=0.3),
    "throttle plate": ShapeStyle(width=2.6),
    "throttle pin, throttle slot, gearing bearing": ShapeStyle(fill=PAPER, width=0.9),
    "throttle ground, gearing tooth, gearing hatching": ShapeStyle(width=0.6),
    "drive": ShapeStyle(fill=PAPER, stroke=VERMILLION, width=1.8),
    "pivot, stop": ShapeStyle(fill=PAPER, width=1.0),
    "struck": ShapeStyle(fill=VERMILLION, width=0.9),
    "lens": ShapeStyle(fill=PAPER, stroke=MUTED, width=0.8),
    "seat, piston, shoe": ShapeStyle(fill=IRON, width=0.9),
    "dashpot": ShapeStyle(fill=LIGHT_STEEL, width=1.0),
    "bore": ShapeStyle(fill=PAPER, stroke=PAPER, width=0.3),
    "oil": ShapeStyle(fill="#9fcbe6", stroke="#9fcbe6", width=0.3),
    "piston rod": ShapeStyle(fill=STEEL, width=0.8),
    "held shoe": ShapeStyle(fill=VERMILLION, stroke="#7a3600", width=0.9),
    "casting hatching": ShapeStyle(stroke=IRON, width=0.5),
    "live steam": ShapeStyle(fill="#f4bd94", stroke="#f4bd94", width=0.3),
    "expanding steam": ShapeStyle(fill="#fbe0bf", stroke="#fbe0bf", width=0.3),
    "spent steam": ShapeStyle(fill="#d5e8f3", stroke="#d5e8f3", width=0.3),
    "pressed steam": ShapeStyle(fill="#cdc5b8", stroke="#cdc5b8", width=0.3),
    "phase frame": ShapeStyle(width=1.6),
    "valve": ShapeStyle(fill="#7d8fa0", width=1.0),
    "valve cavity": ShapeStyle(fill="#d5e8f3", width=0.8),
    "division": ShapeStyle(stroke=MUTED, width=0.5),
    "valve circle": ShapeStyle(width=0.8),
    "projection": ShapeStyle(stroke=GREEN, width=0.9, dashes=(4.0, 2.5)),
    "crank circle": ShapeStyle(stroke=MUTED, width=0.7, dashes=(10.0, 3.0, 2.0, 3.0)),
    "crank web": ShapeStyle(fill=LIGHT_STEEL, width=0.8),
    "eccentric": ShapeStyle(fill="#eb9a5e", stroke="#7a3600", width=0.8),
    "small rod": ShapeStyle(stroke=INK, width=1.8),
    "eccentric rod": ShapeStyle(stroke="#7a3600", width=1.6),
    "crank end curve": ShapeStyle(stroke=BLUE, width=1.6),
    "burst, head end curve": ShapeStyle(stroke=VERMILLION, width=1.6),
    "crank end chord": ShapeStyle(stroke=BLUE, width=4.0),
    "head end chord": ShapeStyle(stroke=VERMILLION, width=4.0),
    "crank end mark": ShapeStyle(fill=BLUE, stroke=PAPER, width=0.8),
    "head end mark": ShapeStyle(fill=VERMILLION, stroke=PAPER, width=0.8),
    "weight section": ShapeStyle(fill="#cfe3f0", stroke="#00436a", width=1.1),
    "weight section hatching": ShapeStyle(stroke="#7db9dc", width=0.7),
    "weight bore": ShapeStyle(fill="#e9edf0", stroke="#00436a", width=0.9),
    "coil": ShapeStyle(stroke=STEEL, width=3.0),
    "coil edge": ShapeStyle(stroke=INK, width=4.6),
    "coil behind": ShapeStyle(stroke=IRON, width=2.4),
    "tail": ShapeStyle(stroke=VERMILLION, width=2.4),
    "trace": ShapeStyle(stroke="#9fcbe6", width=1.6),
    "ring": ShapeStyle(stroke=RULE, width=3.0),
    "sweep": ShapeStyle(fill=GREEN, stroke=GREEN, width=3.0),
    "plan arm": ShapeStyle(width=2.0),
    "hand": ShapeStyle(stroke=GREEN, width=1.0),
    "hub": ShapeStyle(fill=PAPER, width=0.8),
    "belt": ShapeStyle(stroke="#7a3600", width=1.4),
    "butterfly": ShapeStyle(width=2.6),
    "weight": ShapeStyle(fill=VERMILLION, stroke="#7a3600", width=1.0),
    "mark spoke": ShapeStyle(stroke=PAPER, width=1.6),
    "mark": ShapeStyle(fill=PAPER, stroke=PAPER, width=0.1),
}
"""Styles by the roles that have them."""

ROLE_STYLES = {role: style for roles, style in _STYLES.items() for role in roles.split(", ")}
"""Style of each role."""

_STYLE_COLOURS = {colour for style in ROLE_STYLES.values() for colour in (style.fill, style.stroke)}
FILM_COLOURS = tuple(sorted({PAPER, INK, MUTED, RULE, *SERIES_COLOURS, *GREEN_EDGES, *_STYLE_COLOURS} - {"none"}))
"""All colours that occur in a film."""


def parse_rgb(colour: str) -> tuple[int, int, int]:
    """Return '#rrggbb' as three integers 0..255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


class Brush:
    """Creates artists for shapes on axes in metres.

    Consecutive circles of one role share an artist, and so do lines: an artist costs more than its shape. `points_per_pixel` is the
    number of points in a pixel of a 480-pixel frame.
    """

    def __init__(self, axes: Axes, points_per_pixel: float, *, base_zorder: float = 2) -> None:
        self._axes = axes
        self._points_per_pixel = points_per_pixel
        self._base_zorder = base_zorder

    def paint(self, shapes: Sequence[DrawnShape]) -> list[Artist]:
        """Add artists for the shapes, back to front, and return them."""
        artists = [self._make_artist(group) for group in group_shapes(shapes)]
        for order, artist in enumerate(artists):
            artist.set_zorder(self._base_zorder + order / 1000)
            self._axes.add_artist(artist)
        return artists

    def _make_artist(self, group: Sequence[DrawnShape]) -> Artist:
        """Return the artist of a group of shapes."""
        style = ROLE_STYLES[group[0].role]
        width = style.width * self._points_per_pixel
        match group[0]:
            case TextShape(_, x, y, words, _):
                return Words(x, y, words, color=style.stroke, fontsize=8.5 * self._points_per_pixel, fontfamily=SANS_FONT, va="center")
            case Lines():
                line = Line2D(*_line_points(group).T, color=style.stroke, linewidth=width, solid_capstyle="butt")
                if style.dashes:
                    line.set_dashes([length * self._points_per_pixel / width for length in style.dashes])
                return line
            case _:
                fill = style.fill if style.opacity == 1.0 else to_rgba(style.fill, style.opacity)
                return PathPatch(_outline_path(group), facecolor=fill, edgecolor=style.stroke, linewidth=width, joinstyle="round")


def artist_paths(shapes: Sequence[DrawnShape]) -> list[Path | None]:
    """Return the paths (m) of the artists that `Brush.paint` makes for shapes; None for a text."""
    return [_path_of(group) for group in group_shapes(shapes)]


def _path_of(group: Sequence[DrawnShape]) -> Path | None:
    match group[0]:
        case TextShape():
            return None
        case Lines():
            return Path(_line_points(group))
        case _:
            return _outline_path(group)


def group_shapes(shapes: Sequence[DrawnShape]) -> list[list[DrawnShape]]:
    """Return the shapes in groups that share an artist."""

    def group_key(numbered: tuple[int, DrawnShape]) -> tuple[type, str, int]:
        number, shape = numbered
        return type(shape), shape.role, -1 if isinstance(shape, Circle | Lines) else number

    return [[shape for _, shape in group] for _, group in groupby(enumerate(shapes), group_key)]


def _line_points(group: Sequence[DrawnShape]) -> NDArray[np.float64]:
    """Return the points (n, 2) m of all polylines in one row, separated by NaN."""
    lines = (line for shape in group if isinstance(shape, Lines) for line in shape.lines)
    return np.array([point for line in lines for point in (*line, (np.nan, np.nan))], dtype=float).reshape(-1, 2)


_UNIT_CIRCLE = Path.unit_circle()


def _outline_path(group: Sequence[DrawnShape]) -> Path:
    """Return the path of circles or of a polygon."""
    circles = [(shape.radius, shape.x, shape.y) for shape in group if isinstance(shape, Circle)]
    if circles:
        vertices = np.concatenate([np.asarray(_UNIT_CIRCLE.vertices) * radius + (x, y) for radius, x, y in circles])
        return Path(vertices, np.tile(np.asarray(_UNIT_CIRCLE.codes), len(circles)))
    points = [point for shape in group if isinstance(shape, Polygon) for point in (*shape.points, *shape.points[:1])]
    return Path(np.array(points, dtype=float).reshape(-1, 2), closed=True)


_DARKEST, _LIGHTNESS_SPAN = 0.16, 0.72
"""Lightness on a dark ground of what is white by day, and its difference to what is black by day."""
PALE_BLUE: Final = "#9fcbe6"
"""Colour of the curve behind another one."""
NAMED_COLOURS: Final = {"paper": PAPER, "ink": INK, "muted": MUTED, "rule": RULE, "blue": BLUE, "vermillion": VERMILLION, "green": GREEN}
"""Colours that the style of the page calls by name."""


def darken(colour: str) -> str:
    """Return the counterpart of a colour on a dark ground: as chosen, or of the same hue with its lightness turned over."""
    if colour in DARK_COLOURS:
        return DARK_COLOURS[colour]
    hue, lightness, saturation = rgb_to_hls(*(value / 255 for value in parse_rgb(colour)))
    parts = hls_to_rgb(hue, _DARKEST + _LIGHTNESS_SPAN * (1.0 - lightness), saturation)
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)


def variable_of(colour: str) -> str:
    """Return the CSS variable of a colour, as var(--c-fbfaf5); "none" stays."""
    return colour if colour == "none" else f"var(--c-{colour[1:]})"


def colour_rules() -> str:
    """Return the CSS rules that give the colours their values, by day, on a dark ground, and as a visitor chooses."""
    shown = {*FILM_COLOURS, PALE_BLUE}
    light, dark = (_declarations({colour: tone(colour) for colour in sorted(shown)}) for tone in (str, darken))
    names = " ".join(f"--{name}: {variable_of(colour)};" for name, colour in NAMED_COLOURS.items())
    return "\n".join(
        [
            f":root {{ color-scheme: light; {light} {names} }}",
            f"@media (prefers-color-scheme: dark) {{ :root:not([data-theme=light]) {{ color-scheme: dark; {dark} }} }}",
            f":root[data-theme=dark] {{ color-scheme: dark; {dark} }}",
        ]
    )


def role_rules(roles: set[str]) -> str:
    """Return the CSS rules of roles: fill, stroke, and widths as multiples of --stroke, the width 1 of a drawing in its units."""
    rules = []
    for role in sorted(roles):
        style = ROLE_STYLES[role]
        dashes = " ".join(f"calc({length:g} * var(--stroke))" for length in style.dashes)
        dash_rule = f" stroke-dasharray: {dashes};" if dashes else ""
        opacity_rule = f" fill-opacity: {style.opacity:g};" if style.opacity < 1.0 else ""
        rules.append(
            f".{class_of(role)} {{ fill: {variable_of(style.fill)}; stroke: {variable_of(style.stroke)}; "
            f"stroke-width: calc({style.width:g} * var(--stroke));{dash_rule}{opacity_rule} }}"
        )
    return "\n".join(rules)


def class_of(role: str) -> str:
    """Return the CSS class of a role."""
    return "role-" + role.replace(" ", "-")


def series_rules() -> str:
    """Return the CSS rules of the curves."""
    return "\n".join(f".series-{k} {{ --series: {variable_of(colour)}; }}" for k, colour in enumerate((*SERIES_COLOURS, PALE_BLUE)))


def _declarations(values: dict[str, str]) -> str:
    return " ".join(f"--c-{colour[1:]}: {value};" for colour, value in values.items())


OVER_COLOUR_MAP = "over a colour map"
"""Group (`gid`) of what stands on a colour map, which is the same in all themes: it keeps its colours."""

Colour = Any
"""A colour as matplotlib takes it: a name, "#rrggbb", or numbers with an opacity."""


def themed_colour(colour: Colour, theme: Theme) -> Colour:
    """Return the colour in a theme that stands for one of the light theme, with the same opacity."""
    red, green, blue, opacity = to_rgba(colour)
    name = to_hex((red, green, blue))
    if theme is Theme.DARK:
        return to_rgba(DARK_COLOURS[name], opacity) if name in DARK_COLOURS else (*_inverse_lightness(red, green, blue), opacity)
    return (red, green, blue, 0.0 if theme is Theme.TRANSPARENT and name == PAPER else opacity)


def _inverse_lightness(red: float, green: float, blue: float) -> tuple[float, float, float]:
    """Return the colour of the same hue whose mean of the largest and the smallest part is the inverse."""
    shift = 1.0 - max(red, green, blue) - min(red, green, blue)
    return red + shift, green + shift, blue + shift


@contextmanager
def themed(figure: Figure, theme: Theme) -> Iterator[None]:
    """Give a figure the colours of a theme while the body of the with statement runs."""
    changes = recolour(figure, theme)
    try:
        yield
    finally:
        for set_value, _, old in changes:
            set_value(old)


Change = tuple[Callable[[Any], object], Any, Any]
"""A function that sets a property of an artist, the new value, and the old one."""


def recolour(figure: Figure, theme: Theme) -> list[Change]:
    """Give a figure the colours of a theme, and return what was changed."""
    if theme is Theme.LIGHT:
        return []
    figure.draw_without_rendering()  # creates the ticks and their labels
    artists = figure.findobj()
    # An arrow is drawn by its annotation, and is not among the children of the figure.
    arrows = [one.arrow_patch for one in artists if isinstance(one, Annotation) and one.arrow_patch is not None]
    recoloured = (one for one in (*artists, *arrows) if one.get_gid() != OVER_COLOUR_MAP)
    changes = [change for artist in recoloured for change in _changes_of(artist, theme)]
    for set_value, new, _ in changes:
        set_value(new)
    return changes


def _changes_of(artist: Artist, theme: Theme) -> Iterator[Change]:
    """Yield the changes of an artist. The halo of a text remains also without a ground."""
    names: tuple[str, ...] = ()
    match artist:
        case Text() | Line2D():
            names = ("color", *(("markerfacecolor", "markeredgecolor") if isinstance(artist, Line2D) else ()))
        case Patch():
            names = ("facecolor", "edgecolor")
        case Collection():
            names = ("edgecolor",) if artist.get_array() is not None else ("facecolor", "edgecolor")
    thing: Any = artist
    for name in names:
        old = getattr(thing, f"get_{name}")()
        if not (isinstance(old, str) and old in ("none", "auto")):
            yield getattr(thing, f"set_{name}"), _themed_colours(old, theme), old
    effects = thing.get_path_effects()
    if theme is Theme.DARK and effects:
        yield thing.set_path_effects, [withStroke(linewidth=3.0, foreground=themed_colour(PAPER, theme))], effects


def _themed_colours(colours: Colour, theme: Theme) -> Colour:
    """Return the themed colour of one colour, or of each row of an array of them (n, 4)."""
    if isinstance(colours, np.ndarray) and colours.ndim == 2:
        return np.array([themed_colour(colour, theme) for colour in colours]).reshape(-1, 4)
    return themed_colour(colours, theme)

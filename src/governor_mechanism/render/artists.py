"""Artists of matplotlib for shapes, and the colours of a figure in each theme."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import Any

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
from matplotlib.transforms import Bbox, BboxTransformFrom, BboxTransformTo, TransformedBbox
from numpy.typing import NDArray

from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.geometry.primitives import SMALL_TEXT, Circle, DrawnShape, Lines, Polygon, TextShape, is_wording
from governor_mechanism.render.style import DARK_COLOURS, PAPER, ROLE_STYLES, SANS_FONT


class Picture:
    """Place in a figure for shapes in metres: what a brush needs of `Axes`, which are slow to make and to draw."""

    def __init__(
        self,
        figure: Figure,
        rect: tuple[float, float, float, float],  # left and lower edge, width and height, in fractions of the figure
        box: Bbox,  # what is seen in it, m
    ) -> None:
        self._figure = figure
        self.bbox = TransformedBbox(Bbox.from_bounds(*rect), figure.transFigure)
        self.transData = BboxTransformFrom(box) + BboxTransformTo(self.bbox)

    def add_artist(self, artist: Artist) -> Artist:
        """Add an artist, which is seen within the place."""
        artist.set_transform(self.transData)
        artist.set_clip_box(self.bbox)
        return self._figure.add_artist(artist)


class Brush:
    """Creates artists for shapes on axes or in a picture, in metres.

    Consecutive circles of one role share an artist, and so do lines: an artist costs more than its shape. `points_per_pixel` is the
    number of points in a pixel of a 480-pixel frame. Without `shows_words`, words and the keys of their colours are not seen.
    """

    def __init__(self, axes: Axes | Picture, points_per_pixel: float, *, base_zorder: float = 2, shows_words: bool = True) -> None:
        self._axes = axes
        self._points_per_pixel = points_per_pixel
        self._base_zorder = base_zorder
        self._shows_words = shows_words

    def paint(self, shapes: Sequence[DrawnShape]) -> list[Artist]:
        """Add artists for the shapes, back to front, and return them."""
        groups = group_shapes(shapes)
        artists = [self._make_artist(group) for group in groups]
        for order, (artist, (first, *_)) in enumerate(zip(artists, groups, strict=True)):
            artist.set_visible(self._shows_words or not is_wording(first))
            artist.set_zorder(self._base_zorder + order / 1000)
            self._axes.add_artist(artist)
            if isinstance(artist, Text):
                self._keep_inside(artist)
        return artists

    def _keep_inside(self, words: Text) -> None:
        """Move words to the left that would end outside of the axes: their height in pixels does not follow the scale of the drawing."""
        excess = float(words.get_window_extent().x1 - self._axes.bbox.x1)
        if excess > 0.0:
            (left, _), (right, _) = (self._axes.transData.inverted().transform((x, 0.0)) for x in (0.0, excess))
            words.set_x(float(words.get_position()[0]) - (right - left))

    def _make_artist(self, group: Sequence[DrawnShape]) -> Artist:
        """Return the artist of a group of shapes."""
        style = ROLE_STYLES[group[0].role]
        width = style.width * self._points_per_pixel
        match group[0]:
            case TextShape(_, x, y, words, _):
                height = SMALL_TEXT * self._points_per_pixel
                return Words(x, y, words, color=style.stroke, fontsize=height, fontfamily=SANS_FONT, va="center")
            case Lines():
                line = Line2D(*path_points(group).T, color=style.stroke, linewidth=width, solid_capstyle="butt")
                if style.dashes:
                    line.set_dashes([length * self._points_per_pixel / width for length in style.dashes])
                return line
            case _:
                fill = style.fill if style.opacity == 1.0 else to_rgba(style.fill, style.opacity)
                return PathPatch(path_of(group), facecolor=fill, edgecolor=style.stroke, linewidth=width, joinstyle="round")


def artist_paths(shapes: Sequence[DrawnShape]) -> list[Path | None]:
    """Return the paths (m) of the artists that `Brush.paint` makes for shapes; None for a text."""
    return [None if isinstance(group[0], TextShape) else path_of(group) for group in group_shapes(shapes)]


def group_shapes(shapes: Sequence[DrawnShape]) -> list[list[DrawnShape]]:
    """Return the shapes in groups that share an artist."""

    def group_key(numbered: tuple[int, DrawnShape]) -> tuple[type, str, int]:
        number, shape = numbered
        return type(shape), shape.role, -1 if isinstance(shape, Circle | Lines) else number

    return [[shape for _, shape in group] for _, group in groupby(enumerate(shapes), group_key)]


_UNIT_CIRCLE = Path.unit_circle()


def path_of(group: Sequence[DrawnShape]) -> Path:
    """Return the path (m) of the artist of a group of shapes that are no texts."""
    points = path_points(group)
    match group[0]:
        case Circle():
            return Path(points, np.tile(np.asarray(_UNIT_CIRCLE.codes), len(group)))
        case _:
            return Path(points, closed=isinstance(group[0], Polygon))


def path_points(group: Sequence[DrawnShape]) -> NDArray[np.float64]:
    """Return the points (n, 2) m of the path of the artist of a group; polylines are separated by NaN."""
    circles = [np.asarray(_UNIT_CIRCLE.vertices) * shape.radius + (shape.x, shape.y) for shape in group if isinstance(shape, Circle)]
    if circles:
        return np.concatenate(circles)
    points = [point for shape in group if isinstance(shape, Polygon) for point in (*shape.points, *shape.points[:1])]
    lines = (line for shape in group if isinstance(shape, Lines) for line in shape.lines)
    points += [point for line in lines for point in (*line, (np.nan, np.nan))]
    return np.array(points, dtype=float).reshape(-1, 2)


OVER_COLOUR_MAP = "over a colour map"
"""Group (`gid`) of what stands on a colour map, which is the same in all themes: it keeps its colours."""

Colour = Any
"""A colour as matplotlib takes it: a name, "#rrggbb", or numbers with an opacity."""


WHITE = "#ffffff"
"""Ground of the light theme in a file for print."""


def themed_colour(colour: Colour, theme: Theme, paper: str = PAPER) -> Colour:
    """Return the colour in a theme that stands for one of the light theme, with the same opacity; `paper` is the light ground."""
    red, green, blue, opacity = to_rgba(colour)
    name = to_hex((red, green, blue))
    if theme is Theme.DARK:
        return to_rgba(DARK_COLOURS[name], opacity) if name in DARK_COLOURS else (*_inverse_lightness(red, green, blue), opacity)
    if name == PAPER:
        return to_rgba(paper, 0.0 if theme is Theme.TRANSPARENT else opacity)
    return (red, green, blue, opacity)


def _inverse_lightness(red: float, green: float, blue: float) -> tuple[float, float, float]:
    """Return the colour of the same hue whose mean of the largest and the smallest part is the inverse."""
    shift = 1.0 - max(red, green, blue) - min(red, green, blue)
    return red + shift, green + shift, blue + shift


@contextmanager
def themed(figure: Figure, theme: Theme, paper: str = PAPER) -> Iterator[None]:
    """Give a figure the colours of a theme, and a light ground, while the body of the with statement runs."""
    changes = recolour(figure, theme, paper)
    try:
        yield
    finally:
        for set_value, _, old in changes:
            set_value(old)


Change = tuple[Callable[[Any], object], Any, Any]
"""A function that sets a property of an artist, the new value, and the old one."""


def recolour(figure: Figure, theme: Theme, paper: str = PAPER) -> list[Change]:
    """Give a figure the colours of a theme, and a light ground, and return what was changed."""
    if theme is Theme.LIGHT and paper == PAPER:
        return []
    figure.draw_without_rendering()  # creates the ticks and their labels
    artists = figure.findobj()
    # An arrow is drawn by its annotation, and is not among the children of the figure.
    arrows = [one.arrow_patch for one in artists if isinstance(one, Annotation) and one.arrow_patch is not None]
    recoloured = (one for one in (*artists, *arrows) if one.get_gid() != OVER_COLOUR_MAP)
    changes = [change for artist in recoloured for change in _changes_of(artist, theme, paper)]
    for set_value, new, _ in changes:
        set_value(new)
    return changes


def _changes_of(artist: Artist, theme: Theme, paper: str) -> Iterator[Change]:
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
            yield getattr(thing, f"set_{name}"), _themed_colours(old, theme, paper), old
    effects = thing.get_path_effects()
    if theme is not Theme.TRANSPARENT and effects:
        yield thing.set_path_effects, [withStroke(linewidth=3.0, foreground=themed_colour(PAPER, theme, paper))], effects


def _themed_colours(colours: Colour, theme: Theme, paper: str) -> Colour:
    """Return the themed colour of one colour, or of each row of an array of them (n, 4)."""
    if isinstance(colours, np.ndarray) and colours.ndim == 2:
        return np.array([themed_colour(colour, theme, paper) for colour in colours]).reshape(-1, 4)
    return themed_colour(colours, theme, paper)

"""The colours of a figure in a theme."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import Collection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text

from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.style import DARK_COLOURS, PAPER

OVER_COLOUR_MAP = "over a colour map"
"""Group (`gid`) of what stands on a colour map, which is the same in all themes: it keeps its colours."""

Colour = Any
"""A colour as matplotlib takes it: a name, "#rrggbb", or numbers with an opacity."""


def themed_colour(colour: Colour, theme: Theme) -> Colour:
    """Return the colour in a theme that stands for one of the light theme, with the same opacity.

    Result: red, green, blue and opacity, 0 to 1. On a dark ground, a colour outside the table of the drawings
    has the inverse lightness. Without a ground, the paper is invisible.
    """
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
    """Give a figure the colours of a theme while the body of the with statement runs.

    Result: while the figure has these colours.
    """
    changes = recolour(figure, theme)
    try:
        yield
    finally:
        for set_value, _, old in changes:
            set_value(old)


Change = tuple[Callable[[Any], object], Any, Any]
"""A function that sets a property of an artist, the new value, and the old one."""


def recolour(figure: Figure, theme: Theme) -> list[Change]:
    """Give a figure the colours of a theme.

    Result: what was changed.
    """
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

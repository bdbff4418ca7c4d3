"""The colours of a figure in a theme: those of the light drawings, darkened for a dark page."""

from collections.abc import Callable, Iterator
from colorsys import hls_to_rgb, rgb_to_hls
from contextlib import contextmanager
from typing import Any, Final

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
from governor_mechanism.render.style import (
    BLUE,
    DARK_COLOURS,
    FILM_COLOURS,
    GREEN,
    INK,
    MUTED,
    PAPER,
    ROLE_STYLES,
    RULE,
    SERIES_COLOURS,
    VERMILLION,
    parse_rgb,
)

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

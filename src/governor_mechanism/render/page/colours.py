"""Colours of a page: those of the films by day, and their counterparts on a dark ground."""

from colorsys import hls_to_rgb, rgb_to_hls
from typing import Final

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
        rules.append(
            f".{class_of(role)} {{ fill: {variable_of(style.fill)}; stroke: {variable_of(style.stroke)}; "
            f"stroke-width: calc({style.width:g} * var(--stroke));{dash_rule} }}"
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

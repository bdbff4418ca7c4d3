"""Style of the drawings: colours (distinguishable without colour vision) in each theme, strokes, and their rules in CSS."""

from colorsys import hls_to_rgb, rgb_to_hls
from dataclasses import dataclass
from typing import Final

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
    """Fill, stroke, `width` and `dashes` (pixels of 480), `opacity` of a role; without full opacity its stroke is a shape of its own."""

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
    "reaction, reaction key": ShapeStyle(fill=BLUE, stroke=BLUE, width=2.0),
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
    "seat, piston, shoe, shoe key": ShapeStyle(fill=IRON, width=0.9),
    "dashpot": ShapeStyle(fill=LIGHT_STEEL, width=1.0),
    "bore": ShapeStyle(fill=PAPER, stroke=PAPER, width=0.3),
    "oil": ShapeStyle(fill="#9fcbe6", stroke="#9fcbe6", width=0.3),
    "piston rod": ShapeStyle(fill=STEEL, width=0.8),
    "held shoe, held shoe key": ShapeStyle(fill=VERMILLION, stroke="#7a3600", width=0.9),
    "casting hatching": ShapeStyle(stroke=IRON, width=0.5),
    "live steam, live steam key": ShapeStyle(fill="#f4bd94", stroke="#f4bd94", width=0.3),
    "expanding steam, expanding steam key": ShapeStyle(fill="#fbe0bf", stroke="#fbe0bf", width=0.3),
    "spent steam, spent steam key": ShapeStyle(fill="#d5e8f3", stroke="#d5e8f3", width=0.3),
    "pressed steam, pressed steam key": ShapeStyle(fill="#cdc5b8", stroke="#cdc5b8", width=0.3),
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


_DARKEST, _LIGHTNESS_SPAN = 0.16, 0.72
"""Lightness on a dark ground of what is white by day, and its difference to what is black by day."""
PALE_BLUE: Final = "#9fcbe6"
"""Colour of the curve behind another one."""
CURVE_COLOURS = (*SERIES_COLOURS, PALE_BLUE, "#7a3600")
"""Colours of curves over time by number; the last one is that of an opening."""
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
    return "\n".join(f".series-{k} {{ --series: {variable_of(colour)}; }}" for k, colour in enumerate(CURVE_COLOURS))


def _declarations(values: dict[str, str]) -> str:
    return " ".join(f"--c-{colour[1:]}: {value};" for colour, value in values.items())

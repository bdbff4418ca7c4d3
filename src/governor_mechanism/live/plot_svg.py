"""A small plot with axes as SVG."""

import math
from dataclasses import dataclass, field
from html import escape

import numpy as np

from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT
from governor_mechanism.types import BoolArray, FloatArray, IntArray
from governor_mechanism.units.quantities import format_reading_name

WIDTH, HEIGHT = 440.0, 400.0
"""Size of a plot, pixels."""
LEFT, TOP, RIGHT, BOTTOM = 62.0, 40.0, 424.0, 350.0
"""Edges of the region of the curves, pixels from the upper left corner."""
MAX_TICKS = 6
"""Largest number of steps between the ticks of an axis."""
TEXT_HEIGHT = 11.0
"""Height of labels, pixels."""
LEGEND_WIDTH, LEGEND_HEIGHT, LEGEND_COLUMNS = 120.0, 16.0, 3
"""Width and height of an entry of the legend, pixels, and number of them in a row; the first row is the lower one."""


@dataclass
class Plot:
    """A plot of curves over one axis; what is drawn later covers what is drawn earlier."""

    # x_label, y_label: labels of the axes
    x_label: str
    y_label: str
    # x_limits, y_limits: ends of the axes
    x_limits: Vec2
    y_limits: Vec2
    _elements: list[str] = field(default_factory=list)
    _legend: list[tuple[str, str]] = field(default_factory=list)

    def add_curve(
        self, x: FloatArray, y: FloatArray, shown: BoolArray | None = None, *, colour: str, dashes: str = "", name: str = ""
    ) -> None:
        """Draw a curve through points (n,), with its name in the legend, if it has one; `dashes` and gaps are in pixels.

        `shown` tells which points belong to it; neighbours are connected. All do if None.
        """
        runs = _runs_of(np.isfinite(y) if shown is None else shown & np.isfinite(y))
        if not runs:
            return
        # Points far outside would make numbers that browsers round.
        low, high = self.y_limits
        clipped = np.clip(y, low - 2 * (high - low), high + 2 * (high - low))
        path = "".join("M" + "L".join(self._places(x[run], clipped[run])) for run in runs)
        line = f'fill="none" stroke="{colour}" stroke-width="1.8"' + (f' stroke-dasharray="{dashes}"' if dashes else "")
        self._elements.append(f'<path d="{path}" {line}/>')
        if name:
            place = self._next_legend_entry()
            self._legend.append((f'<path d="M{place[0]:.1f} {place[1]:.1f}h22" {line}/>', _write_name(place, name)))

    def add_band(self, x: FloatArray, low: FloatArray, high: FloatArray, shown: BoolArray, *, colour: str, name: str) -> None:
        """Fill what lies between two curves (n,) where it is shown, with its name in the legend."""
        bottom, top = self.y_limits
        span = top - bottom
        for run in _runs_of(shown):
            edges = [self._places(x[run], np.clip(one[run], bottom - 2 * span, top + 2 * span)) for one in (low, high)]
            path = "M" + "L".join([*edges[0], *edges[1][::-1]]) + "Z"
            self._elements.append(f'<path d="{path}" fill="{colour}" fill-opacity="0.3"/>')
        place = self._next_legend_entry()
        sample = f'<rect x="{place[0]:.1f}" y="{place[1] - 5:.1f}" width="22" height="10" fill="{colour}" fill-opacity="0.3"/>'
        self._legend.append((sample, _write_name(place, name)))

    def add_level(self, y: float, colour: str, name: str) -> None:
        """Draw a horizontal line at a value, with its name above the right end."""
        height = self._place(0.0, y)[1]
        self._elements.append(f'<path d="M{LEFT} {height:.1f}H{RIGHT}" stroke="{colour}" stroke-width="1"/>')
        self._elements.append(write_text(RIGHT - 2, height - 9, name, height=TEXT_HEIGHT, colour=colour, anchor="end"))

    def add_point(self, x: float, y: float, colour: str, *, is_filled: bool = True) -> None:
        """Mark a point by a dot, or by a ring if it is not filled."""
        self._elements.append(_draw_dot(*self._place(x, y), colour, colour if is_filled else PAPER))

    def name_points(self, colour: str, name: str) -> None:
        """Add the name of points of a colour to the legend."""
        place = self._next_legend_entry()
        self._legend.append((_draw_dot(place[0] + 11, place[1], colour, colour), _write_name(place, name)))

    def add_note(self, text: str) -> None:
        """Write a line in the middle of the plot."""
        self._elements.append(write_text((LEFT + RIGHT) / 2, (TOP + BOTTOM) / 2, text, height=TEXT_HEIGHT, colour=INK, anchor="middle"))

    def to_svg(self, description: str) -> str:
        """Return the plot as a picture with a description for screen readers."""
        # An inner picture cuts off what is outside of the axes, without names that would have to differ in a page.
        size = f'x="{LEFT - 5}" y="{TOP - 5}" width="{RIGHT - LEFT + 10}" height="{BOTTOM - TOP + 10}"'
        box = f'viewBox="{LEFT - 5} {TOP - 5} {RIGHT - LEFT + 10} {BOTTOM - TOP + 10}"'
        curves = f"<svg {size} {box}>{''.join(self._elements)}</svg>"
        legend = "".join(sample + name for sample, name in self._legend)
        size = f'width="{WIDTH:g}" height="{HEIGHT:g}" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" style="max-width:100%;height:auto"'
        paper = f'<rect width="{WIDTH:g}" height="{HEIGHT:g}" fill="{PAPER}"/>'
        content = f"{paper}{self._axes()}{curves}{legend}"
        return f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{escape(description)}">{content}</svg>'

    def _next_legend_entry(self) -> Vec2:
        """Return the left end and the middle height of the next entry of the legend, pixels."""
        row, column = divmod(len(self._legend), LEGEND_COLUMNS)
        return LEFT + LEGEND_WIDTH * column, TOP - 16 - LEGEND_HEIGHT * row

    def _place(self, x: float, y: float) -> Vec2:
        """Return the pixels of a point."""
        (x0, x1), (y0, y1) = self.x_limits, self.y_limits
        return LEFT + (RIGHT - LEFT) * (x - x0) / (x1 - x0), BOTTOM - (BOTTOM - TOP) * (y - y0) / (y1 - y0)

    def _places(self, x: FloatArray, y: FloatArray) -> list[str]:
        """Return the pixels of points (n,) as a path has them."""
        return [f"{px:.1f} {py:.1f}" for px, py in map(self._place, x, y)]

    def _axes(self) -> str:
        """Return grid, ticks, spines and labels."""
        parts = []
        for value, text in _ticks(self.x_limits):
            x = self._place(value, 0.0)[0]
            parts.append(f'<path d="M{x:.1f} {TOP}V{BOTTOM}" stroke="{RULE}" stroke-width="0.7"/>')
            parts.append(write_text(x, BOTTOM + 14, text, height=TEXT_HEIGHT, colour=MUTED, anchor="middle"))
        for value, text in _ticks(self.y_limits):
            y = self._place(0.0, value)[1]
            parts.append(f'<path d="M{LEFT} {y:.1f}H{RIGHT}" stroke="{RULE}" stroke-width="0.7"/>')
            parts.append(write_text(LEFT - 6, y, text, height=TEXT_HEIGHT, colour=MUTED, anchor="end"))
        parts.append(f'<path d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}" fill="none" stroke="{MUTED}" stroke-width="1"/>')
        parts.append(write_text((LEFT + RIGHT) / 2, BOTTOM + 34, self.x_label, height=TEXT_HEIGHT + 1, colour=INK, anchor="middle"))
        middle = (TOP + BOTTOM) / 2
        parts.append(write_text(14, middle, self.y_label, height=TEXT_HEIGHT + 1, colour=INK, anchor="middle", turned=True))
        return "".join(parts)


def label_axis(name: str, unit: str) -> str:
    """Return the label of an axis for a reading, as "Arm angle [deg]"."""
    words = format_reading_name(name)
    return f"{words[:1].upper()}{words[1:]}{f' [{unit}]' if unit else ''}"


def write_text(x: float, y: float, text: str, *, height: float, colour: str, anchor: str = "start", turned: bool = False) -> str:
    """Return a line of text, all in pixels: its start, middle or end (`anchor`) and its middle height are at (x, y); `turned` is up."""
    # A shift of a third of the height centres digits and letters; Firefox ignores dominant-baseline="central" in some fonts.
    turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
    font = f'font-size="{height:g}" font-family="{SANS_FONT}, sans-serif" text-anchor="{anchor}" fill="{colour}"'
    return f'<text x="{x:.1f}" y="{y + 0.34 * height:.1f}" {font}{turn}>{escape(text)}</text>'


def _runs_of(shown: BoolArray) -> list[IntArray]:
    """Return the indices of neighbours that are shown, run by run."""
    indices = np.flatnonzero(shown)
    return np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1) if len(indices) else []


def _write_name(place: Vec2, name: str) -> str:
    """Return the name of an entry of the legend at a place."""
    return write_text(place[0] + 28, place[1], name, height=TEXT_HEIGHT, colour=INK)


def _draw_dot(x: float, y: float, colour: str, fill: str) -> str:
    """Return a dot at a pixel."""
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{fill}" stroke="{colour}" stroke-width="1.6"/>'


def _ticks(limits: Vec2) -> list[tuple[float, str]]:
    """Return round values between two limits, and their texts."""
    low, high = limits
    step = round_step(high - low, MAX_TICKS)
    numbers = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
    return [(number * step, f"{number * step:.6g}".replace("-", "\u2212")) for number in numbers]

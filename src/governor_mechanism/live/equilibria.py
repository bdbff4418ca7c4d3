"""The equilibria of what turns with a spindle, as a curve beside the drawing: a small plot with axes as SVG."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, Final

import numpy as np

from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, RULE, SANS_FONT, SKY, VERMILLION
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import has_equilibrium_speed
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve, compute_speed_curve
from governor_mechanism.types import BoolArray, FloatArray, IntArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.quantities import display_unit, format_quantity, format_reading_name

WIDTH, HEIGHT = 440.0, 400.0
"""Size of a plot, pixels."""
LEFT = 62.0
TOP = 40.0
RIGHT = 424.0
BOTTOM = 350.0
"""Edges of the region of the curves, pixels from the upper left corner."""
MAX_TICKS = 6
"""Largest number of steps between the ticks of an axis."""
TEXT_HEIGHT = 11.0
"""Height of labels, pixels."""
LEGEND_WIDTH = 120.0
LEGEND_HEIGHT = 16.0
LEGEND_COLUMNS = 3
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
        """Draw a curve through points (n,), or neighbours of those `shown`, with a name for the legend; `dashes` and gaps are in pixels."""
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


COLOUR: Final = re.compile(r'(fill|stroke)="#([0-9a-fA-F]{6})"')
"""A colour of a picture, which has a counterpart on a dark ground, or is the same there."""

CURVE_POINTS: Final = 150
"""Number of points of the speed curve: one for every other pixel of the plot."""

SHOWN_SHARE: Final = 0.1
"""Share of the travel at each end of the speed curve that does not decide which speeds are shown: it may tend to zero or infinity there."""

SPEED_MARGIN: Final = 0.15
"""Margin of the shown speeds, relative to the lowest and the highest one."""

GIVEN_NAME: Final = "as opened"
GIVEN_DASHES: Final = "2 3"
"""Name and dashes of the curve of the scene as it was opened."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Statics:
    """The equilibria of the part of a scene that turns with a spindle, at the speed with which it starts."""

    scene: Scene  # the part alone, at a constant speed
    curve: SpeedCurve
    speed: float  # rad/s
    equilibria: tuple[Equilibrium, ...]
    problem: str  # why there is none at this speed; empty if there is one


class EquilibriumPlot:
    """The speed curve of a scene, with that of the scene as it was opened behind it."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._first = scene, _analyse(scene)

    def draw(self, scene: Scene) -> dict[str, str] | None:
        """Return the curve as SVG, and sentences on the equilibria; None if no spindle speed balances the loads of the scene."""
        found = self._first if scene == self._scene else _analyse(scene)
        if found is None:
            return None
        picture = _plot(found, (self._first or found).curve)
        return {"picture": COLOUR.sub(r'\1="var(--c-\2, #\2)"', picture), "sentences": " ".join(_describe(found))}


def _analyse(scene: Scene) -> Statics | None:
    """Return the equilibria of a scene; None without a part that turns, or without a speed curve."""
    turns = any(part.turns for part in scene.parts)
    if not turns or (len(scene.parts) == 1 and not has_equilibrium_speed(scene)):
        return None
    try:
        alone = rotating_part_alone(scene)
        speed = abs(SpindleSpeedFunction(alone.spindle).start_speed)
        alone = alone.with_changes(spindle=Spindle(speeds=(speed,)))
        curve = compute_speed_curve(alone, CURVE_POINTS, **_friction_of(alone))
    except MechanismError:
        return None
    try:
        equilibria, problem = find_equilibria(alone, speed), ""
    except MechanismError as error:
        sentence = "; ".join(error.problems)
        equilibria, problem = (), f"{sentence[:1].upper()}{sentence[1:]}."
    return Statics(scene=alone, curve=curve, speed=speed, equilibria=equilibria, problem=problem)


def _friction_of(scene: Scene) -> dict[str, Any]:
    """Return resistance and reading of the constant dry friction of a scene; nothing unless there is just one."""
    frictions = [one for one in scene.output_effects if isinstance(one, DryFriction)]
    if len(frictions) != 1 or not frictions[0].force.is_constant:
        return {}
    return {"resistance": frictions[0].force.values[0], "against": frictions[0].reading}


def _describe(found: Statics) -> list[str]:
    """Return sentences on the equilibria: which the mechanism comes to rest in, how stable it is, which others there are, the friction."""
    if found.problem:
        return [found.problem, *_describe_band(found, None)]
    shown = _preferred(found)
    others = [f"{_place_of(found, one)} ({_kind_of(one)})" for one in found.equilibria if one is not shown]
    speed = format_quantity(found.speed, "rad/s", ".5g")
    sentence = f"At {speed}: {_kind_of(shown)} equilibrium at {_place_of(found, shown)}{_other_readings(found, shown)}."
    also = [f"Also in equilibrium at {', '.join(others)}."] if others else []
    return [sentence, _describe_stability(shown), *also, *_describe_band(found, shown)]


def _preferred(found: Statics) -> Equilibrium:
    """Return the equilibrium at which a mechanism comes to rest from its start: the nearest that is not unstable."""
    start = found.scene.start.values.get(found.curve.coordinate_name)
    position = start if isinstance(start, float) else 0.5 * sum(_travel_of(found.curve))
    return min(found.equilibria, key=lambda one: (not (one.stable or one.astatic), abs(one.coordinate - position)))


def _describe_band(found: Statics, shown: Equilibrium | None) -> list[str]:
    """Return a sentence on the speeds between which dry friction holds the mechanism where it is."""
    band = found.curve.insensitivity_band
    if band is None or not band.resistance or shown is None:
        return []
    falling, rising = (np.interp(shown.coordinate, found.curve.coordinate, one) for one in (band.falling_speed, band.rising_speed))
    low, high = (format_quantity(float(one), "rad/s", ".4g") for one in (falling, rising))
    share = f" (insensitivity {100 * float(rising - falling) / found.speed:.2g} %)" if found.speed and np.isfinite(rising) else ""
    return [f"Dry friction holds it there between {low} and {high}{share}."]


def _plot(found: Statics, given: SpeedCurve) -> str:
    """Return the speed curve with the speed of the scene and its equilibria."""
    curve, name = found.curve, found.curve.coordinate_name
    factor, unit = display_unit(_unit_of(found, name))
    x, y = curve.coordinate * factor, curve.speed / RPM
    ends = np.array([*_travel_of(given), *_travel_of(curve)]) * factor
    speeds = np.array([*_shown_speeds(given, found.speed), *_shown_speeds(curve, found.speed)]) / RPM
    limits = (ends.min(), ends.max()), (speeds.min(), speeds.max())
    plot = Plot(label_axis(name, unit), label_axis("equilibrium_speed", "rpm"), *limits)
    if not curve.has_equilibrium.any():
        plot.add_note("no spindle speed gives an equilibrium")
    _add_band(plot, curve, curve.insensitivity_band, x)
    if given is not curve:
        shown = given.coordinate * factor, given.speed / RPM, given.has_equilibrium
        plot.add_curve(*shown, colour=MUTED, dashes=GIVEN_DASHES, name=GIVEN_NAME)
    plot.add_level(found.speed / RPM, GREEN, format_quantity(found.speed, "rad/s", ".5g"))
    unstable = curve.has_equilibrium & ~curve.stable & ~curve.astatic
    plot.add_curve(x, y, _joined(curve.stable, curve), colour=BLUE, name="stable")
    plot.add_curve(x, y, _joined(unstable, curve), colour=BLUE, dashes="6 4", name="unstable")
    plot.add_curve(x, y, curve.astatic, colour=BLUE, dashes="1.5 2.5", name="neutral")
    if curve.folds:
        plot.name_points(VERMILLION, "jump")
    for value, speed in curve.folds:
        plot.add_point(value * factor, speed / RPM, VERMILLION)
    for one in found.equilibria:
        plot.add_point(one.coordinate * factor, found.speed / RPM, INK, is_filled=one.stable)
    return plot.to_svg(f"equilibrium speed over {format_reading_name(name)}")


def _add_band(plot: Plot, curve: SpeedCurve, band: InsensitivityBand | None, x: FloatArray) -> None:
    """Draw the speeds between which dry friction holds the mechanism."""
    if band is not None and band.resistance:
        plot.add_band(x, band.falling_speed / RPM, band.rising_speed / RPM, curve.has_equilibrium, colour=SKY, name="held by friction")


def _unit_of(found: Statics, reading: str) -> str:
    """Return the SI unit of a reading."""
    return READING_UNITS[found.scene.mechanism.reading(reading).quantity]


def _place_of(found: Statics, equilibrium: Equilibrium) -> str:
    """Return the leading coordinate of an equilibrium in words."""
    name = found.curve.coordinate_name
    unit = _unit_of(found, name)
    if equilibrium.astatic:
        low, high = (format_quantity(end, unit, ".4g") for end in equilibrium.extent)
        return f"{format_reading_name(name)} {low} to {high}"
    return f"{format_reading_name(name)} {format_quantity(equilibrium.coordinate, unit, '.4g')}"


def _other_readings(found: Statics, equilibrium: Equilibrium) -> str:
    """Return the other readings of an equilibrium in words."""
    names = [name for name in equilibrium.readings if name != found.curve.coordinate_name]
    texts = [f"{format_reading_name(name)} {format_quantity(equilibrium.readings[name], _unit_of(found, name), '.4g')}" for name in names]
    return f" ({', '.join(texts)})" if texts and not equilibrium.astatic else ""


def _kind_of(equilibrium: Equilibrium) -> str:
    """Return whether an equilibrium is stable, unstable or neutral."""
    return "neutral" if equilibrium.astatic else "stable" if equilibrium.stable else "unstable"


def _describe_stability(equilibrium: Equilibrium) -> str:
    """Return a sentence on the motion near an equilibrium."""
    if equilibrium.contact:
        return f"The loads press contact {equilibrium.contact} there with {equilibrium.push:.3g} N."
    if equilibrium.stable:
        return f"Without damping it swings about it with {equilibrium.frequency / (2 * math.pi):.3g} Hz."
    if equilibrium.astatic:
        return "It stays wherever it is put."
    return f"Without damping a disturbance grows at the rate {equilibrium.divergence_rate:.3g} 1/s."


def _travel_of(curve: SpeedCurve) -> Vec2:
    """Return both ends of the travel (SI)."""
    return float(curve.coordinate[0]), float(curve.coordinate[-1])


def _shown_speeds(curve: SpeedCurve, chosen: float) -> Sequence[float]:
    """Return the range of speeds (rad/s) in which most of a curve and the chosen speed lie, with a margin."""
    margin = int(SHOWN_SHARE * CURVE_POINTS)
    within = slice(margin, CURVE_POINTS - margin)
    speeds = np.append(curve.speed[within][curve.has_equilibrium[within]], chosen)
    return (1 - SPEED_MARGIN) * float(speeds.min()), (1 + SPEED_MARGIN) * float(speeds.max()) or 1.0


def _joined(kind: BoolArray, curve: SpeedCurve) -> BoolArray:
    """Return which points a kind of line covers: its own, and the first one after them, so that kinds meet without a gap."""
    following = np.concatenate([[False], kind[:-1]])
    covered: BoolArray = kind | (following & curve.has_equilibrium)
    return covered

"""Headings of plots: names at the left and a number at the right, in one line or, where they are too long for it, in two."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import INK, SERIF_FONT

NAME_HEIGHT, MIN_NAME_HEIGHT, NUMBER_HEIGHT = 12.5, 11.0, 12.0
"""Height (pixels) of a name, the smallest to which it shrinks for a place beside its number (not below the smallest other words of a film,
9.5, with a margin as it is a serif), and that of the number."""
LINE_PITCH = 15.0
"""Height (pixels) that a second line adds to a heading: its number is clear of the descenders above it."""
_FIRST_LINE = 7.0
"""Distance (pixels) of the middle of the first line from the top."""
_NUMBER_GAP, _NAME_GAP = 8.0, 4.0
"""Smallest distance (pixels) of a name to the number, and to the next name."""


class TextCanvas(Protocol):
    """What writes words and numbers; positions, heights and widths are in pixels of a frame 480 high."""

    def add_text(self, content: str, position: Vec2, height: float, *, max_width: float | None = None, **style: Any) -> Any:
        """Add text."""

    def add_number(self, texts: list[str], unit: str, position: Vec2, height: float, **style: Any) -> float:
        """Add a number that changes with every frame before a unit that ends at the position; return its left edge."""

    def measure_text(self, content: str, height: float, **style: Any) -> float:
        """Return the width of a text."""

    def measure_number(self, texts: list[str], unit: str, height: float, **style: Any) -> float:
        """Return the largest width of a number with its unit."""


@dataclass(frozen=True, kw_only=True)
class PlotHeading:
    """The heading of a plot: the names of its curves with their colours, and the number of the first curve at each frame."""

    names: Sequence[str]
    numbers: list[str]
    unit: str
    colour: str
    name_colours: Sequence[str] = (INK,)

    def needs_two_lines(self, canvas: TextCanvas, width: float) -> bool:
        """Return whether the names have no place beside the number in one line of a width."""
        number = canvas.measure_number(self.numbers, self.unit, NUMBER_HEIGHT, fontweight="bold")
        return self._names_width(canvas, MIN_NAME_HEIGHT) > width - number - _NUMBER_GAP

    def write(self, canvas: TextCanvas, ends: Vec2, top: float, *, in_two_lines: bool) -> None:
        """Write the heading between two ends from a top on: the number beside the names, or in the line below them."""
        left, right = ends
        y = top + _FIRST_LINE
        number_y = y + (LINE_PITCH if in_two_lines else 0.0)
        style = {"color": self.colour, "fontweight": "bold"}
        number_left = canvas.add_number(self.numbers, self.unit, (right, number_y), NUMBER_HEIGHT, **style)
        beside_number = number_left - _NUMBER_GAP
        if not in_two_lines:
            self._write_names(canvas, self.names, (left, beside_number), y)
        elif len(self.names) > 1 or self._names_width(canvas, MIN_NAME_HEIGHT) <= right - left:
            self._write_names(canvas, self.names, ends, y)
        else:
            first, second = _split_name(canvas, self.names[0], right - left)
            self._write_names(canvas, (first,), ends, y)
            self._write_names(canvas, (second,), (left, beside_number), number_y)

    def _write_names(self, canvas: TextCanvas, names: Sequence[str], ends: Vec2, y: float) -> None:
        """Write names in one line between two ends, as high as they have a place."""
        x, right = ends
        natural = self._names_width(canvas, NAME_HEIGHT, names)
        height = max(NAME_HEIGHT * min((right - x) / max(natural, 1.0), 1.0), MIN_NAME_HEIGHT)
        for name, colour in zip(_with_commas(names), self.name_colours, strict=False):
            canvas.add_text(name, (x, y), height, color=colour, fontfamily=SERIF_FONT, max_width=max(right - x, height))
            x += canvas.measure_text(name, height, fontfamily=SERIF_FONT) + _NAME_GAP

    def _names_width(self, canvas: TextCanvas, height: float, names: Sequence[str] | None = None) -> float:
        """Return the width of names in one line."""
        words = _with_commas(self.names if names is None else names)
        return sum(canvas.measure_text(name, height, fontfamily=SERIF_FONT) for name in words) + _NAME_GAP * (len(words) - 1)


def _with_commas(names: Sequence[str]) -> list[str]:
    return [*(f"{name}," for name in names[:-1]), names[-1]]


def _split_name(canvas: TextCanvas, name: str, width: float) -> tuple[str, str]:
    """Return the words of a name that have a place in a line of a width, at least one, and the other words."""
    words = name.split(" ")
    fitting = [k for k in range(2, len(words)) if canvas.measure_text(" ".join(words[:k]), MIN_NAME_HEIGHT, fontfamily=SERIF_FONT) <= width]
    count = max(fitting, default=1)
    return " ".join(words[:count]), " ".join(words[count:])

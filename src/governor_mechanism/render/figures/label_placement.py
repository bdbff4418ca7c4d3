"""Where words along a circle stand clear of each other and of what is there already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

STEP = 4.0
"""Points: words are moved by multiples of it, out from the circle and along it."""
STEPS_OUT, STEPS_ALONG = 5, 14
"""So far at most."""
LETTER, LINE = 0.5, 1.15
"""Breadth of a letter and height of a line, of the size of the letters."""

Box = tuple[float, float, float, float]
"""Left, right, bottom and top (points)."""


@dataclass(frozen=True, kw_only=True)
class Word:
    """Words at a place (points) with their alignment, and the direction out of the circle there."""

    words: str
    size: float
    at: tuple[float, float]
    ha: str
    va: str
    out: tuple[float, float]

    def box(self, shift: tuple[float, float]) -> Box:
        """The room it takes when it is moved by a shift (points)."""
        wide, high = LETTER * self.size * len(self.words), LINE * self.size
        left = self.at[0] + shift[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[self.ha] * wide
        bottom = self.at[1] + shift[1] - {"bottom": 0.0, "center": 0.5, "top": 1.0}[self.va] * high
        return left, left + wide, bottom, bottom + high


def shifts(words: Sequence[Word], taken: Sequence[Box], room: Box) -> list[tuple[float, float]]:
    """How far (points) to move each of the words: by nothing where it stands clear, else by as little as will do."""
    ways = sorted(
        ((far, along) for far in range(STEPS_OUT + 1) for along in range(-STEPS_ALONG, STEPS_ALONG + 1)),
        key=lambda way: (way[0] + abs(way[1]), way),
    )
    boxes, found = list(taken), []
    for word in words:
        (x, y), best = word.out, (0.0, 0.0)
        for far, along in ways:
            shift = STEP * (far * x - along * y), STEP * (far * y + along * x)
            box = word.box(shift)
            inside = box[0] >= room[0] and box[1] <= room[1] and box[2] >= room[2] and box[3] <= room[3]
            if inside and not any(_meet(box, other) for other in boxes):
                best = shift
                break
        boxes.append(word.box(best))
        found.append(best)
    return found


def _meet(one: Box, other: Box) -> bool:
    return one[0] < other[1] and other[0] < one[1] and one[2] < other[3] and other[2] < one[3]

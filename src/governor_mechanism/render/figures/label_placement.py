"""Placement of labels around a circle without overlap."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

_SHIFT_STEP = 4.0
"""Step of a label shift, outward or along the circle, points."""
_MAX_STEPS_OUT, _MAX_STEPS_ALONG = 5, 14
"""Largest numbers of steps outward and along the circle."""
_STEPS = sorted(
    product(range(_MAX_STEPS_OUT + 1), range(-_MAX_STEPS_ALONG, _MAX_STEPS_ALONG + 1)), key=lambda step: (step[0] + abs(step[1]), step)
)
"""Steps outward and along the circle, the shortest way first."""
_LETTER_WIDTH_RATIO, _LINE_HEIGHT_RATIO = 0.5, 1.15
"""Width of a letter and height of a line, as fractions of the font size."""

LabelBox = tuple[float, float, float, float]
"""Left, right, bottom and top (points)."""


@dataclass(frozen=True, kw_only=True)
class TextLabel:
    """Label at a position (points) with its alignment, and the outward direction of the circle there."""

    text: str
    size: float
    position: tuple[float, float]
    ha: str
    va: str
    outward_direction: tuple[float, float]

    def bounding_box(self, shift: tuple[float, float]) -> LabelBox:
        """Return the box of the label (points) after a shift (points)."""
        width, height = _LETTER_WIDTH_RATIO * self.size * len(self.text), _LINE_HEIGHT_RATIO * self.size
        left = self.position[0] + shift[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[self.ha] * width
        bottom = self.position[1] + shift[1] - {"bottom": 0.0, "center": 0.5, "top": 1.0}[self.va] * height
        return left, left + width, bottom, bottom + height

    def find_free_shift(self, occupied: Sequence[LabelBox], allowed_box: LabelBox) -> tuple[float, float]:
        """Return the smallest shift (points) without overlap, or none if no shift within the limits is free."""
        x, y = self.outward_direction
        for outward, along in _STEPS:
            shift = _SHIFT_STEP * (outward * x - along * y), _SHIFT_STEP * (outward * y + along * x)
            box = self.bounding_box(shift)
            inside = box[0] >= allowed_box[0] and box[1] <= allowed_box[1] and box[2] >= allowed_box[2] and box[3] <= allowed_box[3]
            if inside and not any(_overlap(box, other) for other in occupied):
                return shift
        return 0.0, 0.0


def _overlap(first: LabelBox, second: LabelBox) -> bool:
    return first[0] < second[1] and second[0] < first[1] and first[2] < second[3] and second[2] < first[3]

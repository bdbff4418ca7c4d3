"""Key of the steam's colours, a square for each phase and end of the cylinder, of which a frame marks the present one; and of scales."""

from collections.abc import Callable, Iterator, Mapping

from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, Moment
from governor_mechanism.render.geometry.outlines import make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, TextShape, Vec2
from governor_mechanism.render.machines.slide_valve.steam_distribution import (
    STEAM_PHASES,
    SteamDistribution,
    ValveGearPosition,
    steam_phase,
)

PHASE_NAMES = dict(zip(STEAM_PHASES, ("live steam", "expansion", "exhaust", "compression"), strict=True))
"""Name of each phase: what the steam at one end of the cylinder does."""

# In crank radii.
_ROW_PITCH, _WORD_PLACE, _WORD_WIDTH = 0.148, 0.25, 0.75
_RIGHT_WORDS = {-1.0: 0.68, 1.0: 0.78}
"""Place of the right of both words by the end that stands at the left: the words differ in length."""
_SQUARE_PLACES, _SQUARE_WIDTH, _SQUARE_HEIGHT, _FRAME_GAP = (0.0, 1.10), 0.18, 0.075, 0.028
"""Places of the squares of both ends, left and right of the names of the phases, as the ends of the drawn cylinder are."""


class SteamKey:
    """Key with its upper left corner at a place (m), of a size that suits a crank radius in the picture (m).

    `left_side` is the end of the cylinder whose squares stand at the left: -1 for the head end, 1 for the crank end.
    """

    def __init__(self, corner: Vec2, unit: float, left_side: float = -1.0) -> None:
        self._corner, self._unit = corner, unit
        self._right_word = _RIGHT_WORDS[left_side]
        self._places = dict(zip((left_side, -left_side), _SQUARE_PLACES, strict=True))

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the names and the squares."""
        u, (left, _) = self._unit, self._corner
        for side, place in zip(self._places, (0.0, self._right_word), strict=True):
            yield TextShape("scale", left + place * u, self._row(0), "crank end" if side > 0 else "head end", _WORD_WIDTH * u)
        for row, (phase, name) in enumerate(PHASE_NAMES.items(), start=1):
            yield TextShape("scale", left + _WORD_PLACE * u, self._row(row), name, _WORD_WIDTH * u)
            yield from (make_rectangle(phase, *self._square(row, side)) for side in self._places)

    def moving_parts(self, valve_gear: SteamDistribution, position_at: Callable[[Moment], ValveGearPosition]) -> Iterator[DrawnPart]:
        """Yield the frames around the squares of the present phases."""
        yield Flexible(shapes_at=lambda moment: [self._frames(valve_gear, position_at(moment))])

    def _frames(self, valve_gear: SteamDistribution, position: ValveGearPosition) -> Lines:
        frames = []
        for side in self._places:
            square = self._square(1 + STEAM_PHASES.index(steam_phase(valve_gear, position, side)), side, _FRAME_GAP * self._unit)
            points = make_rectangle("", *square).points
            frames.append((*points, points[0]))
        return Lines("phase frame", tuple(frames))

    def _square(self, row: int, side: float, margin: float = 0.0) -> tuple[float, float, float, float]:
        """Return left, right, bottom and top of the square of a row and an end of the cylinder with a margin (m) around it."""
        u, x, y = self._unit, self._corner[0] + self._places[side] * self._unit, self._row(row)
        half = 0.5 * _SQUARE_HEIGHT * u + margin
        return x - margin, x + _SQUARE_WIDTH * u + margin, y - half, y + half

    def _row(self, number: int) -> float:
        return self._corner[1] - (number + 0.5) * _ROW_PITCH * self._unit


def scale_note_shapes(corner: Vec2, unit: float, scales: Mapping[str, float]) -> Iterator[DrawnShape]:
    """Yield the scales of views relative to that of the scale bar, line by line from an upper left corner (m), as large as a key."""
    lines = ("scale of the bar:", *(f"{name} {scale:.2g} ×" for name, scale in scales.items()))
    for row, words in enumerate(lines):
        yield TextShape("scale", corner[0], corner[1] - (row + 0.5) * _ROW_PITCH * unit, words, 1.5 * _WORD_WIDTH * unit)

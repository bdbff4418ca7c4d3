"""Letters as strokes, for labels that move with what they name: Greek ones by their names, x, y and P, and the signs of coordinates.

A letter is one cap height high above its baseline, and drawn from lines and arcs of ellipses.
"""

import math
from collections.abc import Mapping, Sequence

from governor_mechanism.render.geometry.primitives import Lines, Vec2

Stroke = tuple[Vec2, ...]


def _arc(centre: Vec2, radii: Vec2, first: float, last: float) -> Stroke:
    """Return an arc of an ellipse from one angle to another (degrees)."""
    angles = [math.radians(first + (last - first) * k / 16) for k in range(17)]
    return tuple((centre[0] + radii[0] * math.cos(angle), centre[1] + radii[1] * math.sin(angle)) for angle in angles)


_STROKES: Mapping[str, Sequence[Stroke]] = {
    "alpha": [((0.52, 0.62), (0.42, 0.28), (0.30, 0.04), (0.16, 0.0), (0.03, 0.16), (0.03, 0.44), (0.18, 0.62), (0.32, 0.5), (0.54, 0.0))],
    "beta": [((0.05, -0.3), *_arc((0.25, 0.75), (0.20, 0.20), 180, -90)), (*_arc((0.24, 0.27), (0.24, 0.28), 90, -140),)],
    "gamma": [
        ((0.0, 0.52), (0.10, 0.62), (0.20, 0.48), (0.28, 0.08), (0.28, -0.2), (0.22, -0.3), (0.18, -0.16), (0.28, 0.12), (0.50, 0.62))
    ],
    "delta": [_arc((0.24, 0.27), (0.23, 0.27), 0, 360), ((0.40, 0.46), (0.16, 0.74), (0.16, 0.88), (0.28, 0.95), (0.42, 0.88))],
    "epsilon": [_arc((0.26, 0.47), (0.22, 0.15), 40, 270), _arc((0.26, 0.16), (0.25, 0.16), 90, 320)],
    "theta": [_arc((0.22, 0.47), (0.20, 0.47), 0, 360), ((0.02, 0.47), (0.42, 0.47))],
    "phi": [_arc((0.27, 0.3), (0.27, 0.28), 0, 360), ((0.27, 0.9), (0.27, -0.3))],
    "psi": [((0.3, 0.9), (0.3, -0.3)), ((0.0, 0.6), (0.04, 0.25), (0.3, 0.06), (0.56, 0.25), (0.6, 0.6))],
    "omega": [((0.12, 0.6), *_arc((0.16, 0.26), (0.15, 0.26), 160, 350), *_arc((0.46, 0.26), (0.15, 0.26), 190, 380), (0.5, 0.6))],
    "Theta": [_arc((0.33, 0.475), (0.33, 0.475), 0, 360), ((0.18, 0.475), (0.48, 0.475))],
    "Phi": [_arc((0.33, 0.475), (0.33, 0.28), 0, 360), ((0.33, 0.0), (0.33, 0.95))],
    "Omega": [((0.0, 0.0), (0.22, 0.0), *_arc((0.36, 0.54), (0.32, 0.41), 242, -62), (0.5, 0.0), (0.72, 0.0))],
    "x": [((0.0, 0.6), (0.45, 0.0)), ((0.0, 0.0), (0.45, 0.6))],
    "y": [((0.0, 0.6), (0.24, 0.02)), ((0.48, 0.6), (0.1, -0.3))],
}

_SIGNS: Mapping[str, Sequence[Stroke]] = {
    "P": [((0.0, 0.0), (0.0, 0.95), (0.28, 0.95), *_arc((0.28, 0.7), (0.25, 0.25), 90, -90), (0.0, 0.45))],
    "(": [_arc((0.34, 0.35), (0.28, 0.62), 120, 240)],
    ")": [_arc((0.0, 0.35), (0.28, 0.62), 60, -60)],
    ",": [((0.06, 0.04), (0.0, -0.16))],
}
"""What stands beside the letters of coordinates; no name of a reading."""


def is_drawn_letter(name: str) -> bool:
    """Return whether there are strokes for a letter."""
    return name in _STROKES


def make_letters(role: str, names: Sequence[str], middle: Vec2, height: float) -> Lines:
    """Return letters beside one another around a position (m), with capitals of a height (m)."""
    strokes: list[Stroke] = []
    left = 0.0
    for name in names:
        drawn = _STROKES.get(name) or _SIGNS[name]
        width = max(x for stroke in drawn for x, _ in stroke)
        strokes += [tuple((left + x, y) for x, y in stroke) for stroke in drawn]
        left += width + 0.28
    offset = (0.5 * (left - 0.28), 0.38)
    x0, y0 = middle
    return Lines(role, tuple(tuple((x0 + height * (x - offset[0]), y0 + height * (y - offset[1])) for x, y in one) for one in strokes))

"""Drive of a governor's spindle: a pair of bevel wheels at its foot, and the shaft with the pulley that the engine turns."""

from collections.abc import Iterator

from governor_mechanism.render.geometry.outlines import make_hatched_block, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2

# Lengths as fractions of the unit of the drive.
_PITCH_RADIUS, _FACE_WIDTH, _SHAFT_HALF_WIDTH = 0.105, 0.05, 0.018
_SHAFT_END, _BEARING_LEFT, _BEARING_RIGHT, _BEARING_HEIGHT = 0.60, 0.22, 0.31, 0.05
_PULLEY_LEFT, _PULLEY_RIGHT, _PULLEY_RADIUS = 0.42, 0.56, 0.13
DRIVE_DEPTH = 2 * _PITCH_RADIUS
"""Height of the pair of bevel wheels, as a fraction of the unit."""
_TEETH = (-0.8, -0.55, -0.25, 0.05, 0.35, 0.6, 0.82)
"""Places of the drawn teeth across a wheel, as fractions of its pitch radius."""


def spindle_drive_shapes(top: float, unit: float) -> Iterator[DrawnShape]:
    """Yield two bevel wheels below a height `top` (m), the shaft to the right, its bearing, and its pulley; `unit` (m) sizes them."""
    radius, face, half = _PITCH_RADIUS * unit, _FACE_WIDTH * unit, _SHAFT_HALF_WIDTH * unit
    apex = top - radius
    for bottom, height in ((apex + half, _BEARING_HEIGHT * unit), (apex - half - _BEARING_HEIGHT * unit, _BEARING_HEIGHT * unit)):
        box = (_BEARING_LEFT * unit, _BEARING_RIGHT * unit, bottom, bottom + height)
        block, lining = make_hatched_block("bearing", (0.0, 0.0, 0.0), box, 0.03 * unit)
        yield Polygon("gearing bearing", block.points)
        yield Lines("gearing hatching", lining.lines)
    yield make_rectangle("gearing shaft", radius, _SHAFT_END * unit, apex - half, apex + half)
    pulley = (_PULLEY_LEFT * unit, _PULLEY_RIGHT * unit, apex - _PULLEY_RADIUS * unit, apex + _PULLEY_RADIUS * unit)
    yield make_rectangle("gearing wheel", *pulley)
    middle = 0.5 * (pulley[0] + pulley[1])
    yield Lines("gearing tooth", (((middle, pulley[2]), (middle, pulley[3])),))
    yield from _bevel_wheel(radius, face, apex, upright=True)
    yield from _bevel_wheel(radius, face, apex, upright=False)


def _bevel_wheel(radius: float, face: float, apex: float, *, upright: bool) -> Iterator[DrawnShape]:
    """Yield a wheel whose pitch cone has its apex on the axis at a height (m): on the spindle if it is upright, else on the shaft."""

    def place(across: float, along: float) -> Vec2:
        """Return a point at distances from the axis of the wheel and along it from the apex (m)."""
        return (across, apex + along) if upright else (along, apex + across)

    inner = radius - face
    yield Polygon("gearing wheel", tuple(place(*point) for point in ((-radius, radius), (radius, radius), (inner, inner), (-inner, inner))))
    hub = ((-0.5 * radius, radius), (0.5 * radius, radius), (0.5 * radius, 1.25 * radius), (-0.5 * radius, 1.25 * radius))
    yield Polygon("gearing wheel", tuple(place(*point) for point in hub))
    teeth = tuple((place(part * inner, inner), place(part * radius, radius)) for part in _TEETH)
    yield Lines("gearing tooth", teeth)

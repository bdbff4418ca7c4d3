"""A drawing at one moment as a picture that does not move: SVG without colours of its own, styled by the rules of roles."""

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import chain

import numpy as np

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.page.colours import class_of
from governor_mechanism.render.page.picture import Picture
from governor_mechanism.render.page.views import PageView


def draw_poster(view: PageView) -> str:
    """Return the drawing of a view at its first sample as an SVG element."""
    picture, stroke = view.picture, view.stroke
    width, height = picture.size
    shapes = chain(view.static_shapes, view.shapes_at(0))
    elements = "".join(_draw_shapes(picture, shapes))
    return (
        f'<svg viewBox="{-stroke:.0f} {-stroke:.0f} {width + 2 * stroke:.0f} {height + 2 * stroke:.0f}" style="--stroke:{stroke:.2f}"'
        f' aria-hidden="true">{elements}</svg>'
    )


def _draw_shapes(picture: Picture, shapes: Iterable[DrawnShape]) -> Iterator[str]:
    """Yield the elements of shapes, without those that are hidden."""
    for shape in shapes:
        name = class_of(shape.role)
        match shape:
            case Circle(_, x, y, radius):
                if radius > 0.0:
                    (cx, cy), r = _place(picture, [(x, y)])[0], round(radius * picture.scale)
                    yield f'<circle class="{name}" cx="{cx}" cy="{cy}" r="{r}"/>'
            case Polygon(_, points):
                if points:
                    yield f'<path class="{name}" d="{_path(picture, points)}Z"/>'
            case Lines(_, lines):
                path = "".join(_path(picture, line) for line in lines if len(line))
                if path:
                    yield f'<path class="{name} lines" d="{path}"/>'
            case TextShape(_, x, y, text, _):
                tx, ty = _place(picture, [(x, y)])[0]
                yield f'<text class="{name} text" x="{tx}" y="{ty}">{escape(text)}</text>'


def _place(picture: Picture, points: Sequence[Vec2]) -> list[tuple[int, int]]:
    """Return points in whole units of the picture."""
    return [(int(x), int(y)) for x, y in np.rint(picture.place(np.array(points)))]


def _path(picture: Picture, points: Sequence[Vec2]) -> str:
    """Return an open path."""
    return "M" + "L".join(f"{x} {y}" for x, y in _place(picture, points))

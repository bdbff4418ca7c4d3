"""Shapes of a drawing as SVG, in the styles of films."""

from collections.abc import Iterable, Sequence
from html import escape

from governor_mechanism.render.geometry.pixel_view import PixelView
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.style import ROLE_STYLES, SANS_FONT

TEXT_HEIGHT = 8.5
"""Height of a text of a drawing, pixels, as in a film of 480 pixels."""


def draw_shapes(shapes: Iterable[DrawnShape], view: PixelView) -> str:
    """Return the elements of shapes (m), back to front, in the pixels of a view, without the element <svg> around them."""
    left, top, right, bottom = view.rect
    middle_x, middle_y = (left + right) / 2, (top + bottom) / 2

    def place(point: Vec2) -> Vec2:
        return middle_x + (point[0] - view.x) * view.scale, middle_y - (point[1] - view.y) * view.scale

    def path(points: Sequence[Vec2]) -> str:
        return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in map(place, points))

    elements = []
    for shape in shapes:
        style = ROLE_STYLES[shape.role]
        stroke = f'stroke="{style.stroke}" stroke-width="{style.width:g}"'
        fill = f'fill="{style.fill}"' + (f' fill-opacity="{style.opacity:g}"' if style.opacity < 1.0 else "")
        if style.dashes:
            stroke += f' stroke-dasharray="{" ".join(f"{length:g}" for length in style.dashes)}"'
        match shape:
            case Circle(_, x, y, radius):
                cx, cy = place((x, y))
                elements.append(f'<circle cx="{cx:.2f}" cy="{cy:.2f}" r="{radius * view.scale:.2f}" {fill} {stroke}/>')
            case Polygon(_, points) if points:
                elements.append(f'<path d="{path(points)}Z" {fill} {stroke} stroke-linejoin="round"/>')
            case Lines(_, lines) if any(lines):
                elements.append(f'<path d="{"".join(path(line) for line in lines if line)}" fill="none" {stroke}/>')
            case TextShape(_, x, y, text, _):
                tx, ty = place((x, y))
                elements.append(write_text(tx, ty, text, height=TEXT_HEIGHT, colour=style.stroke))
            case _:  # an empty outline
                pass
    return "".join(elements)


def write_text(x: float, y: float, text: str, *, height: float, colour: str, anchor: str = "start", turned: bool = False) -> str:
    """Return a line of text, all in pixels: its start, middle or end (`anchor`) and its middle height are at (x, y); `turned` is up."""
    # A shift of a third of the height centres digits and letters; Firefox ignores dominant-baseline="central" in some fonts.
    turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
    font = f'font-size="{height:g}" font-family="{SANS_FONT}, sans-serif" text-anchor="{anchor}" fill="{colour}"'
    return f'<text x="{x:.1f}" y="{y + 0.34 * height:.1f}" {font}{turn}>{escape(text)}</text>'


def frame_picture(elements: str, width: float, height: float, colour: str, description: str, *, is_faded: bool = False) -> str:
    """Return elements on paper of a size (pixels) and colour as a picture with a description for screen readers.

    A faded one shows an earlier state. It shrinks with a narrow notebook.
    """
    size = f'width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}" style="max-width:100%;height:auto"'
    paper = f'<rect width="{width:g}" height="{height:g}" fill="{colour}"/>'
    content = f'<g opacity="0.4">{elements}</g>' if is_faded else elements
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{escape(description)}">{paper}{content}</svg>'

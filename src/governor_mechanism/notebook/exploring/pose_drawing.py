"""Drawing of a mechanism at any pose of its travel, as SVG in the styles of films."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape

import numpy as np

from governor_mechanism.mechanics.kinematics.point_paths import point_path
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    PixelRect,
    PixelView,
    Polygon,
    TextShape,
    Vec2,
    bounding_box,
    enclose_boxes,
    fit_view,
    round_step,
)
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.motion_layers import curve_shape, requested_points
from governor_mechanism.render.part_run import motion_at_rest
from governor_mechanism.render.style import MUTED, PAPER, ROLE_STYLES, SANS_FONT
from governor_mechanism.types import FloatArray

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


WIDTH, HEIGHT = 320.0, 400.0
"""Size of a drawing, pixels."""
_SHAPES_RECT: PixelRect = (8.0, 8.0, WIDTH - 8.0, HEIGHT - 30.0)
"""Rectangle of the shapes."""


MAX_POSES = 37
"""Number of poses of a drawing, as one for every 10 degrees of a turn; their shapes take most of the time of a new drawing."""

DRAWN_FROM_RUNS = {"flywheel_engine"}
"""Machines whose drawing shows forces of a run, as pressures of steam; here they are drawn from their bodies."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PoseDrawing:
    """Drawing of the only part of a scene over its travel."""

    scene: Scene  # scene of one part
    poses: FloatArray  # poses over the travel; shape (n, bodies, 3)
    readings: Mapping[str, FloatArray]  # readings by name at these poses, SI; shape (n,)

    @cached_property
    def box(self) -> BoundingBox:
        """The box (m) that contains the mechanism at all poses, and the paths of its points."""
        return enclose_boxes([self._drawing.bounds, bounding_box(self._paths)])

    def draw(
        self,
        pose: FloatArray,  # pose of all bodies; shape (bodies, 3)
        box: BoundingBox,  # what the picture shows, m
        *,
        is_faded: bool = False,  # whether it is pale, since it shows an earlier state
    ) -> str:
        """Return a picture of the mechanism."""
        view = fit_view(box, _SHAPES_RECT)
        # The poses of the drawing are a curve without time, so that the time at which it stands is any.
        moving = draw_shapes((*self._drawing.moving_shapes(pose, 0.0), *self._paths), view)
        elements = f"{draw_shapes(self._drawing.static_shapes, view)}{moving}{_scale_bar(view)}"
        return frame_picture(elements, WIDTH, HEIGHT, PAPER, f"drawing of {self.scene.title}", is_faded=is_faded)

    @cached_property
    def _paths(self) -> list[DrawnShape]:
        """The paths of the points that the scene names."""
        points = requested_points(self.scene, self.scene.part, None).values()
        return [curve_shape([point_path(self.scene.part.mechanism, self.poses, point) for point in points])] if points else []

    @cached_property
    def _drawing(self) -> MachineDrawing:
        rows = np.unique(np.linspace(0, len(self.poses) - 1, MAX_POSES).astype(int))
        readings = {name: values[rows] for name, values in self.readings.items()}
        motion = motion_at_rest(self.scene, self.poses[rows], readings)
        if self.scene.part.machine in DRAWN_FROM_RUNS:
            return GenericDrawing(run=motion, part=self.scene.part)
        return drawing_of(motion, self.scene.part)


def _scale_bar(view: PixelView) -> str:
    """Return a scale bar of a round length in millimetres below the shapes."""
    left, _, right, bottom = view.rect
    length, start, y = round_step((right - left) / view.scale, 5), left + 6.0, bottom + 14.0
    end = start + length * view.scale
    bar = f"M{start:.1f} {y:.1f}H{end:.1f}M{start:.1f} {y - 3:.1f}v6M{end:.1f} {y - 3:.1f}v6"
    text = write_text(end + 6.0, y, f"{length * 1e3:g} mm", height=10.0, colour=MUTED)
    return f'<path d="{bar}" stroke="{MUTED}" stroke-width="0.8"/>{text}'

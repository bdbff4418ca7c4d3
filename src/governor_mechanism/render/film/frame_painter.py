"""Painter of one run: the parts at the left in true proportions, the curves of their main readings at the right."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmLayout, FilmOptions, FilmView
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.frame_canvas import LINE_PITCH, FrameCanvas, HeadingRow, PlotHeading
from governor_mechanism.render.film.labels import (
    LABEL_HEIGHT,
    LETTER_WIDTH,
    AngleArc,
    PlacedLabel,
    find_labels,
    place_labels,
    thin_out_numbers,
)
from governor_mechanism.render.film.layout import PLOT_GAP, frame_layout, shift_rect, with_names
from governor_mechanism.render.film.moving_parts import Panel
from governor_mechanism.render.film.outside_view import OutsideView, outside_box
from governor_mechanism.render.frame_data import (
    REACTION,
    DrawnForce,
    FrameData,
    ShownParts,
    enclosing_box,
    find_forces,
    on_one_scale,
    shows_bodies,
    turns_with_spindle,
)
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_shifted, axes_turned
from governor_mechanism.render.geometry.outlines import make_arrow
from governor_mechanism.render.geometry.primitives import (
    SMALL_TEXT,
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    PixelRect,
    PixelView,
    TextShape,
    Vec2,
    arc_points,
    enclose_boxes,
    fit_view,
    round_step,
    share_scale,
)
from governor_mechanism.render.motion_layers import MotionLayers, PointPaths, last_second
from governor_mechanism.render.plot_panels import PlotPanel, choose_part_panels
from governor_mechanism.render.shown_readings import format_film_speed, format_name
from governor_mechanism.render.style import INK, MUTED, ROLE_STYLES, SERIF_FONT, VERMILLION
from governor_mechanism.types import FloatArray

_ARROW_SIZE = 0.055
"""Half width of the arrow of rotation, relative to the height of the drawing."""
_FORCE_LENGTH, _FORCE_HEAD = 0.24, 0.035
"""Length of the largest force, and of the head of an arrow, relative to the larger side of the drawing."""
_MIN_FORCE_RATIO = 0.01
"""Force relative to the largest, below which no arrow is drawn: it would be shorter than a pixel or two."""
_PLAN_ARROW = math.radians(55)
"""Angle of the arrow of rotation on the ring of the plan view."""


def rotation_arrow(data: FrameData, box: BoundingBox) -> list[DrawnShape]:
    """Return an arrow around the axis of a spindle, seen from the side, above a box (m), in the sense of its first rotation."""
    _, _, bottom, top = box
    size = _ARROW_SIZE * (top - bottom)
    sense = 1.0 if data.spindle_angle[-1] >= data.spindle_angle[0] else -1.0
    # The front half of a circle around the axis, whose height is foreshortened; anticlockwise from above is to the right in front.
    front = [(sense * x, top + 0.9 * size + 0.4 * y) for x, y in arc_points((0.0, 0.0), math.radians(160), math.radians(235), size, 32)]
    return [*make_arrow("rotation", front, 0.55 * size), TextShape("rotation", 1.35 * size, top + 0.9 * size, "ω", size)]


def box_with_rotation_arrow(box: BoundingBox) -> BoundingBox:
    """Return a box (m) with space for the arrow of rotation at its top."""
    left, right, bottom, top = box
    return left, right, bottom, top + 1.7 * _ARROW_SIZE * (top - bottom)


def plan_parts(data: FrameData, ring_radius: float) -> list[DrawnPart]:
    """Return the plan view, as parts whose moments are the numbers of the frames, with an arrow of rotation on its ring.

    The arrow is in front of the hand, and as long as the rotation since the last frame if that is longer: a speed too high for the frame
    rate shows as a closed ring.
    """
    angles = data.spindle_angle
    sense = math.copysign(1.0, float(angles[-1] - angles[0]))
    steps = np.abs(np.diff(angles, prepend=angles[:1]))
    lengths = np.clip(steps, _PLAN_ARROW, 2 * math.pi).tolist() if np.ptp(angles) > 0.0 else [0.0] * len(angles)

    def arrow(k: int) -> tuple[DrawnShape, ...]:
        arc = arc_points((0.0, 0.0), -sense * lengths[k], sense * lengths[k], ring_radius, 32)
        return make_arrow("sweep", arc, 0.24 * ring_radius)

    frame = axes_turned((0.0, 0.0), lambda k: float(angles[k]))
    keeps_length = len(set(lengths)) == 1
    return [
        Attached(frame=frame, shapes=arrow(0)) if keeps_length else Flexible(shapes_at=arrow, frame=frame),
        Flexible(shapes_at=lambda k: data.drawing.dial_shapes(data.poses[k], 0.0, ring_radius), frame=frame),
    ]


def trace_shapes(data: FrameData) -> list[DrawnShape]:
    """Return the paths of the mass centres in the shown time, and the path that the drawing traces."""
    poses = data.poses_at(data.sample_times)
    paths = [poses[:, index, :2] for index in range(poses.shape[1])] if shows_bodies(data) else []
    if (traced := data.drawing.traced_path(poses)) is not None:
        paths.append(traced)
    moving = [path for path in paths if np.ptp(path, axis=0).max(initial=0.0) > 1e-6 * data.part.mechanism.length_scale]
    return [Lines("path", tuple(tuple(map(tuple, path.tolist())) for path in moving))]


class ForceArrows:
    """Arrows of the forces on the bodies of a part, all on one scale for a drawing in a box (m).

    Without `shows_all` they are those of joints that are readings of the run, and there are none where the motion is magnified.
    """

    def __init__(self, data: FrameData, box: BoundingBox, *, shows_all: bool, is_magnified: bool = False) -> None:
        left, right, bottom, top = box
        size = max(right - left, top - bottom)
        self._head = _FORCE_HEAD * size
        forces = find_forces(data, only_reactions=not shows_all) if shows_bodies(data) and not is_magnified else []
        self.largest = max((_magnitude(force) for force in forces), default=0.0)
        self._forces = [force for force in forces if _magnitude(force) > _MIN_FORCE_RATIO * self.largest]
        # Metres per newton.
        self.scale = _FORCE_LENGTH * size / self.largest if self.largest else 0.0
        self._starts = [point_path(data.part.mechanism, data.poses, force.point) for force in self._forces]

    @property
    def kinds(self) -> list[str]:
        """Return the kinds of the forces, each once."""
        return list(dict.fromkeys(force.kind for force in self._forces))

    def enclosing_box(self, box: BoundingBox) -> BoundingBox:
        """Return the smallest box (m) around a box and all arrows."""
        if not self._forces:
            return box
        tips = np.concatenate([s + self.scale * f.components for s, f in zip(self._starts, self._forces, strict=True)])
        (x0, y0), (x1, y1) = tips.min(axis=0).tolist(), tips.max(axis=0).tolist()
        return min(box[0], x0), max(box[1], x1), min(box[2], y0), max(box[3], y1)

    def parts(self) -> Iterator[DrawnPart]:
        """Yield the arrows, whose moments are the numbers of the frames."""
        for force, start in zip(self._forces, self._starts, strict=True):
            frame = axes_shifted(partial(_point_of, start))
            yield Flexible(shapes_at=partial(self._arrow, force), frame=frame)

    def _arrow(self, force: DrawnForce, k: int) -> Iterable[DrawnShape]:
        """Return the arrow of a force at frame k, from the origin."""
        return make_arrow(f"{force.kind} force", ((0.0, 0.0), _point_of(self.scale * force.components, k)), self._head)


def _magnitude(force: DrawnForce) -> float:
    """Return the largest magnitude of a force, N."""
    return float(np.hypot(*force.components.T).max(initial=0.0))


def _point_of(path: FloatArray, k: int) -> Vec2:
    """Return the point of a path (n, 2) at frame k."""
    x, y = path[k].tolist()
    return x, y


AddText = Callable[..., Any]
"""Writes words at a position (pixels) with a height (pixels) and a colour."""


class ElevationOverlay:
    """Shapes over the elevation of a part in a box (m), as chosen by options; `box` (m) has space for them."""

    def __init__(self, data: FrameData, box: BoundingBox, options: FilmOptions) -> None:
        self._data = data
        self.static_shapes: list[DrawnShape] = []
        self.box = box
        turns = data.part.plane == TURNING_PLANE and bool(np.ptp(data.spindle_angle) > 0.0)
        if turns:
            self.static_shapes += rotation_arrow(data, box)
            self.box = box_with_rotation_arrow(box)
        if options.traces:
            self.static_shapes += trace_shapes(data)
        self._paths = PointPaths(data, options.paths)
        self.arrows = ForceArrows(data, box, shows_all=options.forces, is_magnified=options.exaggerate > 1.0)
        self.layers = MotionLayers(data, box, options.layers if shows_bodies(data) else ())
        self.box = self.layers.enclosing_box(self._paths.enclosing_box(self.arrows.enclosing_box(self.box)))
        self._angle = AngleArc(data) if options.labels else None
        self._labels = [*find_labels(data), *self._angle.labels] if self._angle is not None else []
        self._placed: list[PlacedLabel] = []

    def place_labels(self, view: PixelView, add_text: AddText, shift: float) -> None:
        """Write the names at the right of a view, and add the shapes of the drawing that do not move to the static ones."""
        self.static_shapes += thin_out_numbers(list(self._data.drawing.static_shapes), view)
        self._placed = place_labels(self._data, self._labels, view, self.static_shapes)
        for label in self._placed:
            add_text(label.name, (view.rect[2] + 6.0 - shift, label.height), LABEL_HEIGHT, color=INK)

    def parts(self) -> Iterator[DrawnPart]:
        """Yield the parts that move, whose moments are the numbers of the frames."""
        yield from self._paths.parts()
        yield from self.arrows.parts()
        yield from self.layers.parts()
        if self._angle is not None:
            yield Flexible(shapes_at=self._angle.shapes_at)
        if self._placed:
            yield Flexible(shapes_at=self._label_lines)

    def _label_lines(self, k: int) -> list[DrawnShape]:
        return [Lines("label line", tuple(piece for label in self._placed for piece in label.lines[k]))]


MAX_SHOWN_READINGS = {True: 3, False: 4}
"""Number of readings in the side panel, with and without the dial."""
CAPTION_PITCH = 14.0
"""Distance (pixels) of lines below a drawing."""
FORCE_NAMES_HEIGHT = 16.0
"""Height (pixels) that the names of forces, or of layers, take from the elevation."""
FORCE_NAMES = {"centrifugal": "centrifugal force", "spring": "spring force", "damping": "damping force", REACTION: "joint force"}
"""Names of kinds of forces; a weight is called so."""


class FramePainter(FrameCanvas):
    """Frames of one run, each part in a panel of its own.

    Of the `parts` of the run, only the last one can have a plan view, and all positions count from its frame. `compared` are the parts of
    all runs that share the limits of this frame (their scale only if they are of like size), by default those of this run alone. `options`
    say what is shown; the frame of a machine alone may have a smaller `height` (of 480), as `painters.machine_height` finds it.
    """

    def __init__(
        self,
        run: Trajectory,
        parts: ShownParts,
        size: int = 480,
        *,
        title: str | None = None,
        compared: Sequence[ShownParts] = (),
        options: FilmOptions = DEFAULT_OPTIONS,
        height: float = layout.REFERENCE_SIZE,
        animated: bool = True,
    ) -> None:
        # By part, its data in all runs.
        self._columns = list(zip(*(compared or [parts]), strict=True))
        has_plan = any(turns_with_spindle(data) for data in self._columns[-1])
        self._names_width = max(map(_measure_names, parts)) if options.labels else 0.0
        self._places = places = with_names(frame_layout(options, has_plan, _aspect_ratio(self._columns), height), self._names_width)
        # The panels of drawings from left to right: the number of the part, and whether it is seen from outside.
        self._slots = [(k, is_outside) for k, data in enumerate(parts) for is_outside in views_of(data, options.view)]
        super().__init__(size, (len(self._slots) - 1) * places.part_pitch, options, places.width, height)
        self._shown_parts = parts
        self.frame_data = frame_data = parts[-1]
        # Whether the plan of the turning plane is shown.
        self._has_dial = places.dial is not None and turns_with_spindle(frame_data)
        self._add_title_and_footer(run, run.scene.title if title is None else title, frame_data)
        panels: list[Panel] = self._make_drawings()
        panels += self._make_reading_plots()
        if places.dial is not None and self._has_dial:
            panels.append(self._make_plan(places.dial))
        self._finish(panels, animated)

    def _make_drawings(self) -> list[Panel]:
        """Return the panels of the drawings from left to right; both views of a part have one scale, and like heights side by side."""
        above = [self._write_above(position) for position in range(len(self._slots))]
        overlays: dict[int, ElevationOverlay] = {}
        views: dict[tuple[int, bool], PixelView] = {}
        for slot, place in zip(self._slots, above, strict=True):
            index, is_outside = slot
            if is_outside:
                views[slot] = self._fit_outside(index, place)
            else:
                overlays[index], views[slot] = self._fit_elevation(index, place)
        for index in {index for index, _ in self._slots if (index, True) in views and (index, False) in views}:
            views[index, False], views[index, True] = share_scale(views[index, False], views[index, True])
        panels = []
        for (index, is_outside), place in zip(self._slots, above, strict=True):
            view = views[index, is_outside]
            panels.append(
                self._make_outside(index, place, view) if is_outside else self._make_elevation(index, place, overlays[index], view)
            )
        return panels

    def _write_above(self, position: int) -> Vec2:
        """Write what is above the drawing at a position from the left: the name of its part, or a factor.

        Return the distance of the drawing from the rightmost one, and the height taken from its top, pixels.
        """
        frame_data = self._shown_parts[self._slots[position][0]]
        shift = position * self._places.part_pitch - self._shift
        x, y = layout.PART_NAME_POSITION
        if len(self._shown_parts) > 1:
            self.add_text(format_name(frame_data.part.name), (x + shift, y), 12.5, fontfamily=SERIF_FONT, max_width=260)
            return shift, layout.PART_NAME_HEIGHT
        if self._options.exaggerate > 1.0:
            words = f"motion magnified {self._options.exaggerate:.4g} ×"
            self.add_text(words, (x + shift, y), 12, color=VERMILLION, fontweight="bold")
            return shift, layout.PART_NAME_HEIGHT
        return shift, 0.0

    def _fit_elevation(self, index: int, place: Vec2) -> tuple[ElevationOverlay, PixelView]:
        """Return what is drawn over the plane of part `index`, and the largest view that has space for it; for `place` see above."""
        frame_data, (shift, above) = self._shown_parts[index], place
        rect = shift_rect(self._places.elevation, shift + self._shift, above)
        box = enclosing_box(on_one_scale(self._columns[index], frame_data), self._options.layout)
        overlay = ElevationOverlay(frame_data, box, self._options)
        names_height, words_height = heights_of_words(frame_data, overlay)
        left, top, right, bottom = shift_rect(rect, 0.0, names_height)
        return overlay, fit_view(overlay.box, (left, top, right - self._names_width, bottom - words_height))

    def _make_elevation(self, index: int, place: Vec2, overlay: ElevationOverlay, view: PixelView) -> Panel:
        """Return the panel of the plane of part `index`, and write its scale bar."""
        frame_data, (shift, above) = self._shown_parts[index], place
        self.view = view
        overlay.place_labels(view, self.add_text, self._shift)
        self._add_scale_bars(frame_data, view, shift, above, overlay)
        drawing = frame_data.drawing
        path = None if self._options.traces else drawing.traced_path(frame_data.poses_at(frame_data.sample_times))
        ends = drawing.traced_path(frame_data.poses)
        if path is not None and _is_behind_ball(frame_data, path):
            path = None
        parts = [*frame_data.moving_parts(), *overlay.parts()]
        if path is not None and ends is not None:
            parts.insert(0, Flexible(shapes_at=lambda k: [Lines("trace", (last_second(frame_data, path, ends, k),))]))
        return self._make_shape_panel(view, overlay.static_shapes, parts)

    def _outside_box(self, index: int) -> BoundingBox:
        """Return the box (m) around part `index` seen from outside, in all runs that share its scale."""
        return enclose_boxes(outside_box(data.drawing.bounds) for data in on_one_scale(self._columns[index], self._shown_parts[index]))

    def _fit_outside(self, index: int, place: Vec2) -> PixelView:
        """Return the largest view of part `index` from outside."""
        shift, above = place
        rect = shift_rect(self._places.elevation, shift + self._shift, above)
        return fit_view(box_with_rotation_arrow(self._outside_box(index)), rect)

    def _make_outside(self, index: int, place: Vec2, view: PixelView) -> Panel:
        """Return the panel of part `index` seen from outside, and write its scale bar."""
        frame_data = self._shown_parts[index]
        seen = OutsideView(frame_data)
        self._add_length_bar(view, place[0])
        self._add_view_words(["seen from outside", *_speed_words(frame_data)], place[0])
        self.outside_view = view
        return self._make_sorted_panel(view, rotation_arrow(frame_data, self._outside_box(index)), seen.shapes_at, seen.order_at)

    def _make_plan(self, rect: PixelRect) -> Panel:
        """Return the panel of the turning plane seen from above, and write its caption."""
        frame_data = self.frame_data
        column = [data for data in on_one_scale(self._columns[-1], frame_data) if turns_with_spindle(data)]
        ring_radius = max(data.drawing.dial_ring_radius() for data in column)
        half_width = 1.12 * ring_radius
        view = fit_view((-half_width, half_width, -half_width, half_width), shift_rect(rect, self._shift))

        is_below_plots = self._places.readings is not None and rect[0] >= self._places.readings[0]
        position = (rect[2] + 6.0, rect[3] - 6.0) if is_below_plots else ((rect[0] + rect[2]) / 2, rect[1] - 8.0)
        self.add_text("plan view", position, SMALL_TEXT, color=MUTED, ha="left" if is_below_plots else "center")
        return self._make_shape_panel(view, (Circle("ring", 0.0, 0.0, ring_radius),), plan_parts(frame_data, ring_radius))

    def _make_reading_plots(self) -> list[Panel]:
        """Return the plots of the shown readings, and write their names and numbers; of what is only stated there are only these."""
        panels = self._choose_panels() if self._places.readings is not None else []
        plotted = [panel for panel in panels if not panel.is_stated]
        rects = self._places.reading_rects(len(plotted), self._has_dial, len(panels) - len(plotted))
        headings = [PlotHeading.of(panel, self.frame_data.times) for panel in panels]
        rects, heights = self._fit_columns(headings, rects)
        label_widths: dict[float, float] = {}
        for (left, *_), panel in zip(rects, plotted, strict=False):
            label_widths[left] = max(label_widths.get(left, 0.0), self._measure_labels(panel.limits))
        plots: list[Panel] = []
        for panel, rect in zip(plotted, rects, strict=False):
            left, top, right, bottom = rect
            plot_top = top + layout.HEADING_HEIGHT + (LINE_PITCH if heights[top] is None else 0.0)
            is_lowest = bottom > max(rect[3] for rect in rects[: len(plotted)]) - 1.0
            place = (left + label_widths[left], plot_top, right, bottom)
            plots.append(self._make_plot(panel, self.frame_data, place, has_time_labels=is_lowest))
        for heading, (left, top, right, _) in zip(headings, rects, strict=True):
            heading.write(self, (left, right), top, heights[top])
        return plots

    def _choose_panels(self) -> list[PlotPanel]:
        """Return the panels of the shown readings, for which there is space."""
        is_row = self._places.plot_columns > 1
        return choose_part_panels(
            self._shown_parts,
            most=self._places.plot_columns if is_row else MAX_SHOWN_READINGS[self._has_dial],
            with_speed=self._has_dial,
            columns=self._columns,
            chosen=self._options.readings,
            in_row=is_row,
        )

    def _fit_columns(
        self, headings: Sequence[PlotHeading], rects: Sequence[PixelRect]
    ) -> tuple[list[PixelRect], dict[float, float | None]]:
        """Return rectangles as wide as their headings need, and by the top of a row the height of its names, None for two lines."""
        fitted: list[PixelRect] = []
        heights: dict[float, float | None] = {}
        for top, group in groupby(zip(headings, rects, strict=True), key=lambda pair: pair[1][1]):
            row = list(group)
            (_, (x, _, _, bottom)), (_, (_, _, last_right, _)) = row[0], row[-1]
            columns = HeadingRow.fit(self, [heading for heading, _ in row], last_right - x - PLOT_GAP * (len(row) - 1))
            heights[top] = columns.height
            for width in columns.widths:
                fitted.append((x, top, x + width, bottom))
                x += width + PLOT_GAP
        return fitted, heights

    def _add_scale_bars(self, frame_data: FrameData, view: PixelView, shift: float, above: float, overlay: ElevationOverlay) -> None:
        """Add a scale bar of a round length in millimetres below the elevation of a part, one of its forces, and how it is seen."""
        left, top, _, bottom = shift_rect(self._places.caption, shift)
        names_top = self._places.elevation[1] + above + 7.0
        layers_top = names_top + (FORCE_NAMES_HEIGHT if overlay.arrows.largest else 0.0)
        self._write_in_colours(overlay.layers.captions, (left, layers_top))
        end = self._add_length_bar(view, shift)
        if overlay.arrows.largest:
            force = round_step(0.5 * overlay.arrows.largest, 1)
            self._add_scale_bar((end + 14.0, (top + bottom) / 2), force * overlay.arrows.scale * view.scale, f"{force:g} N")
            names = [(f"{kind} force", FORCE_NAMES.get(kind, kind)) for kind in overlay.arrows.kinds]
            self._write_in_colours(names, (left, names_top))
        self._add_view_words(_view_words(frame_data), shift, -CAPTION_PITCH if overlay.arrows.largest else 0.0)

    def _add_length_bar(self, view: PixelView, shift: float) -> float:
        """Add a scale bar of a round length in millimetres, and return where its words end."""
        left, top, right, bottom = shift_rect(self._places.caption, shift)
        # The bar stays as short in a wide frame.
        length = round_step(min(right - left, 300.0) / view.scale, 8)
        return self._add_scale_bar((left, (top + bottom) / 2), length * view.scale, f"{length * 1e3:g} mm")

    def _add_view_words(self, lines: Sequence[str], shift: float, rise: float = 0.0) -> None:
        """Write lines at the right below a drawing, upward from a rise (pixels): how it is seen and how fast the film is."""
        _, top, right, bottom = shift_rect(self._places.caption, shift)
        for row, words in enumerate(lines):
            self.add_text(words, (right, (top + bottom) / 2 + rise - row * CAPTION_PITCH), SMALL_TEXT, color=MUTED, ha="right")

    def _write_in_colours(self, captions: Sequence[tuple[str, str]], start: Vec2) -> None:
        """Write words in the colours of their roles, in one line from a position on."""
        x, y = start
        for role, words in captions:
            text = self.add_text(words, (x, y), SMALL_TEXT, color=ROLE_STYLES[role].stroke)
            x += self._width_of(text) + 9.0


def heights_of_words(data: FrameData, overlay: ElevationOverlay) -> Vec2:
    """Return the heights (pixels) of the names of forces and layers above a drawing, and of words on its view beyond one line below it."""
    n_names = bool(overlay.arrows.largest) + bool(overlay.layers.captions)
    return n_names * FORCE_NAMES_HEIGHT, max(len(_view_words(data)) - (not overlay.arrows.largest), 0) * CAPTION_PITCH


_MIN_TRACE = 4.0
"""Extent of a path, in radii of the ball that draws it, below which it looks like dirt beside the ball that hides most of it."""


def _measure_names(data: FrameData) -> float:
    """Return the width (pixels) of the column of the names of a part; zero without names."""
    labels = [*find_labels(data), *AngleArc(data).labels]
    return max((LETTER_WIDTH * LABEL_HEIGHT * len(label.name) + 10.0 for label in labels), default=0.0)


def _is_behind_ball(data: FrameData, path: FloatArray) -> bool:
    """Return whether a ball hides most of the path (s, 2) m that it draws."""
    shapes = data.drawing.moving_shapes(data.poses[0], float(data.times[0]))
    radius = max((shape.radius for shape in shapes if isinstance(shape, Circle) and shape.role == "ball"), default=0.0)
    return float(np.hypot(*np.ptp(path, axis=0))) < _MIN_TRACE * radius


def _view_words(data: FrameData) -> list[str]:
    """Return how the plane of a part is seen, and how fast."""
    return [*(["view turns with spindle"] if data.part.plane == TURNING_PLANE else []), *_speed_words(data)]


def _speed_words(data: FrameData) -> list[str]:
    """Return how fast the film is, if it is not in true time."""
    return [words for words in (format_film_speed(data.slow_down),) if words]


def views_of(data: FrameData, view: FilmView) -> tuple[bool, ...]:
    """Return for each drawing of a part whether it is the view from outside; what does not turn has none."""
    return _SEEN_FROM_OUTSIDE[view] if turns_with_spindle(data) else (False,)


_SEEN_FROM_OUTSIDE = {FilmView.PLANE: (False,), FilmView.OUTSIDE: (True,), FilmView.BOTH: (True, False)}
"""Drawings of a part that turns with a spindle, by the view: whether each is from outside."""


def _aspect_ratio(columns: Sequence[Sequence[FrameData]]) -> float:
    """Return the smallest width relative to the height of what is drawn in the runs of one part; 1 for several parts."""
    if len(columns) > 1:
        return 1.0
    boxes = [enclosing_box(on_one_scale(columns[0], data), FilmLayout.MACHINE_AND_PLOTS) for data in columns[0]]
    return min((right - left) / (top - bottom) for left, right, bottom, top in boxes)

"""Painter of one run: the parts at the left in true proportions, the curves of their main readings at the right."""

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.frame_canvas import FrameCanvas
from governor_mechanism.render.film.frame_data import FrameData, ShownParts, common_axis_limits, enclosing_box, on_one_scale
from governor_mechanism.render.film.layout import PixelView, fit_view, reading_rects, shift_rect
from governor_mechanism.render.film.moving_parts import Panel, plot_reading
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, round_step
from governor_mechanism.render.machines.machine_drawing import SWEEP_ARC_CAPTION
from governor_mechanism.render.number_format import display_unit_of, format_film_speed, format_name, format_numbers
from governor_mechanism.render.style import GREEN, MUTED, SERIES_COLOURS, SERIF_FONT
from governor_mechanism.types import FloatArray

TRACE_DURATION = 1.0
"""Duration (s of film) of the traced path that is shown."""
MAX_SHOWN_READINGS = {True: 3, False: 4}
"""Number of readings in the side panel, with and without the dial."""


class FramePainter(FrameCanvas):
    """Frames of one run, each part in a panel of its own.

    Of the `parts` of the run, only the last one can have a plan view, and all positions count from its frame. `compared` are the parts of
    all runs that share the limits of this frame (their scale only if they are of like size), by default those of this run alone.
    """

    def __init__(
        self,
        run: Trajectory,
        parts: ShownParts,
        size: int = 480,
        *,
        title: str | None = None,
        compared: Sequence[ShownParts] = (),
        animated: bool = True,
    ) -> None:
        super().__init__(size, (len(parts) - 1) * layout.PART_PITCH)
        self._shown_parts = parts
        self.frame_data = frame_data = parts[-1]
        # Whether the plan of the turning plane is shown.
        self._has_dial = _has_plan(frame_data)
        # By part, its data in all runs.
        self._columns = list(zip(*(compared or [parts]), strict=True))
        self._add_title_and_footer(run, run.scene.title if title is None else title, frame_data)
        panels: list[Panel] = [self._make_elevation(data, k) for k, data in enumerate(self._shown_parts)]
        panels += self._make_reading_plots()
        if self._has_dial:
            panels.append(self._make_plan())
        self._finish(panels, animated)

    def _make_elevation(self, frame_data: FrameData, position: int) -> Panel:
        """Return the panel of a part at a position from the left, and write its scale bar and, if there are several, its name."""
        shift, name_height = position * layout.PART_PITCH - self._shift, 0.0
        if len(self._shown_parts) > 1:
            x, y = layout.PART_NAME_POSITION
            self._add_text(format_name(frame_data.part.name), (x + shift, y), 12.5, fontfamily=SERIF_FONT, max_width=260)
            name_height = layout.PART_NAME_HEIGHT
        box = enclosing_box(on_one_scale(self._columns[position], frame_data))
        self.view = fit_view(box, shift_rect(layout.ELEVATION_RECT, shift + self._shift, name_height))
        self._add_scale_bar(frame_data, self.view, shift)
        drawing, poses = frame_data.drawing, frame_data.poses
        path = drawing.traced_path(poses)

        def shapes_at(k: int) -> Sequence[DrawnShape]:
            trace = () if path is None else (self._traced_path(path, k),)
            return (*trace, *drawing.moving_shapes(poses[k], float(frame_data.times[k])))

        return self._make_shape_panel(self.view, drawing.static_shapes, shapes_at)

    def _traced_path(self, path: FloatArray, k: int) -> Lines:
        """Return the part of a path (f, 2) m in the last second of film before frame k."""
        times = self.frame_data.times
        first = int(np.searchsorted(times, times[k] - TRACE_DURATION / self.frame_data.slow_down))
        return Lines("trace", (tuple(map(tuple, path[first : k + 1].tolist())),))

    def _make_plan(self) -> Panel:
        """Return the panel of the turning plane seen from above, and write its caption."""
        frame_data = self.frame_data
        column = [data for data in on_one_scale(self._columns[-1], frame_data) if _has_plan(data)]
        ring_radius = max(data.drawing.dial_ring_radius() for data in column)
        half_width = 1.06 * ring_radius
        view = fit_view((-half_width, half_width, -half_width, half_width), shift_rect(layout.DIAL_RECT, self._shift))
        angle_steps = np.diff(frame_data.spindle_angle, prepend=frame_data.spindle_angle[0])

        def shapes_at(k: int) -> Sequence[DrawnShape]:
            angle, angle_step = float(frame_data.spindle_angle[k]), float(angle_steps[k])
            return frame_data.drawing.dial_shapes(frame_data.poses[k], angle, angle_step, ring_radius)

        lines = [(text, MUTED) for text in frame_data.drawing.plan_caption]
        lines += [(text, GREEN) for text in SWEEP_ARC_CAPTION]
        for line, (text, colour) in enumerate(reversed(lines)):
            self._add_text(text, (398, 446 - 13.5 * line), 9.5, color=colour)
        return self._make_shape_panel(view, (Circle("ring", 0.0, 0.0, ring_radius),), shapes_at)

    def _make_reading_plots(self) -> list[Panel]:
        """Return the plots of the shown readings, and write their names and numbers."""
        selected = self._select_readings()
        plots: list[Panel] = []
        for (frame_data, name), rect, colour in zip(selected, reading_rects(len(selected), self._has_dial), SERIES_COLOURS, strict=False):
            reading = frame_data.readings[name]
            unit, factor = display_unit_of(reading.unit)
            values = reading.values * factor
            reading_colour = GREEN if name == "spindle_speed" else colour
            left, top, right, bottom = rect
            plot_rect = (left + layout.LABEL_WIDTH, top + layout.HEADING_HEIGHT, right - 3.0, bottom - layout.TIME_LABEL_HEIGHT)
            axes = self._add_axes(shift_rect(plot_rect, self._shift))
            limits = common_axis_limits(self._columns[self._shown_parts.index(frame_data)], name)
            plots.append(plot_reading(axes, reading_colour, frame_data, values, limits, self._points_per_pixel))
            number_left = self._add_number(format_numbers(values), unit, (right, top + 7), 12, color=reading_colour, fontweight="bold")
            self._add_text(format_name(name), (left, top + 7), 12.5, fontfamily=SERIF_FONT, max_width=number_left - left - 8)
        return plots

    def _select_readings(self) -> list[tuple[FrameData, str]]:
        """Return the readings to show, each with its part: of several parts the first of each, then the second, and so on."""
        max_readings = MAX_SHOWN_READINGS[self._has_dial]
        columns = [[(data, name) for name in self._readings_of_part(data, max_readings)] for data in self._shown_parts]
        return [one for row in zip_longest(*columns) for one in row if one is not None][:max_readings]

    def _readings_of_part(self, frame_data: FrameData, max_readings: int) -> list[str]:
        """Return the readings that the drawing lists, or else the leading coordinate, another reading and the spindle speed."""
        readings = frame_data.readings
        names = frame_data.drawing.panel_readings
        if not names:
            machine_readings = [name for name in readings if not name.startswith("spindle")]
            names = (frame_data.part.mechanism.coordinate, *machine_readings)
            if self._has_dial:
                names = (*list(dict.fromkeys(names))[: max_readings - 1], "spindle_speed", *machine_readings)
        return [name for name in dict.fromkeys(names) if name in readings]

    def _add_scale_bar(self, frame_data: FrameData, view: PixelView, shift: float) -> None:
        """Add a scale bar of a round length in millimetres below the elevation of a part."""
        left, top, right, bottom = shift_rect(layout.CAPTION_RECT, shift)
        length = round_step((right - left) / view.scale, 8)
        y = (top + bottom) / 2
        self._add_line((left, y), (left + length * view.scale, y), MUTED)
        for x in (left, left + length * view.scale):
            self._add_line((x, y - 3), (x, y + 3), MUTED)
        self._add_text(f"{length * 1e3:g} mm", (left + length * view.scale + 6, y), 9.5, color=MUTED)
        text = format_film_speed(frame_data.slow_down)
        if frame_data.part.plane == TURNING_PLANE:
            text = f"turning plane, {text}" if text else "seen in the turning plane"
        if text:
            self._add_text(text, (right, y), 9.5, color=MUTED, ha="right")


def _has_plan(data: FrameData) -> bool:
    """Return whether a part has a plan view: it turns with a spindle."""
    return data.part.plane == TURNING_PLANE and "spindle_speed" in data.readings

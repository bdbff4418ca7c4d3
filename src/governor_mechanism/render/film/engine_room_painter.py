"""Painter of the engine room of a governed engine: its elevation at the left, and plots stacked at the right."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmLayout, FilmOptions
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.frame_canvas import LINE_PITCH, FrameCanvas, HeadingRow, PlotHeading
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.moving_parts import CurvePanel, Panel
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import at_own_moments
from governor_mechanism.render.geometry.primitives import SMALL_TEXT, PixelRect, PixelView, Vec2, round_step
from governor_mechanism.render.machines.engine_room import arrangement as room
from governor_mechanism.render.machines.engine_room.arrangement import EngineRoomParts
from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing
from governor_mechanism.render.machines.flywheel_engine import BAR
from governor_mechanism.render.plot_panels import choose_room_panels
from governor_mechanism.render.range_bands import RangeBand, name_cycles
from governor_mechanism.render.shown_readings import format_film_speed, format_numbers
from governor_mechanism.render.style import MUTED, SERIF_FONT, VERMILLION

ROOM_RECT: PixelRect = (8.0, 42.0, 8.0 + room.WIDTH, 42.0 + room.HEIGHT)
"""Place of the elevation in a frame of two parts."""
BARE_ROOM_RECT: PixelRect = (8.0, layout.BARE_MARGIN, 8.0 + room.WIDTH, layout.BARE_MARGIN + room.HEIGHT)
"""Place of the elevation in a frame without words."""
FRAME_WIDTHS = {
    FilmLayout.BARE: (room.WIDTH + 16.0, 0.0),
    FilmLayout.MACHINE: (room.WIDTH + 16.0, 0.0),
    FilmLayout.MACHINE_AND_PLOTS: (layout.REFERENCE_SIZE, layout.PART_PITCH),
    FilmLayout.WIDE: (layout.WIDE_WIDTH - layout.PART_PITCH, layout.PART_PITCH),
}
"""Width of the frame without what lies at negative positions, and the width of that, pixels."""


class EngineRoomPainter(FrameCanvas):
    """Frames of a governed engine."""

    def __init__(
        self,
        run: Trajectory,
        governed: EngineRoomParts,
        engine: FrameData,  # at the frame times, as the governor
        governor: FrameData,
        size: int = 480,  # height of the frame, pixels
        *,
        title: str | None = None,  # None takes that of the scene
        options: FilmOptions = DEFAULT_OPTIONS,
        animated: bool = True,  # whether moving artists are left out of the static background
    ) -> None:
        width, shift = FRAME_WIDTHS[options.layout]
        is_bare = options.layout is FilmLayout.BARE
        self._room_rect = BARE_ROOM_RECT if is_bare else ROOM_RECT
        height = self._room_rect[3] + layout.BARE_MARGIN if is_bare else layout.REFERENCE_SIZE
        super().__init__(size, shift, options, width, height)
        self._run = run
        self._governed = governed
        self._data = governor
        self.room = EngineRoomDrawing(run, governed, engine.drawing, governor.drawing)
        (start, stop), duration = governor.time_span, float(np.ptp(run.times))
        which = "first " if start == run.times[0] else ""
        note = f"{which}{stop - start:.4g} of {duration:.4g} s" if stop - start < duration else ""
        self._add_title_and_footer(run, run.scene.title if title is None else title, governor, note)
        plots = self._make_plots()
        self._add_caption([band for panel in plots for band in panel.bands])
        self._finish([self._make_elevation(), *plots], animated)

    @property
    def canvases(self) -> Sequence[FrameCanvas]:
        """The canvas itself."""
        return (self,)

    def paint(self, k: int) -> RgbaPixels:
        """Return frame k as opaque RGBA pixels (size, width, 4)."""
        return self.draw(k).copy()

    def _make_elevation(self) -> Panel:
        """Return the panel of the engine room, and write the names of load and supply, and when a belt breaks."""
        view = PixelView(rect=self._room_rect, scale=1.0, x=0.5 * room.WIDTH, y=0.5 * room.HEIGHT)
        state_at = self.room.states(self._data.times, self._data.poses)
        states = [state_at(k) for k in range(len(self._data.times))]
        if self.room.has_load:
            loads = np.interp(self._data.times, self._run.times, self.room.load_values)
            x, y = self._place((room.LINE_SHAFT[0] + room.BRAKE_ARM + 18.0, room.LINE_SHAFT[1] + 34.0))
            left = self.add_number(format_numbers(loads), "N m", (x, y), 11, color=VERMILLION, fontweight="bold")
            self.add_text("load", (left - 6.0, y), 11.5, fontfamily=SERIF_FONT, ha="right")
        if "supply_pressure" in self._governed.engine.dimensions:
            pressure = self._governed.engine.dimensions["supply_pressure"] / BAR
            position = self._place((room.PIPE_AXIS - room.PIPE_HALF_WIDTH - 8.0, room.HEIGHT - 12.0))
            self.add_text(f"supply {pressure:.4g} bar", position, SMALL_TEXT, color=MUTED, ha="right")
        if self._governed.break_time is not None:
            text = f"belt breaks at {self._governed.break_time:.4g} s"
            self.add_text(text, self._place((room.GOVERNOR_AXIS + 92.0, room.GOVERNOR_BASE + 12.0)), SMALL_TEXT, color=MUTED)
        parts = [at_own_moments(part, states.__getitem__) for part in self.room.moving]
        return self._make_shape_panel(view, tuple(self.room.background_shapes()), parts)

    def _place(self, point: Vec2) -> Vec2:
        """Return the place in the frame of a point of the room."""
        return self._room_rect[0] + point[0] - self._shift, self._room_rect[3] - point[1]

    def _add_caption(self, bands: Sequence[RangeBand]) -> None:
        """Write scale bars of engine and governor, how time and rotation are shown, and what the bands of plots are."""
        x, y = 14.0 - self._shift, 447.0
        engine, governor = self.room.engine, self.room.governor
        for name, scale in ((engine.scaled, engine.pixels_per_metre), ("governor", governor.pixels_per_metre)):
            length = round_step(110.0 / scale, 4)
            x = self._add_scale_bar((x, y), length * scale, f"{name} {length * 1e3:g} mm") + 15.0
        slow_down = self._data.slow_down
        texts = [format_film_speed(slow_down)]
        if (slowing := self.room.rotation_slowing(self._data.times)) > 1:
            texts.append(f"{slowing} turns drawn as 1")
        right = self._room_rect[2] - self._shift
        self.add_text(", ".join(text for text in texts if text), (right, y), SMALL_TEXT, color=MUTED, ha="right", max_width=right - x)
        if bands:
            position, width = (self._right - 12.0, y + 3.5), self._right - 16.0 - right  # below the times of the plots
            self.add_text(f"band: range within {name_cycles(bands)}", position, SMALL_TEXT, color=MUTED, ha="right", max_width=width)

    def _make_plots(self) -> list[CurvePanel]:
        """Return the plots, stacked over a common time axis, and write their names and numbers."""
        if self._options.layout in (FilmLayout.MACHINE, FilmLayout.BARE):
            return []
        plots = choose_room_panels(self._run, self._governed, self.room, self._data.time_span, self._options.readings)
        left, top, _, bottom = layout.READINGS_RECT
        right = self._right - 10.0
        height = (bottom - layout.TIME_LABEL_HEIGHT - top) / len(plots)
        label_width = max(self._measure_labels(plot.limits) for plot in plots)
        headings = [PlotHeading.of(plot, self._data.times) for plot in plots]
        heights = [HeadingRow.fit(self, [heading], right - left).height for heading in headings]
        fitted = [height for height in heights if height is not None]
        name_height = min(fitted) if len(fitted) == len(heights) else None
        panels = []
        for k, (plot, heading) in enumerate(zip(plots, headings, strict=True)):
            y = top + k * height
            is_last = k == len(plots) - 1
            plot_top = y + layout.HEADING_HEIGHT - 2.0 + (LINE_PITCH if name_height is None else 0.0)
            place = (left + label_width, plot_top, right, y + height)
            panels.append(self._make_plot(plot, self._data, place, has_time_labels=is_last))
            heading.write(self, (left, right), y, name_height)
        return panels

"""Layout of a film frame: rectangles in pixels of a 480-pixel square."""

import math
from dataclasses import dataclass, replace

from governor_mechanism.model.results.pictures import FilmLayout, FilmOptions
from governor_mechanism.render.geometry.primitives import ELEVATION_RECT, PixelRect

REFERENCE_SIZE = 480.0
"""Side (pixels) to which all rectangles refer; a frame of another size is scaled as a whole."""

PART_PITCH = 286.0
"""Width (pixels) that each further part adds at the left."""
PART_NAME_POSITION = (14.0, 50.0)
"""Left edge and middle of the name of a part, which only a frame of several parts shows."""
PART_NAME_HEIGHT = 16.0
"""Height (pixels) that the name takes from the elevation."""

CAPTION_RECT: PixelRect = (14.0, 440.0, 286.0, 456.0)
READINGS_RECT: PixelRect = (300.0, 46.0, 470.0, 452.0)
DIAL_RECT: PixelRect = (300.0, 364.0, 388.0, 452.0)
TICK_WIDTH = 7.0
HEADING_HEIGHT = 24.0
TIME_LABEL_HEIGHT = 16.0
"""Margins of the plot of a reading: left for the ticks beside their labels, above for the heading, below all plots for the times."""
PLOT_BOTTOM = 6.0
"""Distance (pixels) of a plot from the heading of the next one."""
STATED_HEIGHT = 20.0
"""Height (pixels) of the line of a reading that is only stated."""
HEADER_RULE_Y, FOOTER_RULE_Y = 35.0, 459.0
"""Heights of the rules under the title and above the last line."""
CLOSING_LINE_LAYOUT: dict[int, tuple[float, tuple[float, ...]]] = {1: (FOOTER_RULE_Y, (470.0,)), 2: (456.0, (463.0, 473.3))}
"""By the number of closing lines: the height of the rule above them, and of their middles."""


def shift_rect(rect: PixelRect, shift: float, lower_top: float = 0.0) -> PixelRect:
    """Return a rectangle further right, with its top lower."""
    left, top, right, bottom = rect
    return left + shift, top + lower_top, right + shift, bottom


@dataclass(frozen=True, kw_only=True)
class FrameLayout:
    """Places in a frame of one part that is `width` wide and `height` high (pixels); each further part adds `part_pitch` at the left.

    Without plots, `readings` and `dial` are None. A dial below the readings takes from their height, one beside them from the elevation.
    `plot_columns` is the largest number of plots in a row: 1 beside a machine, more below one.
    """

    width: float = REFERENCE_SIZE
    height: float = REFERENCE_SIZE
    part_pitch: float = PART_PITCH
    elevation: PixelRect = ELEVATION_RECT
    caption: PixelRect = CAPTION_RECT
    readings: PixelRect | None = READINGS_RECT
    dial: PixelRect | None = DIAL_RECT
    plot_columns: int = 1

    def reading_rects(self, count: int, has_dial: bool, n_stated: int = 0) -> list[PixelRect]:
        """Return the rectangles of `count` plots, stacked or in rows below the machine, and below them those of readings only stated.

        The times stand below the lowest plots. All are above the dial if it is below the readings.
        """
        if self.readings is None:
            return []
        left, top, right, bottom = self.readings
        if has_dial and self.dial is not None and self.dial[0] >= left:
            bottom = self.dial[1] - 8.0
        bottom -= n_stated * STATED_HEIGHT
        times_top = bottom - TIME_LABEL_HEIGHT
        lines = [(left, bottom + k * STATED_HEIGHT, right, bottom + (k + 1) * STATED_HEIGHT) for k in range(n_stated)]
        n_rows = max(math.ceil(count / self.plot_columns), 1)
        n_columns = max(math.ceil(count / n_rows), 1)
        height = (times_top - top) / n_rows
        pitch = (right - left + PLOT_GAP) / n_columns
        places = [divmod(k, n_columns) for k in range(count)]
        plots = [(left + k * pitch, top + j * height, left + (k + 1) * pitch - PLOT_GAP, top + (j + 1) * height) for j, k in places]
        return plots + lines


WIDE_WIDTH = REFERENCE_SIZE * 16 / 9
"""Width (pixels) of a frame in 16:9."""
PLOT_GAP = 14.0
"""Distance (pixels) of plots that are side by side."""
MAX_PLOT_COLUMNS = 3
"""Largest number of plots in a row below a machine: a fourth would leave no place for the name of a reading beside its number."""
MIN_ROW_HEIGHTS, MAX_ROW_HEIGHT = {1: 120.0, 2: 92.0}, 200.0
"""Smallest height (pixels) of a row of plots by the number of rows, with its words, and the largest: higher plots are upright strips."""
CAPTION_HEIGHT = 24.0
"""Height (pixels) of the caption between a machine and the plots below it."""
MIN_GAIN = 1.15
"""Least gain in scale for which the plots stand below a machine: a smaller one would not make up for their smaller width."""
FOOTER_HEIGHT = 16.0
"""Height (pixels) that a frame without a footer gives to its panels."""
MACHINE_WIDTH, MIN_MACHINE_HEIGHT = REFERENCE_SIZE - 16.0, 120.0
"""Width (pixels) that a machine alone has at its disposal, and the smallest height of its place."""
MACHINE_TOP, BELOW_MACHINE = 42.0, 44.0
"""Heights (pixels) of what stands above and below a machine alone: title, and scale bar and footer."""
BARE_MARGIN = 8.0
"""Distance (pixels) of a machine without words from the edges of its frame."""


def machine_frame_height(drawing_height: float, options: FilmOptions) -> float:
    """Return the height (pixels) of the frame of a machine alone that is wider than high, with its lines of words; at most a square."""
    if options.layout is FilmLayout.BARE:
        return min(drawing_height + 2 * BARE_MARGIN, REFERENCE_SIZE)
    below = BELOW_MACHINE - (0.0 if options.footer else FOOTER_HEIGHT)
    return min(MACHINE_TOP + max(drawing_height, MIN_MACHINE_HEIGHT) + below, REFERENCE_SIZE)


def frame_layout(options: FilmOptions, has_dial: bool, aspect_ratio: float = 1.0, height: float = REFERENCE_SIZE) -> FrameLayout:
    """Return the places in a frame for a machine with or without a plan view.

    `aspect_ratio` is the width of what is drawn, relative to its height: a wide machine takes the whole width, above its plots, if it
    is then larger. `height` (pixels) is that of the frame of a machine alone.
    """
    match options.layout:
        case FilmLayout.MACHINE:
            right = REFERENCE_SIZE - 8.0
            bottom = height - BELOW_MACHINE
            places = FrameLayout(
                height=height,
                part_pitch=right,
                elevation=(8.0, MACHINE_TOP, right, bottom),
                caption=(14.0, bottom + 4.0, right - 6.0, bottom + 20.0),
                readings=None,
                dial=None,
            )
        case FilmLayout.BARE:
            right, bottom = REFERENCE_SIZE - BARE_MARGIN, height - BARE_MARGIN
            rect = (BARE_MARGIN, BARE_MARGIN, right, bottom)
            return FrameLayout(height=height, part_pitch=right, elevation=rect, caption=rect, readings=None, dial=None)
        case FilmLayout.WIDE:
            right = 404.0 if has_dial else 500.0
            places = FrameLayout(
                width=WIDE_WIDTH,
                part_pitch=right,
                elevation=(8.0, 42.0, right, 436.0),
                caption=(14.0, 440.0, right, 456.0),
                readings=(524.0, 46.0, WIDE_WIDTH - 12.0, 452.0),
                dial=(414.0, 358.0, 508.0, 452.0),
            )
        case _:
            beside = FrameLayout()
            above = _machine_above_plots(aspect_ratio, len(options.readings) or MAX_PLOT_COLUMNS)
            gain = _fitted_height(above.elevation, aspect_ratio) / _fitted_height(beside.elevation, aspect_ratio)
            places = above if gain >= MIN_GAIN and not has_dial else beside
    return places if options.footer else _without_footer(places)


def with_names(places: FrameLayout, width: float) -> FrameLayout:
    """Return places with a column of a width (pixels) for names at the right of each machine, which stays as large.

    The frame is as much wider, or in 16:9 the plots are narrower.
    """
    more = 0.0 if places.width == WIDE_WIDTH else width
    (left, top, right, bottom), readings = places.elevation, places.readings
    if readings is not None:
        is_beside = readings[0] > right
        readings = (readings[0] + width * is_beside, readings[1], readings[2] + more, readings[3])
    return replace(
        places,
        width=places.width + more,
        part_pitch=places.part_pitch + width,
        elevation=(left, top, right + width, bottom),
        caption=(*places.caption[:2], places.caption[2] + width, places.caption[3]),
        readings=readings,
        dial=None if places.dial is None else shift_rect(places.dial, width),
    )


def _machine_above_plots(aspect_ratio: float, n_plots: int) -> FrameLayout:
    """Return the places of a machine of an aspect ratio over the whole width, with a number of plots in rows below it."""
    left = 8.0
    top = 42.0
    right = REFERENCE_SIZE - 8.0
    bottom = READINGS_RECT[3]
    n_rows = math.ceil(n_plots / MAX_PLOT_COLUMNS)
    height = bottom - top - CAPTION_HEIGHT
    lowest = height - n_rows * MAX_ROW_HEIGHT
    highest = height - n_rows * MIN_ROW_HEIGHTS[n_rows]
    middle = top + min(max((right - left) / aspect_ratio, lowest), highest)
    return FrameLayout(
        elevation=(left, top, right, middle),
        caption=(left + 6.0, middle + 4.0, right - 6.0, middle + 20.0),
        readings=(left + 6.0, middle + CAPTION_HEIGHT, right - 2.0, bottom),
        dial=None,
        plot_columns=MAX_PLOT_COLUMNS,
    )


def _fitted_height(rect: PixelRect, aspect_ratio: float) -> float:
    """Return the height (pixels) of the largest box of an aspect ratio in a rectangle."""
    left, top, right, bottom = rect
    return min((right - left) / aspect_ratio, bottom - top)


def _without_footer(places: FrameLayout) -> FrameLayout:
    """Return places that reach down to where the footer would be."""

    def lower(rect: PixelRect, top: float = 0.0) -> PixelRect:
        return rect[0], rect[1] + top, rect[2], rect[3] + FOOTER_HEIGHT

    if places.plot_columns > 1:
        return replace(places, readings=None if places.readings is None else lower(places.readings))
    return replace(
        places,
        elevation=lower(places.elevation),
        caption=lower(places.caption, FOOTER_HEIGHT),
        readings=None if places.readings is None else lower(places.readings),
        dial=None if places.dial is None else lower(places.dial, FOOTER_HEIGHT),
    )

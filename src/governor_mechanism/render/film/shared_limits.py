"""Limits that the frames of several runs share, for comparison."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.reading_panel import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2
from governor_mechanism.render.number_format import display_unit_of


@dataclass(frozen=True, kw_only=True)
class SharedLimits:
    """Limits of frames.

    `boxes` are the bounding boxes (m) of the parts, `ring_radius` (m) is that of the plan of the last one. `axis_limits` are those of
    the readings in display units, by names of part and reading.
    """

    boxes: tuple[BoundingBox, ...]
    ring_radius: float
    axis_limits: Mapping[tuple[str, str], Vec2]


def shared_limits(frame_data: Sequence[Sequence[FrameData]]) -> SharedLimits:
    """Return the limits that contain the shown parts of every run; the runs have equally many."""
    columns = list(zip(*frame_data, strict=True))
    return SharedLimits(
        boxes=tuple(_enclosing_box(column) for column in columns),
        ring_radius=max(data.drawing.dial_ring_radius() for data in columns[-1]),
        axis_limits={
            (data.part.name, name): _axis_limits([one for one in column if name in one.readings], name)
            for column in columns
            for data in column
            for name in data.readings
        },
    )


def _enclosing_box(column: Sequence[FrameData]) -> BoundingBox:
    """Return the smallest box that contains a part in several runs."""
    boxes = [data.drawing.bounds() for data in column]
    left, right, bottom, top = zip(*boxes, strict=True)
    return min(left), max(right), min(bottom), max(top)


def _axis_limits(data_with_reading: Sequence[FrameData], name: str) -> Vec2:
    """Return the limits of an axis, in the display unit, for a reading of several runs."""
    readings = [data.readings[name] for data in data_with_reading]
    factor = display_unit_of(readings[0].unit)[1]
    values = np.concatenate([reading.values for reading in readings])
    return axis_limits_for(values * factor, READING_NOISE_RATIO * max(reading.scale for reading in readings) * factor)

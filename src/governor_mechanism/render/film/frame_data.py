"""A run interpolated to the frame times of a film, and what the frames of several runs share."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.part import Part
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.page import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2, enclose_boxes
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.number_format import display_unit_of
from governor_mechanism.render.shown_readings import shown_readings
from governor_mechanism.types import FloatArray


class FrameData:
    """One part of a run at the frame times (f,) s, all within `time_span` (s), the shown part of the run.

    `poses` (f, bodies, 3) are those of the part, by cubic Hermite polynomials; `readings` are by plain name, with values (f,) interpolated
    linearly; `spindle_angle` (f,) rad counts from the start and is zero without a spindle speed. `drawing` is that of the whole run.
    A second of the run takes `slow_down` seconds of film.
    """

    def __init__(self, run: Trajectory, part: Part, time_span: Vec2, times: FloatArray, slow_down: float = 1.0) -> None:
        self.part, self.time_span, self.times, self.slow_down = part, time_span, times, slow_down
        self.drawing = drawing_of(run, part, slow_down)
        self.poses = self.drawing.poses.repeat(len(times), axis=0)
        if len(run.times) > 1:
            self.poses = np.asarray(CubicHermiteSpline(run.times, self.drawing.poses, self.drawing.select_bodies(run.velocities))(times))
        readings = self.drawing.select_entries(shown_readings(run))
        speed = readings["spindle_speed"].values if "spindle_speed" in readings else np.zeros(len(run.times))
        spindle_angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(run.times))])
        self.spindle_angle = np.interp(times, run.times, spindle_angle)
        self.readings = {name: replace(one, values=np.interp(times, run.times, one.values)) for name, one in readings.items()}


ShownParts = Sequence[FrameData]
"""Shown parts of a run, from left to right."""


def enclosing_box(column: Sequence[FrameData]) -> BoundingBox:
    """Return the smallest bounding box (m) that contains a part in several runs."""
    return enclose_boxes(data.drawing.bounds for data in column)


def common_axis_limits(column: Sequence[FrameData], name: str) -> Vec2:
    """Return the limits of the axis, in the display unit, of a reading of a part in several runs."""
    readings = [data.readings[name] for data in column if name in data.readings]
    factor = display_unit_of(readings[0].unit)[1]
    values = np.concatenate([reading.values for reading in readings])
    return axis_limits_for(values * factor, READING_NOISE_RATIO * max(reading.scale for reading in readings) * factor)


def find_parts(run: Trajectory, name: str | None) -> tuple[Part, ...]:
    """Return the part of that name, or all parts for None: last one that turns with a spindle, which has a plan view, if there is any."""
    parts = run.scene.parts
    if name is None:
        return tuple(sorted(parts, key=lambda part: part.turns))
    names = [part.name for part in parts]
    if name not in names:
        raise MechanismError(f"the scene has no part {name!r}; its parts are {names}.{did_you_mean(name, names)}")
    return (parts[names.index(name)],)

"""A run interpolated to the frame times of a film, and what the frames of several runs share."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.part import TURNING_PLANE, Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.numerics.hermite import integrate_samples, interpolate_samples
from governor_mechanism.render.figures.page import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.geometry.attached import DrawnPart, Moment, at_own_moments
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2, enclose_boxes
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.governor_parts import GovernorDrawing
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.number_format import display_unit_of
from governor_mechanism.render.part_run import magnify_motion
from governor_mechanism.render.shown_readings import RATE_START, ShownReading, chosen_readings, shown_readings
from governor_mechanism.types import FloatArray

END_TOLERANCE = 1e-9
"""Rounding of a frame time, relative to the shown time."""

MAX_SHARED_SCALE_RATIO = 3.0
"""Largest ratio of the sizes of machines that are shown on one scale: beside a larger one, a smaller would be too small to be seen."""


class FrameData:
    """One part of a run at the frame times (f,) s, all within `time_span` (s), the time that the film shows.

    Outside of the reported times of the run it rests in its first or its last position: `times` (f,) stay there, and `has_ended` (f,) is
    true after the last. `poses` (f, bodies, 3) are those of the part, by cubic Hermite polynomials; `readings` are by plain name, with
    values (f,) interpolated linearly; `spindle_angle` (f,) rad counts from the start and is zero without a spindle speed. `drawing` is that
    of the whole run. A second of the run takes `slow_down` seconds of film. `chosen` are names of readings of the run, or "rate of ...",
    that are shown besides. The motion of the drawing is magnified by `magnification`; the readings are not.

    `sample_times` (s,) are the reported times within the time span and its ends; curves are drawn through them, since a fast crank moves
    far from one frame to the next.
    """

    def __init__(
        self,
        run: Trajectory,
        part: Part,
        time_span: Vec2,
        times: FloatArray,
        slow_down: float = 1.0,
        chosen: Sequence[str] = (),
        magnification: float = 1.0,
    ) -> None:
        # Frame times are computed, so that the last may lie beyond the end by rounding.
        self.has_ended = times > run.times[-1] + END_TOLERANCE * max(abs(time_span[1] - time_span[0]), abs(run.times[-1]))
        times = np.clip(times, run.times[0], run.times[-1])
        self.part, self.time_span, self.times, self.slow_down = part, time_span, times, slow_down
        drawn = run if magnification == 1.0 else magnify_motion(run, magnification)
        self.drawing = drawing_of(drawn, part, slow_down, magnification)
        self._velocities = self.drawing.select_bodies(drawn.velocities)
        self.poses = self.poses_at(times)
        first, last = (float(np.clip(time, run.times[0], run.times[-1])) for time in time_span)
        inside = run.times[(run.times > first) & (run.times < last)]
        self.sample_times = np.unique(np.concatenate([[first], inside, [last]]))
        readings = self.drawing.select_entries(shown_readings(run)) | self._select_chosen(run, chosen)
        speed = readings["spindle_speed"].values if "spindle_speed" in readings else np.zeros(len(run.times))
        self.spindle_angle = np.interp(times, run.times, integrate_samples(run.times, speed))
        self.readings = {name: replace(one, values=np.interp(times, run.times, one.values)) for name, one in readings.items()}
        self._reported = {name: one.values for name, one in readings.items()}

    def poses_at(self, times: FloatArray) -> FloatArray:
        """Return the poses (n, bodies, 3) at times (n,) s within those of the run."""
        reported, poses = self.drawing.run.times, self.drawing.poses
        return poses.repeat(len(times), axis=0) if len(reported) < 2 else interpolate_samples(reported, poses, self._velocities, times)

    def velocities_at(self, times: FloatArray) -> FloatArray:
        """Return the velocities (n, bodies, 3) at times (n,) s within those of the run, linear between its reported times."""
        columns = self._velocities.reshape(len(self._velocities), -1).T
        return np.stack([np.interp(times, self.drawing.run.times, column) for column in columns], axis=1).reshape(-1, *self.poses.shape[1:])

    @cached_property
    def moments(self) -> Sequence[Moment]:
        """The moments of the frames, at which shapes are placed."""
        return [Moment(pose, float(time)) for pose, time in zip(self.poses, self.times, strict=True)]

    def moment_at(self, k: int) -> Moment:
        """Return the moment of frame k."""
        return self.moments[k]

    def moving_parts(self) -> list[DrawnPart]:
        """Return what moves of the drawing, as parts whose moments are the numbers of the frames."""
        return [at_own_moments(part, self.moment_at) for part in self.drawing.moving]

    def sampled_values(self, name: str) -> FloatArray:
        """Return the values (s,) of a reading at the sample times."""
        values: FloatArray = np.interp(self.sample_times, self.drawing.run.times, self._reported[name])
        return values

    def plain_name(self, name: str) -> str | None:
        """Return a chosen name without that of the part, or None if it is one of another part."""
        rate, source = (RATE_START, name.removeprefix(RATE_START)) if name.startswith(RATE_START) else ("", name)
        plain = list(self.drawing.select_entries({source: None}))
        return rate + plain[0] if plain else None

    def _select_chosen(self, run: Trajectory, names: Sequence[str]) -> dict[str, ShownReading]:
        """Return those of the chosen readings that belong to the part, by plain names."""
        chosen = chosen_readings(run, names)
        plain_names = {name: self.plain_name(name) for name in chosen}
        return {plain: chosen[name] for name, plain in plain_names.items() if plain is not None}


ShownParts = Sequence[FrameData]
"""Shown parts of a run, from left to right."""


def turns_with_spindle(data: FrameData) -> bool:
    """Return whether a part turns with a spindle: it then has a plan view, and one from outside."""
    return data.part.plane == TURNING_PLANE and "spindle_speed" in data.readings


def shows_bodies(data: FrameData) -> bool:
    """Return whether a drawing shows the bodies where they are; a diagram of a valve gear, for one, has a map of its own."""
    return isinstance(data.drawing, GovernorDrawing | GenericDrawing)


def enclosing_box(column: Sequence[FrameData]) -> BoundingBox:
    """Return the smallest bounding box (m) that contains a part in several runs."""
    return enclose_boxes(data.drawing.bounds for data in column)


def on_one_scale(column: Sequence[FrameData], shown: FrameData) -> list[FrameData]:
    """Return those of a column that are shown on one scale with one of them: all in a like plane if of like size, else it alone."""

    def size(data: FrameData) -> float:
        left, right, bottom, top = data.drawing.bounds
        return max(right - left, top - bottom)

    alike = [data for data in column if data.part.plane == shown.part.plane]
    sizes = [size(data) for data in alike]
    return alike if max(sizes) <= MAX_SHARED_SCALE_RATIO * min(sizes) else [shown]


def common_axis_limits(column: Sequence[FrameData], name: str) -> Vec2:
    """Return the limits of the axis, in the display unit, of a reading of a part in several runs."""
    readings = [data.readings[name] for data in column if name in data.readings]
    factor = display_unit_of(readings[0].unit)[1]
    values = np.concatenate([data.sampled_values(name) for data in column if name in data.readings])
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

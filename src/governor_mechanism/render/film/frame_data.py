"""A run interpolated to the frame times of a film."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.part import Part
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.shown_readings import ShownReading, shown_readings
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class FrameData:
    """One part of a run at the frame times (f,) s, all within `time_span` (s), the shown part of the run.

    `poses` (f, bodies, 3) are those of the part; `readings` are by plain name, with values (f,); `spindle_angle` (f,) rad counts from
    the start and is zero without a spindle speed. `drawing` is that of the whole run. A second of the run takes `slow_down` seconds
    of film.
    """

    part: Part
    time_span: tuple[float, float]
    times: FloatArray
    poses: FloatArray
    readings: Mapping[str, ShownReading]
    spindle_angle: FloatArray
    drawing: MachineDrawing
    slow_down: float


def find_parts(run: Trajectory, name: str | None) -> tuple[Part, ...]:
    """Return the part of that name, or all parts for None: last one that turns with a spindle, which has a plan view, if there is any."""
    parts = run.scene.parts
    if name is None:
        return tuple(sorted(parts, key=lambda part: part.turns))
    names = [part.name for part in parts]
    if name not in names:
        raise MechanismError(f"the scene has no part {name!r}; its parts are {names}.{did_you_mean(name, names)}")
    return (parts[names.index(name)],)


def interpolate_frame_data(
    run: Trajectory, part: Part, time_span: tuple[float, float], times: FloatArray, slow_down: float = 1.0
) -> FrameData:
    """Interpolate one part to `times` (f,) s: poses by cubic Hermite polynomials, readings linearly."""
    drawing = drawing_of(run, part, slow_down)
    readings = drawing.select_entries(shown_readings(run))
    speed = readings["spindle_speed"].values if "spindle_speed" in readings else np.zeros(len(run.times))
    spindle_angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(run.times))])
    return FrameData(
        part=part,
        time_span=time_span,
        times=times,
        poses=_interpolate_hermite(run.times, drawing.poses, drawing.select_bodies(run.velocities), times),
        readings={name: replace(one, values=np.interp(times, run.times, one.values)) for name, one in readings.items()},
        spindle_angle=np.interp(times, run.times, spindle_angle),
        drawing=drawing,
        slow_down=slow_down,
    )


def _interpolate_hermite(times: FloatArray, values: FloatArray, rates: FloatArray, query_times: FloatArray) -> FloatArray:
    """Interpolate along the first axis by cubic Hermite polynomials; times (n,) increase, `query_times` (f,) lie within them."""
    if len(times) == 1:
        return np.repeat(values, len(query_times), axis=0)
    return np.asarray(CubicHermiteSpline(times, values, rates)(query_times))

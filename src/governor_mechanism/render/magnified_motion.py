"""The motion of a run about its mean position, magnified: for motions too small to be seen. Positions stay those of the mechanism."""

from dataclasses import replace

import numpy as np

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.mechanics.kinematics.range_of_motion import find_range_of_motion
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.film_options import FilmOptionError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

_LEAVE_OUT = "leave {exaggerate} out"
_STOP_TOLERANCE = 1e-6
"""Distance beyond a stop, relative to the scale of its reading, that counts as none: a run rests on a stop to within its accuracy."""
_STOP_COORDINATES = 50
"""Number of coordinates at which the stops are checked: a reading that turns back may pass a stop between the ends of the motion."""
_FACTOR_ACCURACY = 1e-3
"""Accuracy of the largest possible factor, relative to it: three digits of it are stated."""


def require_one_coordinate(scene: Scene) -> None:
    """Check that one coordinate determines all positions of a scene; call it before long work.

    Raises MechanismError if it has several parts, or not exactly one degree of freedom beside a spindle of
    given speed.
    """
    if len(scene.parts) > 1:
        names = ", ".join(part.name for part in scene.parts)
        template = f"{{exaggerate}} magnifies the motion of one part; the scene has {{count}}: {{names}}; {_LEAVE_OUT}"
        raise FilmOptionError(template, count=len(scene.parts), names=names)
    part = scene.part
    reason = ""
    if isinstance(part.spindle, FreeSpindle):
        reason = "its spindle is free"
    elif any(isinstance(effect, Clearance) for effect in part.effects):
        reason = "its links have a clearance"
    elif (count := mobility_of(part.mechanism)) != 1:
        reason = f"it has {count} degrees of freedom" if count else "drivers prescribe its motion"
    if reason:
        template = f"{{exaggerate}} needs a scene whose positions follow one free coordinate, but {{reason}}; {_LEAVE_OUT}"
        raise FilmOptionError(template, reason=reason)


def magnify_motion(
    run: Trajectory,
    factor: float,  # magnification, at least 1. The mean is that over time
) -> Trajectory:
    """Return a run with the positions that its coordinate has at its mean + factor * (coordinate - mean).

    Result: the run with poses, velocities and positional readings of the magnified motion, for drawings.
    Raises MechanismError if not exactly one coordinate determines the positions, or the magnified motion
    leaves the range of the mechanism or passes a stop; the message states the largest possible factor.
    """
    require_one_coordinate(run.scene)
    name = run.scene.part.mechanism.coordinate
    values, rates = run.readings[name], run.rates[name]
    mean = _time_mean(run, name)
    ends = float(values.min()) - mean, float(values.max()) - mean
    if not _is_possible(run.scene, mean, ends, factor):
        largest = _largest_factor(run.scene, mean, ends, factor)
        cure = f"at most {largest:.3g} is possible" if largest > 1.0 + _FACTOR_ACCURACY else "it already uses all of it"
        template = "magnified {factor:g} times, the motion of {name!r} leaves the range of the mechanism; {cure}: change {exaggerate}"
        raise FilmOptionError(template, factor=factor, name=name, cure=cure)
    motion = analyse_kinematics(run.scene, name, mean + factor * (values - mean))
    velocities = motion.velocities * (factor * rates)[:, None, None]
    return replace(run, poses=motion.poses, velocities=velocities, readings={**run.readings, **motion.readings})


def _time_mean(run: Trajectory, name: str) -> float:
    """Return the mean of a reading over time."""
    values, steps = run.readings[name], np.diff(run.times)
    return float(0.5 * ((values[1:] + values[:-1]) @ steps) / steps.sum()) if len(steps) else float(values[0])


def _is_possible(scene: Scene, mean: float, ends: Vec2, factor: float) -> bool:
    """Return whether the coordinate can go from its mean to both ends (relative to it) times a factor, within range and stops."""
    part = scene.part
    extremes = mean + factor * np.array(ends)
    # The ends of the run itself are always possible, though rounding may put them a little beyond a limit.
    if factor > 1.0 and not find_range_of_motion(part.mechanism, rotates_with_spindle=part.turns).contains(extremes).all():
        return False
    try:
        readings = analyse_kinematics(
            scene, part.mechanism.coordinate, np.array([mean, *np.linspace(extremes[0], extremes[1], _STOP_COORDINATES)])
        ).readings
    except MechanismError:
        return False
    stops = [effect for effect in part.effects if isinstance(effect, Stops)]
    return all(_is_within(stop, readings[stop.reading], _STOP_TOLERANCE * part.mechanism.output_scale(stop.reading)) for stop in stops)


def _is_within(stops: Stops, reached: FloatArray, tolerance: float) -> bool:
    """Return whether values (n,) of a reading are between its stops."""
    return bool(stops.low - tolerance <= reached.min() and reached.max() <= stops.high + tolerance)


def _largest_factor(scene: Scene, mean: float, ends: Vec2, impossible: float) -> float:
    """Return the largest possible factor below one that is impossible, by bisection."""
    low, high = 1.0, impossible
    while high - low > _FACTOR_ACCURACY * low:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _is_possible(scene, mean, ends, middle) else (low, middle)
    return low

"""One part of a run, or some poses, as its drawing needs them: poses, effects, ranges of readings, held contacts, recent impacts."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from governor_mechanism.effects.holding import Clearance, Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.inputs import evaluate_reading_function_along
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.range_of_motion import find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.coupling.couplings import RatioCoupling
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.part import FreeSpindle, Part
from governor_mechanism.model.results.pictures import FilmOptionError
from governor_mechanism.model.results.records import Cost, Energy, Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

T = TypeVar("T")
EffectT = TypeVar("EffectT", bound=Effect)

HOLD_EVENT_KINDS = {EventKind.STICK: True, EventKind.REST: True, EventKind.SLIP: False, EventKind.SEPARATION: False}
"""Events that begin (True) or end (False) the hold of a contact."""
FLASH_DURATION = 0.25
"""Duration (s of film) for which an impact is shown."""


def find_shaft_wheel(scene: Scene, part: Part) -> Part | None:
    """Return the part of a scene that is a single wheel, if it turns with the crank of another part; None if there is no such part."""
    for coupling in scene.couplings:
        if isinstance(coupling, RatioCoupling) and abs(coupling.ratio) == 1.0:
            ends = {coupling.first, coupling.second}
            for other in scene.parts:
                is_wheel = other is not part and not other.turns and len(other.mechanism.bodies) == 1
                if is_wheel and any(one.startswith(f"{other.name}.") for one in ends) and f"{part.name}.crank_angle" in ends:
                    return other
    return None


@dataclass(frozen=True, kw_only=True)
class PartRun:
    """A part of a run, seconds taking `slow_down` seconds, readings by plain names; no scales if its motion is magnified."""

    run: Trajectory
    part: Part
    slow_down: float = 1.0
    magnification: float = 1.0

    @property
    def is_magnified(self) -> bool:
        """Whether the motion is magnified."""
        return self.magnification != 1.0

    @property
    def _prefix(self) -> str:
        """Start of the names of the part in the run: empty for the only part, or "part."."""
        return f"{self.part.name}." if len(self.run.scene.parts) > 1 else ""

    def select_entries(self, entries: Mapping[str, T]) -> dict[str, T]:
        """Return the entries of the part from a mapping by name, by plain names."""
        return {name.removeprefix(self._prefix): value for name, value in entries.items() if name.startswith(self._prefix)}

    def select_bodies(self, states: FloatArray) -> FloatArray:
        """Return the bodies of the part, without the shaft of its spindle, of poses or velocities (n, all bodies, 3)."""
        return states[:, [self.run.scene.mechanism.body_index(self._prefix + body.name) for body in self.part.mechanism.bodies], :]

    @cached_property
    def poses(self) -> FloatArray:
        """Poses (n, bodies, 3) of the part."""
        return self.select_bodies(self.run.poses)

    def find_effect(self, kind: type[EffectT], *readings: str) -> EffectT | None:
        """Return the effect of a type, on one of the readings if there are any, or None."""
        effects = (effect for effect in self.part.effects if isinstance(effect, kind))
        return next((effect for effect in effects if not readings or getattr(effect, "reading", "") in readings), None)

    def reading_range(self, reading: str, default: Vec2 = (0.0, 0.0)) -> Vec2:
        """Return the smallest and the largest value of a reading over the run."""
        values = self.run.readings.get(self._prefix + reading)
        return default if values is None else (float(values.min()), float(values.max()))

    def is_held(self, reading: str, time: float) -> bool:
        """Return whether dry friction or a stop holds a reading at a time (s)."""
        changes = [(event.time, HOLD_EVENT_KINDS[event.kind]) for event in self._events_on(reading) if event.kind in HOLD_EVENT_KINDS]
        if not changes:
            low, high = self.reading_range(reading)
            return high - low <= 1e-9 * max(abs(low), abs(high))
        earlier = [is_hold for change_time, is_hold in changes if change_time <= time]
        return earlier[-1] if earlier else not changes[0][1]

    def struck_side(self, reading: str, time: float) -> int:
        """Return 1 for the high and -1 for the low stop of the last impact that is still shown at a time (s), or 0."""
        impacts = (event for event in self._events_on(reading) if event.kind == EventKind.IMPACT)
        recent = [event for event in impacts if 0.0 <= time - event.time < FLASH_DURATION / self.slow_down]
        if not recent:
            return 0
        # The nearer stop is the one that is hit.
        name = self._prefix + reading
        value = float(np.interp(recent[-1].time, self.run.times, self.run.readings[name]))
        contact = next(contact for contact in contacts_of(self.run.scene) if contact.output_name == name)
        return 1 if abs(value - contact.high) < abs(value - contact.low) else -1

    def _events_on(self, reading: str) -> list[Event]:
        return self._contact_events.get(self._prefix + reading, [])

    @cached_property
    def _contact_events(self) -> Mapping[str, list[Event]]:
        """Events of the run by subject; empty without contacts, whose events need no search."""
        events: defaultdict[str, list[Event]] = defaultdict(list)
        for event in self.run.events if contacts_of(self.run.scene) else ():
            events[event.subject].append(event)
        return events


def sample_input(run: Trajectory, load: InputFunction) -> FloatArray:
    """Return a load (n,) at the reported times, SI."""
    values = CubicTimeFunction(load)(run.times)
    for function in load.functions:
        values = values + sample_reading_function(run, function)
    for factor in load.factors:
        values = values * sample_reading_function(run, factor)
    return values


def sample_reading_function(run: Trajectory, function: ReadingFunction) -> FloatArray:
    """Return a function of a reading (n,) at the reported times, SI; a lag follows it from its first value on."""
    values = evaluate_reading_function_along(function, run.readings[function.reading])
    if function.lag:
        for k, decay in enumerate(np.exp(-np.diff(run.times) / function.lag), start=1):
            values[k] += decay * (values[k - 1] - values[k])
    return values


_LEAVE_OUT = "leave {exaggerate} out"
_STOP_TOLERANCE = 1e-6
"""Distance beyond a stop, relative to the scale of its reading, that counts as none: a run rests on a stop to within its accuracy."""
_STOP_COORDINATES = 50
"""Number of coordinates at which the stops are checked: a reading that turns back may pass a stop between the ends of the motion."""
_FACTOR_ACCURACY = 1e-3
"""Accuracy of the largest possible factor, relative to it: three digits of it are stated."""


def require_one_coordinate(scene: Scene) -> None:
    """Check that one coordinate determines all positions of a scene; call it before long work."""
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
    """Return a run with the positions that its coordinate has at its mean + factor * (coordinate - mean)."""
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


def motion_at_rest(
    scene: Scene,
    poses: FloatArray,  # shape (n, bodies, 3)
    readings: Mapping[str, FloatArray] | None = None,
) -> Trajectory:
    """Return poses as a motion at rest in each of them: a drawing asks for ranges of readings and for the space that is swept."""
    zeros = np.zeros(len(poses))
    units = {one.name: READING_UNITS[one.quantity] for one in scene.mechanism.readings}
    return Trajectory(
        scene=scene,
        times=np.arange(len(poses), dtype=np.float64),
        poses=poses,
        velocities=np.zeros_like(poses),
        readings=readings or {},
        rates={},
        units=units,
        scales={},
        joint_gap=zeros,
        energy=Energy(kinetic=zeros, potential=zeros, rotation=zeros, jacobi=zeros, dissipated_energy=zeros, scale=1.0),
        outcome=Outcome.NOT_CERTIFIED,
        cost=Cost(engine="none", reason="", step=0.0, steps=0, runs=0, evaluations={}, wall_time=0.0),
    )

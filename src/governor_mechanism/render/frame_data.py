"""A run interpolated to the frame times of a film, what the frames of several runs share, and forces on bodies over time."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.dynamics.force_laws import centrifugal_force, weight
from governor_mechanism.mechanics.dynamics.output_forces import element_law, pad_coefficients
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.motion_readings import joints_of_reactions
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.part import TURNING_PLANE, Part
from governor_mechanism.model.results.pictures import FilmLayout
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.numerics.interpolation import integrate_samples, interpolate_samples
from governor_mechanism.observables.motion_readings import point_velocity
from governor_mechanism.render.geometry.attached import DrawnPart, Moment, at_own_moments
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2, enclose_boxes
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.machines.registry import DRAWN_WITH_WHEEL, drawing_of
from governor_mechanism.render.part_run import find_shaft_wheel, magnify_motion
from governor_mechanism.render.shown_readings import RATE_START, ShownReading, chosen_readings, shown_readings
from governor_mechanism.types import FloatArray

END_TOLERANCE = 1e-9
"""Rounding of a frame time, relative to the shown time."""

MAX_SHARED_SCALE_RATIO = 3.0
"""Largest ratio of the sizes of machines that are shown on one scale: beside a larger one, a smaller would be too small to be seen."""


class FrameData:
    """One part of a run at the frame times (f,) s, all within `time_span` (s), the time that the film shows.

    Outside of the reported times of the run it rests in its first or its last position: `times` (f,) stay there, and `has_ended` (f,) is
    true after the last. `poses` (f, bodies, 3) are those of the part, by cubic Hermite polynomials, and where a contact event lies
    between two reported times, those of the run itself, unless it is read from a file or magnified; `readings` are by plain name, with
    values (f,) interpolated linearly; `spindle_angle` (f,) rad counts from the start and is zero without a spindle speed. `drawing` is that
    of the whole run. A second of the run takes `slow_down` seconds of film. `chosen` are names of readings of the run, or "rate of ...",
    that are shown besides. The motion of the drawing is magnified by `magnification`; the readings are not.
    `sample_times` (s,) are the reported times within the time span and its ends.
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
        self.part = part
        self.time_span = time_span
        self.times = times
        self.slow_down = slow_down
        drawn = run if magnification == 1.0 else magnify_motion(run, magnification)
        self.drawing = drawing_of(drawn, part, slow_down, magnification)
        self._velocities = self.drawing.select_bodies(drawn.velocities)
        self.poses = self.poses_at(times)
        first, last = (float(np.clip(time, run.times[0], run.times[-1])) for time in time_span)
        inside = run.times[(run.times > first) & (run.times < last)]
        # Curves are drawn through these, since a fast crank moves far from one frame to the next.
        self.sample_times = np.unique(np.concatenate([[first], inside, [last]]))
        readings = self.drawing.select_entries(shown_readings(run)) | self._select_chosen(run, chosen)
        speed = readings["spindle_speed"].values if "spindle_speed" in readings else np.zeros(len(run.times))
        self.spindle_angle = np.interp(times, run.times, integrate_samples(run.times, speed))
        self.readings = {name: replace(one, values=np.interp(times, run.times, one.values)) for name, one in readings.items()}
        self._reported = {name: one.values for name, one in readings.items()}

    def poses_at(self, times: FloatArray) -> FloatArray:
        """Return the poses (n, bodies, 3) at times (n,) s within those of the run."""
        reported, samples = self.drawing.run.times, self.drawing.poses
        if len(reported) < 2:
            return samples.repeat(len(times), axis=0)
        poses = interpolate_samples(reported, samples, self._velocities, times)
        for k, (near_event, _) in self._states_near_events(times).items():
            poses[k] = self.drawing.select_bodies(near_event[np.newaxis])[0]
        return poses

    def velocities_at(self, times: FloatArray) -> FloatArray:
        """Return the velocities (n, bodies, 3) at times (n,) s within those of the run, linear between its reported times."""
        columns = self._velocities.reshape(len(self._velocities), -1).T
        interpolated = [np.interp(times, self.drawing.run.times, column) for column in columns]
        velocities = np.stack(interpolated, axis=1).reshape(-1, *self.poses.shape[1:])
        for k, (_, near_event) in self._states_near_events(times).items():
            velocities[k] = self.drawing.select_bodies(near_event[np.newaxis])[0]
        return velocities

    def _states_near_events(self, times: FloatArray) -> Mapping[int, tuple[FloatArray, FloatArray]]:
        """Return the states of all bodies at those of times (n,) s near contact events, across which nothing can be interpolated."""
        results = self.drawing.run.deferred_results
        return {} if results is None or self.drawing.is_magnified else results.states_near_events(times)

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
    """Return whether a drawing shows the bodies where they are."""
    return data.drawing.shows_bodies


def enclosing_box(column: Sequence[FrameData], layout: FilmLayout) -> BoundingBox:
    """Return the smallest bounding box (m) that contains a part in several runs as a layout shows it."""
    is_bare = layout is FilmLayout.BARE
    return enclose_boxes(data.drawing.bare_bounds if is_bare else data.drawing.bounds for data in column)


def on_one_scale(column: Sequence[FrameData], shown: FrameData) -> list[FrameData]:
    """Return those of a column that are shown on one scale with one of them: all in a like plane if of like size, else it alone."""

    def size(data: FrameData) -> float:
        left, right, bottom, top = data.drawing.bounds
        return max(right - left, top - bottom)

    alike = [data for data in column if data.part.plane == shown.part.plane]
    sizes = [size(data) for data in alike]
    return alike if max(sizes) <= MAX_SHARED_SCALE_RATIO * min(sizes) else [shown]


def find_parts(run: Trajectory, name: str | None) -> tuple[Part, ...]:
    """Return the named part, or all for None, last one that turns with a spindle, without wheels that another part's drawing shows."""
    parts = run.scene.parts
    if name is None:
        on_shafts = [find_shaft_wheel(run.scene, part) for part in parts if part.machine in DRAWN_WITH_WHEEL]
        parts = tuple(part for part in parts if part not in on_shafts)
        return tuple(sorted(parts, key=lambda part: part.turns))
    names = [part.name for part in parts]
    if name not in names:
        raise MechanismError(f"the scene has no part {name!r}; its parts are {names}.{did_you_mean(name, names)}")
    return (parts[names.index(name)],)


REACTION: Final = "reaction"
"""Kind of the forces of joints."""
MIN_FORCE_RATIO = 1e-6
"""Largest force relative to that of all, below which a force is left out."""


@dataclass(frozen=True, kw_only=True)
class DrawnForce:
    """A force on a body."""

    kind: str  # "weight", "centrifugal", "spring", "damping", or REACTION
    name: str  # what it is
    point: Point  # point of the body at which it acts
    components: FloatArray  # components along the axes of the plane, N; shape (samples, 2)


def find_forces(data: FrameData, *, only_reactions: bool = False) -> list[DrawnForce]:
    """Return the forces on the bodies of a part at its sample times, without those that are practically zero."""
    # They are computed at the reported times, and are linear between these. Joints have those that are
    # readings of the run.
    drawing = data.drawing
    forces = list(_joint_forces(drawing))
    if not only_reactions:
        forces = [*_weights(drawing), *_centrifugal_forces(drawing), *_element_forces(drawing), *_effect_forces(drawing), *forces]
    largest = max((_magnitude(force) for force in forces), default=0.0)
    shown = [force for force in forces if _magnitude(force) > MIN_FORCE_RATIO * largest]
    return [replace(force, components=_interpolate(drawing.run.times, force.components, data.times)) for force in shown]


def _interpolate(times: FloatArray, components: FloatArray, at: FloatArray) -> FloatArray:
    """Return components (n, 2) at other times (m,)."""
    return np.column_stack([np.interp(at, times, column) for column in components.T])


def _magnitude(force: DrawnForce) -> float:
    """Return the largest magnitude of a force, N."""
    return float(np.hypot(*force.components.T).max(initial=0.0))


def _weights(drawing: MachineDrawing) -> Iterator[DrawnForce]:
    for body in drawing.part.mechanism.bodies:
        components = np.tile([0.0, weight(body.mass, drawing.part.gravity)], (len(drawing.poses), 1))
        yield DrawnForce(kind="weight", name=f"weight of {body.name}", point=Point(body=body.name), components=components)


def _centrifugal_forces(drawing: MachineDrawing) -> Iterator[DrawnForce]:
    """Yield the centrifugal force on each body of a plane that turns, m omega^2 x at its mass centre."""
    part, readings = drawing.part, drawing.select_entries(drawing.run.readings)
    if not (part.turns and part.has_centrifugal and "spindle_speed" in readings):
        return
    for index, body in enumerate(part.mechanism.bodies):
        force = centrifugal_force(body.mass, drawing.poses[:, index, 0], readings["spindle_speed"] ** 2)
        components = np.column_stack([force, np.zeros(len(force))])
        yield DrawnForce(kind="centrifugal", name=f"centrifugal force on {body.name}", point=Point(body=body.name), components=components)


def _element_forces(drawing: MachineDrawing) -> Iterator[DrawnForce]:
    """Yield the forces of springs and dampers between points, on each body that moves."""
    mechanism = drawing.part.mechanism
    for element in mechanism.force_elements:
        if not isinstance(element, Spring | Damper):
            continue
        (first, first_velocity), (second, second_velocity) = (_follow(drawing, point) for point in (element.first, element.second))
        length = np.hypot(*(second - first).T)
        direction = (second - first) / np.maximum(length, 1e-12)[:, None]
        law, coefficients = element_law(element)
        pull = -law.force(pad_coefficients(coefficients), length, np.sum(direction * (second_velocity - first_velocity), axis=1))
        kind = "spring" if isinstance(element, Spring) else "damping"
        for point, sign in ((element.first, 1.0), (element.second, -1.0)):
            if point.body != GROUND:
                components = sign * pull[:, None] * direction
                yield DrawnForce(kind=kind, name=f"{element.name} on {point.body}", point=point, components=components)


def _joint_forces(drawing: MachineDrawing) -> Iterator[DrawnForce]:
    """Yield the forces of the joints that are readings, on their second bodies, or on the first if the second is the ground."""
    requested = drawing.select_entries(dict.fromkeys(joints_of_reactions(drawing.run.scene.mechanism)))
    if not requested or drawing.shows_joint_forces:
        return
    reactions = drawing.select_entries(drawing.run.reactions)
    for joint in drawing.part.mechanism.joints:
        if joint.name in requested:
            point, sign = (joint.first, -1.0) if joint.second.body == GROUND else (joint.second, 1.0)
            components = sign * reactions[joint.name].force
            yield DrawnForce(kind=REACTION, name=f"{joint.name} on {point.body}", point=point, components=components)


def _follow(drawing: MachineDrawing, point: Point) -> tuple[FloatArray, FloatArray]:
    """Return positions and velocities (n, 2) of a point at the reported times."""
    mechanism = drawing.part.mechanism
    velocities = drawing.select_bodies(drawing.run.velocities)
    return point_path(mechanism, drawing.poses, point), point_velocity(mechanism, drawing.poses, velocities, point)


def _effect_forces(drawing: MachineDrawing) -> Iterator[DrawnForce]:
    """Yield the forces of effects along readings that are a coordinate of a point."""
    readings, rates = (drawing.select_entries(entries) for entries in (drawing.run.readings, drawing.run.rates))
    for effect in drawing.part.output_effects:
        reading = drawing.part.mechanism.reading(effect.reading)
        if not isinstance(effect, OutputForce) or not isinstance(reading, PointCoordinate) or effect.reading not in rates:
            continue
        if reading.origin.body != GROUND or reading.point.body == GROUND:
            continue
        values = readings[effect.reading]
        force = np.asarray(effect.evaluate(values, rates[effect.reading])) * np.ones(len(values))
        components = force[:, None] * np.array([reading.direction_x, reading.direction_y])
        kind = "damping" if effect.dissipates else "spring"
        name = f"{effect.key.replace('_', ' ')} on {reading.point.body}"
        yield DrawnForce(kind=kind, name=name, point=reading.point, components=components)

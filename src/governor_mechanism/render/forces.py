"""Forces on the bodies of a part over time, N: weight, centrifugal force, springs and dashpots by their laws, and those of joints."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.force_elements import element_law
from governor_mechanism.mechanics.dynamics.forces.force_laws import centrifugal_force, weight
from governor_mechanism.mechanics.dynamics.forces.output_forces import pad_coefficients
from governor_mechanism.mechanics.kinematics.point_paths import point_path
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.motion_readings import joints_of_reactions
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.observables.motion_readings import point_velocity
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.types import FloatArray

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
    """Return the forces on the bodies of a part at its sample times, without those that are practically zero.

    They are computed at the reported times, and are linear between these. Joints have those that are readings of the run.
    """
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
    mechanism, velocities = drawing.part.mechanism, drawing.select_bodies(drawing.run.velocities)
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
        kind, name = "damping" if effect.dissipates else "spring", f"{effect.key.replace('_', ' ')} on {reading.point.body}"
        yield DrawnForce(kind=kind, name=name, point=reading.point, components=components)

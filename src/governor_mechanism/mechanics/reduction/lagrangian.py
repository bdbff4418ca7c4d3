"""A mechanism of mobility one, followed along its coordinate: inertias, potential, and their derivatives.

Knows no machine by name: all is read off the joints, the bodies and the loads. A prime is a derivative by the leading
coordinate, in rad or m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import springs_of
from governor_mechanism.mechanics.dynamics.force_laws import (
    height_energy,
    spindle_inertia,
    spindle_inertia_bend,
    spindle_inertia_rate,
    spring_energy,
    spring_force,
)
from governor_mechanism.mechanics.kinematics.batched_assembly import Closing
from governor_mechanism.mechanics.kinematics.output_variables import measure, measured
from governor_mechanism.mechanics.kinematics.points import place
from governor_mechanism.mechanics.kinematics.range_of_motion import Travel, find_travel
from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.model.force_elements import Force, Load, Spring, Torque, TorsionSpring
from governor_mechanism.model.mechanism import BodyAngle, Mechanism, Reading
from governor_mechanism.model.scene import TURNING, FreeSpindle, Scene
from governor_mechanism.model.time_functions import Program
from governor_mechanism.types import FloatArray

CANCELLED = 1e-15
"""Of its parts: a slope of the spindle's inertia smaller than this is rounding, and counts as none."""


@dataclass(frozen=True, kw_only=True)
class Along:
    """A mechanism at n values of its coordinate: poses and their two derivatives (n, bodies, 3), and what follows.

    inertia I (n,): kinetic energy is I q'^2 / 2; spindle J (n,): moment of inertia about the spindle (kg m2); potential
    V (n,) J; each with its derivatives by the coordinate.
    """

    coordinate: FloatArray
    poses: FloatArray
    tangents: FloatArray
    curvatures: FloatArray
    inertia: FloatArray
    inertia_slope: FloatArray
    spindle: FloatArray
    spindle_slope: FloatArray
    spindle_bend: FloatArray
    potential: FloatArray
    potential_slope: FloatArray
    potential_bend: FloatArray

    def joined(self, other: Along) -> Along:
        """These values and then those of another."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__}
        return Along(**{name: np.concatenate(pair) for name, pair in pairs.items()})

    def chosen(self, which: NDArray[np.integer] | slice) -> Along:
        """Some of the values, in the order of their indices."""
        return Along(**{name: getattr(self, name)[which] for name in self.__dataclass_fields__})


class Reduction:
    """One scene's mechanism along its leading coordinate; loads as they are at the start."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanism: Mechanism = scene.part.mechanism
        self._closing = Closing(self.mechanism)
        assembler = self._closing.assembler
        if assembler.equations.driven.any() or assembler.mobility != 1:
            raise MechanismError(
                f"statics follow one coordinate of a mechanism of mobility one without drives; this one has mobility "
                f"{assembler.mobility}"
            )
        self.unit = self._closing.unit
        """What a radian, or a machine size, of the coordinate is in SI."""
        free = scene.spindle if isinstance(scene.spindle, FreeSpindle) else None
        self.rest_inertia = free.inertia if free else 0.0
        """Moment of inertia (kg m2) of the spindle itself, where it is known."""

    @cached_property
    def travel(self) -> Travel:
        """How far the mechanism goes. Raises MechanismError as `find_travel` does."""
        return find_travel(self.mechanism, turning=self.scene.part.plane == TURNING)

    def at(self, values: Sequence[float] | FloatArray, near: FloatArray | None = None) -> Along:
        """Assembled at values (n,) of the coordinate, on the track of the travel, or all near poses (bodies, 3).

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        asked = np.asarray(values, dtype=np.float64)
        expected = (
            self.travel.track.expected(asked) if near is None else np.repeat(near[np.newaxis], len(asked), axis=0)
        )
        return self.over(self._closing.at(expected, asked), asked)

    def over(self, poses: FloatArray, values: FloatArray) -> Along:
        """Everything at poses (n, bodies, 3) assembled at values (n,). Raises MechanismError at a dead centre."""
        tangents, curvatures = self._closing.path(poses)
        path = (poses, tangents, curvatures)
        inertia, inertia_slope = self._inertia(tangents, curvatures)
        spindle = self._spindle(*path)
        potential = self._potential(*path)
        return Along(
            coordinate=values,
            poses=poses,
            tangents=tangents,
            curvatures=curvatures,
            inertia=inertia,
            inertia_slope=inertia_slope,
            spindle=spindle[0],
            spindle_slope=spindle[1],
            spindle_bend=spindle[2],
            potential=potential[0],
            potential_slope=potential[1],
            potential_bend=potential[2],
        )

    def slopes(self, along: Along, name: str) -> FloatArray:
        """Derivative (n,) of a reading by the coordinate."""
        gradient = measure(self.mechanism, name, along.poses).gradient
        slope: FloatArray = np.sum(gradient * along.tangents, axis=(-2, -1))
        return slope

    def _inertia(self, tangents: FloatArray, curvatures: FloatArray) -> tuple[FloatArray, FloatArray]:
        masses = np.array([[b.mass, b.mass, b.moments.xx + b.moments.yy] for b in self.mechanism.bodies])
        axes = (-2, -1)
        return np.sum(masses * tangents**2, axis=axes), 2 * np.sum(masses * tangents * curvatures, axis=axes)

    def _spindle(
        self, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        total, parts = _three(len(poses)), np.zeros(len(poses))
        if not (self.scene.centrifugal and self.scene.part.plane == TURNING):
            return total
        for index, body in enumerate(self.mechanism.bodies):
            x, angle = poses[:, index, 0], poses[:, index, 2]
            moments, tangent = body.moments.in_plane, tangents[:, index]
            total[0][:] += spindle_inertia(body.mass, *moments, body.moments.zz, x, angle)
            total[1][:] += spindle_inertia_rate(body.mass, *moments, x, angle, tangent[:, 0], tangent[:, 2])
            total[2][:] += spindle_inertia_bend(body.mass, moments, x, angle, tangent, curvatures[:, index])
            parts += 2 * body.mass * self.mechanism.size * np.abs(tangent[:, 0])
            parts += (abs(moments[1] - moments[0]) + 2 * abs(moments[2])) * np.abs(tangent[:, 2])
        total[1][np.abs(total[1]) < CANCELLED * parts] = 0.0
        return total

    def _potential(
        self, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        total = _three(len(poses))
        for index, body in enumerate(self.mechanism.bodies):
            for part, path in zip(total, (poses, tangents, curvatures), strict=True):
                part += height_energy(body.mass, self.scene.gravity, path[:, index, 1])
        for load in self.mechanism.loads:
            for part, share in zip(total, self._of_load(load, poses, tangents, curvatures), strict=True):
                part += share
        for spring in springs_of(self.scene):
            along = self._way(self.mechanism.reading(spring.reading), poses, tangents, curvatures)
            pulls = ~(spring.one_sided & (along[0] < spring.free))
            for part, share in zip(total, _of_spring(spring.rate, spring.free, *along), strict=True):
                part += np.where(pulls, share, 0.0)
        return total

    def _of_load(
        self, load: Load, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Energy of a load and its derivatives; dampers have none, forces and torques that of their value at t = 0."""
        if isinstance(load, Spring):
            length = self._length(load, poses, tangents, curvatures)
            return _of_spring(load.stiffness, load.free_length, *length)
        if isinstance(load, TorsionSpring | Torque):
            angle = BodyAngle(name="", quantity="angle", body=load.second, against=load.first)
            turn, slope, bend = self._way(angle, poses, tangents, curvatures)
            if isinstance(load, TorsionSpring):
                return _of_spring(load.stiffness, load.free_angle, turn, slope, bend)
            moment = _at_start(load.moment)
            return -moment * turn, -moment * slope, -moment * bend
        if isinstance(load, Force):
            force = np.array([_at_start(load.x), _at_start(load.y)])
            point = place(self.mechanism, load.point)
            inward = point.inward(poses, tangents)
            bend = point.velocity(poses, curvatures) + inward
            return -point.position(poses) @ force, -point.velocity(poses, tangents) @ force, -bend @ force
        none = np.zeros(len(poses))
        return none, none, none

    def _length(
        self, spring: Spring, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Length of a spring and its derivatives; where its ends meet it has no direction, and pulls nowhere."""
        first, second = place(self.mechanism, spring.first), place(self.mechanism, spring.second)
        line = second.position(poses) - first.position(poses)
        rate = second.velocity(poses, tangents) - first.velocity(poses, tangents)
        bend = second.velocity(poses, curvatures) - first.velocity(poses, curvatures)
        bend += second.inward(poses, tangents) - first.inward(poses, tangents)
        length = np.linalg.norm(line, axis=-1)
        safe = np.where(length > 0.0, length, 1.0)
        slope = np.sum(line * rate, axis=-1) / safe
        return length, slope, (np.sum(rate**2 + line * bend, axis=-1) - slope**2) / safe

    def _way(
        self, reading: Reading, poses: FloatArray, tangents: FloatArray, curvatures: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        found, axes = measured(reading, self.mechanism, poses, tangents), (-2, -1)
        slope = np.sum(found.gradient * tangents, axis=axes)
        return found.value, slope, np.sum(found.gradient * curvatures, axis=axes) + found.bend


def _at_start(program: Program) -> float:
    """The value at t = 0; at a step there the one after it."""
    return float(TimeCurve(program)(np.array([0.0]))[0])


def _three(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Room for a quantity and its two derivatives."""
    return np.zeros(count), np.zeros(count), np.zeros(count)


def _of_spring(
    stiffness: float, free: float, way: FloatArray, slope: FloatArray, bend: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    pull = spring_force(stiffness, free, way)
    return spring_energy(stiffness, free, way), pull * slope, stiffness * slope**2 + pull * bend

"""A mechanism of mobility one, followed along its coordinate: inertias, potential, and their derivatives.

Knows no machine by name: all is read off the joints, the bodies and the loads. A prime is a derivative by the leading
coordinate, in rad or m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BPoly

from governor_mechanism.equations.assembly import Assembler
from governor_mechanism.equations.forces import (
    height_energy,
    spindle_inertia,
    spindle_inertia_bend,
    spindle_inertia_rate,
    spring_energy,
    spring_force,
)
from governor_mechanism.equations.points import Array, place
from governor_mechanism.equations.readings import Measure, measure, measured
from governor_mechanism.errors import MechanismError
from governor_mechanism.loads import Force, Load, Spring, Torque, TorsionSpring
from governor_mechanism.mechanism import BodyAngle, LineAngle, Mechanism, Separation
from governor_mechanism.scene import TURNING, FreeSpindle, Scene

COARSE, POLISH = (17, 65, 257), 12
"""So many values of a sweep are assembled one by one, more where the others stray; Newton steps for all at once."""

STRAY = 0.05
"""Machine sizes, and rad: others that close farther from where they were expected may be on another branch."""

SMALL = 1e-8
"""Machine sizes, and rad: after a Newton step of this size rounding alone is left."""


@dataclass(frozen=True, kw_only=True)
class Along:
    """A mechanism at n values of its coordinate: poses and their two derivatives (n, bodies, 3), and what follows.

    inertia I (n,): kinetic energy is I q'^2 / 2; spindle J (n,): moment of inertia about the spindle (kg m2); potential
    V (n,) J; each with its derivatives by the coordinate.
    """

    coordinate: Array
    poses: Array
    tangents: Array
    curvatures: Array
    inertia: Array
    inertia_slope: Array
    spindle: Array
    spindle_slope: Array
    spindle_bend: Array
    potential: Array
    potential_slope: Array
    potential_bend: Array


class Reduction:
    """One scene's mechanism along its leading coordinate; loads as they are at the start."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanism: Mechanism = scene.part.mechanism
        self._assembler = Assembler(self.mechanism)
        self._scale = np.array([self.mechanism.size, self.mechanism.size, 1.0])
        if self._assembler.equations.driven.any() or self._assembler.mobility != 1:
            raise MechanismError(
                f"statics follow one coordinate of a mechanism of mobility one without drives; this one has mobility "
                f"{self._assembler.mobility}"
            )
        free = scene.spindle if isinstance(scene.spindle, FreeSpindle) else None
        self.rest_inertia = free.inertia if free else 0.0
        """Moment of inertia (kg m2) of the spindle itself, where it is known."""

    def at(self, values: Sequence[float] | Array, near: Array | None = None) -> Along:
        """Assembled exactly at values (n,) of the coordinate, each from the one before."""
        asked, poses = np.asarray(values, dtype=np.float64), list[Array]()
        for value in asked:
            near = self._assembler.poses(float(value), near)
            poses.append(near)
        return self.over(np.array(poses).reshape(-1, len(self.mechanism.bodies), 3), asked)

    def sweep(self, values: Array) -> Along:
        """Assembled at many values (n,) in order: a few one by one, the rest from a cubic path through them."""
        for count in COARSE:
            knots = np.linspace(values[0], values[-1], count)
            poses = self._followed(knots)
            tangents = self._tangents(self._rows(poses, measure(self.mechanism, self.mechanism.coordinate, poses)))
            expected = BPoly.from_derivatives(knots, np.stack([poses, tangents], axis=1))(values)
            found = self._near(expected, values)
            if found is not None:
                return self.over(found, values)
        return self.at(values)

    def _followed(self, values: Array) -> Array:
        """Poses (n, bodies, 3) at values in order, each from its neighbour, beginning nearest to the sketch."""
        sketch = np.array(self.mechanism.sketch, dtype=np.float64)
        name = self.mechanism.coordinate
        begin = int(np.argmin(np.abs(values - measure(self.mechanism, name, sketch).value)))
        poses = np.zeros((len(values), *sketch.shape))
        poses[begin] = self._assembler.poses(float(values[begin]))
        for direction in (range(begin, 0, -1), range(begin, len(values) - 1)):
            for k in direction:
                following = k + (1 if direction.step > 0 else -1)
                step = values[following] - values[k]
                here = poses[k : k + 1]
                expected = here + step * self._tangents(self._rows(here, measure(self.mechanism, name, here)))
                found = self._near(expected, values[following : following + 1])
                poses[following] = (
                    self._assembler.poses(float(values[following]), poses[k]) if found is None else found[0]
                )
        return poses

    def _near(self, expected: Array, values: Array) -> Array | None:
        """Assembled poses near expected ones, (n, bodies, 3); None where they may be on another branch."""
        poses = self._closed(expected, values)
        strays = poses is None or np.max(np.abs(poses - expected) / self._scale) > STRAY
        return None if strays else poses

    def _closed(self, poses: Array, values: Array) -> Array | None:
        """Poses (n, bodies, 3) that are nearly assembled at values (n,), assembled; None where they do not close."""
        name = self.mechanism.coordinate
        turned = isinstance(self.mechanism.reading(name), LineAngle)
        for _ in range(POLISH):
            found = measure(self.mechanism, name, poses)
            off = found.value - values
            off = np.remainder(off + np.pi, 2 * np.pi) - np.pi if turned else off
            every = np.column_stack([self._assembler.equations.openings(poses), off])
            step = self._solve(self._rows(poses, found), every)
            poses = poses - step
            if np.max(np.abs(step) / self._scale) < SMALL:
                return poses
        return None

    def over(self, poses: Array, values: Array) -> Along:
        """Everything at poses (n, bodies, 3) assembled at values (n,). Raises MechanismError at a dead centre."""
        tangents, curvatures = self._path(poses)
        path = (poses, tangents, curvatures)
        inertia, inertia_slope = self._inertia(*path)
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

    def _path(self, poses: Array) -> tuple[Array, Array]:
        """First and second derivative of poses (n, bodies, 3) by the coordinate."""
        name = self.mechanism.coordinate
        found = measure(self.mechanism, name, poses)
        rows = self._rows(poses, found)
        tangents = self._tangents(rows)
        bends = self._assembler.equations.bends(poses, tangents)
        turned = -measure(self.mechanism, name, poses, tangents).bend
        return tangents, self._solve(rows, np.concatenate([bends, turned[:, np.newaxis]], axis=1))

    def _tangents(self, rows: Array) -> Array:
        ahead = np.zeros(rows.shape[:-1])
        ahead[:, -1] = 1.0
        return self._solve(rows, ahead)

    def slopes(self, along: Along, name: str) -> Array:
        """Derivative (n,) of a reading by the coordinate."""
        gradient = measure(self.mechanism, name, along.poses).gradient
        slope: Array = np.sum(gradient * along.tangents, axis=(-2, -1))
        return slope

    def _rows(self, poses: Array, lead: Measure) -> Array:
        joints = self._assembler.equations.gradients(poses).reshape(len(poses), -1, self._assembler.free.size)
        rows = np.concatenate([joints, lead.gradient.reshape(len(poses), 1, -1)], axis=1)
        return rows[..., self._assembler.free]

    def _solve(self, rows: Array, right: Array) -> Array:
        """Derivatives of all poses (n, bodies, 3) that the joints and the coordinate ask for."""
        count, free = len(rows), self._assembler.free
        try:
            square = rows.shape[1] == rows.shape[2]
            found = (
                np.linalg.solve(rows, right[..., np.newaxis])
                if square
                else np.linalg.pinv(rows) @ right[..., np.newaxis]
            )
        except np.linalg.LinAlgError as error:
            raise MechanismError(
                f"{self.mechanism.coordinate!r} stands at a dead centre there and does not settle the others"
            ) from error
        every = np.zeros((count, free.size))
        every[:, free] = found[..., 0]
        return every.reshape(count, -1, 3)

    def _inertia(self, poses: Array, tangents: Array, curvatures: Array) -> tuple[Array, Array]:
        masses = np.array([[b.mass, b.mass, b.moments.xx + b.moments.yy] for b in self.mechanism.bodies])
        axes = (-2, -1)
        return np.sum(masses * tangents**2, axis=axes), 2 * np.sum(masses * tangents * curvatures, axis=axes)

    def _spindle(self, poses: Array, tangents: Array, curvatures: Array) -> tuple[Array, Array, Array]:
        total = _three(len(poses))
        if not (self.scene.centrifugal and self.scene.part.plane == TURNING):
            return total
        for index, body in enumerate(self.mechanism.bodies):
            x, angle = poses[:, index, 0], poses[:, index, 2]
            moments, tangent = body.moments.in_plane, tangents[:, index]
            total[0][:] += spindle_inertia(body.mass, *moments, body.moments.zz, x, angle)
            total[1][:] += spindle_inertia_rate(body.mass, *moments, x, angle, tangent[:, 0], tangent[:, 2])
            total[2][:] += spindle_inertia_bend(body.mass, moments, x, angle, tangent, curvatures[:, index])
        return total

    def _potential(self, poses: Array, tangents: Array, curvatures: Array) -> tuple[Array, Array, Array]:
        total = _three(len(poses))
        for index, body in enumerate(self.mechanism.bodies):
            for part, path in zip(total, (poses, tangents, curvatures), strict=True):
                part += height_energy(body.mass, self.scene.gravity, path[:, index, 1])
        for load in self.mechanism.loads:
            for part, share in zip(total, self._of_load(load, poses, tangents, curvatures), strict=True):
                part += share
        return total

    def _of_load(self, load: Load, poses: Array, tangents: Array, curvatures: Array) -> tuple[Array, Array, Array]:
        """Energy of a load and its derivatives; dampers have none, forces and torques that of their first value."""
        if isinstance(load, Spring):
            length = Separation(name="", quantity="length", first=load.first, second=load.second)
            return _of_spring(load.stiffness, load.free_length, *self._way(length, poses, tangents, curvatures))
        if isinstance(load, TorsionSpring | Torque):
            angle = BodyAngle(name="", quantity="angle", body=load.second, against=load.first)
            turn, slope, bend = self._way(angle, poses, tangents, curvatures)
            if isinstance(load, TorsionSpring):
                return _of_spring(load.stiffness, load.free_angle, turn, slope, bend)
            moment = load.moment.values[0]
            return -moment * turn, -moment * slope, -moment * bend
        if isinstance(load, Force):
            force = np.array([load.x.values[0], load.y.values[0]])
            point = place(self.mechanism, load.point)
            inward = point.inward(poses, tangents)
            bend = point.velocity(poses, curvatures) + inward
            return -point.position(poses) @ force, -point.velocity(poses, tangents) @ force, -bend @ force
        none = np.zeros(len(poses))
        return none, none, none

    def _way(
        self, reading: Separation | BodyAngle, poses: Array, tangents: Array, curvatures: Array
    ) -> tuple[Array, Array, Array]:
        found, axes = measured(reading, self.mechanism, poses, tangents), (-2, -1)
        slope = np.sum(found.gradient * tangents, axis=axes)
        return found.value, slope, np.sum(found.gradient * curvatures, axis=axes) + found.bend


def _three(count: int) -> tuple[Array, Array, Array]:
    """Room for a quantity and its two derivatives."""
    return np.zeros(count), np.zeros(count), np.zeros(count)


def _of_spring(stiffness: float, free: float, way: Array, slope: Array, bend: Array) -> tuple[Array, Array, Array]:
    pull = spring_force(stiffness, free, way)
    return spring_energy(stiffness, free, way), pull * slope, stiffness * slope**2 + pull * bend

"""Moment of inertia of a turning plane about its spindle, and the torque that a given speed needs."""

from functools import cached_property

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.force_laws import spindle_inertia, spindle_inertia_rate
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.coupling.coupled_system import TurningPlane
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray


class PlaneRotation:
    """Rotation of a plane with its spindle.

    Parameters
    ----------
    mechanism
        Mechanism with the bodies of the plane.
    plane
        The plane.

    Attributes
    ----------
    plane
        The plane.
    shaft_index
        Index of the body that the plane turns with; -1 if its speed is given.
    speed_function
        Given speed as a function of time; None where it is not given.
    """

    def __init__(self, mechanism: Mechanism, plane: TurningPlane) -> None:
        self.plane, self._mechanism = plane, mechanism
        self.shaft_index = mechanism.body_index(plane.shaft) if plane.shaft else -1
        self.speed_function = SpindleSpeedFunction(plane.given_speed, plane.ratio) if plane.given_speed else None

    def speed(self, times: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the speed (n,) rad/s at times (n,) s, with velocities (n, bodies, 3)."""
        return self.of_shaft(velocities) if self.speed_function is None else self.speed_function(times)

    def of_shaft(self, motion: FloatArray) -> FloatArray:
        """Return the angle or speed (n,) of the plane from poses or velocities (n, bodies, 3)."""
        column: FloatArray = self.plane.ratio * motion[:, self.shaft_index, 2]
        return column

    def inertia(self, poses: FloatArray) -> FloatArray:
        """Return the moment of inertia (n,) kg m2 of the bodies about the spindle at poses (n, bodies, 3)."""
        masses, (xx, yy, xy, zz) = self._masses, self._second_moments
        total: FloatArray = spindle_inertia(masses, xx, yy, xy, zz, poses[:, self._bodies, 0], poses[:, self._bodies, 2]).sum(axis=1)
        return total

    def driving_torque(self, times: FloatArray, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the torque (n,) N m that drives the plane at its given speed: the rate of the angular momentum, d(J omega)/dt."""
        masses, (xx, yy, xy, _), (x, angle) = self._masses, self._second_moments, (poses[:, self._bodies, k] for k in (0, 2))
        x_rate, angular_velocity = (velocities[:, self._bodies, k] for k in (0, 2))
        inertia_rate = spindle_inertia_rate(masses, xx, yy, xy, x, angle, x_rate, angular_velocity).sum(axis=1)
        torque: FloatArray = inertia_rate * self.speed(times, velocities)
        if self.speed_function is not None and not self.speed_function.is_constant:
            torque += self.inertia(poses) * self.speed_function.derivative(times)
        return torque

    @property
    def _bodies(self) -> list[int]:
        return list(self.plane.bodies)

    @cached_property
    def _masses(self) -> FloatArray:
        return np.array([self._mechanism.bodies[k].mass for k in self.plane.bodies])

    @cached_property
    def _second_moments(self) -> FloatArray:
        """Second moments xx, yy, xy and zz of the bodies, kg m2; shape (4, bodies)."""
        moments = [self._mechanism.bodies[k].second_moments for k in self.plane.bodies]
        return np.array([[one.xx, one.yy, one.xy, one.zz] for one in moments]).reshape(-1, 4).T


@once_per_object
def plane_rotations(scene: Scene) -> tuple[PlaneRotation, ...]:
    """Return the rotation of each plane of a scene that turns with a spindle.

    Result: rotations in the order of the planes.
    """
    return tuple(PlaneRotation(scene.mechanism, plane) for plane in scene.system.planes)

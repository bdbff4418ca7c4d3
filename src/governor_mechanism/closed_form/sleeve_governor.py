"""Statics and motion of a governor of two balls and a sleeve, from the paths of ball and sleeve over one coordinate q.

With x and y of a ball and the height z of the sleeve, m and M the masses of one ball and of the sleeve, F the force that presses the
sleeve down besides its weight, and ' the derivative by q, Lagrange's equation is

    (2 m (x'^2 + y'^2) + M z'^2) q'' + (2 m (x' x'' + y' y'') + M z' z'') q'^2 = 2 m w^2 x x' - 2 m g y' - (M g + F) z'

The geometry of each governor stands in a file of its own; all values are floats or arrays that broadcast.
"""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import raise_where
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorPaths:
    """Paths of a ball and the sleeve at values of the coordinate (rad), with the masses.

    Attributes
    ----------
    ball_mass, sleeve_mass
        Masses of one ball and of the sleeve, kg.
    gravity
        Gravitational acceleration, m/s2.
    x, x1, x2
        Distance of a ball from the axis (m) and its first and second derivative.
    y1, y2
        First and second derivative of the height of a ball.
    z1, z2
        First and second derivative of the height of the sleeve.
    """

    ball_mass: float
    sleeve_mass: float
    gravity: float
    x: FloatArray
    x1: FloatArray
    x2: FloatArray
    y1: FloatArray
    y2: FloatArray
    z1: FloatArray
    z2: FloatArray

    @property
    def inertia(self) -> FloatArray:
        """Moment of inertia along the coordinate, kg m2."""
        return np.asarray(2 * self.ball_mass * (self.x1**2 + self.y1**2) + self.sleeve_mass * self.z1**2)

    def load_moment(self, sleeve_force: FloatArray) -> FloatArray:
        """Return the moment of weights and sleeve force (N, downward) against the coordinate, N m."""
        load = self.sleeve_mass * self.gravity + sleeve_force
        return np.asarray(2 * self.ball_mass * self.gravity * self.y1 + load * self.z1)

    def equilibrium_speed(self, sleeve_force: FloatArray) -> FloatArray:
        """Return the spindle speed (rad/s) of equilibrium under a force on the sleeve (N, downward)."""
        squared = self.load_moment(sleeve_force) / (2 * self.ball_mass * self.x * self.x1)
        message = "no speed holds the balls there: their weight and the load drive them outward"
        raise_where(squared < 0, message, ("sleeve_force", sleeve_force, "N"))
        return np.sqrt(squared)

    def holding_force(self, speed: FloatArray) -> FloatArray:
        """Return the force (N, downward) that holds the sleeve at a spindle speed (rad/s), besides its weight."""
        moment = 2 * self.ball_mass * (speed**2 * self.x * self.x1 - self.gravity * self.y1)
        return np.asarray(moment / self.z1 - self.sleeve_mass * self.gravity)

    def squared_frequency(self, sleeve_force: FloatArray, sleeve_rate: FloatArray, speed: FloatArray) -> FloatArray:
        """Return the squared natural frequency (rad2/s2) at a constant speed; the sleeve force grows by sleeve_rate (N/m)."""
        load = self.sleeve_mass * self.gravity + sleeve_force
        weights = 2 * self.ball_mass * self.gravity * self.y2 + load * self.z2 + sleeve_rate * self.z1**2
        centrifugal = 2 * self.ball_mass * speed**2 * (self.x1**2 + self.x * self.x2)
        return np.asarray((weights - centrifugal) / self.inertia)

    def acceleration(self, rate: FloatArray, speed: FloatArray, sleeve_force: FloatArray) -> FloatArray:
        """Return the acceleration (rad/s2) of the coordinate at its rate and the spindle speed (rad/s), under a force on the sleeve (N)."""
        m, mass = self.ball_mass, self.sleeve_mass
        inertia_slope = 2 * m * (self.x1 * self.x2 + self.y1 * self.y2) + mass * self.z1 * self.z2
        moment = 2 * m * speed**2 * self.x * self.x1 - self.load_moment(sleeve_force)
        return np.asarray((moment - inertia_slope * rate**2) / self.inertia)

    def spindle_acceleration(self, rate: FloatArray, speed: FloatArray, constant_inertia: FloatArray, torque: FloatArray) -> FloatArray:
        """Return the acceleration (rad/s2) of a free spindle with a constant inertia (kg m2) under a torque (N m)."""
        inertia = constant_inertia + 2 * self.ball_mass * self.x**2
        return np.asarray((torque - 4 * self.ball_mass * self.x * self.x1 * rate * speed) / inertia)

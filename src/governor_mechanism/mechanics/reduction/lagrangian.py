"""Lagrangian coefficients of a mechanism with one degree of freedom: inertias, potential and their derivatives.

They follow from joints, bodies and force elements of any machine. A prime is a derivative by the leading coordinate, in rad or m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of, potential_derivatives
from governor_mechanism.mechanics.kinematics.batched_assembly import BatchedPositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import Force, ForceElement, Spring, Torque, TorsionSpring
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import FloatArray

CANCELLATION_RATIO = 1e-15
"""Derivative of the spindle inertia relative to its terms below which it is rounding and set to zero."""


@dataclass(frozen=True)
class PathCoefficients:
    """The Lagrangian coefficients at n values of the coordinate.

    Attributes
    ----------
    coordinate
        Leading coordinate q, SI; shape (n,).
    poses
        Poses; shape (n, bodies, 3).
    tangents
        First derivative of the poses; shape (n, bodies, 3).
    curvatures
        Second derivative of the poses; shape (n, bodies, 3).
    inertia
        I in the kinetic energy I q'^2 / 2; shape (n,).
    inertia_derivative
        I'; shape (n,).
    spindle_inertia
        Moment of inertia J of the bodies about the spindle, kg m2; shape (n,).
    spindle_inertia_derivative
        J'; shape (n,).
    spindle_inertia_second_derivative
        J''; shape (n,).
    potential_derivative
        V' of the potential energy V; shape (n,).
    potential_second_derivative
        V''; shape (n,).
    """

    coordinate: FloatArray
    poses: FloatArray
    tangents: FloatArray
    curvatures: FloatArray
    inertia: FloatArray
    inertia_derivative: FloatArray
    spindle_inertia: FloatArray
    spindle_inertia_derivative: FloatArray
    spindle_inertia_second_derivative: FloatArray
    potential_derivative: FloatArray
    potential_second_derivative: FloatArray

    def force_terms(self, speed_squared: FloatArray | float) -> FloatArray:
        """Return V' and -J' w^2 / 2 (2, n), which sum up to the generalised force against the coordinate."""
        return np.array([self.potential_derivative, -0.5 * speed_squared * self.spindle_inertia_derivative])

    def stiffness_terms(self, speed_squared: FloatArray | float) -> FloatArray:
        """Return V'' and -J'' w^2 / 2 (2, n), which sum up to the stiffness."""
        return np.array([self.potential_second_derivative, -0.5 * speed_squared * self.spindle_inertia_second_derivative])

    def concatenate(self, other: PathCoefficients) -> PathCoefficients:
        """Return these values followed by those of another."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__}
        return PathCoefficients(**{name: np.concatenate(pair) for name, pair in pairs.items()})

    def select(self, indices: NDArray[np.integer] | slice) -> PathCoefficients:
        """Return the values at some indices."""
        return PathCoefficients(**{name: getattr(self, name)[indices] for name in self.__dataclass_fields__})


class SingleDofReduction:
    """One scene's mechanism reduced to its leading coordinate; time functions have their values at t = 0.

    Parameters
    ----------
    scene
        The scene.

    Attributes
    ----------
    scene
        The scene.
    mechanism
        Its mechanism.
    coordinate_scale
        SI value of a radian, or of a length scale, of the coordinate.
    free_spindle_inertia
        Moment of inertia of a free spindle itself, kg m2; else 0.

    Raises
    ------
    MechanismError
        If the mechanism has drives or another number of degrees of freedom than one.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanism: Mechanism = scene.part.mechanism
        self._position_solver = BatchedPositionSolver(self.mechanism)
        mobility = self._position_solver.mobility
        if self._position_solver.equations.is_driven.any() or mobility != 1:
            raise MechanismError(
                f"statics need a mechanism with one degree of freedom and without drives; this one has mobility {mobility}"
            )
        self.coordinate_scale = self.mechanism.output_scale(self.mechanism.coordinate)
        """SI value of a radian, or of a length scale, of the coordinate."""
        self.free_spindle_inertia = scene.spindle.inertia if isinstance(scene.spindle, FreeSpindle) else 0.0
        """Moment of inertia of a free spindle itself, kg m2; else 0."""

    @cached_property
    def range_of_motion(self) -> RangeOfMotion:
        """Range of motion of the mechanism. Raises MechanismError as `find_range_of_motion` does."""
        return find_range_of_motion(self.mechanism, rotates_with_spindle=self.scene.part.plane == TURNING_PLANE)

    def evaluate(self, values: Sequence[float] | FloatArray, guess: FloatArray | None = None) -> PathCoefficients:
        """Assemble the mechanism at values (n,) of the coordinate, guided by the path or by one guess (bodies, 3), and evaluate it.

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        coordinates = np.asarray(values, dtype=np.float64)
        if guess is None:
            guesses = self.range_of_motion.path.predict_poses(coordinates)
        else:
            guesses = np.repeat(guess[np.newaxis], len(coordinates), axis=0)
        return self.evaluate_at_poses(self._position_solver.solve_at_coordinates(guesses, coordinates), coordinates)

    def evaluate_at_poses(self, poses: FloatArray, values: FloatArray) -> PathCoefficients:
        """Return the coefficients at poses (n, bodies, 3) assembled at values (n,). Raises MechanismError at a turning point."""
        tangents, curvatures = self._position_solver.path_derivatives(poses)
        path = np.stack([poses, tangents, curvatures])
        return PathCoefficients(values, *path, *self._reduced_inertia(path), *self._spindle_inertia(path), *self._potential(path))

    def output_derivative(self, coefficients: PathCoefficients, name: str) -> FloatArray:
        """Return the derivative (n,) of a reading by the coordinate."""
        return evaluate_output(self.mechanism, name, coefficients.poses).rate(coefficients.tangents)

    def _reduced_inertia(self, path: FloatArray) -> FloatArray:
        """Return the inertia and its derivative (2, n) along a path (3, n, bodies, 3): poses, tangents and curvatures."""
        masses = np.array([[b.mass, b.mass, b.second_moments.xx + b.second_moments.yy] for b in self.mechanism.bodies])
        axes, (_, tangents, curvatures) = (-2, -1), path
        return np.array([np.sum(masses * tangents**2, axis=axes), 2 * np.sum(masses * tangents * curvatures, axis=axes)])

    def _spindle_inertia(self, path: FloatArray) -> FloatArray:
        """Return the moment of inertia about the spindle and its two derivatives (3, n) along a path."""
        (poses, tangents, curvatures), total = path, np.zeros(path.shape[:2])
        if not (self.scene.has_centrifugal and self.scene.part.plane == TURNING_PLANE):
            return total
        magnitude = np.zeros(len(poses))
        for index, body in enumerate(self.mechanism.bodies):
            x, angle = poses[:, index, 0], poses[:, index, 2]
            moments, tangent = body.second_moments.in_plane, tangents[:, index]
            total[0] += force_laws.spindle_inertia(body.mass, *moments, body.second_moments.zz, x, angle)
            total[1] += force_laws.spindle_inertia_rate(body.mass, *moments, x, angle, tangent[:, 0], tangent[:, 2])
            total[2] += force_laws.spindle_inertia_second_derivative(body.mass, moments, x, angle, tangent, curvatures[:, index])
            magnitude += 2 * body.mass * self.mechanism.length_scale * np.abs(tangent[:, 0])
            magnitude += (abs(moments[1] - moments[0]) + 2 * abs(moments[2])) * np.abs(tangent[:, 2])
        total[1][np.abs(total[1]) < CANCELLATION_RATIO * magnitude] = 0.0
        return total

    def _potential(self, path: FloatArray) -> FloatArray:
        """Return the first two derivatives (2, n) of the potential along a path."""
        total = np.zeros((2, path.shape[1]))
        for index, body in enumerate(self.mechanism.bodies):
            total += force_laws.gravitational_energy(body.mass, self.scene.gravity, path[1:, :, index, 1])
        for element in self.mechanism.force_elements:
            total += self._element_potential(element, path)
        for effect in output_forces_of(self.scene):
            output = self._output_derivatives(self.mechanism.reading(effect.reading), path)
            _, force, stiffness = potential_derivatives(effect, output[0])
            total += _derivatives_along_path(force, stiffness, output)
        return total

    def _element_potential(self, element: ForceElement, path: FloatArray) -> FloatArray:
        """Return the first two derivatives of the potential of a force element; zero for dampers, forces and torques as at t = 0."""
        if isinstance(element, Spring | TorsionSpring):
            displacement = self._output_derivatives(element.displacement, path)
            displacement[1:] = np.where(np.isnan(displacement[1]), 0.0, displacement[1:])  # coincident points: no line of action
            force = force_laws.spring_force(element.stiffness, element.free_displacement, displacement[0])
            return _derivatives_along_path(force, element.stiffness, displacement)
        if isinstance(element, Torque):
            return -_initial_value(element.moment) * self._output_derivatives(element.displacement, path)[1:]
        total = np.zeros((2, path.shape[1]))
        if isinstance(element, Force):
            for component, coordinate in zip((element.x, element.y), element.displacements, strict=True):
                total -= _initial_value(component) * self._output_derivatives(coordinate, path)[1:]
        return total

    def _output_derivatives(self, reading: Reading, path: FloatArray) -> FloatArray:
        """Return the value of an output and its two derivatives (3, n) along a path."""
        poses, tangents, curvatures = path
        output = OutputDerivatives(self.mechanism, reading, poses, tangents)
        return np.array([output.value, output.rate(tangents), output.acceleration(curvatures)])


def _initial_value(program: InputFunction) -> float:
    """Return the value at t = 0; at a discontinuity the right limit."""
    return float(CubicTimeFunction(program)(np.array([0.0]))[0])


def _derivatives_along_path(force: FloatArray, stiffness: FloatArray | float, displacement: FloatArray) -> FloatArray:
    """Return the derivatives (2, n) of a potential along a path from those by a displacement, given with its derivatives (3, n)."""
    _, derivative, second_derivative = displacement
    return np.array([force * derivative, stiffness * derivative**2 + force * second_derivative])

"""Lagrangian coefficients of a mechanism with one degree of freedom at many values of its leading coordinate.

They follow from joints, bodies and force elements of any machine. A prime is a derivative by the leading coordinate, in rad or m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.contacts import output_forces_of
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lagrangian_lowering import lower_lagrangian
from governor_mechanism.mechanics.reduction.node_evaluation import Coefficient, evaluate_coefficients_at_nodes, make_reduction_workspace
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


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
    """One scene's mechanism reduced to its leading coordinate; loads have their values at t = 0.

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
        self._solver = CoordinateSolver(self.mechanism)
        mobility = self._solver.mobility
        if self._solver.equations.is_driven.any() or mobility != 1:
            raise MechanismError(
                f"statics need a mechanism with one degree of freedom and without drives; this one has mobility {mobility}"
            )
        if any(isinstance(element, CylinderGas) for element in self.mechanism.force_elements):
            raise MechanismError("statics and linearisation are not for an engine that gas drives, which turns over; run it instead")
        effects = [effect for effect in output_forces_of(scene) if not effect.dissipates]
        outputs = list(dict.fromkeys(effect.reading for effect in effects))
        self._arrays = lower_lagrangian(scene, "", scene.part, outputs, effects)
        self._workspace = make_reduction_workspace(self._arrays)
        loads = [load for element in self.mechanism.force_elements for load in element.loads]
        self._loads = np.array([CubicTimeFunction(load)(np.zeros(1))[0] for load in loads])  # at a discontinuity the right limit
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
        return self.evaluate_near(guesses, coordinates)

    def evaluate_near(self, guesses: FloatArray, values: FloatArray) -> PathCoefficients:
        """Return the coefficients at values (n,), near guesses of the poses (n, bodies, 3). Raises MechanismError as `solve_nodes` does."""
        nodes = self._solver.solve_nodes(guesses, values)
        coefficients = evaluate_coefficients_at_nodes(self._arrays, self._workspace, nodes.reshape(len(values), 3, -1)).T
        unit_forces = coefficients[Coefficient.FIRST_LOAD :].reshape(-1, 2, len(values))
        coefficients[Coefficient.POTENTIAL_DERIVATIVE : Coefficient.POTENTIAL_SECOND_DERIVATIVE + 1] -= np.tensordot(
            self._loads, unit_forces, axes=1
        )
        return PathCoefficients(values, *nodes.swapaxes(0, 1), *coefficients[: Coefficient.DAMPING])

    def output_derivative(self, coefficients: PathCoefficients, name: str) -> FloatArray:
        """Return the derivative (n,) of a reading by the coordinate."""
        return evaluate_output(self.mechanism, name, coefficients.poses).rate(coefficients.tangents)

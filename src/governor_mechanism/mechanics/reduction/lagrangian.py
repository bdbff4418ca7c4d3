"""Lagrangian coefficients of a mechanism with one degree of freedom at many values of its leading coordinate.

They follow from joints, bodies and force elements of any machine. A prime is a derivative by the leading coordinate, in rad or m.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.forces.output_forces import OUTPUT_FORCE_DTYPE, lower_outputs, output_force_record
from governor_mechanism.mechanics.dynamics.system.lowering import BODY_DTYPE, make_body_record
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver, lower_assembly
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.range_of_motion import RangeOfMotion, find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.node_evaluation import (
    OUTPUT_LIMIT_DTYPE,
    Coefficient,
    ReductionArrays,
    evaluate_coefficients_at_nodes,
    make_reduction_workspace,
)
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import GROUND_INDEX, FloatArray


def lower_lagrangian(
    scene: Scene,
    prefix: str,
    part: Part,
    # readings of the part that are evaluated with the coefficients, among them those of the effects
    outputs: Sequence[str],
    effects: Sequence[OutputForce],
) -> ReductionArrays:
    """Lower a part to the arrays of its Lagrangian coefficients, without bounds or limits; gas is left out: its force has kinks."""
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    has_centrifugal_forces = plane is not None and plane.is_loaded
    own_elements = [
        element
        for element in scene.mechanism.force_elements
        if not acts_elsewhere(element, prefix, part) and not isinstance(element, CylinderGas)
    ]
    rows, element_forces = lower_outputs(scene.mechanism, outputs, own_elements, {}, 0)
    first_body = scene.mechanism.body_index(prefix + mechanism.bodies[0].name)
    for side in ("first", "second"):
        rows.table[side] -= np.where(rows.table[side] != GROUND_INDEX, first_body, 0)
    effect_records = [output_force_record(effect, outputs.index(effect.reading)) for effect in effects]
    if effect_records:
        element_forces = np.concatenate([np.array(effect_records, dtype=OUTPUT_FORCE_DTYPE), element_forces])
    return ReductionArrays(
        assembly=lower_assembly(mechanism),
        mass=np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).ravel(),
        bodies=np.array([make_body_record(body, part.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        output_rows=rows._replace(row_bodies=bodies_of_rows(rows.table)),
        forces=element_forces,
        n_loads=sum(len(element.loads) for element in own_elements),
        output_scales=np.array([scene.mechanism.output_scale(name) for name in outputs]),
        limits=np.zeros(0, dtype=OUTPUT_LIMIT_DTYPE),
        steady_speed=-1.0,
        time_scale=time_scale(scene),
        low=-math.inf,
        high=math.inf,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=False,
    )


def acts_elsewhere(element: ForceElement, prefix: str, part: Part) -> bool:
    """Return whether a force element acts on no body of a part."""
    return {prefix + body.name for body in part.mechanism.bodies}.isdisjoint(element.bodies)


@dataclass(frozen=True)
class PathCoefficients:
    """The Lagrangian coefficients at n values of the coordinate."""

    coordinate: FloatArray  # leading coordinate q, SI; shape (n,)
    poses: FloatArray  # poses; shape (n, bodies, 3)
    tangents: FloatArray  # first derivative of the poses; shape (n, bodies, 3)
    curvatures: FloatArray  # second derivative of the poses; shape (n, bodies, 3)
    inertia: FloatArray  # i in the kinetic energy I q'^2 / 2; shape (n,)
    inertia_derivative: FloatArray  # i'; shape (n,)
    spindle_inertia: FloatArray  # moment of inertia J of the bodies about the spindle, kg m2; shape (n,)
    spindle_inertia_derivative: FloatArray  # j'; shape (n,)
    spindle_inertia_second_derivative: FloatArray  # j''; shape (n,)
    potential_derivative: FloatArray  # v' of the potential energy V; shape (n,)
    potential_second_derivative: FloatArray  # v''; shape (n,)

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
    """A scene's mechanism reduced to its leading coordinate, with the loads at t = 0; MechanismError for drives or another mobility."""

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
        """Assemble at values (n,), guided by the path or a guess (bodies, 3), and evaluate; MechanismError names an open joint."""
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

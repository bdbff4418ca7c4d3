"""Kinematics: how a driven mechanism stands and moves along its coordinate, or in the time of its drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray

TIME_VARIABLE = "time"
"""The name of what drives follow."""


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """A mechanism at n values of a coordinate, or at n times: nothing is integrated.

    poses, velocities, accelerations (n, bodies, 3) of mass centres in m, rad, s; readings map names to (n,) SI arrays,
    rates and accelerations_of them to their first and second time derivatives.
    """

    over: str
    values: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    reading_accelerations: Mapping[str, FloatArray]


def solve_kinematics(
    scene: Scene, over: str, values: Sequence[float] | FloatArray, rate: float = 1.0, acceleration: float = 0.0
) -> Kinematics:
    """Positions, velocities and accelerations of a scene's mechanism over values (n,) of a reading, or over times.

    Over a reading (SI), the scene's drives are taken off, and the reading moves at `rate` and `acceleration` (SI/s,
    SI/s2) at each value. Over "time" (s), the drives themselves move it. Raises MechanismError for a mechanism that
    this does not settle, and where it cannot be assembled or stands at a dead centre.
    """
    samples = _validate_samples(over, values, rate, acceleration)
    mechanism = scene.part.mechanism
    if over == TIME_VARIABLE:
        kinematic_solver = _KinematicSolver(mechanism, [], {})
        _require_degrees_of_freedom(mechanism, kinematic_solver.degrees_of_freedom(), 0, "over 'time' its drives must hold it")
    else:
        mechanism.reading(over)
        joints = tuple(joint for joint in mechanism.joints if not isinstance(joint, RotationalDriver | TranslationalDriver))
        mechanism = replace(mechanism, joints=joints)
        start_values = {name: value for name, value in scene.start.values.items() if isinstance(value, float | int)}
        kinematic_solver = _KinematicSolver(mechanism, [over], start_values)
        _require_degrees_of_freedom(mechanism, kinematic_solver.degrees_of_freedom(), 1, f"over {over!r} one reading must settle it")
    states = [kinematic_solver.solve_at(float(value), rate, acceleration) for value in samples]
    poses, velocities, accelerations = (np.array(column) for column in zip(*states, strict=True))
    output_derivatives = {reading.name: evaluate_output(mechanism, reading.name, poses, velocities) for reading in mechanism.readings}
    axes = (-2, -1)
    return Kinematics(
        over=over,
        values=samples,
        poses=poses,
        velocities=velocities,
        accelerations=accelerations,
        readings={name: one.value for name, one in output_derivatives.items()},
        rates={name: np.sum(one.gradient * velocities, axis=axes) for name, one in output_derivatives.items()},
        reading_accelerations={
            name: np.sum(one.gradient * accelerations, axis=axes) + one.quadratic_velocity_term for name, one in output_derivatives.items()
        },
    )


class _KinematicSolver:
    """Goes from value to value, each assembled from the one before."""

    def __init__(self, mechanism: Mechanism, driving_readings: list[str], start_values: Mapping[str, float | str]) -> None:
        self._mechanism, self._driving_readings = mechanism, driving_readings
        self._guess = PositionSolver(mechanism).solve({name: float(value) for name, value in start_values.items()})

    def degrees_of_freedom(self) -> int:
        return PositionSolver(self._mechanism).count_degrees_of_freedom(self._guess)

    def solve_at(self, value: float, rate: float, acceleration: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Poses, velocities and accelerations (bodies, 3) at one value, or one time."""
        mechanism, driving_readings = self._mechanism, self._driving_readings
        time = 0.0 if driving_readings else value
        position_solver = PositionSolver(mechanism, time)
        try:
            poses = position_solver.solve(dict.fromkeys(driving_readings, value), self._guess)
        except MechanismError as error:
            time_clause = "" if driving_readings else f"at t = {value:.6g} s, where its drives stand then: "
            raise MechanismError(f"{time_clause}{error}") from error
        self._guess = poses
        equations, free = position_solver.equations, position_solver.free_mask
        prescribed = equations.prescribed_motion(np.array(time))
        driving_outputs = [evaluate_output(mechanism, name, poses) for name in driving_readings]
        jacobian_blocks = [equations.jacobian(poses).reshape(len(equations.joint_indices), free.size)]
        jacobian_blocks += [one.gradient.reshape(1, -1) for one in driving_outputs]
        jacobian = np.concatenate(jacobian_blocks)[:, free]
        _require_nonsingular(position_solver, jacobian, driving_readings, value)
        velocities, accelerations = np.zeros(poses.shape), np.zeros(poses.shape)
        velocities.ravel()[free] = _solve_least_squares(jacobian, np.append(prescribed[:, 1], [rate] * len(driving_readings)))
        gamma = equations.gamma(poses, velocities, time)
        driving_gamma = [
            acceleration - float(evaluate_output(mechanism, name, poses, velocities).quadratic_velocity_term) for name in driving_readings
        ]
        accelerations.ravel()[free] = _solve_least_squares(jacobian, np.append(gamma, driving_gamma))
        return poses, velocities, accelerations


def _solve_least_squares(jacobian: FloatArray, rhs: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(jacobian, rhs, rcond=None)[0], dtype=np.float64)


def _require_nonsingular(position_solver: PositionSolver, jacobian: FloatArray, driving_readings: list[str], value: float) -> None:
    length_scale = position_solver.mechanism.length_scale
    coordinate_scale = np.tile([length_scale, length_scale, 1.0], len(position_solver.mechanism.bodies))[position_solver.free_mask]
    scaled_jacobian = jacobian * coordinate_scale
    row_norms = np.linalg.norm(scaled_jacobian, axis=1, keepdims=True)
    singular_values = np.linalg.svd(scaled_jacobian / np.where(row_norms > 0, row_norms, 1.0), compute_uv=False)
    if np.sum(singular_values > RANK_TOLERANCE * singular_values[0]) < len(coordinate_scale):
        location = f"{driving_readings[0]} = {value:.6g}" if driving_readings else f"t = {value:.6g} s"
        raise MechanismError(
            f"at {location} the mechanism stands at a dead centre or change point: what drives it there does not settle "
            "how it moves; leave that value out, or drive it elsewhere"
        )


def _require_degrees_of_freedom(mechanism: Mechanism, degrees_of_freedom: int, required: int, reason: str) -> None:
    if degrees_of_freedom != required:
        raise MechanismError(f"kinematics need mobility {required}: {reason}; this mechanism has mobility {degrees_of_freedom} then")


def _validate_samples(over: str, values: Sequence[float] | FloatArray, rate: float, acceleration: float) -> FloatArray:
    for what, number in (("rate", rate), ("acceleration", acceleration)):
        if not isinstance(number, int | float):
            raise MechanismError(f"{what} of {over!r} must be a number in SI; got {number!r}")
        require_finite(number, "", f"{what} of {over!r}")
    try:
        samples = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        samples = np.array([np.nan])
    if samples.ndim != 1 or not samples.size or not np.all(np.isfinite(samples)):
        raise MechanismError(f"values of {over!r} must be a list of finite numbers in SI; got {values!r}")
    return samples

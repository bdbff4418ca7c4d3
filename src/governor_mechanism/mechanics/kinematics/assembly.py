"""Assembly of a mechanism: poses at given values of its outputs, consistent velocities, degrees of freedom."""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import RowEvaluation, constraint_equations_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value, wrap_difference
from governor_mechanism.model.joints import Distance
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, find_single_free_direction, least_norm_solution, numerical_rank
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray

MAX_CONTINUATION_STEP = 0.1
"""Largest change of an output in one continuation step, in length scales or rad; keeps Newton's iteration on its branch."""

MAX_TRAVEL = 200.0
"""Largest distance of a requested value from the guess, in length scales or rad (about thirty turns); a larger one is a user error."""

ASSEMBLY_TOLERANCE = 1e-13
"""Closure tolerance of the joints relative to the mechanism's length scale; rounding leaves about 1e-15."""

CLOSURE_ROUNDINGS = 4.0
"""Roundings of the farthest coordinate that closed joints may have: more than the closure tolerance beyond 100 length scales."""

TURNING_POINT_OFFSET = 1e-3
"""Distance from a turning point of an output, in length scales and rad, below which the guess is moved off it, and by how much."""

MAX_ACCELERATION_RESIDUAL = 1e-6
"""Part of the accelerations that the joints demand and cannot have, relative to them, above which the velocities lie on no branch."""

PARTING_STEP = 1e-3
"""Change of all coordinates, in length scales and rad, that parts coincident points; different for each, so that no two move alike."""

MAX_NEWTON_STEP = 0.3
"""Largest Newton step, in length scales and rad; near a turning point longer steps can cycle without converging."""


class PositionSolver:
    """Assemble one mechanism at given values of its outputs, from its initial guess or from nearby poses.

    Parameters
    ----------
    mechanism
        The mechanism to assemble.
    time
        Time at which the drives are evaluated, s.

    Attributes
    ----------
    mechanism
        The mechanism to assemble.
    time
        Time at which the drives are evaluated, s.
    equations
        The constraint equations of its joints and drives.
    free_mask
        Which coordinates may change; shape (3 bodies,). A body that cannot rotate keeps its angle.
    pose_scales
        SI values of a length scale and of a radian for the coordinates of a body; shape (3,).
    free_coordinate_scales
        SI value of a length scale, or of a radian, of each free coordinate; shape (free coordinates,).
    free_masses
        Mass (kg) or moment of inertia (kg m2) of each free coordinate; shape (free coordinates,).
    """

    def __init__(self, mechanism: Mechanism, time: float = 0.0) -> None:
        self.mechanism, self.time = mechanism, time
        self.equations = constraint_equations_of(mechanism)
        self.free_mask = np.array([body.moves for body in mechanism.bodies], dtype=np.bool_).ravel()
        self.pose_scales = np.array([mechanism.length_scale, mechanism.length_scale, 1.0])
        self.free_coordinate_scales = np.tile(self.pose_scales, len(mechanism.bodies))[self.free_mask]
        inertias = [[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]
        self.free_masses: FloatArray = np.array(inertias).ravel()[self.free_mask]

    @cached_property
    def initial_guess(self) -> FloatArray:
        """Poses of the mechanism's initial guess, with points that are to be apart a little apart; shape (bodies, 3)."""
        return self._part_coincident_points(np.array(self.mechanism.initial_guess, dtype=np.float64))

    @property
    def mobility(self) -> int:
        """Degrees of freedom that joints and drives leave at the initial guess: free coordinates minus the rank of the Jacobian."""
        return self.count_degrees_of_freedom(self.initial_guess)

    def count_degrees_of_freedom(self, poses: FloatArray, *, include_drives: bool = True) -> int:
        """Return the degrees of freedom at poses (bodies, 3), with or without the constraints of the drives."""
        rows = self._free_rows([self.equations.evaluate(poses)], np.array(self.mechanism.length_scale))
        return int(self.free_mask.sum()) - numerical_rank(rows if include_drives else rows[~self.equations.is_driven])

    def scaled_joint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the dimensionless joint Jacobian (equations, free coordinates) at poses (bodies, 3), lengths in length scales."""
        scaled: FloatArray = self.joint_jacobian(poses) * self.free_coordinate_scales / self.mechanism.length_scale
        return scaled

    def joint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the joint Jacobian (..., equations, free coordinates) at poses (..., bodies, 3)."""
        return self._select_free(self.equations.jacobian(poses))

    def _free_rows(self, evaluations: Sequence[RowEvaluation], row_scales: FloatArray) -> Any:
        """Return the derivatives (rows, free coordinates) of scaled rows at one state by scaled coordinates: sparse if there are many."""
        if sum(one.residuals.size for one in evaluations) < MIN_SPARSE_ROWS:
            free_rows = self._select_free(np.concatenate([one.jacobian for one in evaluations])) * self.free_coordinate_scales
            free_rows /= row_scales[..., np.newaxis]
            return free_rows
        from scipy.sparse import vstack  # slow to import

        rows = vstack([one.sparse_jacobian() for one in evaluations], format="csr")[:, self.free_mask]
        rows.sort_indices()
        rows.data *= self.free_coordinate_scales[rows.indices]
        rows.data /= np.repeat(np.broadcast_to(row_scales, rows.shape[0]), np.diff(rows.indptr))
        return rows

    def _select_free(self, jacobian: FloatArray) -> FloatArray:
        """Return the derivatives (..., free coordinates) of a Jacobian (..., bodies, 3) by the free coordinates."""
        free_jacobian: FloatArray = jacobian.reshape(*jacobian.shape[:-2], self.free_mask.size)[..., self.free_mask]
        return free_jacobian

    def solve_at_coordinate(
        self,
        value: float,  # leading coordinate, SI
        # poses near the solution; shape (bodies, 3). Default: the mechanism's initial guess
        guess: FloatArray | None = None,
    ) -> FloatArray:
        """Solve for the poses (bodies, 3) at a value of the leading coordinate, on the branch of the guess; raise as `solve` does."""
        return self.solve({self.mechanism.coordinate: value}, guess)

    def solve(
        self,
        values: Mapping[str, float],  # values of outputs by name, SI
        # poses near the solution; shape (bodies, 3). Default: the mechanism's initial guess
        guess: FloatArray | None = None,
    ) -> FloatArray:
        """Solve for poses (bodies, 3) at values of outputs, on the branch of the guess, or nearest to it; raise for an open joint."""
        # The solution is reached by continuation: Newton's iteration restarts after every
        # `MAX_CONTINUATION_STEP`. A value farther than `MAX_TRAVEL` from the guess is refused too.
        start = self.initial_guess if guess is None else self._part_coincident_points(guess)
        poses = self._gauss_newton(start, {})
        displacements = self._displacements(poses, values)
        moved = self._move_off_turning_point(poses, displacements)
        if moved is not poses:
            poses, displacements = moved, self._displacements(moved, values)
        max_displacement = max((abs(change) / self.mechanism.output_scale(name) for name, change in displacements.items()), default=0.0)
        if max_displacement > MAX_TRAVEL:
            raise MechanismError(
                f"the values of {list(values)} are {max_displacement:.6g} rad or length scales away from the initial guess; "
                f"at most {MAX_TRAVEL:g} are allowed: use a nearer initial guess, or leave out whole turns"
            )
        n_steps = max(1, math.ceil(max_displacement / MAX_CONTINUATION_STEP))
        for remaining in np.arange(n_steps - 1, -1, -1) / n_steps:
            poses = self._gauss_newton(poses, {name: value - float(remaining) * displacements[name] for name, value in values.items()})
        return poses

    def solve_velocities(
        self,
        poses: FloatArray,  # assembled poses; shape (bodies, 3)
        rates: Mapping[str, float],  # rates of outputs by name, SI per second
    ) -> FloatArray:
        """Solve for velocities (bodies, 3) of least kinetic energy that satisfy drives and rates; MechanismError for contradictions."""
        if not (any(rates.values()) or self.equations.is_driven.any()):
            return np.zeros(poses.shape)  # nothing moves
        jacobian = self.jacobian(poses, list(rates))
        rhs = np.append(self.equations.prescribed_motion(np.array(self.time))[:, 1], list(rates.values()))
        # A massless coordinate gets a small mass or moment of inertia.
        total_mass = sum(body.mass for body in self.mechanism.bodies) or 1.0
        small_masses = 1e-6 * total_mass * (self.mechanism.length_scale / self.free_coordinate_scales) ** 2
        regular_masses = np.where(self.free_masses == 0, small_masses, self.free_masses)
        inverse_sqrt_masses = 1 / np.sqrt(regular_masses)
        free_velocities = inverse_sqrt_masses * least_norm_solution(jacobian * inverse_sqrt_masses, rhs)
        residual = jacobian @ free_velocities - rhs
        rhs_scale = max(float(np.max(np.abs(rhs), initial=0.0)), 1e-300)
        if np.max(np.abs(residual), initial=0.0) > 1e-9 * rhs_scale:
            raise MechanismError(self._contradiction_message(residual, list(rates)))
        velocities = self.expand_free(free_velocities)
        self._require_accelerations(poses, velocities)
        return velocities

    def _require_accelerations(self, poses: FloatArray, velocities: FloatArray) -> None:
        """Raise an error if no accelerations keep the joints closed at velocities (bodies, 3), as on no branch at a change point."""
        scaled_jacobian = self.scaled_joint_jacobian(poses)
        gamma = self.equations.gamma(poses, velocities, self.time)
        gamma /= self.mechanism.length_scale
        residual = scaled_jacobian @ least_norm_solution(scaled_jacobian, gamma) - gamma
        if np.max(np.abs(residual), initial=0.0) > MAX_ACCELERATION_RESIDUAL * np.max(np.abs(gamma), initial=0.0):
            name = self.equations.joints[self.equations.joint_indices[int(np.argmax(np.abs(residual)))]].name
            raise MechanismError(
                f"the start is a change point, where motion branches, and joint {name!r} would open on the motion that the rates of the "
                "start begin; give rates of more readings, so that they choose a branch, or start beside the change point"
            )

    def _displacements(self, poses: FloatArray, values: Mapping[str, float]) -> dict[str, float]:
        """Return how far outputs are from their values at poses (bodies, 3), SI."""
        return {name: -self._output_residual(name, value, poses) for name, value in values.items()}

    def _move_off_turning_point(self, poses: FloatArray, displacements: Mapping[str, float]) -> FloatArray:
        """Return poses slightly moved along the motion if the only output to be changed is at a turning point there."""
        moving_outputs = [name for name, change in displacements.items() if abs(change) > ASSEMBLY_TOLERANCE]
        null_direction = find_single_free_direction(self.scaled_joint_jacobian(poses)) if len(moving_outputs) == 1 else None
        if null_direction is None:
            return poses
        output_rate = self.output_derivative(moving_outputs[0], poses, null_direction)
        if abs(output_rate) > TURNING_POINT_OFFSET * self.mechanism.output_scale(moving_outputs[0]):
            return poses
        offset = TURNING_POINT_OFFSET * self.free_coordinate_scales * null_direction * np.sign(null_direction[0] or 1.0)
        return self._gauss_newton(poses + self.expand_free(offset), {})

    def output_derivative(self, name: str, poses: FloatArray, direction: FloatArray) -> float:
        """Return the derivative of an output along a direction (free coordinates,) in length scales and rad."""
        # It is zero where a vanishing distance has no direction.
        with np.errstate(invalid="ignore"):
            gradient = np.nan_to_num(evaluate_output(self.mechanism, name, poses).gradient.ravel()[self.free_mask])
        return float(np.sum(gradient * self.free_coordinate_scales * direction))

    def _contradiction_message(self, residual: FloatArray, rates: list[str]) -> str:
        worst = int(np.argmax(np.abs(residual)))
        n_joint_rows = len(self.equations.joint_indices)
        if worst >= n_joint_rows:
            return f"the rate of {rates[worst - n_joint_rows]!r} at the start contradicts joints, drives, or another rate"
        name = self.equations.joints[self.equations.joint_indices[worst]].name
        return (
            f"joint {name!r} cannot follow the drives and rates of the start: they contradict each other there, "
            "or the start is a change point, where the joints do not determine the direction of motion"
        )

    def jacobian(self, poses: FloatArray, names: list[str]) -> FloatArray:
        """Return the Jacobian of the joints and then of the named outputs with respect to the free coordinates."""
        gradients = [self._select_free(evaluate_output(self.mechanism, name, poses).gradient)[np.newaxis] for name in names]
        return np.concatenate([self.joint_jacobian(poses), *gradients])

    def _part_coincident_points(self, poses: FloatArray) -> FloatArray:
        """Return poses in which no points coincide that are to be apart: nothing says in which direction they would part."""
        with np.errstate(divide="ignore", invalid="ignore"):  # kernels that run as Python warn where there is no direction
            are_apart = self.equations.evaluate(poses).is_differentiable
        if are_apart:
            return poses
        return poses + self.expand_free(self.free_coordinate_scales * np.linspace(PARTING_STEP, 2 * PARTING_STEP, self.free_mask.sum()))

    def _gauss_newton(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """Solve joints and requested output values by Gauss-Newton iteration with minimum-norm steps."""
        names, length_scale = list(values), self.mechanism.length_scale
        row_scales = np.array([length_scale] * len(self.equations.joint_indices) + [self.mechanism.output_scale(name) for name in names])
        converged = False
        for _ in range(60):
            if converged:
                break
            joints = self.equations.evaluate(poses, self.time)
            outputs = [evaluate_output(self.mechanism, name, poses) for name in names]
            differences = [float(output.value) - values[name] for name, output in zip(names, outputs, strict=True)]
            output_residuals = [wrap_difference(self.mechanism.reading(name), one) for name, one in zip(names, differences, strict=True)]
            residual = np.append(joints.residuals, output_residuals) / row_scales
            rounding = CLOSURE_ROUNDINGS * np.finfo(np.float64).eps * np.max(np.abs(poses[:, :2]), initial=0.0) / length_scale
            # One more step leaves only rounding.
            converged = np.max(np.abs(residual), initial=0.0) < max(ASSEMBLY_TOLERANCE, rounding)
            step = least_norm_solution(self._free_rows([joints, *(output.row for output in outputs)], row_scales), -residual)
            step_size = float(np.max(np.abs(step)))
            poses = poses + self.expand_free(self.free_coordinate_scales * step * min(1.0, MAX_NEWTON_STEP / max(step_size, 1e-300)))
            if step_size < 1e-15:
                break
        return poses if converged else self._check_closure(poses, values)

    def _output_residual(self, name: str, value: float, poses: FloatArray) -> float:
        return wrap_difference(self.mechanism.reading(name), float(evaluate_output_value(self.mechanism, name, poses)) - value)

    def _check_closure(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        tolerance = 1e3 * ASSEMBLY_TOLERANCE
        residuals = {name: self._output_residual(name, value, poses) for name, value in values.items()}
        unsatisfied = [name for name in residuals if not abs(residuals[name]) < tolerance * self.mechanism.output_scale(name)]
        location = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        location = f" at {location}" if location else ""
        joint, gap = self.equations.largest_gap(poses, self.time) if self.equations.joints else (None, 0.0)
        if math.isfinite(gap) and abs(gap) < tolerance * self.mechanism.length_scale:
            if not unsatisfied:
                return poses
            raise MechanismError(
                f"the mechanism cannot be assembled{location}: its joints close, but {unsatisfied[0]} misses its value by "
                f"{abs(residuals[unsatisfied[0]]):.6g}; the values contradict each other or the joints"
            )
        suggestion = ""
        if isinstance(joint, Distance):
            suggestion = f"; a length near {joint.length + gap:.6g} m instead of {joint.length:.6g} m would close it"
        name = joint.name if joint else ""
        raise MechanismError(f"the mechanism cannot be assembled{location}: joint {name!r} stays open by {abs(gap):.6g} m{suggestion}")

    def expand_free(self, free_values: NDArray[np.floating]) -> FloatArray:
        """Expand values of the free coordinates to (..., bodies, 3), with zeros for the angles of bodies that cannot rotate."""
        expanded = np.zeros((*free_values.shape[:-1], self.free_mask.size))
        expanded[..., self.free_mask] = free_values
        return expanded.reshape(*free_values.shape[:-1], -1, 3)


REPORTABLE_GAP_RATIO = 1e-9
"""Gap of the initial guess relative to the length scale below which the guess counts as exact and is not reported."""


@once_per_object
def position_solver_of(mechanism: Mechanism) -> PositionSolver:
    """Return the solver of a mechanism at time 0."""
    return PositionSolver(mechanism)


@once_per_object
def mobility_of(mechanism: Mechanism) -> int:
    """Return the degrees of freedom that joints and drives leave at the initial guess, as `PositionSolver.mobility`."""
    return position_solver_of(mechanism).mobility


def assembly_notes(scene: Scene) -> tuple[str, ...]:
    """Return a sentence for each note on a scene's dimensions and on the closing of its initial guess."""
    mechanism = scene.mechanism
    if scene.start.values or not mechanism.joints:
        return mechanism.notes
    joint, gap = constraint_equations_of(mechanism).largest_gap(np.array(mechanism.initial_guess, dtype=np.float64))
    if abs(gap) < REPORTABLE_GAP_RATIO * mechanism.length_scale:
        return mechanism.notes
    return (*mechanism.notes, f"the start was a guess: joint {joint.name!r} was open by {abs(gap):.3g} m and has been closed")

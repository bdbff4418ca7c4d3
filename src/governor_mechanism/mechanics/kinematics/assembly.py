"""Assembly of a mechanism: poses at given values of its outputs, consistent velocities, degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.model.joints import Distance
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import least_norm_solution, numerical_rank
from governor_mechanism.types import FloatArray

MAX_CONTINUATION_STEP = 0.1
"""Largest change of an output in one continuation step, in length scales or rad; keeps Newton's iteration on its branch."""

MAX_TRAVEL = 200.0
"""Largest distance of a requested value from the guess, in length scales or rad (about thirty turns); a larger one is a user error."""

ASSEMBLY_TOLERANCE = 1e-13
"""Closure tolerance of the joints relative to the mechanism's length scale; rounding leaves about 1e-15."""

TURNING_POINT_OFFSET = 1e-3
"""Distance from a turning point of an output, in length scales and rad, below which the guess is moved off it, and by how much."""

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
    free_coordinate_scales
        SI value of a length scale, or of a radian, of each free coordinate; shape (free coordinates,).
    """

    def __init__(self, mechanism: Mechanism, time: float = 0.0) -> None:
        self.mechanism, self.time = mechanism, time
        self.equations = ConstraintEquations(mechanism)
        can_rotate = [body.can_rotate for body in mechanism.bodies]
        self.free_mask = np.array([[True, True, rotates] for rotates in can_rotate], dtype=np.bool_).ravel()
        """Which coordinates may change; shape (3 bodies,). A body that cannot rotate keeps its angle."""
        self.free_coordinate_scales = np.tile([mechanism.length_scale, mechanism.length_scale, 1.0], len(can_rotate))[self.free_mask]
        """SI value of a length scale, or of a radian, of each free coordinate; shape (free coordinates,)."""
        prescribed = self.equations.prescribed_motion(np.array(time))
        self._prescribed_rates = prescribed[:, 1]

    @property
    def mobility(self) -> int:
        """Degrees of freedom that joints and drives leave at the initial guess: free coordinates minus the rank of the Jacobian."""
        return self.count_degrees_of_freedom(self._initial_guess())

    def count_degrees_of_freedom(self, poses: FloatArray, *, include_drives: bool = True) -> int:
        """Return the degrees of freedom at poses (bodies, 3), with or without the constraints of the drives."""
        jacobian = self.scaled_joint_jacobian(poses)
        return int(self.free_mask.sum()) - numerical_rank(jacobian if include_drives else jacobian[~self.equations.is_driven])

    def scaled_joint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the dimensionless joint Jacobian (equations, free coordinates) at poses (bodies, 3), lengths in length scales."""
        jacobian = self.equations.jacobian(poses).reshape(len(self.equations.joint_indices), self.free_mask.size)[:, self.free_mask]
        scaled: FloatArray = jacobian * self.free_coordinate_scales / self.mechanism.length_scale
        return scaled

    def solve_at_coordinate(self, value: float, guess: FloatArray | None = None) -> FloatArray:
        """Solve for the poses at a value of the leading coordinate, on the branch of the guess.

        A mechanism that cannot be assembled raises MechanismError as in `solve`.

        Parameters
        ----------
        value
            Leading coordinate, SI.
        guess
            Poses near the solution; shape (bodies, 3). Default: the mechanism's initial guess.

        Returns
        -------
        FloatArray
            Assembled poses; shape (bodies, 3).
        """
        return self.solve({self.mechanism.coordinate: value}, guess)

    def solve(self, values: Mapping[str, float], guess: FloatArray | None = None) -> FloatArray:
        """Solve for the poses at values of any outputs, on the branch of the guess or, without values, nearest to it.

        The solution is reached by continuation: Newton's iteration restarts after every `MAX_CONTINUATION_STEP`.

        Parameters
        ----------
        values
            Values of outputs by name, SI.
        guess
            Poses near the solution; shape (bodies, 3). Default: the mechanism's initial guess.

        Returns
        -------
        FloatArray
            Assembled poses; shape (bodies, 3).

        Raises
        ------
        MechanismError
            If the mechanism cannot be assembled (the message names the joint that stays open), or if a value is farther than
            `MAX_TRAVEL` from the guess.
        """
        poses = self._move_off_turning_point(self._gauss_newton(self._initial_guess() if guess is None else guess, {}), values)
        displacements = {name: value - float(evaluate_output_value(self.mechanism, name, poses)) for name, value in values.items()}
        for name in displacements:
            if isinstance(self.mechanism.reading(name), LineAngle):
                displacements[name] = math.remainder(displacements[name], math.tau)
        max_displacement = max(
            (abs(displacement) / self.mechanism.output_scale(name) for name, displacement in displacements.items()), default=0.0
        )
        if max_displacement > MAX_TRAVEL:
            raise MechanismError(
                f"the values of {list(values)} are {max_displacement:.6g} rad or length scales away from the initial guess; "
                f"at most {MAX_TRAVEL:g} are allowed: use a nearer initial guess, or leave out whole turns"
            )
        n_steps = max(1, math.ceil(max_displacement / MAX_CONTINUATION_STEP))
        for remaining in np.arange(n_steps - 1, -1, -1) / n_steps:
            poses = self._gauss_newton(poses, {name: value - float(remaining) * displacements[name] for name, value in values.items()})
        return poses

    def solve_velocities(self, poses: FloatArray, rates: Mapping[str, float]) -> FloatArray:
        """Solve for the velocities that satisfy drives and given rates with the least kinetic energy.

        Parameters
        ----------
        poses
            Assembled poses; shape (bodies, 3).
        rates
            Rates of outputs by name, SI per second.

        Returns
        -------
        FloatArray
            Velocities; shape (bodies, 3).

        Raises
        ------
        MechanismError
            If joints, drives and rates contradict each other.
        """
        jacobian = self._jacobian(poses, list(rates))
        rhs = np.append(self._prescribed_rates, list(rates.values()))
        inverse_sqrt_masses = 1 / np.sqrt(self._mass_diagonal())
        free_velocities = inverse_sqrt_masses * least_norm_solution(jacobian * inverse_sqrt_masses, rhs)
        residual = jacobian @ free_velocities - rhs
        rhs_scale = max(float(np.max(np.abs(rhs), initial=0.0)), 1e-300)
        if np.max(np.abs(residual), initial=0.0) > 1e-9 * rhs_scale:
            raise MechanismError(self._contradiction_message(residual, list(rates)))
        return self.expand_free(free_velocities)

    def _move_off_turning_point(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """Return poses slightly moved along the motion if the only output to be changed is at a turning point there."""
        moving_outputs = [name for name, value in values.items() if abs(self._output_residual(name, value, poses)) > ASSEMBLY_TOLERANCE]
        if len(moving_outputs) != 1 or self.count_degrees_of_freedom(poses) != 1:
            return poses
        null_direction = np.linalg.svd(self.scaled_joint_jacobian(poses))[2][-1]
        gradient = evaluate_output(self.mechanism, moving_outputs[0], poses).gradient.ravel()[self.free_mask]
        output_rate = float(np.sum(gradient * self.free_coordinate_scales * null_direction))
        if abs(output_rate) > TURNING_POINT_OFFSET * self.mechanism.output_scale(moving_outputs[0]):
            return poses
        return self._gauss_newton(
            poses
            + self.expand_free(TURNING_POINT_OFFSET * self.free_coordinate_scales * null_direction * np.sign(null_direction[0] or 1.0)),
            {},
        )

    def initial_guess_gap(self) -> tuple[str, float]:
        """Return the name of the joint with the largest gap in the initial guess, and that gap, m."""
        if not self.equations.joints:
            return "", 0.0
        joint, gap = self.equations.largest_gap(self._initial_guess(), self.time)
        return joint.name, abs(gap)

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

    def _mass_diagonal(self) -> FloatArray:
        """Return the masses of the free coordinates; a massless rotation gets a small moment of inertia."""
        length_scale = self.mechanism.length_scale
        masses = [
            [body.mass, body.mass, body.second_moments.xx + body.second_moments.yy or 1e-6 * body.mass * length_scale**2]
            for body in self.mechanism.bodies
        ]
        return np.array(masses).ravel()[self.free_mask]

    def _initial_guess(self) -> FloatArray:
        return np.array(self.mechanism.initial_guess, dtype=np.float64)

    def _jacobian(self, poses: FloatArray, names: list[str]) -> FloatArray:
        """Return the Jacobian of the joints and then of the named outputs with respect to the free coordinates."""
        blocks = [self.equations.jacobian(poses).reshape(len(self.equations.joint_indices), self.free_mask.size)]
        blocks += [evaluate_output(self.mechanism, name, poses).gradient.reshape(1, -1) for name in names]
        return np.concatenate(blocks)[:, self.free_mask]

    def _gauss_newton(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """Solve joints and requested output values by Gauss-Newton iteration with minimum-norm steps."""
        names, length_scale = list(values), self.mechanism.length_scale
        row_scales = np.array([length_scale] * len(self.equations.joint_indices) + [self.mechanism.output_scale(name) for name in names])
        converged = False
        for _ in range(60):
            output_residuals = [self._output_residual(name, values[name], poses) for name in names]
            residual = np.append(self.equations.residuals(poses, self.time), output_residuals) / row_scales
            if converged:
                return poses
            converged = np.max(np.abs(residual), initial=0.0) < ASSEMBLY_TOLERANCE  # one more step leaves only rounding
            jacobian = self._jacobian(poses, names) * self.free_coordinate_scales / row_scales[:, np.newaxis]
            step = least_norm_solution(jacobian, -residual)
            step_size = float(np.max(np.abs(step)))
            poses = poses + self.expand_free(self.free_coordinate_scales * step * min(1.0, MAX_NEWTON_STEP / max(step_size, 1e-300)))
            if step_size < 1e-15:
                break
        return self._check_closure(poses, values)

    def _output_residual(self, name: str, value: float, poses: FloatArray) -> float:
        residual = float(evaluate_output_value(self.mechanism, name, poses)) - value
        return math.remainder(residual, math.tau) if isinstance(self.mechanism.reading(name), LineAngle) else residual

    def _check_closure(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        residuals = {name: self._output_residual(name, value, poses) for name, value in values.items()}
        unsatisfied = [
            name for name in residuals if not abs(residuals[name]) < 1e3 * ASSEMBLY_TOLERANCE * self.mechanism.output_scale(name)
        ]
        location = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        location = f" at {location}" if location else ""
        joint, gap = self.equations.largest_gap(poses, self.time) if self.equations.joints else (None, 0.0)
        if math.isfinite(gap) and abs(gap) < 1e3 * ASSEMBLY_TOLERANCE * self.mechanism.length_scale:
            if not unsatisfied:
                return poses
            raise MechanismError(
                f"the mechanism cannot be assembled{location}: its joints close, but {unsatisfied[0]} misses its value by "
                f"{abs(residuals[unsatisfied[0]]):.6g}; the values contradict each other or the joints"
            )
        suggestion = ""
        if isinstance(joint, Distance):
            closing_length = joint.length + gap
            suggestion = f"; a length near {closing_length:.6g} m instead of {joint.length:.6g} m would close it"
        name = joint.name if joint else ""
        raise MechanismError(f"the mechanism cannot be assembled{location}: joint {name!r} stays open by {abs(gap):.6g} m{suggestion}")

    def expand_free(self, free_values: NDArray[np.floating]) -> FloatArray:
        """Expand values of the free coordinates to shape (bodies, 3), with zeros for the angles of bodies that cannot rotate."""
        expanded = np.zeros(self.free_mask.size)
        expanded[self.free_mask] = free_values
        return expanded.reshape(-1, 3)


REPORTABLE_GAP_RATIO = 1e-9
"""Gap of the initial guess relative to the length scale below which the guess counts as exact and is not reported."""


def assembly_notes(scene: Scene) -> tuple[str, ...]:
    """Return the notes on a scene's dimensions and on the closing of its initial guess.

    Parameters
    ----------
    scene
        The scene to assemble.

    Returns
    -------
    tuple[str, ...]
        One sentence each; empty if there is nothing to report.
    """
    mechanism = scene.part.mechanism
    joint, gap = PositionSolver(mechanism).initial_guess_gap()
    if gap < REPORTABLE_GAP_RATIO * mechanism.length_scale or scene.start.values:
        return mechanism.notes
    return (*mechanism.notes, f"the start was a guess: joint {joint!r} was open by {gap:.3g} m and has been closed")

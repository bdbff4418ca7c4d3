"""Steady states of z'' = a(z, z'): an equilibrium, or a steady motion along cyclic coordinates, on which no acceleration depends."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import jacobian
from governor_mechanism.statics.first_order_system import FirstOrderSystem
from governor_mechanism.statics.scene_dynamics import SceneDynamics
from governor_mechanism.types import FloatArray, IntArray

Accelerations = Callable[[FloatArray, FloatArray], FloatArray]
"""Accelerations (k, n) at k coordinates and rates (k, n); NaN where there are none."""

PERTURBATION = 0.01
"""Displacement in scales of the states at which cyclic coordinates are recognised, to exclude those that are neutral at one state only."""

TEST_DISPLACEMENT = 0.4
"""Displacement in scales along a cyclic coordinate that must not change the accelerations."""

SLOPE_TOLERANCE = 1e-10
"""Relative accuracy of the derivatives by which cyclic coordinates are recognised."""

CYCLIC_TOLERANCE = 1e-9
"""Change of the accelerations, relative to the largest, below which they do not depend on a coordinate."""

SPEED_WEIGHT = 1e-6
"""Weight of the speeds of cyclic coordinates beside the positions, so that a speed which nothing determines keeps its start value."""

RANK_TOLERANCE = 1e-9
"""Singular value relative to the largest below which equations are dependent."""

MIN_ROW_SIZE = 1e-10
"""Derivative of a dimensionless acceleration below which it is rounding: the state is neutral."""

MAX_STEP = 0.3
"""Largest Newton step in scales."""

MAX_DISTANCE = 10.0
"""Distance of a root in scales, as predicted by a Newton step, beyond which there is none near the start."""

MIN_DECREASE = 0.1
"""Decrease of the accelerations in a Newton step, relative to the decrease that the linearised equations promise."""

NEWTON_TOLERANCE = 1e-8
"""Relative accuracy of the derivatives in Newton's method."""

MAX_ITERATIONS = 60
"""Largest number of Newton steps."""

RESIDUAL_TOLERANCE = 1e-10
"""Acceleration that may remain in a steady state, in scales over the square of the time scale."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A steady state: coordinates z, rates along the cyclic directions."""

    accelerations: Accelerations  # the function a(z, z')
    z: FloatArray  # coordinates; shape (n,)
    rates: FloatArray  # rates; shape (n,)
    positions: IntArray  # indices of the coordinates that stay constant and describe the state together with `cyclic`; shape (m,)
    cyclic: FloatArray  # directions of the cyclic coordinates; shape (n, n - m)
    scales: FloatArray  # scales of the coordinates; shape (n,)
    time_scale: float  # characteristic time, s

    @property
    def is_steady(self) -> bool:
        """Whether no acceleration remains but rounding."""
        sensitivity = _size(self.residual_jacobian)
        return bool(np.isfinite(sensitivity)) and _size(self.residual) <= RESIDUAL_TOLERANCE * max(1.0, sensitivity)

    @cached_property
    def residual(self) -> FloatArray:
        """Dimensionless accelerations (n,) along the basis."""
        residual: FloatArray = self._residuals(np.zeros((1, len(self.z))))[0]
        return residual

    def _residuals(self, unknowns: FloatArray) -> FloatArray:
        """Return the dimensionless accelerations (k, n) along the basis after dimensionless changes (k, n)."""
        along_basis = np.linalg.solve(self.basis, self.accelerations(*self.displaced(unknowns)).T).T
        residuals: FloatArray = along_basis * self.time_scale**2 / self.unknown_scales
        return residuals

    @cached_property
    def residual_jacobian(self) -> FloatArray:
        """Return the Jacobian (n, n) of the residual in steady motions with respect to positions and cyclic speeds, dimensionless."""
        zeros, ones = np.zeros(len(self.z)), np.ones(len(self.z))
        return jacobian(self._residuals, zeros, ones, tolerance=NEWTON_TOLERANCE)[0]

    def displaced(self, unknowns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return coordinates and rates after dimensionless changes (k, n) of positions and cyclic speeds; shape (k, n) each."""
        m = len(self.positions)
        z = np.tile(self.z, (len(unknowns), 1))
        changes = self.unknown_scales * unknowns
        z[:, self.positions] += changes[:, :m]
        return z, self.rates + changes[:, m:] @ self.cyclic.T / self.time_scale

    @property
    def direction_of_acceleration(self) -> FloatArray:
        """Direction (n,) of the remaining accelerations of the positions, with a largest component of one scale."""
        m, direction = len(self.positions), np.zeros(len(self.z))
        residual = self.residual[:m]
        direction[self.positions] = self.scales[self.positions] * residual / max(_size(residual), 1e-300)
        return direction

    @cached_property
    def basis(self) -> FloatArray:
        """Unit vectors of the positions, then the cyclic directions; shape (n, n)."""
        return np.hstack([np.eye(len(self.z))[:, self.positions], self.cyclic])

    def expand(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return coordinates and rates (k, n) for k states: m positions, their rates, and speeds of the cyclic coordinates."""
        m, z = len(self.positions), np.tile(self.z, (len(states), 1))
        z[:, self.positions] += states[:, :m]
        rates = states[:, 2 * m :] @ self.cyclic.T
        rates[:, self.positions] += states[:, m : 2 * m]
        return z, rates

    @property
    def first_order_system(self) -> FirstOrderSystem:
        """The first-order equations; the state is displacements of the positions, their rates, and speeds of the cyclic coordinates."""
        m, inverse_basis = len(self.positions), np.linalg.inv(self.basis)

        def derivative(states: FloatArray) -> FloatArray:
            return np.hstack([states[:, m : 2 * m], self.accelerations(*self.expand(states)) @ inverse_basis.T])

        scales, speeds = self.unknown_scales, (inverse_basis @ self.rates)[m:]
        return FirstOrderSystem(
            derivative=derivative,
            state=np.concatenate([np.zeros(2 * m), speeds]),
            scales=np.concatenate([scales[:m], scales / self.time_scale]),
            n_conserved=self._count_conserved(),
        )

    @cached_property
    def unknown_scales(self) -> FloatArray:
        """Scales of the positions and of the cyclic coordinates; shape (n,)."""
        ratios = np.full(self.cyclic.shape, np.inf)
        np.divide(self.scales[:, np.newaxis], np.abs(self.cyclic), out=ratios, where=self.cyclic != 0.0)
        return np.append(self.scales[self.positions], np.min(ratios, axis=0))

    def _count_conserved(self) -> int:
        """Return the number of speeds that no equation determines; each belongs to a momentum that stays constant."""
        rows = self.residual_jacobian
        row_sizes = np.max(np.abs(rows), axis=1, initial=0.0)
        rows = rows[row_sizes > MIN_ROW_SIZE] / row_sizes[row_sizes > MIN_ROW_SIZE, np.newaxis]
        rank = int(np.sum(np.linalg.svd(rows, compute_uv=False) > RANK_TOLERANCE)) if len(rows) else 0
        return min(len(self.z) - len(self.positions), len(self.z) - rank)


def find_cyclic_directions(
    accelerations: Accelerations,  # accelerations (k, n) at coordinates and rates
    z: FloatArray,  # coordinates near which to look; shape (n,)
    rates: FloatArray,  # their rates; shape (n,)
    scales: FloatArray,  # scales of the coordinates; shape (n,)
    time_scale: float,  # characteristic time, s
) -> tuple[IntArray, FloatArray]:
    """Return the constant positions and the directions of the cyclic coordinates; shape (m,)."""
    from scipy.linalg import null_space, qr  # slow to import

    def shifted_accelerations(at: FloatArray, v: FloatArray, shifts: FloatArray) -> FloatArray:
        return accelerations(at + scales * shifts, np.tile(v, (len(shifts), 1)))

    n = len(z)
    patterns = np.cos(np.arange(1.0, 1.0 + 6 * len(z)) ** 1.5).reshape(3, 2, len(z))
    states = [(z + PERTURBATION * scales * p, rates + scales * r / time_scale) for p, r in patterns]
    parts = [jacobian(partial(shifted_accelerations, p, v), np.zeros(n), np.ones(n), tolerance=SLOPE_TOLERANCE) for p, v in states]
    matrix = np.concatenate([part / scales[:, np.newaxis] for part, _ in parts])
    noise = np.concatenate([np.broadcast_to(errors, (n, n)) / scales[:, np.newaxis] for _, errors in parts])
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(noise))):
        return np.arange(n), np.zeros((n, 0))
    is_zero = np.all(np.abs(matrix) <= 1e2 * noise, axis=0)
    others = np.flatnonzero(~is_zero)
    combinations = null_space(matrix[:, others], rcond=CYCLIC_TOLERANCE) if len(others) else np.zeros((0, 0))
    candidates = np.hstack([np.eye(n)[:, is_zero], np.eye(n)[:, others] @ combinations])
    candidates = scales[:, np.newaxis] * candidates
    places, speeds = (np.array(one) for one in zip(*states, strict=True))
    at_states = accelerations(places, speeds)
    largest = float(np.max(np.abs(at_states / scales)))

    def is_cyclic(direction: FloatArray) -> bool:
        changes = accelerations(places + TEST_DISPLACEMENT * direction, speeds) - at_states
        return bool(np.max(np.abs(changes / scales)) <= CYCLIC_TOLERANCE * largest)

    candidates = candidates[:, [is_cyclic(direction) for direction in candidates.T]]
    n_cyclic = candidates.shape[1]
    if not n_cyclic:
        return np.arange(n), np.zeros((n, 0))
    pivots = np.sort(qr((candidates / scales[:, np.newaxis]).T, mode="r", pivoting=True)[1][:n_cyclic])
    cyclic = candidates @ np.linalg.inv(candidates[pivots])
    return np.setdiff1d(np.arange(n), pivots), np.where(np.abs(cyclic) < CYCLIC_TOLERANCE * np.max(np.abs(cyclic)), 0.0, cyclic)


def find_steady_state(
    accelerations: Accelerations,  # accelerations (k, n) at coordinates and rates
    z: FloatArray,  # coordinates to start from; shape (n,)
    rates: FloatArray,  # rates to start from; shape (n,). Only those along cyclic coordinates matter
    scales: FloatArray,  # scales of the coordinates; shape (n,)
    time_scale: float,  # characteristic time, s
) -> SteadyState:
    """Return the state that Newton's method reaches from given coordinates and rates; `is_steady` says whether it has converged."""
    positions, cyclic = find_cyclic_directions(accelerations, z, rates, scales, time_scale)
    basis = np.hstack([np.eye(len(z))[:, positions], cyclic])
    m, speeds = len(positions), np.linalg.solve(basis, rates)[len(positions) :]
    state = SteadyState(accelerations, z, cyclic @ speeds, positions, cyclic, scales, time_scale)
    unknown_weights = np.where(np.arange(len(z)) < m, 1.0, SPEED_WEIGHT)
    size = _size(state.residual)
    for _ in range(MAX_ITERATIONS):
        residual, matrix = state.residual, state.residual_jacobian
        if not np.all(np.isfinite(matrix)):
            break
        # Rows are scaled, so that the rank does not depend on stiffness; the shortest step keeps speeds that nothing determines.
        row_sizes = np.max(np.abs(matrix), axis=1)
        row_factors = np.divide(1.0, row_sizes, out=np.zeros(len(row_sizes)), where=row_sizes > MIN_ROW_SIZE)
        weighted_rows = matrix * unknown_weights * row_factors[:, np.newaxis]
        step = unknown_weights * np.linalg.lstsq(weighted_rows, -residual * row_factors, rcond=1e-13)[0]
        if _size(step[:m]) > MAX_DISTANCE:
            break
        damping = min(1.0, MAX_STEP / max(_size(step[:m]), 1e-300))
        for factor in 0.5 ** np.arange(12):
            (next_z,), (next_rates,) = state.displaced(factor * damping * step[np.newaxis])
            candidate = replace(state, z=next_z, rates=next_rates)
            candidate_size = _size(candidate.residual)
            if candidate_size < (1.0 - MIN_DECREASE * factor * damping) * size:
                break
        else:
            break  # only rounding remains, or there is no root
        state, size = candidate, candidate_size
        if size == 0.0 or _size(step) < 1e-15:
            break
    return state


def _size(values: FloatArray) -> float:
    size = float(np.max(np.abs(values), initial=0.0))
    return size if np.isfinite(size) else np.inf


MAX_RESTARTS = 12
"""Largest number of restarts of Newton's method, each with other independent coordinates and slack springs."""

RELAXATION_STEP = 0.1
"""Displacement along the accelerations, in scales, before a restart: where Newton's method stalls, the forces lead to an equilibrium."""

NO_STEADY_STATE = (
    "no steady state was found near the start: accelerations remain; start nearer to an equilibrium or a steady rotation. "
    "If a torque depends on the angle of a turning shaft, its steady state is periodic: use the mean torque"
)


def settle(
    scene: Scene,
    poses: FloatArray,  # assembled poses near the steady state; shape (bodies, 3)
    # their time derivatives, of which those of steadily turning shafts matter; shape (bodies, 3)
    velocities: FloatArray,
    time: float | None = None,  # time at which inputs are taken, s; that of their last change if None
) -> tuple[SceneDynamics, SteadyState]:
    """Find the steady state near given poses; raise MechanismError if there is no steady state near the start, or it is periodic."""
    for _ in range(MAX_RESTARTS):
        dynamics = SceneDynamics(scene, poses, velocities, time)
        dynamics.require_no_uneven_turning()
        dynamics.set_contact_mode(dynamics.start, dynamics.start_rates)
        state = find_steady_state(dynamics.accelerations, dynamics.start, dynamics.start_rates, dynamics.scales, dynamics.time_scale)
        # Coordinates that describe the start well may not do so at the steady state, and springs may have become slack.
        if state.is_steady and dynamics.is_well_conditioned(state.z) and not dynamics.set_contact_mode(state.z, state.rates):
            return dynamics, state
        relaxed = state.z if state.is_steady else state.z + RELAXATION_STEP * state.direction_of_acceleration
        motions = [dynamics.mass_centre_motion(z, state.rates) for z in (relaxed, state.z)]
        poses, velocities = next(motion for motion in motions if np.all(np.isfinite(motion[0])))
    touching = list(dict.fromkeys(gap.contact for gap in outline_gaps_of(scene)))
    clause = f". Where parts touch, the motion has no linear equations: contacts are {', '.join(map(repr, touching))}" if touching else ""
    raise MechanismError(f"{NO_STEADY_STATE}{clause}")

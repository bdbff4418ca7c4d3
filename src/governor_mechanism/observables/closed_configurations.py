"""All configurations in which the joints of a mechanism close, in an order that does not depend on its initial guess."""

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_rows import rotate_vector
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.observables.block_equations import BlockEquations, UnsuitableBlockError
from governor_mechanism.observables.constraint_blocks import Block, Decomposition, closing_bodies, decompose
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray

N_STARTS: Final = 100
"""Number of starts where the equations are not solved as a whole; what none of them reaches is not found."""

N_IDLE_STARTS: Final = 40
"""Number of starts in sequence without a new configuration after which the search ends."""

MAX_CONFIGURATIONS: Final = 1000
"""Number of configurations above which a mechanism is refused."""

SAME_TOLERANCE: Final = 1e-6
"""Difference of poses, length scales and rad, below which two configurations are the same; double ones leave 1e-7."""

POLISHING_TOLERANCE: Final = 1e-3
"""Change of a solution, length scales and rad, by closing all joints, above which it is one of some of the equations only."""

HEIGHT_TOLERANCE: Final = 1e-6
"""Difference of sums of heights, length scales, below which two configurations are equally high; rounding leaves 1e-13."""

ORDER_DECIMALS: Final = 6
"""Decimals of the angles by which configurations are ordered, rad; rounding leaves 1e-12."""


@dataclass(frozen=True, eq=False)
class ClosedConfigurations:
    """Poses (configurations, bodies, 3) in which the joints close."""

    solver: PositionSolver  # solver of the mechanism
    poses: FloatArray  # the poses in their order; shape (n, bodies, 3), m and rad
    methods: tuple[str, ...]  # how they were found: "closed form", "homotopy of 6 paths", "many starts"
    complete: bool  # whether there are certainly no others
    closing: IntArray  # numbers of the bodies that take part in the closing

    def find_highest(self, among: Iterable[int] | None = None) -> int:
        """Return the index of the configuration with the highest mass centres, or farthest right; singular ones are the last choice.

        It is one of all, or of those with given indices.
        """
        # Bodies that take no part in the closing do not count.
        indices = range(len(self.poses)) if among is None else among
        mobilities = {k: self.solver.count_degrees_of_freedom(self.poses[k]) for k in indices}
        regular = [k for k, mobility in mobilities.items() if mobility == min(mobilities.values())]
        reach, height = self.poses[:, self.closing, :2].sum(axis=1).T
        highest = max(float(height[k]) for k in regular)
        tolerance = HEIGHT_TOLERANCE * self.solver.mechanism.length_scale
        return max((k for k in regular if height[k] > highest - tolerance), key=lambda k: float(reach[k]))

    def find_nearest(self, poses: FloatArray) -> int:
        """Return the index of the configuration nearest to given poses: of least squares, in length scales and rad."""
        return int(np.argmin([np.sum(_differences(self.solver, one, poses)[self.closing] ** 2) for one in self.poses]))


def enumerate_configurations(solver: PositionSolver) -> ClosedConfigurations:
    """Return all configurations of a mechanism that its joints and drives determine, but for bodies that hang on one joint."""
    parts = decompose(solver)
    if parts.n_undetermined:
        raise MechanismError(_undetermined(parts.n_undetermined))
    methods: list[str] = []
    complete, poses = True, list[FloatArray]()
    try:
        poses, methods, complete = _solve_blocks(solver, parts)
        poses = _polish_all(solver, parts, poses)
    except UnsuitableBlockError:
        poses = []
        methods = []
        complete = False
    if not complete:
        poses = _search_from_many_starts(solver, parts, poses)
        methods = [*methods, "many starts"]
    closing = closing_bodies(parts, len(solver.mechanism.bodies))
    ordered = sorted(poses, key=lambda one: _order_key(solver, parts.blocks, one))
    shape = (len(ordered), len(solver.mechanism.bodies), 3)
    return ClosedConfigurations(solver, np.array(ordered).reshape(shape), tuple(dict.fromkeys(methods)), complete, closing)


def _undetermined(count: int) -> str:
    values = "one value more" if count == 1 else f"{count} values more"
    return (
        f"the joints and drives leave {count} {'degree' if count == 1 else 'degrees'} of freedom: {values} must be given, as an angle of "
        "a body, a driver or a value of [start]"
    )


def _solve_blocks(solver: PositionSolver, parts: Decomposition) -> tuple[list[FloatArray], list[str], bool]:
    """Return the solutions of all blocks in turn, and how they were found."""
    found = [solver.initial_guess.copy()]
    methods = list[str]()
    complete = True
    for block in parts.blocks:
        extended = list[FloatArray]()
        for poses in found:
            solutions = BlockEquations(solver, block, poses).solve()
            extended += solutions.poses
            complete = complete and solutions.complete
            methods += [] if solutions.method == "in turn" else [solutions.method]
        found = extended
        if len(found) > MAX_CONFIGURATIONS:
            raise UnsuitableBlockError
    return [_place_hanging_bodies(solver, parts, poses) for poses in found], methods, complete


def _place_hanging_bodies(solver: PositionSolver, parts: Decomposition, poses: FloatArray) -> FloatArray:
    """Return poses with the hanging bodies moved to the points they hang on, at the angles of the guess."""
    # Where the joint lets them slide or swing, they keep their place against it in the guess.
    placed, guess = poses.copy(), solver.initial_guess
    for body, row in parts.hanging:
        record = solver.equations.rows.table[row]
        ends = ((int(record["first"]), record["x1"], record["y1"]), (int(record["second"]), record["x2"], record["y2"]))
        own, other = ends if ends[0][0] == body else ends[::-1]
        gap = _point(guess, *own) - _point(guess, *other)
        is_coincidence = record["kind"] == RowKind.FIXED_DIRECTION and (record["direction_x"] == 1.0)
        placed[body, :2] += _point(placed, *other) - _point(placed, *own) + (0.0 if is_coincidence else gap)
    return placed


def _point(poses: FloatArray, body: int, x: float, y: float) -> FloatArray:
    """Return the position of a point of a body, or of the ground, m."""
    pose = poses[body] if body != GROUND_INDEX else np.zeros(3)
    position: FloatArray = pose[:2] + np.array(rotate_vector(pose[2], x, y))
    return position


def _polish_all(solver: PositionSolver, parts: Decomposition, candidates: Iterable[FloatArray]) -> list[FloatArray]:
    """Return the different configurations near candidates in which all joints close."""
    found: list[FloatArray] = []
    solved = sorted({k // 3 for block in parts.blocks for k in block.coordinates})
    for candidate in candidates:
        with suppress(MechanismError):
            poses = solver.solve({}, candidate)
            if largest_difference(solver, poses, candidate, solved) < POLISHING_TOLERANCE:
                _add_new(solver, found, poses)
    return found


def _add_new(solver: PositionSolver, found: list[FloatArray], poses: FloatArray) -> bool:
    """Add poses unless they are known; return whether they are new."""
    is_new = all(largest_difference(solver, poses, other) > SAME_TOLERANCE for other in found)
    found += [poses] if is_new else []
    return is_new


def largest_difference(solver: PositionSolver, one: FloatArray, other: FloatArray, bodies: Sequence[int] | None = None) -> float:
    """Return the largest difference of two sets of poses of some bodies, or of all, in length scales and rad without whole turns."""
    return float(np.max(np.abs(_differences(solver, one, other)[bodies]), initial=0.0))


def _differences(solver: PositionSolver, one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the differences of two sets of poses (bodies, 3), length scales and rad; whole turns do not count."""
    differences: FloatArray = (one - other) / solver.pose_scales
    differences[:, 2] = np.remainder(differences[:, 2] + math.pi, math.tau) - math.pi
    return differences


def _search_from_many_starts(solver: PositionSolver, parts: Decomposition, known: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the known configurations and others that Newton's iteration reaches from random poses."""
    found, generator = list(known), np.random.default_rng(0)
    spread = np.array([solver.mechanism.length_scale, solver.mechanism.length_scale, math.pi])
    centre = solver.initial_guess.mean(axis=0) * np.array([1.0, 1.0, 0.0])
    idle = 0
    for k in range(N_STARTS):
        start = solver.initial_guess.copy()
        if k:
            random = centre + spread * generator.uniform(-1.0, 1.0, size=start.shape)
            is_free = solver.free_mask.reshape(start.shape)
            start = _place_hanging_bodies(solver, parts, np.where(is_free, random, start))
        idle += 1
        with suppress(MechanismError):
            if _add_new(solver, found, _within_a_turn(solver, solver.solve({}, start))):
                idle = 0
        if idle > N_IDLE_STARTS:
            break
    return found


def _within_a_turn(solver: PositionSolver, poses: FloatArray) -> FloatArray:
    """Return poses with angles within half a turn where that keeps all joints closed."""
    wrapped = poses.copy()
    wrapped[:, 2] = np.remainder(wrapped[:, 2] + math.pi, math.tau) - math.pi
    residual = float(np.max(np.abs(solver.equations.residuals(wrapped, solver.time)), initial=0.0))
    return wrapped if residual < 1e-9 * solver.mechanism.length_scale else poses


def _order_key(solver: PositionSolver, blocks: Sequence[Block], poses: FloatArray) -> tuple[float, ...]:
    """Return by what configurations are ordered: the sense in which each block closes, then its angles, then its positions."""
    # The sense, the sign of a determinant, changes only where a block passes a singular configuration.
    jacobian = solver.scaled_joint_jacobian(poses)
    column_of = {int(coordinate): k for k, coordinate in enumerate(np.flatnonzero(solver.free_mask))}
    key: list[float] = []
    for block in blocks:
        determinant = float(np.linalg.det(_block_jacobian(solver, jacobian[:, [column_of[k] for k in block.coordinates]], block)))
        key.append(-math.copysign(1.0, determinant) if abs(determinant) > 1e-9 else 0.0)
        values = poses.ravel()[list(block.coordinates)] / np.tile(solver.pose_scales, len(poses))[list(block.coordinates)]
        is_angle = np.array(block.coordinates) % 3 == 2
        angles = np.round(np.remainder(values[is_angle] + 1e-9, math.tau), ORDER_DECIMALS)
        key += [*angles.tolist(), *np.round(values[~is_angle], ORDER_DECIMALS).tolist()]
    return tuple(key)


def _block_jacobian(solver: PositionSolver, columns: FloatArray, block: Block) -> FloatArray:
    """Return the Jacobian of a block, with the rows of drives last and of one sign, so that any driver of a value gives the same."""
    is_driven = solver.equations.is_driven
    rows = columns[sorted(block.rows, key=lambda row: (bool(is_driven[row]), row))]
    n_driven = int(np.sum(is_driven[list(block.rows)]))
    for row in rows[len(rows) - n_driven :]:
        row *= math.copysign(1.0, row[np.flatnonzero(row)[0]]) if np.any(row) else 1.0
    return rows

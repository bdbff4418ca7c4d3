"""The constraint equations of a mechanism as blocks that are solved one after the other."""

import heapq
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints import GROUND, Distance, Joint, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.types import IntArray

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Block:
    """Coordinates (3 body + 0, 1, 2 for x, y, angle) that some constraint rows determine together when the blocks before are known."""

    coordinates: tuple[int, ...]
    rows: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Blocks in the order of their solution, hanging bodies with the row of their only joint, and what nothing determines."""

    blocks: tuple[Block, ...]
    hanging: tuple[tuple[int, int], ...]
    n_undetermined: int


def decompose(solver: PositionSolver) -> Decomposition:
    """Return the blocks of the constraint equations of a mechanism."""
    hanging = _find_hanging_bodies(solver)
    bodies = {body for body, _ in hanging}
    incidence = _incidence(solver)
    row_bodies = solver.equations.rows.row_bodies
    rows = [k for k in range(len(row_bodies)) if not bodies & set(row_bodies[k].tolist())]
    columns = [3 * body + k for body in range(len(solver.mechanism.bodies)) if body not in bodies for k in range(3)]
    columns = [column for column in columns if solver.free_mask[column]]
    row_of = _match(incidence, rows, columns)
    blocks = _order_blocks(incidence, row_of, _coincidence_pairs(solver)) if len(row_of) == len(columns) else []
    return Decomposition(tuple(blocks), hanging, len(columns) - len(row_of))


def _find_hanging_bodies(solver: PositionSolver) -> tuple[tuple[int, int], ...]:
    """Return the bodies that one joint connects, also after others were left out, and the first row of this joint; the last found first."""
    rows, joints = solver.equations.rows.row_bodies, solver.equations.joint_indices
    remaining = set(range(len(solver.mechanism.bodies)))
    found: list[tuple[int, int]] = []
    while True:
        for body in sorted(remaining, reverse=True):
            own = [k for k in range(len(rows)) if body in rows[k] and all(other < 0 or other in remaining for other in rows[k])]
            if own and len({int(joints[k]) for k in own}) == 1 and not solver.equations.is_driven[own[0]]:
                found.append((body, own[0]))
                remaining.discard(body)
                break
        else:
            return tuple(reversed(found))


def _incidence(solver: PositionSolver) -> BoolArray:
    """Return which coordinates each row depends on, found at random poses; shape (rows, coordinates)."""
    generator = np.random.default_rng(0)
    poses = generator.uniform(-1.0, 1.0, size=(3, len(solver.mechanism.bodies), 3)) * np.array([1.0, 1.0, 3.0])
    poses[..., :2] *= solver.mechanism.length_scale
    jacobian = solver.equations.jacobian(poses).reshape(3, len(solver.equations.joint_indices), solver.free_mask.size)
    incidence: BoolArray = np.any(np.abs(jacobian) > 0.0, axis=0) & solver.free_mask
    return incidence


def _match(incidence: BoolArray, rows: list[int], columns: list[int]) -> dict[int, int]:
    """Return for as many coordinates as possible a row that determines it, each row for one coordinate."""
    row_of: dict[int, int] = {}
    column_of: dict[int, int] = {}

    def try_column(column: int, visited: set[int]) -> bool:
        for row in rows:
            if incidence[row, column] and row not in visited:
                visited.add(row)
                if row not in column_of or try_column(column_of[row], visited):
                    column_of[row] = column
                    row_of[column] = row
                    return True
        return False

    for column in columns:
        try_column(column, set())
    return row_of


def _coincidence_pairs(solver: PositionSolver) -> list[tuple[int, int]]:
    """Return pairs of rows by which two points coincide: they are solved together."""
    table, joints = solver.equations.rows.table, solver.equations.joint_indices
    is_point_row = (table["kind"] == RowKind.FIXED_DIRECTION) & ((table["direction_x"] != 0) | (table["direction_y"] != 0))
    return [(k, k + 1) for k in range(len(table) - 1) if joints[k] == joints[k + 1] and is_point_row[k] and is_point_row[k + 1]]


def _order_blocks(incidence: BoolArray, row_of: dict[int, int], pairs: list[tuple[int, int]]) -> list[Block]:
    """Return the strongly connected parts of the dependence of coordinates on one another, those that need no others first."""
    columns = sorted(row_of)
    column_of = {row: column for column, row in row_of.items()}
    needs = {column: {int(other) for other in np.flatnonzero(incidence[row_of[column]]) if other in row_of} for column in columns}
    together = [(column_of[one], column_of[other]) for one, other in pairs if one in column_of and other in column_of]
    together += [(3 * body, 3 * body + 1) for body in {column // 3 for column in columns} if {3 * body, 3 * body + 1} <= set(columns)]
    for one, other in together:
        needs[one].add(other)
        needs[other].add(one)
    reach = {column: _reachable(needs, column) for column in columns}
    parts = {column: frozenset(other for other in reach[column] if column in reach[other]) for column in columns}
    blocks = {min(part): part for part in parts.values()}
    waits_for = {first: {min(parts[need]) for column in part for need in needs[column]} - {first} for first, part in blocks.items()}
    ordered: list[Block] = []
    done: set[int] = set()
    ready = [first for first in blocks if not waits_for[first]]
    heapq.heapify(ready)
    while ready:
        first = heapq.heappop(ready)
        done.add(first)
        part = tuple(sorted(blocks[first]))
        ordered.append(Block(part, tuple(sorted(row_of[column] for column in part))))
        for other in blocks:
            if other not in done and other not in ready and waits_for[other] <= done:
                heapq.heappush(ready, other)
    return ordered


def _reachable(needs: dict[int, set[int]], start: int) -> set[int]:
    """Return the coordinates that one depends on, itself included."""
    found, open_ends = {start}, [start]
    while open_ends:
        for other in needs[open_ends.pop()] - found:
            found.add(other)
            open_ends.append(other)
    return found


def hanging_bodies(decomposition: Decomposition) -> Iterable[int]:
    """Return the numbers of the hanging bodies."""
    return [body for body, _ in decomposition.hanging]


def closing_bodies(decomposition: Decomposition, n_bodies: int) -> IntArray:
    """Return the numbers of the bodies that take part in the closing; all if none does."""
    closing = [body for body in range(n_bodies) if body not in set(hanging_bodies(decomposition))]
    return np.array(closing or range(n_bodies), dtype=np.int64)


def count_undetermined(solver: PositionSolver) -> int:
    """Return how many values of the bodies that take part in the closing neither joints nor drives determine."""
    return decompose(solver).n_undetermined


def angle_driver(body: str, angle: float, reference: str = GROUND) -> Joint:
    """Return the driver that holds a body at an angle (rad) to another one."""
    motion = PrescribedMotion.constant_rate(angle, 0.0)
    return RotationalDriver(name=f"angle of {body}", first=Point(body=reference), second=Point(body=body), motion=motion)


def hold_values(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """Return a mechanism whose readings are held at values, SI; raise MechanismError for a reading that no driver can hold."""
    drivers = [_reading_driver(mechanism.reading(name), value) for name, value in values.items()]
    return replace(mechanism, joints=(*mechanism.joints, *drivers))


def _reading_driver(reading: Reading, value: float) -> Joint:
    """Return the driver that holds a reading."""
    name = f"value of {reading.name}"
    if isinstance(reading, BodyAngle):
        return replace(angle_driver(reading.body, value, reading.reference_body), name=name)
    if isinstance(reading, PointDistance):
        return Distance(name=name, first=reading.first, second=reading.second, length=value)
    if isinstance(reading, PointCoordinate):
        motion = PrescribedMotion.constant_rate(value + reading.zero, 0.0)
        angle = math.atan2(reading.direction_y, reading.direction_x)
        return TranslationalDriver(name=name, first=reading.origin, second=reading.point, motion=motion, angle=angle)
    raise MechanismError(
        f"the assemblies at a value of reading {reading.name!r} are not listed; give the angle of a body, a coordinate of a point or a "
        "distance instead"
    )


def hold_needed_angles(mechanism: Mechanism, angles: Iterable[tuple[str, float]]) -> tuple[Mechanism, list[str]]:
    """Return a mechanism that holds the first of some angles (body, rad) that leave fewer values undetermined, and these bodies."""
    held: list[str] = []
    n_undetermined = count_undetermined(PositionSolver(mechanism))
    for body, angle in angles:
        if not n_undetermined:
            break
        trial = replace(mechanism, joints=(*mechanism.joints, angle_driver(body, angle)))
        if (remaining := count_undetermined(PositionSolver(trial))) < n_undetermined:
            mechanism, n_undetermined = trial, remaining
            held.append(body)
    return mechanism, held

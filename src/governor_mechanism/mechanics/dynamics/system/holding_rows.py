"""Constraint rows of a contact mode: those that hold outputs or break joints, and an order of all rows that gives a narrow band."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.contact_modes import (
    ContactMode,
    forced_output_names,
    initial_mode,
    rows_of_held_contacts,
    watched_output_names,
)
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.system.arrays import RUBBING_DTYPE, System
from governor_mechanism.mechanics.dynamics.system.event_functions import EventFunctionKind
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintTable, bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import FOR_EVENTS, FOR_FORCES, ConstraintRows
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows
from governor_mechanism.mechanics.kinematics.row_evaluation import RowEvaluation
from governor_mechanism.mechanics.kinematics.time_functions import N_CUBIC_COLUMNS, VALUE_COLUMN
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import numerical_rank
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, IntArray, RecordArray


def find_coupled_rows(row_bodies: IntArray) -> IntArray:
    """Return the pairs of rows that share a body, as (row, earlier or same row, side of the body in the first, side in the second)."""
    rows_of_body: dict[int, list[tuple[int, int]]] = {}
    pairs: list[tuple[int, int, int, int]] = []
    for row, bodies in enumerate(row_bodies.tolist()):
        sides = [(side, body_index) for side, body_index in enumerate(bodies) if body_index != GROUND_INDEX]
        for side, body_index in sides:
            rows_of_body.setdefault(body_index, []).append((row, side))
        pairs += sorted(
            (row, other_row, side, other_side) for side, body_index in sides for other_row, other_side in rows_of_body[body_index]
        )
    return np.array(pairs, dtype=np.int64).reshape(-1, 4)


def bandwidth_reducing_order(row_bodies: IntArray) -> IntArray:
    """Return an order of the rows that keeps coupled rows together (reverse Cuthill-McKee), the same on every machine."""
    coupled: list[set[int]] = [set() for _ in row_bodies]
    for row, other_row in find_coupled_rows(row_bodies)[:, :2].tolist():
        coupled[row].add(other_row)
        coupled[other_row].add(row)
    by_degree = sorted(range(len(coupled)), key=lambda row: len(coupled[row]))
    place = {row: k for k, row in enumerate(by_degree)}
    waiting = dict.fromkeys(by_degree)
    order: list[int] = []
    n_followed = 0
    while waiting:
        # Rows without a path to those before begin with that of the fewest coupled rows.
        reached = [next(iter(waiting))] if n_followed == len(order) else []
        if not reached:
            reached = sorted((row for row in coupled[order[n_followed]] if row in waiting), key=place.__getitem__)
            n_followed += 1
        for row in reached:
            del waiting[row]
        order += reached
    return np.array(order[::-1], dtype=np.int64)


def disable_rows(constraint_table: ConstraintTable, joints: Sequence[int]) -> RecordArray:
    """Return the rows of the joints, those of broken ones without effect."""
    table: RecordArray = constraint_table.rows.table.copy()
    is_broken = np.isin(constraint_table.joint_indices, joints)
    for name in ("direction_x", "direction_y", "first_angle_factor", "second_angle_factor", "third_angle_factor", "constant"):
        table[name][is_broken] = 0.0
    return table


def constraint_row_order(scene: Scene, mode: ContactMode | None = None) -> IntArray:
    """Return the order of the constraint rows of a system, as indices in the list of the joints' rows, then the holding rows."""
    return _initial_row_order(scene) if mode is None else _row_order_in_mode(scene, mode)


@once_per_object
def _initial_row_order(scene: Scene) -> IntArray:
    return _row_order_in_mode(scene, initial_mode(scene))


def _row_order_in_mode(scene: Scene, mode: ContactMode) -> IntArray:
    output_rows = make_output_rows(scene.mechanism, forced_output_names(scene), {})
    return order_rows(make_constraint_table(scene.mechanism).rows, make_holding_rows(scene, mode, output_rows))


def order_rows(rows: ConstraintRows, holding_rows: RecordArray) -> IntArray:
    """Return the order of joint rows and holding rows that gives a narrow band."""
    return bandwidth_reducing_order(bodies_of_rows(np.concatenate([rows.table, holding_rows])))


def make_holding_rows(scene: Scene, mode: ContactMode, output_rows: ConstraintRows) -> RecordArray:
    """Return the rows of the outputs that are held in a mode."""
    output_names = forced_output_names(scene)
    outputs = [output_names.index(contact.output_name) for contact in contacts_of(scene)]
    held = [(output, value) for output, value in zip(outputs, mode.held_values, strict=True) if value is not None]
    rows: RecordArray = output_rows.table[[output for output, _ in held]]
    for i, (_, value) in enumerate(held):
        rows[i]["constant"] += value
    return rows


def make_rubbing(
    scene: Scene,
    mode: ContactMode,
    held_rows: IntArray,  # constraint rows of the held outputs; shape (held outputs,)
) -> RecordArray:
    """Return the friction of what slides in a mode, as records of `RUBBING_DTYPE`."""
    contacts, output_names = contacts_of(scene), forced_output_names(scene)
    rows, names, records = rows_of_held_contacts(mode, held_rows.tolist()), [contact.output_name for contact in contacts], []
    for contact, sign in zip(contacts, mode.sliding_signs, strict=True):
        if contact.normal is not None and sign:
            output, row = output_names.index(contact.output_name), rows[names.index(contact.normal)]
            records.append((output, row, sign * contact.friction_coefficient))
    return np.array(records, dtype=RUBBING_DTYPE)


def uses_of_rows(scene: Scene, rubbing: RecordArray, event_rows: Sequence[int], n_rows: int) -> IntArray:
    """Return the use of each output row: forces follow from those of outlines only where effects act along them, or parts rub."""
    watched = [forced_output_names(scene).index(name) for name in watched_output_names(scene)]
    uses = np.full(n_rows, FOR_FORCES)
    uses[watched] = 0
    uses[rubbing["output_index"]] |= FOR_FORCES
    uses[event_rows] |= FOR_EVENTS
    return uses


def with_held_values(
    system: System,
    output_indices: Sequence[int],
    mode: ContactMode,  # mode that holds the same outputs as the system, at its own values
) -> System:
    """Return a system whose holding rows have other values; they are set, not incremented, so that rounding does not accumulate."""
    table = system.constraint_rows.table.copy()
    for k, value in enumerate(mode.held_values):
        if value is not None:
            is_hold = (system.event_functions["kind"] == EventFunctionKind.FORCE) & (system.event_functions["contact_index"] == k)
            row, output_row = int(system.event_functions["source_index"][is_hold][0]), system.output_rows.table[output_indices[k]]
            table[row]["constant"] = output_row["constant"] + value
    return system._replace(constraint_rows=system.constraint_rows._replace(table=table))


def stands_still(system: System, state: FloatArray, cubics: FloatArray, length_scale: float) -> bool:
    """Return whether joints, standing drives and sticking contacts hold every body, and nothing that loads one varies within a turn."""
    rows, drives = system.constraint_rows, system.constraint_rows.table["drive"]
    is_free = system.inverse_mass.ravel() > 0.0
    n_free = int(is_free.sum())
    if len(rows.table) < n_free:
        return False
    is_driven = np.any(cubics[drives[drives != NO_INDEX], :VALUE_COLUMN])
    if is_driven or len(system.lags) or np.any(system.planes["amplitude"]) or np.any(cubics[:, N_CUBIC_COLUMNS:]):
        return False
    poses = state[: system.state_layout.velocities].reshape(-1, 3)
    scales = np.tile([1.0, 1.0, 1.0 / length_scale], len(poses))
    jacobian = (RowEvaluation(rows, poses).jacobian.reshape(-1, len(scales)) * scales)[:, is_free]
    return numerical_rank(jacobian) == n_free

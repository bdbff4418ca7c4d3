"""Lowering of a scene to the arrays of the multibody model in one contact mode: records of its bodies, constraint rows and their order."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from governor_mechanism.mechanics.curves.segments import concatenate_segments
from governor_mechanism.mechanics.dynamics.arrays import RUBBING_DTYPE, System, body_reference_point, lay_out_state
from governor_mechanism.mechanics.dynamics.contact_modes import (
    ContactMode,
    forced_output_names,
    initial_mode,
    make_output_forces,
    rows_of_held_contacts,
    watched_output_names,
)
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.event_functions import (
    KINKS,
    EventFunctionKind,
    are_gaps,
    make_event_functions,
    rows_of_event_functions,
)
from governor_mechanism.mechanics.dynamics.inputs import InputLayout, loads_of, make_input_layout, make_input_terms
from governor_mechanism.mechanics.dynamics.output_forces import lower_outputs
from governor_mechanism.mechanics.kinematics.constraint_equations import (
    ConstraintTable,
    RowEvaluation,
    bodies_of_rows,
    make_constraint_table,
)
from governor_mechanism.mechanics.kinematics.constraint_rows import FOR_EVENTS, FOR_FORCES, ConstraintRows, Origins
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows
from governor_mechanism.mechanics.kinematics.time_functions import N_CUBIC_COLUMNS, VALUE_COLUMN, CubicTimeFunction
from governor_mechanism.model.mechanism import Body, Mechanism, Shaft
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.numerics.jit import record_dtype
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
    rows = rows_of_held_contacts(mode, held_rows.tolist())
    names = [contact.output_name for contact in contacts]
    records = []
    for contact, sign in zip(contacts, mode.sliding_signs, strict=True):
        if contact.normal is not None and sign:
            output = output_names.index(contact.output_name)
            row = rows[names.index(contact.normal)]
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
            row = int(system.event_functions["source_index"][is_hold][0])
            output_row = system.output_rows.table[output_indices[k]]
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


BODY_DTYPE = record_dtype(
    ("mass", "f8"),  # kg
    ("x", "f8"),  # mass centre from the origin, in body axes, m
    ("y", "f8"),
    ("xx", "f8"),  # second moments about the mass centre, kg m2
    ("yy", "f8"),
    ("xy", "f8"),
    ("zz", "f8"),
    ("gravity", "f8"),  # gravitational acceleration, m/s2
    ("plane", "i8"),  # plane whose centrifugal forces the body carries, or NO_INDEX
)
"""One body."""

PLANE_DTYPE = record_dtype(
    ("shaft", "i8"),  # body that the plane turns with, or NO_INDEX
    ("input_index", "i8"),  # input of its given speed, or NO_INDEX
    ("has_reaction", "i8"),  # whether its bodies act on the shaft
    ("ratio", "f8"),  # its speed relative to the shaft or the input
    ("amplitude", "f8"),  # relative amplitude of a fluctuation of the given speed
    ("cycles_per_turn", "f8"),
)
"""One plane with centrifugal forces."""

# `constrained_solution` removes it again by an iteration that converges by about this ratio; a smaller ratio
# conditions the joint equations worse.
STAND_IN_INERTIA_RATIO = 1e-3
"""Stand-in inertia of massless coordinates, relative to the smallest mass and moment of inertia of the mechanism."""


def make_body_record(
    body: Body,
    gravity: float,  # gravitational acceleration, m/s2
    plane: int,  # index of the plane whose centrifugal forces it carries, or NO_INDEX
    origin: tuple[float, float] = (0.0, 0.0),  # its origin in body axes from the mass centre, m
) -> tuple[float, ...]:
    """Return a body as a record of `BODY_DTYPE`."""
    moments = body.second_moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz, gravity, plane)


def make_body_records(scene: Scene, origins: Origins) -> RecordArray:
    """Return the bodies as records of `BODY_DTYPE`."""
    loaded_planes = [plane for plane in scene.system.planes if plane.is_loaded]
    plane_of_body = {body: index for index, plane in enumerate(loaded_planes) for body in plane.bodies}
    records = [
        make_body_record(body, gravity, plane_of_body.get(index, NO_INDEX), origins[body.name])
        for index, (body, gravity) in enumerate(zip(scene.mechanism.bodies, scene.system.gravity, strict=True))
    ]
    return np.array(records, dtype=BODY_DTYPE)


def make_plane_records(scene: Scene, speeds: Sequence[Spindle]) -> RecordArray:
    """Return the planes with centrifugal forces as records of `PLANE_DTYPE`; `speeds` are the inputs of given speeds."""
    records = []
    for plane in scene.system.planes:
        if plane.is_loaded and plane.given_speed:
            given = plane.given_speed
            records.append((NO_INDEX, speeds.index(given), 0, plane.ratio, 0.5 * given.speed_fluctuation, given.cycles_per_turn))
        elif plane.is_loaded:
            records.append((scene.mechanism.body_index(plane.shaft), NO_INDEX, plane.has_reaction, plane.ratio, 0.0, 1.0))
    return np.array(records, dtype=PLANE_DTYPE)


def make_inertia(mechanism: Mechanism, origins: Origins) -> tuple[FloatArray, FloatArray]:
    """Return mass (twice) and moment of inertia about the origin of each body, (bodies, 3), and the stand-ins for those that are 0."""
    # Coordinates that cannot change have neither. The moment of inertia of a shaft follows with the
    # poses.
    rows = []
    for body in mechanism.bodies:
        moment = 1.0 if isinstance(body, Shaft) else body.planar_inertia + body.mass * math.hypot(*origins[body.name]) ** 2
        rows.append([body.mass, body.mass, moment])
    moves = np.array([body.moves for body in mechanism.bodies]).reshape(-1, 3)
    inertia = np.where(moves, np.array(rows).reshape(-1, 3), 0.0)
    masses = inertia[:, 0][inertia[:, 0] > 0]
    moments = inertia[:, 2][inertia[:, 2] > 0]
    mass = float(np.min(masses)) if masses.size else 1.0
    moment = float(np.min(moments, initial=mass * mechanism.length_scale**2))
    return inertia, np.where(moves & (inertia == 0), STAND_IN_INERTIA_RATIO * np.array([mass, mass, moment]), 0.0)


def make_system(
    scene: Scene,
    # contact mode; the initial mode if left out, in which nothing is held and no friction acts
    mode: ContactMode | None = None,
) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """Lower a scene to arrays and inputs: spindle speeds, drives, loads of elements, friction forces, inputs of factors and lags."""
    system, inputs = _make_initial_system(scene)
    return (system if mode is None else system._replace(**_arrays_of_mode(scene, mode, system.output_rows, system.force_elements))), inputs


def given_speeds(scene: Scene) -> list[Spindle]:
    """Return the given spindles of a scene, each once."""
    return list(dict.fromkeys(plane.given_speed for plane in scene.system.planes if plane.given_speed))


@once_per_object
def multibody_input_layout(scene: Scene) -> InputLayout:
    """Return the layout of the inputs of a scene, of which the drives move joints and points of the ground."""
    n_drives = len(make_constraint_table(scene.mechanism).motions)
    return make_input_layout(loads_of(scene), contacts_of(scene), len(given_speeds(scene)), n_drives)


@once_per_object
def _make_initial_system(scene: Scene) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    mechanism = scene.mechanism
    origins, constraint_table = _make_joint_rows(scene)
    speeds = given_speeds(scene)
    layout = multibody_input_layout(scene)
    loads = loads_of(scene)
    output_rows, force_elements = lower_outputs(
        mechanism, forced_output_names(scene), mechanism.force_elements, origins, layout.element_loads.start
    )
    inputs: list[InputFunction | PrescribedMotion] = [speed.speed_function for speed in speeds]
    inputs += [*constraint_table.motions, *loads]
    inputs += [InputFunction()] * (layout.n_inputs - len(inputs))
    inertia, stand_in_inertia = make_inertia(mechanism, origins)
    total_inertia = inertia + stand_in_inertia
    inverse_mass = np.divide(1.0, total_inertia, out=np.zeros_like(inertia), where=total_inertia > 0)
    bodies = make_body_records(scene, origins)
    system = System(
        state_layout=lay_out_state(len(bodies)),
        force_elements=force_elements,
        bodies=bodies,
        inverse_mass=inverse_mass,
        equal_mass_metric=inverse_mass * np.where(total_inertia[:, :1] > 0, total_inertia[:, :1], 1.0),
        stand_in_inertia=stand_in_inertia,
        has_stand_in_inertia=bool(stand_in_inertia.any()),
        planes=make_plane_records(scene, speeds),
        n_inputs=layout.n_inputs,
        **_arrays_of_mode(scene, initial_mode(scene), output_rows, force_elements),
    )
    return system, tuple(map(CubicTimeFunction, inputs))


@once_per_object
def _make_joint_rows(scene: Scene) -> tuple[Origins, ConstraintTable]:
    """Return the origins of the bodies and the rows of the joints, which are the same in all modes."""
    origins = {body.name: body_reference_point(scene.mechanism, body) for body in scene.mechanism.bodies}
    return origins, make_constraint_table(scene.mechanism, origins)


def _arrays_of_mode(scene: Scene, mode: ContactMode, output_rows: ConstraintRows, force_elements: RecordArray) -> dict[str, Any]:
    """Return the fields of a system that depend on the contact mode."""
    constraint_table = _make_joint_rows(scene)[1]
    layout = multibody_input_layout(scene)
    holding_rows = make_holding_rows(scene, mode, output_rows)
    row_order = order_rows(constraint_table.rows, holding_rows)
    held_rows = np.argsort(row_order)[len(constraint_table.joint_indices) :]
    segments = concatenate_segments([constraint_table.rows.curve_segments, output_rows.curve_segments])
    holding_rows["first_segment"] += len(constraint_table.rows.curve_segments)
    joint_rows = disable_rows(constraint_table, [scene.mechanism.joint_index(name) for name in mode.broken])
    ordered_rows = np.concatenate([joint_rows, holding_rows])[row_order]
    rows = ConstraintRows(ordered_rows, bodies_of_rows(ordered_rows), segments)
    rows.table["drive"] += np.where(rows.table["drive"] != NO_INDEX, layout.drives.start, 0)
    row_pairs = find_coupled_rows(rows.row_bodies)
    event_functions = make_event_functions(scene, mode, layout.friction_inputs, held_rows, force_elements)
    rubbing = make_rubbing(scene, mode, held_rows)
    output_table = output_rows.table.copy()
    output_table["use"] = uses_of_rows(scene, rubbing, rows_of_event_functions(event_functions), len(output_table))
    input_terms, lags = make_input_terms(forced_output_names(scene), mode.segments, layout, loads_of(scene))
    return {
        "constraint_rows": rows,
        "row_pairs": row_pairs,
        "bandwidth": int(np.max(row_pairs[:, 0] - row_pairs[:, 1], initial=0)),
        "output_forces": make_output_forces(scene, mode, layout.friction_inputs),
        "output_rows": output_rows._replace(table=output_table),
        "rubbing": rubbing,
        "event_functions": event_functions,
        "n_kinks": sum(kind in KINKS for kind in event_functions["kind"].tolist()),
        "watches_gaps_alone": are_gaps(scene, event_functions),
        "input_terms": input_terms,
        "lags": lags,
    }

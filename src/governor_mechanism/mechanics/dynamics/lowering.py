"""Lowering of a scene to the arrays of the compiled kernels: bodies, constraint rows, forces, event functions."""

import math
from collections.abc import Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT, GasPressure
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics import contacts, output_forces
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.constraint_solver import bandwidth_reducing_order, find_coupled_rows
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, initial_mode
from governor_mechanism.mechanics.dynamics.force_elements import lower_outputs
from governor_mechanism.mechanics.dynamics.inputs import EVENT_ROUNDING_RATIO, make_input_terms, output_of_reading
from governor_mechanism.mechanics.dynamics.output_forces import EventFunctionKind
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintTable, bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import CONSTANT_PARAMETER, make_output_rows
from governor_mechanism.mechanics.kinematics.points import Origins, rotate_vector
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body, Mechanism, Shaft
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion, TableFunction
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import BoolArray, FloatArray, IntArray, RecordArray, record_dtype

BODY_DTYPE = record_dtype("f8 mass x y xx yy xy zz gravity", "i8 plane")
"""One body: mass (kg), mass centre relative to the origin in body axes (m), second moments about the mass centre (kg m2), gravitational
acceleration (m/s2), and the plane whose centrifugal forces it carries, or -1."""

PLANE_DTYPE = record_dtype("i8 shaft input_index has_reaction", "f8 ratio amplitude cycles_per_turn")
"""One plane with centrifugal forces: body that it turns with, or -1, and then the input of its given speed; whether its bodies act on the
shaft; ratio of its speed to that of shaft or input; relative amplitude of a fluctuation of the given speed and its cycles per turn."""


class PlaneColumn(IntEnum):
    """Column of the motion of a plane: speed (rad/s), acceleration if it is given (rad/s2), inertia (kg m2) and its rate (kg m2/s)."""

    SPEED = 0
    ACCELERATION = 1
    INERTIA = 2
    INERTIA_RATE = 3


N_PLANE_COLUMNS = len(PlaneColumn)
"""Number of columns of the motion of a plane."""

STAND_IN_INERTIA_RATIO = 1e-3
"""Stand-in inertia of massless coordinates, relative to the smallest mass and moment of inertia of the mechanism.

`remove_stand_in_inertia` removes it again by an iteration that converges by about this ratio; a smaller ratio conditions the
joint equations worse.
"""

EventFunctionRecord = tuple[EventFunctionKind, int, int, float, float, float, int, int]
"""A record of `EVENT_FUNCTION_DTYPE`."""


class System(NamedTuple):
    """Arrays of the multibody model in one contact mode.

    Poses refer to the origin of each body: its mass centre, or the ground pin of a point mass. The last of the joints' rows
    are those of held outputs, before the rows are reordered to a narrow band.

    Attributes
    ----------
    constraint_rows
        Rows of the joints and of held outputs.
    force_elements
        Forces of the force elements, records of `OUTPUT_FORCE_DTYPE`.
    row_pairs
        Pairs of rows that share a body, see `find_coupled_rows`; shape (pairs, 4).
    bandwidth
        Half bandwidth of J M^-1 J^T, without the diagonal.
    bodies
        Records of `BODY_DTYPE`; shape (bodies,).
    inverse_mass
        Inverse mass (twice) and inverse moment of inertia about the origin, 0 for coordinates that cannot change; shape (bodies, 3). For a
        shaft it changes with the poses, see `update_inverse_mass`. It includes the stand-in inertia.
    equal_mass_metric
        The inverse masses that the bodies would have if all had the same mass, 1; shape (bodies, 3). In this metric the rows of the joints
        are nearly dependent near a change point alone, not where a light body carries a heavy one.
    stand_in_inertia
        Mass (twice) and moment of inertia in `inverse_mass` that a massless coordinate does not have; shape (bodies, 3).
    has_stand_in_inertia
        Whether any of it is not 0.
    planes
        Records of `PLANE_DTYPE`.
    output_rows
        Rows of the outputs along which effects act or on which loads depend, then of those along which force elements act.
    output_forces
        Records of `OUTPUT_FORCE_DTYPE`.
    event_functions
        Records of `EVENT_FUNCTION_DTYPE`.
    input_terms
        Records of `INPUT_TERM_DTYPE`, in the order of their evaluation.
    lags
        Records of `LAG_DTYPE`.
    n_inputs
        Number of inputs.
    first_friction_input
        Index of the first friction force among them.
    """

    constraint_rows: ConstraintRows
    force_elements: RecordArray
    row_pairs: IntArray
    bandwidth: int
    bodies: RecordArray
    inverse_mass: FloatArray
    equal_mass_metric: FloatArray
    stand_in_inertia: FloatArray
    has_stand_in_inertia: bool
    planes: RecordArray
    output_rows: ConstraintRows
    output_forces: RecordArray
    event_functions: RecordArray
    input_terms: RecordArray
    lags: RecordArray
    n_inputs: int
    first_friction_input: int


class SystemWorkspace(NamedTuple):
    """Work arrays of one evaluation, so that the kernels allocate nothing in their loops.

    Attributes
    ----------
    row_values
        Prescribed motion, residual and gamma of each row; shape (rows, 5).
    jacobian
        Jacobian of each row with respect to both poses; shape (rows, 2, 3).
    band
        Band of J M^-1 J^T; shape (rows, bandwidth + 1).
    factor
        Its Cholesky factor, with the shape of `band`.
    equal_mass_band
        As `band`, in the metric of equal masses.
    multipliers
        Lagrange multipliers, N; shape (rows,).
    multiplier_corrections
        Their corrections by iterative refinement, N; shape (rows,).
    generalised_forces
        Applied forces, N and N m; shape (bodies, 3).
    output_row_values
        As `row_values`, for the outputs; shape (outputs, 5).
    output_jacobian
        As `jacobian`, for the outputs; shape (outputs, 2, 3).
    inverse_mass
        As that of the system, at the poses of the last evaluation; shape (bodies, 3).
    plane_motion
        Speed (rad/s), acceleration if the speed is given (rad/s2), moment of inertia (kg m2) and its rate (kg m2/s) of each plane;
        shape (planes, 4).
    inputs
        Values of the inputs; shape (inputs,).
    force_elements
        As those of the system, with the switches of gas at the last evaluation.
    is_armed
        Whether each event function of a kink is monitored; shape (event functions,).
    """

    row_values: FloatArray
    jacobian: FloatArray
    band: FloatArray
    factor: FloatArray
    equal_mass_band: FloatArray
    multipliers: FloatArray
    multiplier_corrections: FloatArray
    generalised_forces: FloatArray
    output_row_values: FloatArray
    output_jacobian: FloatArray
    inverse_mass: FloatArray
    plane_motion: FloatArray
    inputs: FloatArray
    force_elements: RecordArray
    is_armed: BoolArray


def make_system(scene: Scene, mode: ContactMode | None = None) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """Lower a scene to arrays.

    Parameters
    ----------
    scene
        The scene.
    mode
        Contact mode; the initial mode if left out, in which nothing is held and no friction acts.

    Returns
    -------
    system : System
        The arrays.
    inputs : tuple[CubicTimeFunction, ...]
        Inputs as functions of time: given spindle speeds, drives, loads of force elements, friction forces, inputs of factors and lags.
    """
    return _make_initial_system(scene) if mode is None else _make_system_in_mode(scene, mode)


@once_per_object
def _make_initial_system(scene: Scene) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    return _make_system_in_mode(scene, initial_mode(scene))


def _make_system_in_mode(scene: Scene, mode: ContactMode) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    mechanism = scene.mechanism
    origins = {body.name: body_reference_point(mechanism, body) for body in mechanism.bodies}
    constraint_table = make_constraint_table(mechanism, origins)
    output_names = forced_output_names(scene)
    speeds = list(dict.fromkeys(plane.given_speed for plane in scene.system.planes if plane.given_speed))
    first_load = len(speeds) + len(constraint_table.motions)
    output_rows, force_elements = lower_outputs(mechanism, output_names, mechanism.force_elements, origins, first_load)
    holding_rows = _make_holding_rows(scene, mode, output_rows)
    row_order = _row_order(constraint_table.rows, holding_rows)
    held_rows = np.argsort(row_order)[len(constraint_table.joint_indices) :]
    joint_rows = _disable_rows(constraint_table, [mechanism.joint_index(name) for name in mode.broken])
    ordered_rows = np.concatenate([joint_rows, holding_rows])[row_order]
    rows = ConstraintRows(ordered_rows, bodies_of_rows(ordered_rows), constraint_table.rows.curve_segments)
    rows.table["drive"] += np.where(rows.table["drive"] >= 0, len(speeds), 0)
    row_pairs = find_coupled_rows(rows.row_bodies)
    loads, n_frictions = contacts.loads_of(scene), sum(contact.friction is not None for contact in contacts_of(scene))
    first_friction_input = first_load + len(loads) - n_frictions
    input_terms, lags, n_further_inputs = make_input_terms(output_names, mode.segments, first_load, loads, n_frictions)
    inputs: list[InputFunction | PrescribedMotion] = [speed.speed_function for speed in speeds]
    inputs += [*constraint_table.motions, *loads, *(InputFunction(),) * n_further_inputs]
    inertia, stand_in_inertia = _make_inertia(mechanism, origins)
    total_inertia = inertia + stand_in_inertia
    inverse_mass = np.divide(1.0, total_inertia, out=np.zeros_like(inertia), where=total_inertia > 0)
    system = System(
        constraint_rows=rows,
        force_elements=force_elements,
        row_pairs=row_pairs,
        bandwidth=int(np.max(row_pairs[:, 0] - row_pairs[:, 1], initial=0)),
        bodies=_make_body_records(scene, origins),
        inverse_mass=inverse_mass,
        equal_mass_metric=inverse_mass * np.where(total_inertia[:, :1] > 0, total_inertia[:, :1], 1.0),
        stand_in_inertia=stand_in_inertia,
        has_stand_in_inertia=bool(stand_in_inertia.any()),
        planes=_make_plane_records(scene, speeds),
        output_rows=output_rows,
        output_forces=_make_output_forces(scene, mode, first_friction_input),
        event_functions=_make_event_functions(scene, mode, first_friction_input, held_rows, force_elements),
        input_terms=input_terms,
        lags=lags,
        n_inputs=len(inputs),
        first_friction_input=first_friction_input,
    )
    return system, tuple(map(CubicTimeFunction, inputs))


def _make_body_records(scene: Scene, origins: Origins) -> RecordArray:
    """Return the bodies as records of `BODY_DTYPE`."""
    loaded_planes = [plane for plane in scene.system.planes if plane.is_loaded]
    plane_of_body = {body: index for index, plane in enumerate(loaded_planes) for body in plane.bodies}
    records = [
        make_body_record(body, gravity, plane_of_body.get(index, -1), origins[body.name])
        for index, (body, gravity) in enumerate(zip(scene.mechanism.bodies, scene.system.gravity, strict=True))
    ]
    return np.array(records, dtype=BODY_DTYPE)


def _make_plane_records(scene: Scene, speeds: Sequence[Spindle]) -> RecordArray:
    """Return the planes with centrifugal forces as records of `PLANE_DTYPE`; `speeds` are the inputs of given speeds."""
    records = []
    for plane in scene.system.planes:
        if plane.is_loaded and plane.given_speed:
            given = plane.given_speed
            records.append((-1, speeds.index(given), 0, plane.ratio, 0.5 * given.speed_fluctuation, given.cycles_per_turn))
        elif plane.is_loaded:
            records.append((scene.mechanism.body_index(plane.shaft), -1, plane.has_reaction, plane.ratio, 0.0, 1.0))
    return np.array(records, dtype=PLANE_DTYPE)


def _make_inertia(mechanism: Mechanism, origins: Origins) -> tuple[FloatArray, FloatArray]:
    """Return mass (twice) and moment of inertia about the origin of each body, and the stand-ins for those that are 0; (bodies, 3).

    Coordinates that cannot change have neither. The moment of inertia of a shaft follows with the poses.
    """
    rows = []
    for body in mechanism.bodies:
        moment = 1.0 if isinstance(body, Shaft) else body.planar_inertia + body.mass * math.hypot(*origins[body.name]) ** 2
        rows.append([body.mass, body.mass, moment])
    moves = np.array([body.moves for body in mechanism.bodies]).reshape(-1, 3)
    inertia = np.where(moves, np.array(rows).reshape(-1, 3), 0.0)
    masses, moments = inertia[:, 0][inertia[:, 0] > 0], inertia[:, 2][inertia[:, 2] > 0]
    mass = float(np.min(masses)) if masses.size else 1.0
    moment = float(np.min(moments, initial=mass * mechanism.length_scale**2))
    return inertia, np.where(moves & (inertia == 0), STAND_IN_INERTIA_RATIO * np.array([mass, mass, moment]), 0.0)


def _disable_rows(constraint_table: ConstraintTable, joints: Sequence[int]) -> RecordArray:
    """Return the rows of the joints, those of broken ones without effect."""
    table: RecordArray = constraint_table.rows.table.copy()
    is_broken = np.isin(constraint_table.joint_indices, joints)
    for name in ("p0", "p1", "p2", "p3", "p4", "p5"):
        table[name][is_broken] = 0.0
    return table


@once_per_object
def forced_output_names(scene: Scene) -> list[str]:
    """Return the readings along which effects act or on which loads depend.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    list[str]
        Names in the order of the output rows of a system.
    """
    functions = contacts.reading_functions_of(scene)
    return list(
        dict.fromkeys([effect.reading for effect in scene.output_effects] + [output_of_reading(one.reading)[0] for one in functions])
    )


def count_output_forces(system: System) -> IntArray:
    """Return how many output forces of each kind a system has.

    Parameters
    ----------
    system
        Arrays of the multibody model.

    Returns
    -------
    IntArray
        Number of forces by law, in the order of `FORCE_LAWS`, then of sliding frictions; shape (laws + 1,).
    """
    return np.bincount(system.output_forces["law"], minlength=output_forces.SLIDING_FRICTION + 1)


def constraint_row_order(scene: Scene, mode: ContactMode | None = None) -> IntArray:
    """Return the index of each row of a system in the list of the joints' rows, then the holding rows; shape (rows,)."""
    return _initial_row_order(scene) if mode is None else _row_order_in_mode(scene, mode)


@once_per_object
def _initial_row_order(scene: Scene) -> IntArray:
    return _row_order_in_mode(scene, initial_mode(scene))


def _row_order_in_mode(scene: Scene, mode: ContactMode) -> IntArray:
    output_rows = make_output_rows(scene.mechanism, forced_output_names(scene), {})
    return _row_order(make_constraint_table(scene.mechanism).rows, _make_holding_rows(scene, mode, output_rows))


def _row_order(rows: ConstraintRows, holding_rows: RecordArray) -> IntArray:
    """Return the order of joint rows and holding rows that gives a narrow band."""
    return bandwidth_reducing_order(np.concatenate([rows.row_bodies, bodies_of_rows(holding_rows)]))


def _make_holding_rows(scene: Scene, mode: ContactMode, output_rows: ConstraintRows) -> RecordArray:
    """Return the rows of the outputs that are held in a mode."""
    output_names = forced_output_names(scene)
    outputs = [output_names.index(contact.output_name) for contact in contacts_of(scene)]
    held = [(output, value) for output, value in zip(outputs, mode.held_values, strict=True) if value is not None]
    rows: RecordArray = output_rows.table[[output for output, _ in held]]
    for i, (_, value) in enumerate(held):
        rows[i][CONSTANT_PARAMETER[int(rows[i]["kind"])]] += value
    return rows


def _make_output_forces(scene: Scene, mode: ContactMode, friction_input: int) -> RecordArray:
    """Return the output forces in a mode; `friction_input` is the index of the first friction input."""
    output_names = forced_output_names(scene)
    records = [
        output_forces.output_force_record(effect, output_names.index(effect.reading)) for effect in contacts.active_forces_of(scene, mode)
    ]
    for contact, sign in zip(contacts_of(scene), mode.sliding_signs, strict=True):
        if sign:
            output, law = output_names.index(contact.output_name), output_forces.SLIDING_FRICTION
            records.append(output_forces.make_output_force(law, output, (float(sign),), has_power=True, input_index=friction_input))
        friction_input += contact.friction is not None
    return np.array(records, dtype=output_forces.OUTPUT_FORCE_DTYPE)


def _make_event_functions(
    scene: Scene, mode: ContactMode, friction_input: int, held_rows: IntArray, force_elements: RecordArray
) -> RecordArray:
    """Return the event functions of a mode.

    Their contact index counts the contacts, then the one-sided springs. `held_rows` are the constraint rows of the held
    outputs, `friction_input` is the index of the first friction input.
    """
    output_names, rows, records = forced_output_names(scene), iter(held_rows.tolist()), list[EventFunctionRecord]()
    mechanism, time = scene.mechanism, time_scale(scene)
    length_scale, mass = mechanism.length_scale, sum(body.mass for body in mechanism.bodies)
    tolerances = {name: EVENT_ROUNDING_RATIO * mechanism.output_scale(name) for name in output_names}
    force_tolerance = EVENT_ROUNDING_RATIO * mass * length_scale / time**2
    states = zip(contacts_of(scene), mode.held_values, mode.sliding_signs, strict=True)
    for contact_index, (contact, held, sign) in enumerate(states):
        name, output_index = contact.output_name, output_names.index(contact.output_name)
        friction_index = friction_input if contact.friction is not None else -1
        friction_input += contact.friction is not None
        if held is not None:
            row = next(rows)
            # A stop pushes with unlimited force in one direction; friction holds in both, up to its limit.
            for direction, is_unlimited in ((1.0, held <= contact.low), (-1.0, held >= contact.high)):
                if not is_unlimited:
                    records.append((EventFunctionKind.FORCE, row, -1, direction, 0.0, force_tolerance, friction_index, contact_index))
            continue
        if mode.is_locked:
            continue
        if sign:
            records.append((EventFunctionKind.RATE, output_index, -1, -float(sign), 0.0, tolerances[name] / time, -1, contact_index))
        for direction, bound in ((1.0, contact.high), (-1.0, -contact.low)):
            if np.isfinite(bound):
                records.append((EventFunctionKind.VALUE, output_index, -1, direction, bound, tolerances[name], -1, contact_index))
    one_sided = () if mode.is_locked else contacts.one_sided_forces_of(scene)
    for contact_index, (effect, taut) in enumerate(zip(one_sided, mode.taut, strict=False), start=len(mode.held_values)):
        direction, name = (-1.0 if taut else 1.0), effect.reading
        threshold, tolerance = direction * effect.slack_below, tolerances[name]
        records.append((EventFunctionKind.VALUE, output_names.index(name), -1, direction, threshold, tolerance, -1, contact_index))
    first_table = len(mode.held_values) + len(mode.taut)
    for contact_index, (table, segment) in enumerate(zip(contacts.reading_tables_of(scene), mode.segments, strict=True), start=first_table):
        records += _table_event_functions(table, segment, contact_index, output_names, tolerances, time)
    records += make_gas_event_functions(force_elements, first_table + len(mode.segments))
    return np.array(records, dtype=output_forces.EVENT_FUNCTION_DTYPE)


def make_gas_event_functions(force_elements: RecordArray, contact_index: int) -> list[EventFunctionRecord]:
    """Return the event functions of the kinks of gas in cylinders; gases that share a kink share its function.

    Parameters
    ----------
    force_elements
        Records of `OUTPUT_FORCE_DTYPE`.
    contact_index
        What they have as index of a contact.

    Returns
    -------
    list[EventFunctionRecord]
        Records of `EVENT_FUNCTION_DTYPE`: the switch of each gas, then both dead centres of each crank.
    """
    gases = [force for force in force_elements if force["law"] == FORCE_LAWS.index(GasPressure)]
    return list(dict.fromkeys(_gas_event_functions(gases, contact_index)))


def _gas_event_functions(gases: Sequence[Any], contact_index: int) -> Iterator[EventFunctionRecord]:
    """Yield the event functions of gases; the same one for each gas that has it."""
    for gas in gases:
        switch, stroke = float(gas["coefficients"][SWITCH_COEFFICIENT]), float(gas["coefficients"][7])
        rows, switch_input = (int(gas["output_index"]), int(gas["argument_index"])), int(gas["switch_input"])
        if switch_input >= 0:
            yield EventFunctionKind.SWITCH, *rows, 1.0 / stroke, 0.0, EVENT_ROUNDING_RATIO, switch_input, contact_index
        elif 0.0 < switch < 1.0:
            yield EventFunctionKind.SWITCH, *rows, 1.0 / stroke, switch, EVENT_ROUNDING_RATIO, -1, contact_index
    for angle in sorted({int(gas["argument_index"]) for gas in gases}):
        for sign in (1.0, -1.0):
            yield EventFunctionKind.DEAD_CENTRE, angle, -1, sign, 0.0, EVENT_ROUNDING_RATIO, -1, contact_index


def _table_event_functions(
    table: TableFunction, segment: int, contact_index: int, output_names: Sequence[str], tolerances: Mapping[str, float], time: float
) -> Iterator[EventFunctionRecord]:
    """Yield the event functions at the ends of a segment of a table."""
    name, is_rate = output_of_reading(table.reading)
    kind, tolerance = (EventFunctionKind.RATE, tolerances[name] / time) if is_rate else (EventFunctionKind.VALUE, tolerances[name])
    if segment > 0:
        yield kind, output_names.index(name), -1, -1.0, -table.positions[segment - 1], tolerance, -1, contact_index
    if segment < len(table.positions):
        yield kind, output_names.index(name), -1, 1.0, table.positions[segment], tolerance, -1, contact_index


def with_held_values(system: System, output_indices: Sequence[int], mode: ContactMode) -> System:
    """Return a system with other values of the held outputs.

    The values are set, not incremented, so that rounding does not accumulate.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    output_indices
        Output row of each contact.
    mode
        Mode that holds the same outputs as the system, at its own values.

    Returns
    -------
    System
        The system with the constants of the holding rows replaced.
    """
    table = system.constraint_rows.table.copy()
    for k, value in enumerate(mode.held_values):
        if value is not None:
            is_hold = (system.event_functions["kind"] == EventFunctionKind.FORCE) & (system.event_functions["contact_index"] == k)
            row, output_row = int(system.event_functions["source_index"][is_hold][0]), system.output_rows.table[output_indices[k]]
            constant = CONSTANT_PARAMETER[int(output_row["kind"])]
            table[row][constant] = output_row[constant] + value
    return system._replace(constraint_rows=system.constraint_rows._replace(table=table))


def make_system_workspace(system: System) -> SystemWorkspace:
    """Return work arrays for the evaluation of a system.

    Parameters
    ----------
    system
        Arrays of the multibody model.

    Returns
    -------
    SystemWorkspace
        Arrays of zeros.
    """
    rows, bodies = len(system.constraint_rows.table), len(system.bodies)
    band = (rows, system.bandwidth + 1)
    return SystemWorkspace(
        row_values=np.zeros((rows, N_ROW_COLUMNS)),
        jacobian=np.zeros((rows, 2, 3)),
        band=np.zeros(band),
        factor=np.zeros(band),
        equal_mass_band=np.zeros(band),
        multipliers=np.zeros(rows),
        multiplier_corrections=np.zeros(rows),
        generalised_forces=np.zeros((bodies, 3)),
        output_row_values=np.zeros((len(system.output_rows.table), N_ROW_COLUMNS)),
        output_jacobian=np.zeros((len(system.output_rows.table), 2, 3)),
        inverse_mass=system.inverse_mass.copy(),
        plane_motion=np.zeros((len(system.planes), N_PLANE_COLUMNS)),
        inputs=np.zeros(system.n_inputs),
        force_elements=system.force_elements.copy(),
        is_armed=np.ones(len(system.event_functions), dtype=np.bool_),
    )


def to_mass_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities of the body origins to those of the mass centres.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    poses
        Poses of the body origins, m and rad; shape (..., bodies, 3).
    velocities
        Their time derivatives; shape (..., bodies, 3).

    Returns
    -------
    poses : FloatArray
        Poses of the mass centres; shape (..., bodies, 3).
    velocities : FloatArray
        Their time derivatives; shape (..., bodies, 3).
    """
    return _shift_reference_points(system, 1.0, poses, velocities)


def from_mass_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities of the mass centres to those of the body origins.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    poses
        Poses of the mass centres, m and rad; shape (..., bodies, 3).
    velocities
        Their time derivatives; shape (..., bodies, 3).

    Returns
    -------
    poses : FloatArray
        Poses of the body origins; shape (..., bodies, 3).
    velocities : FloatArray
        Their time derivatives; shape (..., bodies, 3).
    """
    return _shift_reference_points(system, -1.0, poses, velocities)


def _shift_reference_points(system: System, sign: float, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return poses and velocities of points shifted by the vector from body origin to mass centre (sign 1) or back (-1)."""
    poses, velocities = poses.copy(), velocities.copy()
    arm_x, arm_y = rotate_vector(poses[..., 2], sign * system.bodies["x"], sign * system.bodies["y"])
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def body_reference_point(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """Return the origin of a body in body axes (m): the ground pin of a point mass, else the mass centre."""
    pin = ground_pin_of_point_mass(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own_point = pin.first if pin.first.body == body.name else pin.second
    return own_point.x, own_point.y


def ground_pin_of_point_mass(mechanism: Mechanism, body: Body) -> Pin | None:
    """Return the pin about which a point mass rotates.

    About a pin that joins it to the ground, a point mass has a moment of inertia. The pin does not move, so the coupling of
    rotation and translation in its mass matrix never acts on the motion.

    Parameters
    ----------
    mechanism
        Mechanism with its bodies and joints.
    body
        Body of the mechanism.

    Returns
    -------
    Pin or None
        The pin; None if there is none, or if the body cannot rotate, has no mass, or has a moment of inertia of its own.
    """
    if not body.can_rotate or body.mass == 0 or body.planar_inertia > 0:
        return None
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            own_point = points[body.name]
            if own_point.x != 0.0 or own_point.y != 0.0:
                return joint
    return None


def make_body_record(body: Body, gravity: float, plane: int, origin: tuple[float, float] = (0.0, 0.0)) -> tuple[float, ...]:
    """Return a body as a record of `BODY_DTYPE`, for an origin in body axes (m)."""
    moments = body.second_moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz, gravity, plane)

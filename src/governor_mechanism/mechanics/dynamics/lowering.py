"""A scene as arrays for the compiled kernels: bodies, rows, loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.constraint_solver import bandwidth_reducing_order, find_coupled_rows
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, initial_mode, output_dampers_of, output_springs_of
from governor_mechanism.mechanics.dynamics.force_elements import make_force_element_table
from governor_mechanism.mechanics.dynamics.output_forces import (
    DASHPOT_FORCE,
    EVENT_FUNCTION_DTYPE,
    FORCE_EVENT,
    FRICTION_FORCE,
    OUTPUT_FORCE_DTYPE,
    RATE_EVENT,
    SPRING_FORCE,
    VALUE_EVENT,
)
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import CONSTANT_PARAMETER, make_holding_rows, make_output_rows
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.scene import TURNING_PLANE, FreeSpindle, Scene, Spindle
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.types import FloatArray, IntArray, RecordArray

BODY_DTYPE = np.dtype([(name, "f8") for name in ("mass", "x", "y", "xx", "yy", "xy", "zz")])
"""One body: mass; where the mass centre is from the origin, in body axes; second moments about the mass centre."""


EVENT_ROUNDING_RATIO = 1e-12
"""Of a size, a speed or a force: less is rounding."""


class System(NamedTuple):
    """Rows, loads and pairs as in `rows`, `applied` and `schur`; bodies (bodies,) of BODY, inverse_mass (bodies, 3).

    Coordinates are counted from a body's origin, its mass centre but for a lever. A free spindle has spindle_inertia
    (kg m2) of its own. The last rows hold readings that stick or rest; gauges, acts and watch as in `acting`; a given
    speed swings by `uneven` of itself, `cycles_per_turn` times a turn.
    """

    constraint_rows: ConstraintRows
    force_elements: RecordArray
    row_pairs: IntArray
    bandwidth: int
    bodies: RecordArray
    inverse_mass: FloatArray
    gravity: float
    has_centrifugal_forces: bool
    has_free_spindle: bool
    spindle_inertia: float
    output_rows: ConstraintRows
    output_forces: RecordArray
    event_functions: RecordArray
    fluctuation_amplitude: float
    cycles_per_turn: float


class SystemWorkspace(NamedTuple):
    """Room for one evaluation, so that none is allocated in the loop."""

    row_values: FloatArray
    jacobian: FloatArray
    band: FloatArray
    factor: FloatArray
    multipliers: FloatArray
    generalised_forces: FloatArray
    output_row_values: FloatArray
    output_jacobian: FloatArray


def make_system(scene: Scene, mode: ContactMode | None = None) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """The arrays of a scene of one part, and its programs: the spindle's speed or torque, the drives', the loads'.

    mode says what sticks, rests and pulls; left out, nothing does. Raises MechanismError for a body that has no inertia
    of its own to turn.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    mode = initial_mode(scene) if mode is None else mode
    origins = {body.name: body_reference_point(mechanism, body) for body in mechanism.bodies}
    constraint_table = make_constraint_table(mechanism, origins)
    output_rows = make_output_rows(mechanism, forced_output_names(scene), origins)
    holding_rows = _make_holding_rows(scene, mode, output_rows)
    row_order = _row_order(constraint_table.rows, holding_rows)
    ordered_rows = np.concatenate([constraint_table.rows.table, holding_rows])[row_order]
    rows = ConstraintRows(ordered_rows, bodies_of_rows(ordered_rows), constraint_table.rows.curve_segments)
    rows.table["drive"] += rows.table["drive"] >= 0  # program 0 is the spindle's
    row_pairs = find_coupled_rows(rows.row_bodies)
    force_elements, element_inputs = make_force_element_table(mechanism, origins, 1 + len(constraint_table.motions))
    friction_inputs = [contact.friction for contact in contacts_of(scene) if contact.friction is not None]
    first_friction_input = 1 + len(constraint_table.motions) + len(element_inputs)
    inertias = [_inertia_about_origin(body, origins[body.name]) for body in mechanism.bodies]
    inverse_masses = [
        [1 / body.mass, 1 / body.mass, 1 / inertia if body.can_rotate else 0.0]
        for body, inertia in zip(mechanism.bodies, inertias, strict=True)
    ]
    free_spindle = spindle if isinstance(spindle, FreeSpindle) else None
    system = System(
        constraint_rows=rows,
        force_elements=force_elements,
        row_pairs=row_pairs,
        bandwidth=int(np.max(row_pairs[:, 0] - row_pairs[:, 1], initial=0)),
        bodies=np.array([make_body_record(body, origins[body.name]) for body in mechanism.bodies], dtype=BODY_DTYPE),
        inverse_mass=np.array(inverse_masses),
        gravity=scene.gravity,
        has_centrifugal_forces=scene.has_centrifugal and scene.part.plane == TURNING_PLANE,
        has_free_spindle=free_spindle is not None,
        spindle_inertia=free_spindle.inertia if free_spindle else 0.0,
        output_rows=output_rows,
        output_forces=_make_output_forces(scene, mode, first_friction_input),
        event_functions=_make_event_functions(
            scene, mode, first_friction_input, np.argsort(row_order)[len(constraint_table.joint_indices) :]
        ),
        fluctuation_amplitude=0.5 * spindle.speed_fluctuation if isinstance(spindle, Spindle) else 0.0,
        cycles_per_turn=spindle.cycles_per_turn if isinstance(spindle, Spindle) else 1.0,
    )
    inputs: list[InputFunction | PrescribedMotion] = [spindle.torque if isinstance(spindle, FreeSpindle) else spindle.speed_function]
    inputs += [*constraint_table.motions, *element_inputs, *friction_inputs]
    return system, tuple(map(CubicTimeFunction, inputs))


def forced_output_names(scene: Scene) -> list[str]:
    """The readings along which something acts, in the order of a system's gauges."""
    return list(dict.fromkeys(effect.reading for effect in scene.output_effects))


def count_output_forces(system: System) -> IntArray:
    """(3,) how many loads along readings there are of each kind: springs, brakes, frictions that slide."""
    return np.bincount(system.output_forces["kind"], minlength=3)


def constraint_row_order(scene: Scene, mode: ContactMode | None = None) -> IntArray:
    """(rows,) where each row of a system stands among the joints' rows as `joint_table` lists them, then those held."""
    mechanism = scene.part.mechanism
    output_rows = make_output_rows(mechanism, forced_output_names(scene), {})
    return _row_order(make_constraint_table(mechanism).rows, _make_holding_rows(scene, mode or initial_mode(scene), output_rows))


def _row_order(rows: ConstraintRows, holding_rows: RecordArray) -> IntArray:
    return bandwidth_reducing_order(np.concatenate([rows.row_bodies, bodies_of_rows(holding_rows)]))


def _make_holding_rows(scene: Scene, mode: ContactMode, output_rows: ConstraintRows) -> RecordArray:
    """The rows of what sticks or rests."""
    output_names = forced_output_names(scene)
    held = [
        (output_names.index(contact.output_name), value)
        for contact, value in zip(contacts_of(scene), mode.held_values, strict=True)
        if value is not None
    ]
    return make_holding_rows(output_rows.table, [at for at, _ in held], [value for _, value in held])


def _make_output_forces(scene: Scene, mode: ContactMode, friction_input: int) -> RecordArray:
    """The loads along gauges; the program of the first friction is given."""
    output_names, taut, records = forced_output_names(scene), iter(mode.taut), []
    for spring in output_springs_of(scene):
        if not spring.one_sided or next(taut):
            records.append((SPRING_FORCE, output_names.index(spring.reading), spring.rate, spring.free_value, -1))
    for dashpot in output_dampers_of(scene):
        records.append((DASHPOT_FORCE, output_names.index(dashpot.reading), dashpot.linear, dashpot.quadratic, -1))
    for contact, sign in zip(contacts_of(scene), mode.sliding_signs, strict=True):
        if sign:
            records.append((FRICTION_FORCE, output_names.index(contact.output_name), float(sign), 0.0, friction_input))
        friction_input += contact.friction is not None
    return np.array(records, dtype=OUTPUT_FORCE_DTYPE)


def _make_event_functions(scene: Scene, mode: ContactMode, friction_input: int, held_rows: IntArray) -> RecordArray:
    """What has to be watched in a mode; `about` counts keepers, then one-sided springs."""
    output_names, rows, records = forced_output_names(scene), iter(held_rows.tolist()), []
    tolerances = _OutputTolerances(scene)
    contacts = contacts_of(scene)
    for contact_index, (contact, held, sign) in enumerate(zip(contacts, mode.held_values, mode.sliding_signs, strict=True)):
        output_index = output_names.index(contact.output_name)
        friction_index = friction_input if contact.friction is not None else -1
        friction_input += contact.friction is not None
        if held is not None:
            row = next(rows)
            # A stop pushes off its own side without bound; friction holds either way.
            bounds = ((1.0, held <= contact.low), (-1.0, held >= contact.high))
            records += [
                (FORCE_EVENT, row, direction, 0.0, tolerances.force, friction_index, contact_index)
                for direction, unbounded in bounds
                if not unbounded
            ]
            continue
        if mode.is_locked:
            continue
        if sign:
            records.append((RATE_EVENT, output_index, -float(sign), 0.0, tolerances.rate(contact.output_name), -1, contact_index))
        for direction, bound in ((1.0, contact.high), (-1.0, -contact.low)):
            if np.isfinite(bound):
                records.append((VALUE_EVENT, output_index, direction, bound, tolerances.value(contact.output_name), -1, contact_index))
    one_sided = [] if mode.is_locked else [spring for spring in output_springs_of(scene) if spring.one_sided]
    for contact_index, (spring, taut) in enumerate(zip(one_sided, mode.taut, strict=False), start=len(contacts)):
        direction, output_index = (-1.0 if taut else 1.0), output_names.index(spring.reading)
        records.append(
            (VALUE_EVENT, output_index, direction, direction * spring.free_value, tolerances.value(spring.reading), -1, contact_index)
        )
    return np.array(records, dtype=EVENT_FUNCTION_DTYPE)


def with_held_values(system: System, output_indices: Sequence[int], mode: ContactMode) -> System:
    """The system of a mode that holds the same readings as this one's, but at values of its own.

    gauges are those of the keepers. A value is set anew, not moved on from the last, so that rounding does not add up.
    """
    table = system.constraint_rows.table.copy()
    for k, value in enumerate(mode.held_values):
        if value is not None:
            is_hold = (system.event_functions["kind"] == FORCE_EVENT) & (system.event_functions["contact_index"] == k)
            row, output_row = (int(system.event_functions["source_index"][is_hold][0]), system.output_rows.table[output_indices[k]])
            constant = CONSTANT_PARAMETER[int(output_row["kind"])]
            table[row][constant] = output_row[constant] + value
    return system._replace(constraint_rows=system.constraint_rows._replace(table=table))


class _OutputTolerances:
    """What is rounding in readings, their rates, and forces along them."""

    def __init__(self, scene: Scene) -> None:
        self._mechanism = scene.part.mechanism
        self._time_scale = time_scale(scene)
        mass = sum(body.mass for body in self._mechanism.bodies)
        self.force = EVENT_ROUNDING_RATIO * mass * self._mechanism.length_scale / self._time_scale**2

    def value(self, name: str) -> float:
        length = self._mechanism.reading(name).quantity == "length"
        return EVENT_ROUNDING_RATIO * (self._mechanism.length_scale if length else 1.0)

    def rate(self, name: str) -> float:
        return self.value(name) / self._time_scale


def make_system_workspace(system: System) -> SystemWorkspace:
    """Room for evaluations of this system."""
    rows, bodies = len(system.constraint_rows.table), len(system.bodies)
    band = (rows, system.bandwidth + 1)
    return SystemWorkspace(
        row_values=np.zeros((rows, 5)),
        jacobian=np.zeros((rows, 2, 3)),
        band=np.zeros(band),
        factor=np.zeros(band),
        multipliers=np.zeros(rows),
        generalised_forces=np.zeros((bodies, 3)),
        output_row_values=np.zeros((len(system.output_rows.table), 5)),
        output_jacobian=np.zeros((len(system.output_rows.table), 2, 3)),
    )


def to_mass_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and velocities (..., bodies, 3) of mass centres from those of the origins."""
    return _shift_reference_points(_mass_centre_offsets(system), poses, velocities)


def from_mass_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and velocities (..., bodies, 3) of the origins from those of mass centres."""
    return _shift_reference_points(-_mass_centre_offsets(system), poses, velocities)


def _shift_reference_points(offsets: FloatArray, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    poses, velocities = poses.copy(), velocities.copy()
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    arm_x, arm_y = cosine * offsets[:, 0] - sine * offsets[:, 1], sine * offsets[:, 0] + cosine * offsets[:, 1]
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def body_reference_point(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """From where a body's coordinates are counted, in its own axes (m): the pin of a lever, else the mass centre."""
    pin = ground_pin_of_point_mass(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own_point = pin.first if pin.first.body == body.name else pin.second
    return own_point.x, own_point.y


def ground_pin_of_point_mass(mechanism: Mechanism, body: Body) -> Pin | None:
    """The pin of a lever; None for other bodies. Raises MechanismError for a body that has no inertia to turn with.

    A lever is a body whose mass is in one point and that a pin holds to the ground: about that pin it has inertia. The
    pin stands still, so the mass's coupling between turning and moving never acts on the motion.
    """
    if not body.can_rotate or body.second_moments.xx + body.second_moments.yy > 0:
        return None
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            own_point = points[body.name]
            if own_point.x != 0.0 or own_point.y != 0.0:
                return joint
    raise MechanismError(
        f"body {body.name!r} cannot turn: its mass is in one point, and no pin beside that point joins it to ground; "
        "give it second moments, or turns=False"
    )


def _mass_centre_offsets(system: System) -> FloatArray:
    """(bodies, 2) m: where mass centres are from the origins, in body axes."""
    return np.stack([system.bodies["x"], system.bodies["y"]], axis=-1)


def make_body_record(body: Body, origin: tuple[float, float] = (0.0, 0.0)) -> tuple[float, ...]:
    """A body as a record of BODY, its coordinates counted from an origin (body axes, m)."""
    moments = body.second_moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz)


def _inertia_about_origin(body: Body, origin: tuple[float, float]) -> float:
    return body.second_moments.xx + body.second_moments.yy + body.mass * (origin[0] ** 2 + origin[1] ** 2)

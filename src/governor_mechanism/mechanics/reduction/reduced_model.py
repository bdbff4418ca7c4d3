"""The reduced model as records: its state, its shaft, and the layouts of its contact mode and its event functions."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows, rows_of_readings
from governor_mechanism.mechanics.reduction.table import PiecewiseTable
from governor_mechanism.model.joints import GROUND, Gear, Pin
from governor_mechanism.model.part import FIXED_PLANE, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place, record_dtype
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray, RecordArray


@dataclass(frozen=True, kw_only=True)
class ShaftTrain:
    """Bodies geared to one shaft, itself included; without bodies if there is no shaft."""

    rotors: tuple[str, ...]  # names of all bodies that only rotate
    # ratio to the shaft, and angle (rad) where that of the shaft is zero, of each body that turns with it;
    # the shaft is the first
    motion: dict[str, tuple[float, float]]
    spindle_ratio: float  # ratio of the spindle speed to that of the shaft; 0 if the speed of the spindle is given
    has_reaction: bool  # whether the bodies of the turning plane act on the shaft

    def ratio(self, body: str) -> float:
        """Return the ratio of a body to the shaft; 0 for the ground."""
        return self.motion.get(body, (0.0, 0.0))[0]


def parts_with_coordinate(scene: Scene) -> list[tuple[str, Part]]:
    """Return prefix and part of all parts that are more than a shaft."""
    if len(scene.parts) == 1:
        return [("", scene.part)]
    return [(f"{part.name}.", part) for part in scene.parts if not _is_shaft(part)]


def _is_shaft(part: Part) -> bool:
    """Return whether each body of a part in a fixed plane is pinned to the ground at its mass centre, and nothing else joins them."""
    joints = part.mechanism.joints
    pinned = [point for joint in joints if isinstance(joint, Pin) for point in (joint.first, joint.second) if point.body != GROUND]
    return (
        part.plane == FIXED_PLANE
        and all(isinstance(joint, Pin) or (isinstance(joint, Gear) and not joint.is_carried) for joint in joints)
        and sorted(point.body for point in pinned) == sorted(body.name for body in part.mechanism.bodies)
        and all(point.x == point.y == 0.0 for point in pinned)
    )


def find_shaft_train(scene: Scene) -> ShaftTrain:
    """Return the shaft of a scene, which the spindle turns with unless its speed is given."""
    mechanism, (prefix, part) = scene.mechanism, parts_with_coordinate(scene)[0]
    moving = {prefix + body.name for body in part.mechanism.bodies}
    rotors = tuple(body.name for body in mechanism.bodies if body.name not in moving)
    plane = next((plane for plane in scene.system.planes if plane.shaft), None)
    motion = {name: (1.0, 0.0) for name in ([plane.shaft] if plane else rotors[:1])}
    gears = [joint for joint in mechanism.joints if isinstance(joint, Gear) and not {joint.first.body, joint.second.body} & moving]
    for _ in rotors:
        for gear in gears:
            first, second = gear.first.body, gear.second.body
            if first in motion:
                ratio, angle = motion[first]
                motion.setdefault(second, (gear.ratio * ratio, gear.ratio * angle + gear.offset))
            elif second in motion:
                ratio, angle = motion[second]
                motion[first] = ratio / gear.ratio, (angle - gear.offset) / gear.ratio
    return ShaftTrain(
        rotors=rotors, motion=motion, spindle_ratio=plane.ratio if plane else 0.0, has_reaction=plane is not None and plane.has_reaction
    )


def shaft_readings(scene: Scene, train: ShaftTrain) -> set[str]:
    """Return the names of the readings that are functions of the angle of the shaft: angles, travels of the bodies that turn with it."""
    mechanism, (prefix, part) = scene.mechanism, parts_with_coordinate(scene)[0]
    own = {prefix + reading.name for reading in part.mechanism.readings}
    readings = [reading for reading in mechanism.readings if reading.name not in own]
    if not readings:
        return set()
    rotors = [mechanism.body_index(body) for body in train.motion]
    bodies = rows_of_readings(mechanism, readings, {}).row_bodies
    follows_shaft = (np.isin(bodies, rotors) | (bodies == GROUND_INDEX)).all(axis=1) & (bodies != GROUND_INDEX).any(axis=1)
    return {readings[k].name for k in np.flatnonzero(follows_shaft)}


class ShaftOutputs(NamedTuple):
    """Output rows of bodies on the shaft, and the arrays of their evaluation."""

    rows: ConstraintRows  # the output rows
    # poses of the mass centres where the angle of the shaft is zero, m and rad; shape (bodies, 3), or (0, 3)
    # without rows
    poses: FloatArray
    tangents: FloatArray  # their derivatives by the angle of the shaft, with the shape of `poses`
    turned_poses: FloatArray  # poses at the last evaluation, with the shape of `poses`
    row_values: FloatArray  # values of the rows at the last evaluation; shape (rows, columns)
    jacobian: FloatArray  # derivatives of the rows by the poses of both bodies there; shape (rows, 2, 3)
    derivatives: FloatArray  # derivatives of the rows by the angle of the shaft there, m/rad or 1; shape (rows,)

    def with_own_results(self) -> "ShaftOutputs":
        """Return the outputs with arrays of their own for the results of an evaluation."""
        results = (np.zeros_like(array) for array in (self.turned_poses, self.row_values, self.jacobian, self.derivatives))
        return ShaftOutputs(self.rows, self.poses, self.tangents, *results)


def lower_shaft_outputs(
    scene: Scene,
    train: ShaftTrain,
    names: Sequence[str],  # names of the readings, in the order of the outputs
) -> ShaftOutputs:
    """Return the outputs of bodies on the shaft."""
    mechanism = scene.mechanism
    poses, tangents = np.zeros((2, len(mechanism.bodies) if names else 0, 3))
    for joint in mechanism.joints:
        points = {point.body: point for point in (joint.first, joint.second)} if isinstance(joint, Pin) else {}
        for body in points.keys() & train.motion.keys() if GROUND in points and names else ():
            poses[mechanism.body_index(body), :2] = points[GROUND].x, points[GROUND].y
    for body, (ratio, angle) in train.motion.items() if names else ():
        index = mechanism.body_index(body)
        poses[index, 2], tangents[index, 2] = angle, ratio
    rows, n_rows = make_output_rows(mechanism, names, {}), len(names)
    results = np.zeros_like(poses), np.zeros((n_rows, N_ROW_COLUMNS)), np.zeros((n_rows, 2, 3)), np.zeros(n_rows)
    return ShaftOutputs(rows, poses, tangents, *results)


@jit_in_place
def evaluate_shaft_outputs(
    outputs: ShaftOutputs,
    angle: float,  # angle of the shaft, rad
) -> None:
    """Evaluate the outputs at an angle of the shaft (rad) into their arrays."""
    if outputs.rows.table.size == 0:
        return
    for k in range(outputs.poses.shape[0]):
        for c in range(3):
            outputs.turned_poses[k, c] = outputs.poses[k, c] + angle * outputs.tangents[k, c]
    evaluate_rows(outputs.rows, outputs.turned_poses, outputs.tangents, outputs.row_values, outputs.jacobian)
    for i in range(outputs.derivatives.size):
        outputs.derivatives[i] = output_rate(outputs.rows, outputs.jacobian, i, outputs.tangents)


class ModeLayout(NamedTuple):
    """First index of each part of a contact mode, in their order."""

    held: int  # whether the mechanism is held at rest
    contacts: int  # state of each contact: 1, -1, 0 or HELD, see `mechanics.contact.rules`
    springs: int  # whether each one-sided spring is taut
    tables: int  # segment of each table of a reading
    kinks: int  # whether each kink is monitored


class EventLayout(NamedTuple):
    """First index of each kind of event function, in their order."""

    sticks: int  # rate of each contact, against its sliding
    high_stops: int  # value of each contact beyond its high stop
    low_stops: int  # value of each contact beyond its low stop
    springs: int  # elongation of each one-sided spring, or its negative value while it is taut
    release_up: int  # static force upwards beyond what holds the mechanism
    release_down: int  # static force downwards beyond that
    table_ends: int  # value of each table beyond the upper and the lower end of its segment, in turn
    kinks: int  # those of gas


def lay_out_mode(n_contacts: int, n_springs: int, n_tables: int) -> ModeLayout:
    """Return the layout of a contact mode."""
    contacts = 1
    springs = contacts + n_contacts
    tables = springs + n_springs
    return ModeLayout(held=0, contacts=contacts, springs=springs, tables=tables, kinks=tables + n_tables)


def lay_out_events(n_contacts: int, n_springs: int, n_tables: int) -> EventLayout:
    """Return the layout of the event functions."""
    high_stops = n_contacts
    low_stops = high_stops + n_contacts
    springs = low_stops + n_contacts
    release_up = springs + n_springs
    table_ends = release_up + 2
    return EventLayout(
        sticks=0,
        high_stops=high_stops,
        low_stops=low_stops,
        springs=springs,
        release_up=release_up,
        release_down=release_up + 1,
        table_ends=table_ends,
        kinks=table_ends + 2 * n_tables,
    )


COORDINATE = -2
"""Index that stands for the coordinate among those of outputs."""


class StateIndex(IntEnum):
    """Indices in a state of the reduced model."""

    COORDINATE = 0
    RATE = 1
    WORK = 2
    """Work as in `StateHistory`, J."""
    DISSIPATED_ENERGY = 3
    """The dissipated part of the work, J."""
    SHAFT_ANGLE = 4
    """Angle of the shaft, rad; constant without one."""
    SHAFT_SPEED = 5
    """Its rate, rad/s."""


N_STATES = len(StateIndex)
"""Number of states."""

N_FURTHER_STATES = N_STATES - 2
"""Number of states after the coordinate and its rate, which a conservative model has none of."""

MODEL_PARAMETERS_DTYPE = record_dtype(
    ("is_conservative", "i8"),  # whether the quadratic and the potential column hold all forces
    ("is_spindle_loaded", "i8"),  # whether a change of the spindle speed loads the bodies
    ("has_shaft", "i8"),  # whether a shaft turns freely, so that its angle and speed are states
    ("has_reaction", "i8"),  # whether the bodies in the turning plane act on the shaft
    ("n_loads", "i8"),  # number of inputs of force elements
    ("first_load_input", "i8"),  # the first input of force elements that act along the coordinate
    ("n_outputs", "i8"),  # number of outputs in the table
    ("n_tables", "i8"),  # number of tables of readings
    ("spindle_ratio", "f8"),  # ratio of the spindle speed to that of the shaft; 0 if the spindle speed is given
    ("shaft_inertia", "f8"),  # moment of inertia of all bodies that only rotate, at the speed of the shaft, kg m2
    ("shaft_damping", "f8"),  # coefficient of the torsion dampers on the shaft, N m s/rad
    ("fluctuation_amplitude", "f8"),  # relative amplitude of the fluctuation of a given spindle speed
    ("cycles_per_turn", "f8"),  # cycles of that fluctuation per turn
    ("min_rate", "f8"),  # rate of the coordinate below which the integration ends
    ("stall_ratio", "f8"),  # ratio to the shaft of a body on it with which the integration ends where it turns back, or 0
    ("coordinate_scale", "f8"),  # scale of the coordinate, m or rad
    ("time_scale", "f8"),  # characteristic time, s
    ("energy_scale", "f8"),  # scale of energies, J
    ("force_scale", "f8"),  # scale of generalised forces along the coordinate
)
"""Scalars of a reduced model."""

ONE_SIDED_SPRING_DTYPE = record_dtype(
    ("output_index", "i8"),  # the output along which it acts
    ("slack_below", "f8"),  # value of the output below which it is slack
    ("scale", "f8"),  # scale of the output
)
"""A spring that goes slack instead of pushing."""

SHAFT_TORQUE_DTYPE = record_dtype(
    ("input_index", "i8"),  # its input, N m
    ("ratio", "f8"),  # speed relative to that of the shaft of what it acts on
)
"""A torque on the shaft that an input gives."""


class ReducedModel(NamedTuple):
    """The motion table and the forces along it; few arrays, because each one adds to the cost of a kernel call."""

    # coefficients, intervals, neighbours, periodicity: as in `PiecewiseTable`
    coefficients: FloatArray
    intervals: FloatArray
    neighbours: IntArray
    periodicity: FloatArray
    parameters: RecordArray  # record of `MODEL_PARAMETERS_DTYPE`; shape (1,)
    one_sided_springs: RecordArray  # records of `ONE_SIDED_SPRING_DTYPE`; shape (springs,)
    # force laws that the table does not contain, records of `OUTPUT_FORCE_DTYPE`. Outputs are counted from
    # those of the table on; an index of COORDINATE is the coordinate.
    output_forces: RecordArray
    contacts: RecordArray  # records of `CONTACT_DTYPE`; shape (contacts,)
    shaft_torques: RecordArray  # records of `SHAFT_TORQUE_DTYPE`
    shaft_forces: RecordArray  # gas on the shaft, like `output_forces`
    shaft_outputs: ShaftOutputs  # outputs of bodies on the shaft along which gas acts or on which loads depend
    kinks: RecordArray  # kinks of gas, records of `EVENT_FUNCTION_DTYPE`; shape (kinks,)
    table_segments: RecordArray  # segments of all tables of readings, records of `TABLE_SEGMENT_DTYPE`
    input_terms: RecordArray  # records of `INPUT_TERM_DTYPE`; those of tables are set where a segment begins
    inputs: FloatArray  # values of the inputs at the last evaluation; shape (inputs,)
    mode_layout: ModeLayout  # layout of the contact mode
    event_layout: EventLayout  # layout of the event functions
    # cubics of the inputs in local time, highest power first, then the integral at local time 0; shape
    # (inputs, 5)
    input_cubics: FloatArray
    mode: IntArray  # contact mode, see `ModeLayout`

    def with_own_results(self) -> "ReducedModel":
        """Return the model with arrays of its own for what an integration changes."""
        return self._replace(
            output_forces=self.output_forces.copy(),
            shaft_forces=self.shaft_forces.copy(),
            shaft_outputs=self.shaft_outputs.with_own_results(),
            input_terms=self.input_terms.copy(),
            inputs=np.zeros_like(self.inputs),
        )

    def on_table(self, table: PiecewiseTable, input_cubics: FloatArray, mode: IntArray) -> "ReducedModel":
        """Return the model along a motion table, with cubics of its inputs (inputs, 5) and a contact mode."""
        return self._replace(
            coefficients=table.coefficients,
            intervals=table.intervals,
            neighbours=table.neighbours,
            periodicity=table.periodicity,
            input_cubics=input_cubics,
            mode=mode,
        )

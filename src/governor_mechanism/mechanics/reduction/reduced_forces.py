"""Arrays of the forces along the coordinate and on the shaft of the reduced model."""

from enum import IntEnum
from typing import NamedTuple

from governor_mechanism.mechanics.dynamics.forces.output_forces import MAX_COEFFICIENTS
from governor_mechanism.mechanics.reduction.shaft_outputs import ShaftOutputs
from governor_mechanism.types import FloatArray, RecordArray

COORDINATE = -2
"""Index that stands for the coordinate among those of outputs."""


class ModeLayout(NamedTuple):
    """First index of each part of a contact mode, in their order.

    Attributes
    ----------
    held
        Whether the mechanism is held at rest.
    contacts
        State of each contact: 1, -1, 0 or HELD, see `mechanics.contact.rules`.
    springs
        Whether each one-sided spring is taut.
    tables
        Segment of each table of a reading.
    kinks
        Whether each kink is monitored.
    phases
        Phase of the cycle that each gas is kept in, or IN_NO_PHASE.
    """

    held: int
    contacts: int
    springs: int
    tables: int
    kinks: int
    phases: int


class EventLayout(NamedTuple):
    """First index of each kind of event function, in their order.

    Attributes
    ----------
    sticks
        Rate of each contact, against its sliding.
    high_stops
        Value of each contact beyond its high stop.
    low_stops
        Value of each contact beyond its low stop.
    springs
        Elongation of each one-sided spring, or its negative value while it is taut.
    release_up
        Static force upwards beyond what holds the mechanism.
    release_down
        Static force downwards beyond that.
    table_ends
        Value of each table beyond the upper and the lower end of its segment, in turn.
    kinks
        Those of gas.
    """

    sticks: int
    high_stops: int
    low_stops: int
    springs: int
    release_up: int
    release_down: int
    table_ends: int
    kinks: int


def lay_out_mode(n_contacts: int, n_springs: int, n_tables: int, n_kinks: int) -> ModeLayout:
    """Return the layout of a contact mode."""
    contacts = 1
    springs = contacts + n_contacts
    tables = springs + n_springs
    kinks = tables + n_tables
    return ModeLayout(held=0, contacts=contacts, springs=springs, tables=tables, kinks=kinks, phases=kinks + n_kinks)


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


class ReducedForces(NamedTuple):
    """The forces along the output columns of the motion table; few arrays, because each one adds to the cost of a kernel call.

    Attributes
    ----------
    parameters
        Scalars, indexed by `ForceParameter`.
    one_sided_springs
        Springs that go slack instead of pushing: output index, value below which they are slack, output scale; shape (n, 3).
    output_forces
        Force laws that the table does not contain, by `OutputForceColumn`; shape (n, columns).
    contacts
        Records of `CONTACT_DTYPE`; shape (contacts,).
    shaft_torques
        Input of each torque on the shaft, and its ratio to the shaft; shape (n, 2).
    shaft_forces
        Gas on the shaft, like `output_forces`; shape (n, columns).
    shaft_outputs
        Outputs of bodies on the shaft along which gas acts or on which loads depend. Outputs are counted from those of the table on.
    kinks
        Kinks of gas, records of `EVENT_FUNCTION_DTYPE`; an index of COORDINATE is the coordinate; shape (kinks,).
    table_segments
        Segments of all tables of readings, records of `TABLE_SEGMENT_DTYPE`.
    input_terms
        Records of `INPUT_TERM_DTYPE`; those of tables are set where a segment begins.
    inputs
        Values of the inputs at the last evaluation; shape (inputs,).
    mode_layout
        Layout of the contact mode.
    event_layout
        Layout of the event functions.
    """

    parameters: FloatArray
    one_sided_springs: FloatArray
    output_forces: FloatArray
    contacts: RecordArray
    shaft_torques: FloatArray
    shaft_forces: FloatArray
    shaft_outputs: ShaftOutputs
    kinks: RecordArray
    table_segments: RecordArray
    input_terms: RecordArray
    inputs: FloatArray
    mode_layout: ModeLayout
    event_layout: EventLayout


class OutputForceColumn(IntEnum):
    """Columns of `ReducedForces.output_forces`."""

    OUTPUT = 0
    """Index of the output."""
    LAW = 1
    """Index of the force law in `FORCE_LAWS`."""
    DISSIPATES = 2
    """Whether the force dissipates energy."""
    MODE = 3
    """Index in the contact mode of whether a one-sided spring is taut; NO_INDEX for a force that always acts."""
    CRANK_ANGLE = 4
    """Output that is the crank angle of a gas, or COORDINATE."""
    PHASE = 5
    """Index in the contact mode of the phase of the cycle that a gas is kept in, or IN_NO_PHASE; NO_INDEX for other forces."""
    INPUT = 6
    """Input by which the force is multiplied, or NO_INDEX."""
    FIRST_COEFFICIENT = 7
    """From here on the coefficients of the law."""


N_OUTPUT_FORCE_COLUMNS = OutputForceColumn.FIRST_COEFFICIENT + MAX_COEFFICIENTS
"""Number of columns of `ReducedForces.output_forces`."""


class ForceParameter(IntEnum):
    """Indices of `ReducedForces.parameters`."""

    IS_SPINDLE_LOADED = 0
    """Whether a change of the spindle speed loads the bodies."""
    SPINDLE_RATIO = 1
    """Ratio of the spindle speed to that of the shaft; 0 if the spindle speed is given."""
    SHAFT_INERTIA = 2
    """Moment of inertia of all bodies that only rotate, at the speed of the shaft, kg m2."""
    FLUCTUATION_AMPLITUDE = 3
    """Relative amplitude of the fluctuation of a given spindle speed."""
    CYCLES_PER_TURN = 4
    """Cycles of that fluctuation per turn."""
    FORCE_SCALE = 5
    """Scale of generalised forces along the coordinate."""
    IS_CONSERVATIVE = 6
    """Whether the quadratic and the potential column hold all forces."""
    LOAD_COUNT = 7
    """Number of inputs of force elements."""
    COORDINATE_SCALE = 8
    """Scale of the coordinate, m or rad."""
    TIME_SCALE = 9
    """Characteristic time, s."""
    ENERGY_SCALE = 10
    """Scale of energies, J."""
    HAS_SHAFT = 11
    """Whether a shaft turns freely, so that its angle and speed are states."""
    HAS_REACTION = 12
    """Whether the bodies in the turning plane act on the shaft."""
    SHAFT_DAMPING = 13
    """Coefficient of the torsion dampers on the shaft, N m s/rad."""
    FIRST_LOAD_INPUT = 14
    """Index of the first input of force elements that act along the coordinate."""
    OUTPUT_COUNT = 15
    """Number of outputs in the table."""
    MIN_RATE = 16
    """Rate of the coordinate below which the integration ends."""
    STALL_RATIO = 17
    """Ratio to the shaft of a body on it with which the integration ends where it turns back, or 0."""
    TABLE_COUNT = 18
    """Number of tables of readings."""

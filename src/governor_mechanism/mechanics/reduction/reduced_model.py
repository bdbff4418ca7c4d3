"""The reduced model as arrays, and its state: a motion table, the forces along it, inputs and contact mode."""

from enum import IntEnum
from typing import NamedTuple

from governor_mechanism.mechanics.reduction.reduced_forces import EventLayout, ModeLayout, ReducedForces
from governor_mechanism.mechanics.reduction.shaft_outputs import ShaftOutputs
from governor_mechanism.mechanics.reduction.table import PiecewiseTable
from governor_mechanism.types import FloatArray, IntArray, RecordArray


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


class ReducedModel(NamedTuple):
    """The motion table and the forces along it, in few arrays; see `PiecewiseTable` and `ReducedForces`.

    Attributes
    ----------
    coefficients
        As in `PiecewiseTable`.
    intervals
        As in `PiecewiseTable`.
    neighbours
        As in `PiecewiseTable`.
    periodicity
        As in `PiecewiseTable`.
    parameters
        As in `ReducedForces`.
    one_sided_springs
        As in `ReducedForces`.
    output_forces
        As in `ReducedForces`.
    contacts
        As in `ReducedForces`.
    shaft_torques
        As in `ReducedForces`.
    shaft_forces
        As in `ReducedForces`.
    shaft_outputs
        As in `ReducedForces`.
    kinks
        As in `ReducedForces`.
    table_segments
        As in `ReducedForces`.
    input_terms
        As in `ReducedForces`.
    inputs
        As in `ReducedForces`.
    mode_layout
        As in `ReducedForces`.
    event_layout
        As in `ReducedForces`.
    input_cubics
        Cubics of the inputs in local time, highest power first, then the integral at local time 0; shape (inputs, 5).
    mode
        Contact mode, see `ModeLayout`.
    """

    coefficients: FloatArray
    intervals: FloatArray
    neighbours: IntArray
    periodicity: FloatArray
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
    input_cubics: FloatArray
    mode: IntArray


def make_reduced_model(table: PiecewiseTable, forces: ReducedForces, input_cubics: FloatArray, mode: IntArray) -> ReducedModel:
    """Combine a table, its forces and the inputs to a reduced model.

    Parameters
    ----------
    table
        The motion table.
    forces
        The forces along the coordinate.
    input_cubics
        Inputs from the local time 0 on; shape (inputs, 5).
    mode
        Contact mode, see `ModeLayout`.

    Returns
    -------
    ReducedModel
        The arrays that the kernels read.
    """
    return ReducedModel(table.coefficients, table.intervals, table.neighbours, table.periodicity, *forces, input_cubics, mode)

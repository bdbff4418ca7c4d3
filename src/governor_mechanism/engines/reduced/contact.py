"""Contacts of the reduced model: their motion from the table, their transition, and their event functions; compiled.

An event is an upward zero crossing of an event function.
"""

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.equation import INACTIVE_EVENT_VALUE
from governor_mechanism.mechanics.contact.impacts import dissipated_by_impulses
from governor_mechanism.mechanics.contact.rules import HELD, ContactDynamics, find_touched_stop
from governor_mechanism.mechanics.contact.tolerances import REST_TOLERANCE
from governor_mechanism.mechanics.contact.transition import EventLog, make_transition
from governor_mechanism.mechanics.dynamics.event_functions import evaluate_event_function
from governor_mechanism.mechanics.dynamics.inputs import EVENT_ROUNDING_RATIO
from governor_mechanism.mechanics.dynamics.output_forces import IN_NO_PHASE, evaluate_gas_phase
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    evaluate_output,
    evaluate_output_rate,
    evaluate_output_second_derivative,
    evaluate_state_rates,
    evaluate_static_force,
    evaluate_table_output,
    friction_limit,
)
from governor_mechanism.mechanics.reduction.lagrangian import TableColumn
from governor_mechanism.mechanics.reduction.reduced_model import ReducedModel, StateIndex, evaluate_shaft_outputs
from governor_mechanism.mechanics.reduction.table import ON_TABLE, find_piece
from governor_mechanism.numerics.interpolation import evaluate_piece
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray


class ReducedState(NamedTuple):
    """State of a reduced model at a local time (s), with its place in the table."""

    model: ReducedModel
    piece: int
    t: float
    local_time: float
    state: FloatArray


@jit
def evaluate_reduced_contacts(place: ReducedState) -> ContactDynamics:
    """Return the motion of the outputs with contacts or one-sided springs."""
    model = place.model
    piece = place.piece
    t = place.t
    rate = place.state[1]
    n_contacts = model.contacts.size
    n_springs = model.one_sided_springs.size
    parameters = model.parameters[0]
    angle = place.state[StateIndex.SHAFT_ANGLE]
    speed = place.state[StateIndex.SHAFT_SPEED]
    acceleration = evaluate_state_rates(model, piece, t, rate, angle, speed, place.local_time, False).acceleration
    values = np.empty(n_contacts)
    derivatives = np.empty(n_contacts)
    accelerations = np.empty(n_contacts)
    limits = np.empty(n_contacts)
    for k in range(n_contacts):
        output = model.contacts[k].output_index
        values[k], derivatives[k] = evaluate_table_output(model, piece, t, output)
        accelerations[k] = derivatives[k] * acceleration + evaluate_output_second_derivative(model, piece, t, output) * rate * rate
        limits[k] = friction_limit(model, k)
    stretches, stretch_rates = np.empty(n_springs), np.empty(n_springs)
    for i in range(n_springs):
        spring = model.one_sided_springs[i]
        value, derivative = evaluate_table_output(model, piece, t, spring.output_index)
        stretches[i] = (value - spring.slack_below) / spring.scale
        stretch_rates[i] = derivative * rate / spring.scale
    inverse_inertia = evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    compliance = np.empty((n_contacts, n_contacts))
    for i in range(n_contacts):
        for k in range(n_contacts):
            compliance[i, k] = derivatives[i] * derivatives[k] * inverse_inertia
    return ContactDynamics(
        model.contacts, values, derivatives * rate, accelerations, compliance, limits, stretches, stretch_rates,
        parameters.time_scale, parameters.energy_scale, 1, False,
    )  # fmt: skip


@jit_in_place
def apply_reduced_impulses(place: ReducedState, dynamics: ContactDynamics, impulses: FloatArray) -> None:
    """Change the rate of the coordinate by impulses along the outputs."""
    model, state = place.model, place.state
    inverse_inertia = evaluate_piece(model.coefficients, place.piece, TableColumn.INVERSE_INERTIA, place.t)
    for k in range(impulses.size):
        derivative = evaluate_table_output(model, place.piece, place.t, model.contacts[k].output_index)[1]
        state[1] += inverse_inertia * derivative * impulses[k]
    dissipated_energy = dissipated_by_impulses(dynamics, impulses)
    state[StateIndex.WORK] += dissipated_energy
    state[StateIndex.DISSIPATED_ENERGY] += dissipated_energy


change_contact_states = jit(make_transition(evaluate_reduced_contacts, apply_reduced_impulses))


@jit
def apply_transition(
    model: ReducedModel, time: float, local_time: float, piece_guess: int, is_released: bool, state: FloatArray, log: EventLog
) -> None:
    """Update contact mode and state after events; `is_released`: the force exceeds what can be held."""
    piece, t, _ = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_guess)
    layout = model.mode_layout
    states = model.mode[layout.contacts : layout.springs]
    are_taut = model.mode[layout.springs : layout.tables]
    released = np.full(states.size, is_released)
    change_contact_states(ReducedState(model, piece, t, local_time, state), states, are_taut, released, time, log)
    is_held = np.any(states == HELD)
    model.mode[layout.held] = is_held
    if is_held:
        state[1] = 0.0


def make_event_tolerances(model: ReducedModel) -> FloatArray:
    """Return the rounding of the event functions in their order, see `EventLayout`; none where nothing has events."""
    begins_table = np.isneginf(model.table_segments["low"])
    if not model.contacts.size and not model.one_sided_springs.size and not begins_table.any() and not model.kinks.size:
        return np.zeros(0)
    scales, parameters = model.contacts["scale"], model.parameters[0]
    contact_scales = scales / parameters["time_scale"], scales, scales
    force_scales = np.full(2, parameters["force_scale"])
    tolerances = EVENT_ROUNDING_RATIO * np.concatenate([*contact_scales, model.one_sided_springs["scale"], force_scales])
    return np.concatenate([tolerances, np.repeat(model.table_segments["tolerance"][begins_table], 2), model.kinks["tolerance"]])


@jit_in_place
def set_table_terms(model: ReducedModel) -> None:
    """Set the terms of the inputs to the segments of tables in the contact mode."""
    for k in range(model.parameters[0].n_tables):
        segment = model.table_segments[model.mode[model.mode_layout.tables + k]]
        term = model.input_terms[segment.term_index]
        term.a, term.b, term.c = segment.a, segment.b, segment.c


@jit_in_place
def change_table_segments(model: ReducedModel, event_values: FloatArray) -> None:
    """Let tables whose event functions are positive go on to the next segment."""
    for k in range(model.parameters[0].n_tables):
        upper_end = model.event_layout.table_ends + 2 * k
        is_above = event_values[upper_end] > 0.0
        is_below = event_values[upper_end + 1] > 0.0
        model.mode[model.mode_layout.tables + k] += int(is_above) - int(is_below)
    set_table_terms(model)


@jit_in_place
def _evaluate_table_ends(model: ReducedModel, piece: int, t: float, state: FloatArray, event_values: FloatArray) -> None:
    """Fill the event functions at the ends of the segments of tables."""
    for k in range(model.parameters[0].n_tables):
        segment = model.table_segments[model.mode[model.mode_layout.tables + k]]
        upper_end = model.event_layout.table_ends + 2 * k
        value = evaluate_output(model, piece, t, segment.source_index)[0]
        if segment.is_rate:
            value = evaluate_output_rate(model, piece, t, segment.source_index, state[1], state[StateIndex.SHAFT_SPEED])
        if segment.high < math.inf:
            event_values[upper_end] = value - segment.high
        if segment.low > -math.inf:
            event_values[upper_end + 1] = segment.low - value


@jit_in_place
def _evaluate_kinks(model: ReducedModel, piece: int, t: float, event_values: FloatArray) -> None:
    """Fill the event functions of the kinks that are monitored."""
    for i in range(model.kinks.size):
        kink, argument = model.kinks[i], 0.0
        if model.mode[model.mode_layout.kinks + i] != 0:
            if kink.argument_index != NO_INDEX:
                argument = evaluate_output(model, piece, t, kink.argument_index)[0]
            value = evaluate_output(model, piece, t, kink.source_index)[0]
            event_values[model.event_layout.kinks + i] = evaluate_event_function(model.kinks, i, value, argument, 0.0)


@jit_in_place
def _keep_phases(model: ReducedModel, forces: RecordArray, piece: int, t: float) -> None:
    """Keep the gases among some forces in their present phases of the cycle."""
    for i in range(forces.size):
        gas = forces[i]
        if gas.argument_index != NO_INDEX:
            travel = evaluate_output(model, piece, t, gas.output_index)[0]
            crank_angle = evaluate_output(model, piece, t, gas.argument_index)[0]
            gas.phase = int(evaluate_gas_phase(gas.coefficients, travel, crank_angle))


@jit_in_place
def find_blocked_directions(model: ReducedModel, piece_index: int, t: float) -> tuple[bool, bool]:
    """Return whether stops block an increase, and a decrease, of the coordinate."""
    up_blocked = down_blocked = False
    for k in range(model.contacts.size):
        value, output_derivative = evaluate_table_output(model, piece_index, t, model.contacts[k].output_index)
        outward_derivative = find_touched_stop(model.contacts, k, value, REST_TOLERANCE) * output_derivative
        up_blocked = up_blocked or outward_derivative > 0.0
        down_blocked = down_blocked or outward_derivative < 0.0
    return up_blocked, down_blocked


@jit_in_place
def is_jammed(model: ReducedModel, coordinate: float, piece_guess: int) -> bool:
    """Return whether friction presses what is held more than it lets it yield (Painleve): rigid bodies do not determine how it goes on."""
    piece, t, _ = find_piece(model.intervals, model.neighbours, model.periodicity, coordinate, piece_guess)
    first, contacts = model.mode_layout.contacts, model.contacts
    for k in range(contacts.size):
        normal, sign = contacts[k].normal, model.mode[first + k]
        if normal != NO_INDEX and model.mode[first + normal] == HELD and sign != HELD:
            by_normal = evaluate_table_output(model, piece, t, contacts[normal].output_index)[1]
            by_tangent = evaluate_table_output(model, piece, t, contacts[k].output_index)[1]
            if by_normal * (by_normal - sign * contacts[k].friction_coefficient * by_tangent) <= 0.0:
                return True
    return False


@jit_in_place
def evaluate_reduced_event_functions(
    model: ReducedModel, state: FloatArray, local_time: float, piece_guess: int, event_values: FloatArray
) -> None:
    """Fill the event functions at a state; inactive outside the table."""
    event_values[:] = INACTIVE_EVENT_VALUE
    piece, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_guess)
    if side != ON_TABLE:
        return
    layout = model.event_layout
    evaluate_shaft_outputs(model.shaft_outputs, state[StateIndex.SHAFT_ANGLE])
    _evaluate_table_ends(model, piece, t, state, event_values)
    _evaluate_kinks(model, piece, t, event_values)
    if model.mode[model.mode_layout.held] != 0:
        force, resistance = evaluate_static_force(model, piece, t, state, local_time)
        up_blocked, down_blocked = find_blocked_directions(model, piece, t)
        if not up_blocked:
            event_values[layout.release_up] = force - resistance
        if not down_blocked:
            event_values[layout.release_down] = -force - resistance
        return
    for k in range(model.contacts.size):
        value, output_derivative = evaluate_table_output(model, piece, t, model.contacts[k].output_index)
        sliding_sign = model.mode[model.mode_layout.contacts + k]
        if sliding_sign != 0:
            event_values[layout.sticks + k] = -sliding_sign * output_derivative * state[StateIndex.RATE]
        if model.contacts[k].high < math.inf:
            event_values[layout.high_stops + k] = value - model.contacts[k].high
        if model.contacts[k].low > -math.inf:
            event_values[layout.low_stops + k] = model.contacts[k].low - value
    for i in range(model.one_sided_springs.size):
        spring = model.one_sided_springs[i]
        elongation = evaluate_table_output(model, piece, t, spring.output_index)[0] - spring.slack_below
        is_taut = model.mode[model.mode_layout.springs + i] != 0
        event_values[layout.springs + i] = -elongation if is_taut else elongation


@jit_in_place
def begin_phases(model: ReducedModel, state: FloatArray, local_time: float, piece_guess: int, event_values: FloatArray) -> None:
    """Keep all gas in the phase that begins or goes on here, and let the event functions of kinks that are not negative wait.

    Those are functions of the kink at which the integration goes on. Before they rise again there is a dead centre, at which they are
    monitored again. The event values are overwritten.
    """
    first_mode, first_value = model.mode_layout.kinks, model.event_layout.kinks
    for i in range(model.kinks.size):
        model.mode[first_mode + i] = 1
    evaluate_reduced_event_functions(model, state, local_time, piece_guess, event_values)
    for i in range(model.kinks.size):
        model.mode[first_mode + i] = event_values[first_value + i] < 0.0
    piece, t, _ = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_guess)
    _keep_phases(model, model.output_forces, piece, t)
    _keep_phases(model, model.shaft_forces, piece, t)


@jit_in_place
def end_phases(model: ReducedModel) -> None:
    """Let the phase of each gas follow from the state again."""
    for i in range(model.output_forces.size):
        model.output_forces[i].phase = IN_NO_PHASE
    for i in range(model.shaft_forces.size):
        model.shaft_forces[i].phase = IN_NO_PHASE

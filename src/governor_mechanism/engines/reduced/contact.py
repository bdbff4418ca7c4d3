"""Contact-mode transitions at events: impact, stick, slip, slack springs; compiled.

The rules are those of `engines.multibody.contact`, for one coordinate: any contact that holds, holds the whole mechanism.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.reduced.event_functions import find_active_stop, find_blocked_directions
from governor_mechanism.mechanics.contact import tolerances as bouncing
from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE, MIN_REBOUND_HEIGHT, REST_TOLERANCE, STICTION_RATE_TOLERANCE
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    MODE_HELD,
    N_QUADRATURES,
    ReducedModel,
    evaluate_acceleration,
    evaluate_friction_limit,
    evaluate_static_force,
    evaluate_table_output,
)
from governor_mechanism.mechanics.reduction.lowering import ForceParameter
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.table import find_piece
from governor_mechanism.model.events import EventKind
from governor_mechanism.numerics.chebyshev import evaluate_piece
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, IntArray

jit_zeno_time = jit_internal(bouncing.zeno_time)

HOLDING_FORCE_TOLERANCE = 1e-9
"""Tolerance of the force balance of a held mechanism, in force scales."""

EVENT_KINDS = tuple(EventKind)
"""Kinds of events; their positions are the codes in the records (time, code, contact or spring)."""

STICK_EVENT, SLIP_EVENT, IMPACT_EVENT, REST_EVENT, SEPARATION_EVENT, SLACK_EVENT, TAUT_EVENT = range(7)
"""Codes of the contact events, in the order of `EventKind`."""


class EventLog(NamedTuple):
    """Records (time, code, contact or spring) of events, and the number of events and of the last simultaneous ones."""

    records: FloatArray
    counts: IntArray


@jit_internal
def record_event(log: EventLog, time: float, kind: int, subject: int) -> None:
    """Record an event while there is capacity, and count it."""
    n_events = log.counts[0]
    if n_events < log.records.shape[0]:
        log.records[n_events, 0], log.records[n_events, 1], log.records[n_events, 2] = time, kind, subject
    log.counts[0] += 1


@jit_internal
def apply_transition(
    model: ReducedModel, time: float, local_time: float, piece_guess: int, event_values: FloatArray, state: FloatArray, log: EventLog
) -> None:
    """Update contact mode and state (coordinate, rate, quadratures) after events; event_values are not positive at a start."""
    piece, t, _ = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_guess)
    n_contacts, n_springs = model.contacts.shape[0], model.one_sided_springs.shape[0]
    was_held, rest_times = model.mode[MODE_HELD] != 0, np.full(n_contacts, time)
    _update_one_sided_springs(model, piece, t, state, time, log)
    model.mode[MODE_HELD] = 0
    _apply_impacts(model, piece, t, time, local_time, state, rest_times, log)
    force_index = 3 * n_contacts + n_springs
    is_released = was_held and (event_values[force_index] > 0.0 or event_values[force_index + 1] > 0.0)
    if (
        abs(state[1])
        <= STICTION_RATE_TOLERANCE * model.parameters[ForceParameter.COORDINATE_SCALE] / model.parameters[ForceParameter.TIME_SCALE]
    ):
        direction = _breakaway_direction(model, piece, t, local_time, is_released)
        model.mode[MODE_HELD] = 1 if direction == 0 else 0
        state[1] = 0.0 if direction == 0 else state[1]
        _update_friction_signs(model, piece, t, float(direction), event_values, False)
    else:
        _update_friction_signs(model, piece, t, state[1], event_values, True)
    _record_hold_changes(model, piece, t, was_held, model.mode[MODE_HELD] != 0, rest_times, log)


@jit_internal
def _update_one_sided_springs(model: ReducedModel, piece: int, t: float, state: FloatArray, time: float, log: EventLog) -> None:
    """Update which one-sided springs are taut or slack."""
    n_contacts = model.contacts.shape[0]
    for i in range(model.one_sided_springs.shape[0]):
        value, output_derivative = evaluate_table_output(model, piece, t, model.one_sided_springs[i, 0])
        elongation = value - model.one_sided_springs[i, 1]
        is_at_free_value = abs(elongation) < CONTACT_TOLERANCE * model.one_sided_springs[i, 2]
        is_taut = output_derivative * state[1] > 0.0 if is_at_free_value else elongation > 0.0
        if is_taut != (model.mode[1 + n_contacts + i] != 0):
            model.mode[1 + n_contacts + i] = 1 if is_taut else 0
            record_event(log, time, TAUT_EVENT if is_taut else SLACK_EVENT, i)


@jit_internal
def _apply_impacts(
    model: ReducedModel, piece: int, t: float, time: float, local_time: float, state: FloatArray, rest_times: FloatArray, log: EventLog
) -> None:
    """Reverse the rate at a stop by Newton's law of restitution; end bounces that are too low, and set their rest times."""
    has_struck, restitution = False, 1.0
    for k in range(model.contacts.shape[0]):
        value, output_derivative = evaluate_table_output(model, piece, t, model.contacts[k, 0])
        if (
            find_active_stop(model, k, value, CONTACT_TOLERANCE) * output_derivative * state[1]
            > STICTION_RATE_TOLERANCE * model.contacts[k, 5] / model.parameters[ForceParameter.TIME_SCALE]
        ):
            has_struck, restitution = True, min(restitution, model.contacts[k, 4])
            record_event(log, time, IMPACT_EVENT, k)
    if not has_struck:
        return
    v_before, quadrature_rates = state[1], np.empty((1, N_QUADRATURES))
    state[1] = -restitution * v_before
    _set_friction_signs(model, piece, t, state[1])
    separating_acceleration = evaluate_acceleration(model, piece, t, state[1], local_time, True, quadrature_rates, 0)
    _set_friction_signs(model, piece, t, v_before)
    returning_acceleration = evaluate_acceleration(model, piece, t, state[1], local_time, True, quadrature_rates, 0)
    bouncing_ends = False
    for k in range(model.contacts.shape[0]):
        value, output_derivative = evaluate_table_output(model, piece, t, model.contacts[k, 0])
        side = find_active_stop(model, k, value, CONTACT_TOLERANCE)
        separation_rate, return_acceleration = (-side * output_derivative * state[1], side * output_derivative * separating_acceleration)
        is_small = separation_rate * separation_rate < 2.0 * return_acceleration * MIN_REBOUND_HEIGHT * model.contacts[k, 5]
        if restitution < 1.0 and return_acceleration > 0.0 and separation_rate > 0.0 and is_small:
            rest_times[k] = time + jit_zeno_time(
                separation_rate, return_acceleration, side * output_derivative * returning_acceleration, restitution
            )
            bouncing_ends = True
    if bouncing_ends:
        state[1] = 0.0
    dissipated_energy = (
        0.5 * (v_before * v_before - state[1] * state[1]) / evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    )
    state[2] += dissipated_energy
    state[3] += dissipated_energy


@jit_internal
def _breakaway_direction(model: ReducedModel, piece: int, t: float, local_time: float, is_released: bool) -> int:
    """Return the direction in which the coordinate leaves rest: 1, -1, or 0 if it is held."""
    quadrature_rates, tolerance = np.empty((1, N_QUADRATURES)), HOLDING_FORCE_TOLERANCE * model.parameters[ForceParameter.FORCE_SCALE]
    force = evaluate_static_force(model, piece, t, local_time, quadrature_rates)
    resistance = evaluate_friction_limit(model, piece, t, local_time)
    up_blocked, down_blocked = find_blocked_directions(model, piece, t)
    can_hold = up_blocked or down_blocked
    for k in range(model.contacts.shape[0]):
        can_hold = can_hold or model.contacts[k, 1] >= 0
    cannot_rise = up_blocked or force <= resistance + tolerance
    cannot_fall = down_blocked or -force <= resistance + tolerance
    if can_hold and cannot_rise and cannot_fall and not is_released:
        return 0
    if force > 0.0:
        return 0 if up_blocked else 1
    return 0 if down_blocked else -1


@jit_internal
def _set_friction_signs(model: ReducedModel, piece: int, t: float, direction: float) -> None:
    """Set friction to oppose the rates of the outputs in a direction of motion."""
    for k in range(model.contacts.shape[0]):
        if model.contacts[k, 1] >= 0 and direction != 0.0:
            output_derivative = evaluate_table_output(model, piece, t, model.contacts[k, 0])[1]
            model.mode[1 + k] = 1 if output_derivative * direction > 0.0 else -1


@jit_internal
def _update_friction_signs(
    model: ReducedModel, piece: int, t: float, direction: float, event_values: FloatArray, may_reverse: bool
) -> None:
    """Set friction in all contacts; one whose rate just crossed zero reverses if may_reverse is set."""
    for k in range(model.contacts.shape[0]):
        previous_sign = model.mode[1 + k]
        model.mode[1 + k] = 0
        if model.contacts[k, 1] >= 0 and direction != 0.0:
            output_derivative = evaluate_table_output(model, piece, t, model.contacts[k, 0])[1]
            model.mode[1 + k] = 1 if output_derivative * direction > 0.0 else -1
            if may_reverse and event_values[3 * k] > 0.0 and previous_sign != 0:
                model.mode[1 + k] = -previous_sign


@jit_internal
def _record_hold_changes(
    model: ReducedModel, piece: int, t: float, was_held: bool, is_held: bool, rest_times: FloatArray, log: EventLog
) -> None:
    """Record the events of all contacts that begin or cease to hold the mechanism."""
    for k in range(model.contacts.shape[0] if was_held != is_held else 0):
        value = evaluate_table_output(model, piece, t, model.contacts[k, 0])[0]
        at_stop = find_active_stop(model, k, value, REST_TOLERANCE) != 0
        if at_stop:
            record_event(log, rest_times[k], REST_EVENT if is_held else SEPARATION_EVENT, k)
        elif model.contacts[k, 1] >= 0:
            record_event(log, rest_times[k], STICK_EVENT if is_held else SLIP_EVENT, k)

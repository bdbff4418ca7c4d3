"""Event functions of the reduced model: an event is an upward zero crossing; compiled."""

import math

import numpy as np

from governor_mechanism.integrators.event_location import INACTIVE_EVENT_VALUE
from governor_mechanism.mechanics.contact.rules import find_touched_stop
from governor_mechanism.mechanics.contact.tolerances import REST_TOLERANCE
from governor_mechanism.mechanics.dynamics.contacts import ContactColumn
from governor_mechanism.mechanics.dynamics.lowering import EVENT_ROUNDING_RATIO
from governor_mechanism.mechanics.reduction.equation_of_motion import MODE_HELD, ReducedModel, evaluate_static_force, evaluate_table_output
from governor_mechanism.mechanics.reduction.lowering import ForceParameter, ReducedForces
from governor_mechanism.mechanics.reduction.table import find_piece
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray


def make_event_tolerances(forces: ReducedForces) -> FloatArray:
    """Return the rounding of the event functions; none without contacts and one-sided springs.

    Each contact has its rate, its high and its low stop; each one-sided spring its elongation; two more are the static force
    upwards and downwards minus the friction limit.
    """
    if not len(forces.contacts) and not len(forces.one_sided_springs):
        return np.zeros(0)
    scales, parameters = forces.contacts[:, ContactColumn.SCALE], forces.parameters
    contact_scales = np.column_stack([scales / parameters[ForceParameter.TIME_SCALE], scales, scales]).ravel()
    force_scales = np.full(2, parameters[ForceParameter.FORCE_SCALE])
    return EVENT_ROUNDING_RATIO * np.concatenate([contact_scales, forces.one_sided_springs[:, 2], force_scales])


@jit_internal
def find_blocked_directions(model: ReducedModel, piece_index: int, t: float) -> tuple[bool, bool]:
    """Return whether stops block an increase, and a decrease, of the coordinate."""
    up_blocked = down_blocked = False
    for k in range(model.contacts.shape[0]):
        value, output_derivative = evaluate_table_output(model, piece_index, t, model.contacts[k, ContactColumn.OUTPUT])
        outward_derivative = find_touched_stop(model.contacts, k, value, REST_TOLERANCE) * output_derivative
        up_blocked, down_blocked = up_blocked or outward_derivative > 0.0, down_blocked or outward_derivative < 0.0
    return up_blocked, down_blocked


@jit_internal
def evaluate_reduced_event_functions(
    model: ReducedModel, state: FloatArray, local_time: float, piece_guess: int, event_values: FloatArray
) -> None:
    """Fill the event functions at a state; inactive outside the table."""
    event_values[:] = INACTIVE_EVENT_VALUE
    piece, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_guess)
    if side >= 0:
        return
    n_contacts, n_springs = model.contacts.shape[0], model.one_sided_springs.shape[0]
    if model.mode[MODE_HELD] != 0:
        force, resistance = evaluate_static_force(model, piece, t, state, local_time)
        up_blocked, down_blocked = find_blocked_directions(model, piece, t)
        if not up_blocked:
            event_values[3 * n_contacts + n_springs] = force - resistance
        if not down_blocked:
            event_values[3 * n_contacts + n_springs + 1] = -force - resistance
        return
    for k in range(n_contacts):
        value, output_derivative = evaluate_table_output(model, piece, t, model.contacts[k, ContactColumn.OUTPUT])
        if model.mode[1 + k] != 0:
            event_values[3 * k] = -model.mode[1 + k] * output_derivative * state[1]
        if model.contacts[k, ContactColumn.HIGH] < math.inf:
            event_values[3 * k + 1] = value - model.contacts[k, ContactColumn.HIGH]
        if model.contacts[k, ContactColumn.LOW] > -math.inf:
            event_values[3 * k + 2] = model.contacts[k, ContactColumn.LOW] - value
    for i in range(n_springs):
        elongation = evaluate_table_output(model, piece, t, model.one_sided_springs[i, 0])[0] - model.one_sided_springs[i, 1]
        event_values[3 * n_contacts + i] = -elongation if model.mode[1 + n_contacts + i] != 0 else elongation

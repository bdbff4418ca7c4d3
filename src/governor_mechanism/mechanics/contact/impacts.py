"""Impacts at stops, and the end of a bouncing sequence; compiled functions over arrays.

At a stop the rate of an output is reversed by the coefficient of restitution. Where parts with friction strike each other, the
tangential impulse stops their sliding if it is at most the coefficient of friction times the normal impulse; otherwise it is that,
against the sliding that remains.
"""

import math

import numpy as np

from governor_mechanism.mechanics.contact import rules
from governor_mechanism.mechanics.contact.rules import HELD, ContactDynamics
from governor_mechanism.mechanics.contact.tolerances import MIN_REBOUND_HEIGHT
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray, IntArray


@jit
def resolve_impacts(
    dynamics: ContactDynamics,
    states: IntArray,  # state of each contact, 1, -1, 0 or HELD; shape (contacts,)
    impulses: FloatArray,  # result: the impulses along the outputs; shape (contacts,)
) -> BoolArray:
    """Reverse the rates of contacts that strike a stop, by Newton's law of restitution.

    Contacts that rest on a stop stay there. Friction bears no impulse, but under the impulse of parts that rub.

    Result: which contacts have struck; shape (contacts,).
    """
    n_contacts, rates_before = states.size, dynamics.rates.copy()
    has_struck = np.zeros(n_contacts, dtype=np.bool_)
    for _ in range(2 * n_contacts):
        is_constrained, rate_changes, is_striking = np.zeros(n_contacts, dtype=np.bool_), -dynamics.rates, False
        for k in range(n_contacts):
            side = rules.find_active_stop(dynamics, k)
            if side * dynamics.rates[k] > rules.rest_rate(dynamics, k):
                is_constrained[k] = has_struck[k] = is_striking = True
                rate_changes[k] *= 1.0 + dynamics.contacts[k].restitution
            elif side != 0 and states[k] == HELD:
                is_constrained[k] = True
        if not is_striking:
            break
        step = _solve_impulses(dynamics, is_constrained, rate_changes)
        impulses += step
        dynamics.rates[:] += rules.multiply(dynamics.compliance, step)
    dynamics.rates[:] = rates_before
    return has_struck


@jit
def _solve_impulses(
    dynamics: ContactDynamics,
    is_constrained: BoolArray,  # contacts along whose outputs normal impulses act; shape (contacts,)
    rate_changes: FloatArray,  # changes of their rates, m/s or rad/s; shape (contacts,)
) -> FloatArray:
    """Return the impulses that change rates, with the first consistent choice of what sticks and slides under them, or the best one.

    Result: impulses, N s or N m s; shape (contacts,).
    """
    if not rules.has_normal_friction(dynamics.contacts):
        return rules.solve_forces(dynamics, is_constrained, rate_changes)
    n_contacts, least_violation = is_constrained.size, np.inf
    states, best, n_choices = np.zeros(n_contacts, dtype=np.int64), np.zeros(n_contacts), 1
    for k in range(n_contacts):
        normal = dynamics.contacts[k].normal
        if normal != NO_INDEX and is_constrained[normal]:
            n_choices *= 3
    for choice in range(n_choices):
        remaining, is_stopped = choice, is_constrained.copy()
        for k in range(n_contacts):
            normal = dynamics.contacts[k].normal
            if normal != NO_INDEX and is_constrained[normal]:
                states[k] = remaining % 3 - 1
                is_stopped[k] = states[k] == 0
                remaining //= 3
        step = rules.solve_rubbing_forces(dynamics, is_stopped, states, np.where(is_constrained, rate_changes, -dynamics.rates))
        violation = _evaluate_violation(dynamics, is_constrained, states, step)
        if violation < least_violation:
            best, least_violation = step, violation
    return best


@jit
def _evaluate_violation(dynamics: ContactDynamics, is_constrained: BoolArray, states: IntArray, impulses: FloatArray) -> float:
    """Return the largest violation of Coulomb's law by impulses: what sticks beyond the limit, or slides against its sign.

    It is relative to the scales of impulse and rate.
    """
    rates, violation = dynamics.rates + rules.multiply(dynamics.compliance, impulses), 0.0
    for k in range(states.size):
        contact = dynamics.contacts[k]
        if contact.normal != NO_INDEX and is_constrained[contact.normal]:
            if states[k] == 0:
                excess = abs(impulses[k]) - contact.friction_coefficient * impulses[contact.normal]
                violation = max(violation, excess * contact.scale / (dynamics.energy_scale * dynamics.time_scale))
            else:
                violation = max(violation, -states[k] * rates[k] * dynamics.time_scale / contact.scale)
    return violation


@jit
def dissipated_by_impulses(
    dynamics: ContactDynamics,
    impulses: FloatArray,  # impulses, N s or N m s; shape (contacts,)
) -> float:
    """Return the energy that impulses along the outputs dissipate (J)."""
    mean_rates = dynamics.rates + 0.5 * rules.multiply(dynamics.compliance, impulses)
    return float(-np.sum(impulses * mean_rates))


@jit_in_place
def zeno_time(rebound_rate: float, deceleration: float, return_acceleration: float, restitution: float) -> float:
    """Return the time until an infinite sequence of bounces comes to rest, a geometric series.

    Friction makes the accelerations away from the stop and back to it differ. Without an acceleration back, the time is
    that of the first rise alone.
    """
    if not return_acceleration > 0.0:
        return rebound_rate / deceleration
    first_bounce_time = rebound_rate * (1.0 / deceleration + 1.0 / math.sqrt(deceleration * return_acceleration))
    return first_bounce_time / (1.0 - restitution * math.sqrt(return_acceleration / deceleration))


@jit
def _evaluate_bounce_accelerations(dynamics: ContactDynamics, states: IntArray, has_struck: BoolArray, direction: int) -> FloatArray:
    """Return the accelerations while contacts that struck move away from the stop (direction 1), or back (-1) against friction.

    With one degree of freedom all other outputs reverse with them.
    """
    sliding = states.copy()
    for k in range(states.size):
        if has_struck[k] or states[k] != HELD:
            is_reversed = direction < 0 and (has_struck[k] or dynamics.mobility == 1)
            sliding[k] = (-1 if is_reversed else 1) * rules.direction_of_motion(dynamics, k)
    return rules.evaluate_forces(dynamics, sliding)[1]


@jit
def settle_final_bounces(
    dynamics: ContactDynamics,
    states: IntArray,  # state of each contact, 1, -1, 0 or HELD; shape (contacts,)
    has_struck: BoolArray,  # which contacts have struck a stop; shape (contacts,)
    impulses: FloatArray,  # result: the impulses along the outputs that stop them; shape (contacts,)
    # result: how long the bounces of each contact would go on, s; 0 of one that does not settle; shape
    # (contacts,)
    durations: FloatArray,
) -> bool:
    """Stop the contacts that bounce no higher than MIN_REBOUND_HEIGHT.

    Result: whether there were any.
    """
    departing = _evaluate_bounce_accelerations(dynamics, states, has_struck, 1)
    returning = _evaluate_bounce_accelerations(dynamics, states, has_struck, -1)
    is_constrained, settles = np.zeros(states.size, dtype=np.bool_), False
    for k in range(states.size):
        side, restitution = rules.find_active_stop(dynamics, k), dynamics.contacts[k].restitution
        rebound_rate, deceleration = -side * dynamics.rates[k], side * departing[k]
        is_constrained[k] = side != 0 and states[k] == HELD
        if has_struck[k] and restitution < 1.0 and deceleration > 0.0 and rebound_rate > 0.0:
            max_height = MIN_REBOUND_HEIGHT * dynamics.contacts[k].scale
            if rebound_rate * rebound_rate < 2.0 * deceleration * max_height:
                durations[k] = zeno_time(rebound_rate, deceleration, side * returning[k], restitution)
                is_constrained[k] = settles = True
    if settles and rules.has_normal_friction(dynamics.contacts):
        # The rebounds that are left out press less than the rest that takes their place, by the impulse that stops the contact.
        sliding = np.zeros(states.size, dtype=np.int64)
        for k in range(states.size):
            sliding[k] = 0 if rules.is_at_rest(dynamics, k) else rules.direction_of_motion(dynamics, k)
        impulses += rules.solve_rubbing_forces(dynamics, is_constrained, sliding, -dynamics.rates)
    elif settles:
        impulses += rules.solve_forces(dynamics, is_constrained, -dynamics.rates)
    return settles

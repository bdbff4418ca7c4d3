"""Impacts at stops, and the end of a bouncing sequence; compiled functions over arrays.

At a stop the rate of an output is reversed by the coefficient of restitution (Newton). Where a part with friction strikes another
one, the sliding changes in the course of the impact, and may stop or turn back before the normal rate does: the coefficient of
restitution is that of the energy which the normal impulse gives back (Stronge), so that no impact gains energy. Where several such parts
strike or rest at once, tangential impulses stop the sliding if they are at most the coefficients of friction times the normal impulses;
otherwise they are those, against the sliding that remains. The restitution is Newton's then, or 0 if the impact would gain energy by it.

W. J. Stronge, Impact Mechanics, 2nd edition 2018, chapter 4.
"""

import math

import numpy as np

from governor_mechanism.mechanics.contact import rules
from governor_mechanism.mechanics.contact.rules import HELD, ContactDynamics
from governor_mechanism.mechanics.contact.tolerances import MIN_COMPLIANCE_RATIO, MIN_REBOUND_HEIGHT
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray, IntArray


@jit
def resolve_impacts(
    dynamics: ContactDynamics,
    states: IntArray,  # state of each contact, 1, -1, 0 or HELD; shape (contacts,)
    impulses: FloatArray,  # result: the impulses along the outputs; shape (contacts,)
) -> BoolArray:
    """Reverse the rates of contacts that strike a stop, by Newton's law of restitution; return which have struck, (contacts,)."""
    # Contacts that rest on a stop stay there. Friction bears no impulse, but under the impulse of parts
    # that rub.
    n_contacts, rates_before = states.size, dynamics.rates.copy()
    has_struck = np.zeros(n_contacts, dtype=np.bool_)
    for _ in range(2 * n_contacts):
        is_constrained = np.zeros(n_contacts, dtype=np.bool_)
        rate_changes = -dynamics.rates
        is_striking = False
        for k in range(n_contacts):
            side = rules.find_active_stop(dynamics, k)
            if side * dynamics.rates[k] > rules.rest_rate(dynamics, k):
                is_constrained[k] = has_struck[k] = is_striking = True
                rate_changes[k] *= 1.0 + dynamics.contacts[k].restitution
            elif side != 0 and states[k] == HELD:
                is_constrained[k] = True
        if not is_striking:
            break
        tangent = _find_single_tangent(dynamics, is_constrained)
        if tangent != NO_INDEX:
            step = _solve_sliding_impact(dynamics, tangent)
        else:
            step = _solve_impulses(dynamics, is_constrained, rate_changes)
            if rules.has_normal_friction(dynamics.contacts) and dissipated_by_impulses(dynamics, step) < 0.0:
                step = _solve_impulses(dynamics, is_constrained, -dynamics.rates)
        impulses += step
        dynamics.rates[:] += rules.multiply(dynamics.compliance, step)
    dynamics.rates[:] = rates_before
    return has_struck


@jit_in_place
def _find_single_tangent(dynamics: ContactDynamics, is_constrained: BoolArray) -> int:
    """Return the contact along which parts slide that strike, where no other contact takes part in the impact, or NO_INDEX."""
    tangent, n_constrained = NO_INDEX, 0
    for k in range(is_constrained.size):
        normal = dynamics.contacts[k].normal
        n_constrained += is_constrained[k]
        if normal != NO_INDEX and is_constrained[normal]:
            tangent = k
    return tangent if n_constrained == 1 else NO_INDEX


MAX_IMPACT_PHASES = 6
"""Largest number of phases of an impact: sliding, and sticking or sliding back, in compression and in restitution."""


@jit
def _solve_sliding_impact(dynamics: ContactDynamics, tangent: int) -> FloatArray:
    """Return the impulses of parts that strike each other with friction: rates change linearly with the normal impulse in each phase.

    Compression ends where the parts come no nearer; restitution ends where the normal impulse has given back the square of the coefficient
    of restitution of the work that it took.

    Result: impulses, N s or N m s; shape (contacts,).
    """
    contact, compliance = dynamics.contacts[tangent], dynamics.compliance
    normal, friction = contact.normal, contact.friction_coefficient
    side = 1.0 if dynamics.rates[normal] > 0.0 else -1.0  # toward the stop
    by_normal = compliance[normal, normal]
    by_tangent = compliance[tangent, tangent]
    coupling = -side * compliance[tangent, normal]
    restitution = dynamics.contacts[normal].restitution
    approach = -side * dynamics.rates[normal]
    slip = dynamics.rates[tangent]
    energy = 0.0
    is_compressing = True
    impulses = np.zeros(dynamics.rates.size)
    for _ in range(MAX_IMPACT_PHASES):
        # It sticks where friction can stop it, and otherwise slides as the normal impulse drives it.
        sticks = slip == 0.0 and abs(coupling) <= friction * by_tangent
        ratio = -math.copysign(friction, coupling if slip == 0.0 else slip)
        if sticks:
            ratio = -coupling / by_tangent if by_tangent > 0.0 else 0.0
        normal_slope = by_normal + coupling * ratio
        slip_slope = 0.0 if sticks else coupling + by_tangent * ratio
        if abs(normal_slope) <= MIN_COMPLIANCE_RATIO * by_normal:
            normal_slope = 0.0  # what friction holds cannot yield
        is_slowing = slip_slope < 0.0 if slip > 0.0 else slip < 0.0 < slip_slope  # the product of both may be 0 by rounding
        to_stop = -slip / slip_slope if is_slowing else math.inf
        if is_compressing:
            to_end = -approach / normal_slope if normal_slope > 0.0 else math.inf
        elif normal_slope > 0.0:
            to_end = (math.sqrt(approach * approach + 2.0 * normal_slope * energy) - approach) / normal_slope
        else:
            to_end = math.inf
        length = min(to_stop, to_end)
        if length == math.inf:
            break  # nothing can move
        work = length * (approach + 0.5 * normal_slope * length)
        energy -= restitution * restitution * work if is_compressing else work
        impulses[normal] -= side * length
        impulses[tangent] += ratio * length
        approach += normal_slope * length
        slip = slip + slip_slope * length if to_end < to_stop else 0.0
        if to_end <= to_stop:
            if not is_compressing or restitution == 0.0:
                break
            is_compressing, approach = False, 0.0
    return impulses


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
    states = np.zeros(n_contacts, dtype=np.int64)
    best = np.zeros(n_contacts)
    n_choices = 1
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
        violation = _evaluate_violation(dynamics, is_constrained, rate_changes, states, step)
        if violation < least_violation:
            best, least_violation = step, violation
    return best


@jit
def _evaluate_violation(
    dynamics: ContactDynamics, is_constrained: BoolArray, rate_changes: FloatArray, states: IntArray, impulses: FloatArray
) -> float:
    """Return the largest violation of Coulomb's law by impulses: what sticks beyond the limit, slides against its sign, or is pulled.

    It is relative to the scales of impulse and rate.
    """
    rates = dynamics.rates + rules.multiply(dynamics.compliance, impulses)
    violation = 0.0
    for k in range(states.size):
        contact = dynamics.contacts[k]
        if contact.normal != NO_INDEX and is_constrained[contact.normal]:
            normal, unit = contact.normal, dynamics.energy_scale * dynamics.time_scale
            pull = impulses[normal] * rules.find_active_stop(dynamics, normal)
            missed = abs(rates[normal] - dynamics.rates[normal] - rate_changes[normal])  # where impulses are not determined
            normal_scale = dynamics.contacts[normal].scale
            violation = max(violation, pull * normal_scale / unit, missed * dynamics.time_scale / normal_scale)
            if states[k] == 0:
                excess = abs(impulses[k]) + contact.friction_coefficient * pull
                violation = max(violation, excess * contact.scale / unit)
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
    """Return the time until an infinite sequence of bounces comes to rest, a geometric series."""
    # Friction makes the accelerations away from the stop and back to it differ. Without an acceleration
    # back, the time is that of the first rise alone.
    if not return_acceleration > 0.0:
        return rebound_rate / deceleration
    first_bounce_time = rebound_rate * (1.0 / deceleration + 1.0 / math.sqrt(deceleration * return_acceleration))
    return first_bounce_time / (1.0 - restitution * math.sqrt(return_acceleration / deceleration))


@jit
def _evaluate_bounce_accelerations(dynamics: ContactDynamics, states: IntArray, has_struck: BoolArray, direction: int) -> FloatArray:
    """Return the accelerations while contacts that struck move away from the stop (direction 1), or back (-1) against friction."""
    # With one degree of freedom all other outputs reverse with them.
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
    """Stop the contacts that bounce no higher than MIN_REBOUND_HEIGHT; return whether there were any."""
    departing = _evaluate_bounce_accelerations(dynamics, states, has_struck, 1)
    returning = _evaluate_bounce_accelerations(dynamics, states, has_struck, -1)
    is_constrained, settles = np.zeros(states.size, dtype=np.bool_), False
    for k in range(states.size):
        side = rules.find_active_stop(dynamics, k)
        restitution = dynamics.contacts[k].restitution
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

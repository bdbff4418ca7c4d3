"""Rules of contact: which contacts rest, stick, slip and leave; compiled functions over arrays.

A contact is an output variable that dry friction or stops may hold. At rest it is held while the holding force is within the
friction limit, or pushes away from the stop; otherwise it slides in the direction of the net force. All contact forces f act on
the accelerations of the outputs linearly, a = a0 + C f, so that the rules need no more of a mechanism than its `ContactDynamics`.

Where parts touch, a contact along the normal has another one along the tangent, whose friction limit is a multiple of its force:
what slides has the tangential force -sign * coefficient * normal force.
"""

from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.contact import tolerances
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.numerics.linear_equations import solve_band_system, solve_dense
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray, IntArray, RecordArray

HELD = 2
"""State of a contact that holds its output. Other states are the sign of the rate that friction opposes, or 0 without friction."""


class ContactDynamics(NamedTuple):
    """Motion of the outputs with contacts at one time, and their response to forces along them."""

    contacts: RecordArray  # records of `CONTACT_DTYPE`; shape (contacts,)
    values: FloatArray  # values of the outputs, m or rad; shape (contacts,)
    rates: FloatArray  # their rates, m/s or rad/s; shape (contacts,)
    accelerations: FloatArray  # their accelerations without any contact force, m/s2 or rad/s2; shape (contacts,)
    compliance: FloatArray  # acceleration of each output by a unit force along each; shape (contacts, contacts)
    friction_limits: FloatArray  # friction forces, N or N m; shape (contacts,)
    # distance of each one-sided spring's output from its free value, in scales of the output; shape
    # (springs,)
    stretches: FloatArray
    stretch_rates: FloatArray  # its rate, per second; shape (springs,)
    time_scale: float  # characteristic time, s
    energy_scale: float  # scale of energies, J
    mobility: int  # number of degrees of freedom, without those that are driven
    is_driven: bool  # whether drives move the mechanism, so that held contacts do not stop it


@jit_in_place
def rest_rate(dynamics: ContactDynamics, k: int) -> float:
    """Return the rate below which the output of a contact is at rest, m/s or rad/s."""
    return float(tolerances.STICTION_RATE_TOLERANCE * dynamics.contacts[k].scale / dynamics.time_scale)


@jit_in_place
def is_at_rest(dynamics: ContactDynamics, k: int) -> bool:
    """Return whether the output of a contact is at rest."""
    return bool(abs(dynamics.rates[k]) <= rest_rate(dynamics, k))


@jit_in_place
def find_touched_stop(contacts: RecordArray, k: int, value: float, relative_distance: float) -> int:
    """Return the stop that the output of a contact is at within a relative distance: 1 the high one, -1 the low one, 0 neither."""
    distance = relative_distance * contacts[k].scale
    if value >= contacts[k].high - distance:
        return 1
    return -1 if value <= contacts[k].low + distance else 0


@jit_in_place
def has_friction(contacts: RecordArray, k: int) -> bool:
    """Return whether a contact has friction, with a limit of its own or with one that follows from a normal force."""
    return bool(contacts[k].friction_input != NO_INDEX or contacts[k].normal != NO_INDEX)


@jit_in_place
def has_normal_friction(contacts: RecordArray) -> bool:
    """Return whether the friction of a contact follows from a normal force."""
    n_rubbing = 0
    for k in range(contacts.size):
        n_rubbing += contacts[k].normal != NO_INDEX
    return n_rubbing > 0


@jit
def find_active_stop(dynamics: ContactDynamics, k: int) -> int:
    """Return the stop that a contact touches: 1 the high one, -1 the low one, 0 neither."""
    return find_touched_stop(
        dynamics.contacts, k, dynamics.values[k], tolerances.REST_TOLERANCE if is_at_rest(dynamics, k) else tolerances.CONTACT_TOLERANCE
    )


@jit_in_place
def direction_of_motion(dynamics: ContactDynamics, k: int) -> int:
    """Return the state of a contact that slides at its present rate."""
    if not has_friction(dynamics.contacts, k) or dynamics.rates[k] == 0.0:
        return 0
    return 1 if dynamics.rates[k] > 0.0 else -1


@jit
def is_resting(
    dynamics: ContactDynamics,
    states: IntArray,  # state of each contact, 1, -1, 0 or HELD; shape (contacts,)
    k: int,
) -> bool:
    """Return whether a contact is at rest: held itself, or where nothing can move, able to hold."""
    can_hold = dynamics.contacts[k].friction_input != NO_INDEX or find_active_stop(dynamics, k) != 0
    return bool(states[k] == HELD or (can_hold and is_locked(dynamics, states)))


@jit
def is_locked(
    dynamics: ContactDynamics,
    states: IntArray,  # state of each contact, 1, -1, 0 or HELD; shape (contacts,)
) -> bool:
    """Return whether the held contacts leave no degree of freedom, so that the mechanism is at rest."""
    return bool(not dynamics.is_driven and np.sum(states == HELD) == dynamics.mobility)


@jit
def update_spring_segments(
    dynamics: ContactDynamics,
    segments: IntArray,  # segments, changed in place; shape (springs,)
) -> BoolArray:
    """Update the segment of each one-sided spring, 1 taut, 0 slack; return which changed, (springs,)."""
    previous = segments.copy()
    for i in range(segments.size):
        stretch = dynamics.stretches[i]
        segments[i] = (dynamics.stretch_rates[i] if abs(stretch) < tolerances.CONTACT_TOLERANCE else stretch) > 0.0
    has_changed: BoolArray = segments != previous
    return has_changed


@jit
def solve_forces(
    dynamics: ContactDynamics,
    is_constrained: BoolArray,  # along which outputs the forces act; shape (contacts,)
    # changes, of which those of the other outputs are ignored; shape (contacts,)
    right_hand_side: FloatArray,
) -> FloatArray:
    """Return the forces (contacts,), N or N m, along outputs that change their accelerations, or the impulses that change their rates."""
    # An output at a turning point takes no force. Forces along dependent outputs are those of least
    # norm.
    indices = np.empty(is_constrained.size, dtype=np.int64)
    forces = np.zeros(is_constrained.size)
    n_constrained, unit = 0, dynamics.energy_scale * dynamics.time_scale**2
    for k in range(is_constrained.size):
        if is_constrained[k] and dynamics.compliance[k, k] * unit > tolerances.MIN_COMPLIANCE_RATIO * dynamics.contacts[k].scale ** 2:
            indices[n_constrained] = k
            n_constrained += 1
    band = np.zeros((n_constrained, n_constrained))
    solution = np.empty(n_constrained)
    for i in range(n_constrained):
        solution[i] = right_hand_side[indices[i]]
        for j in range(i + 1):
            band[j, i - j] = dynamics.compliance[indices[i], indices[j]]
    solve_band_system(band, np.empty_like(band), np.empty((2, n_constrained, n_constrained)), solution)
    for i in range(n_constrained):
        forces[indices[i]] = solution[i]
    return forces


@jit
def solve_rubbing_forces(
    dynamics: ContactDynamics,
    is_constrained: BoolArray,  # along which outputs the forces act; shape (contacts,)
    # state of each contact: one with normal friction that is not constrained slides where its normal contact is; shape (contacts,)
    states: IntArray,
    right_hand_side: FloatArray,  # changes, of which those of the other outputs are ignored; shape (contacts,)
) -> FloatArray:
    """Return forces or impulses (contacts,) along outputs as `solve_forces`, and those of friction under them, if they are determined."""
    n_contacts = is_constrained.size
    friction = np.zeros(n_contacts)
    matrix = np.zeros((n_contacts, n_contacts))
    solution = np.zeros(n_contacts)
    for k in range(n_contacts):
        normal = dynamics.contacts[k].normal
        if normal != NO_INDEX and is_constrained[normal] and not is_constrained[k]:
            friction[k] = -states[k] * dynamics.contacts[k].friction_coefficient
    # Without dimensions the numbers of independent contacts are of order 1.
    scale = np.empty(n_contacts)
    unit = dynamics.energy_scale * dynamics.time_scale**2
    for k in range(n_contacts):
        scale[k] = dynamics.contacts[k].scale
    for i in range(n_contacts):
        if not is_constrained[i]:
            matrix[i, i] = 1.0
            continue
        solution[i] = right_hand_side[i] / scale[i]
        for j in range(n_contacts):
            if is_constrained[j]:
                matrix[i, j] += dynamics.compliance[i, j] * unit / (scale[i] * scale[j])
            elif friction[j] != 0.0:
                normal = dynamics.contacts[j].normal
                matrix[i, normal] += dynamics.compliance[i, j] * friction[j] * unit / (scale[i] * scale[normal])
    solve_dense(matrix, solution)
    solution *= unit / scale
    for k in range(n_contacts):
        if friction[k] != 0.0:
            solution[k] = friction[k] * solution[dynamics.contacts[k].normal]
    return solution


@jit
def evaluate_forces(dynamics: ContactDynamics, states: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the contact forces in given states, and the accelerations of the outputs with them."""
    forces = np.zeros(states.size)
    for k in range(states.size):
        if states[k] != HELD:
            forces[k] = -states[k] * dynamics.friction_limits[k]
    is_held = states == HELD
    if has_normal_friction(dynamics.contacts):
        right_hand_side = -dynamics.accelerations - multiply(dynamics.compliance, forces)
        forces += solve_rubbing_forces(dynamics, is_held, states, right_hand_side)
        return forces, dynamics.accelerations + multiply(dynamics.compliance, forces)
    forces += solve_forces(dynamics, is_held, -dynamics.accelerations - multiply(dynamics.compliance, forces))
    return forces, dynamics.accelerations + multiply(dynamics.compliance, forces)


@jit
def multiply(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Return a small matrix times a vector, without a call of BLAS."""
    product = np.zeros(vector.size)
    for i in range(vector.size):
        for k in range(vector.size):
            product[i] += matrix[i, k] * vector[k]
    return product


@jit
def select_contact_states(
    dynamics: ContactDynamics,
    is_released: BoolArray,  # which contacts cannot hold; shape (contacts,)
    states: IntArray,  # result: state of each contact, 1, -1, 0 or HELD; shape (contacts,)
) -> None:
    """Select consistent states of all contacts by enumeration: the first consistent ones, else those of least violation."""
    n_contacts = states.size
    candidates = np.empty((n_contacts, 3), dtype=np.int64)
    n_candidates = np.zeros(n_contacts, dtype=np.int64)
    for k in range(n_contacts):
        n_candidates[k] = _list_candidates(dynamics, k, is_released[k], candidates[k])
    choice = np.zeros(n_contacts, dtype=np.int64)
    trial = np.empty(n_contacts, dtype=np.int64)
    least_violation = np.inf
    for _ in range(np.prod(n_candidates)):
        for k in range(n_contacts):
            trial[k] = candidates[k, choice[k]]
        for k in range(n_contacts):  # nothing rubs that does not touch
            normal = dynamics.contacts[k].normal
            if normal != NO_INDEX and trial[normal] != HELD:
                trial[k] = 0
        # More held contacts than degrees of freedom: fewer, with others at their force limits, describe the same motion
        # with determinate forces.
        if np.sum(trial == HELD) <= dynamics.mobility:
            violation = compute_violation(dynamics, trial)
            if violation < least_violation:
                states[:], least_violation = trial, violation
            if least_violation <= tolerances.MODE_CONSISTENCY_TOLERANCE:
                return
        for k in range(n_contacts - 1, -1, -1):
            choice[k] = (choice[k] + 1) % n_candidates[k]
            if choice[k] != 0:
                break


@jit_in_place
def _list_candidates(dynamics: ContactDynamics, k: int, is_released: bool, candidates: IntArray) -> int:
    """Fill the possible states of a contact, and return their number."""
    if not is_at_rest(dynamics, k):
        candidates[0] = direction_of_motion(dynamics, k)
        return 1
    side, n_candidates = find_active_stop(dynamics, k), 0
    is_rubbing = has_friction(dynamics.contacts, k)
    if (is_rubbing or side != 0) and not is_released:
        candidates[0], n_candidates = HELD, 1
    if not is_rubbing:
        candidates[n_candidates] = 0
        return n_candidates + 1
    for sign in (1, -1):
        if sign != side:
            candidates[n_candidates] = sign
            n_candidates += 1
    return n_candidates


@jit
def compute_violation(dynamics: ContactDynamics, states: IntArray) -> float:
    """Return the largest violation of the complementarity conditions, relative to the scales of force and acceleration."""
    forces, accelerations = evaluate_forces(dynamics, states)
    violation = 0.0
    for k in range(states.size):
        scale, side = dynamics.contacts[k].scale, find_active_stop(dynamics, k)
        acceleration = accelerations[k] * dynamics.time_scale**2 / scale
        if states[k] == HELD:
            # A stop pushes with unlimited force in one direction; friction holds in both, up to its limit.
            excess = 0.0
            limit = dynamics.friction_limits[k]
            normal = dynamics.contacts[k].normal
            if normal != NO_INDEX:
                limit = dynamics.contacts[k].friction_coefficient * forces[normal]
            if side >= 0:
                excess = max(excess, forces[k] - limit)
            if side <= 0:
                excess = max(excess, -forces[k] - limit)
            violation = max(violation, excess * scale / dynamics.energy_scale)
            # At a turning point of a reading no force along it can hold it: the mechanism moves on.
            if abs(acceleration) > tolerances.TURNING_POINT_ACCELERATION_TOLERANCE:
                violation = max(violation, abs(acceleration))
        elif is_at_rest(dynamics, k):
            direction = states[k] if states[k] != 0 else -side
            violation = max(violation, -direction * acceleration)
    return violation

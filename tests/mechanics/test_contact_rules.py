"""Rules of contact over arrays: weights and stops whose forces, impulses and states are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.contact.impacts import dissipated_by_impulses, resolve_impacts, settle_final_bounces, zeno_time
from governor_mechanism.mechanics.contact.rules import HELD, ContactDynamics, select_contact_states, update_spring_segments
from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE, MIN_REBOUND_HEIGHT
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events, record_hold_changes
from governor_mechanism.mechanics.dynamics.contacts import CONTACT_DTYPE
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.types import NO_INDEX

LOW, HIGH = -1.0, 2.0
AT_STOPS = {-1: LOW, 0: 0.5, 1: HIGH}
MASS, RESTITUTION = 4.0, 0.25


def motion(values, rates, accelerations=None, *, compliance=None, friction=None, mobility=None, is_driven=False) -> ContactDynamics:
    """Return the motion of outputs between two stops; without a compliance, of weights that do not touch each other."""
    n = len(values)
    contacts = np.zeros(n, dtype=CONTACT_DTYPE)
    limits = np.zeros(n) if friction is None else np.array(friction)
    contacts["low"], contacts["high"], contacts["restitution"], contacts["scale"] = LOW, HIGH, RESTITUTION, 1.0
    contacts["friction_input"], contacts["normal"] = np.where(limits > 0.0, 0, NO_INDEX), NO_INDEX
    return ContactDynamics(
        contacts=contacts,
        values=np.array(values, dtype=float),
        rates=np.array(rates, dtype=float),
        accelerations=np.zeros(n) if accelerations is None else np.array(accelerations, dtype=float),
        compliance=np.eye(n) / MASS if compliance is None else np.array(compliance),
        friction_limits=limits,
        stretches=np.zeros(0),
        stretch_rates=np.zeros(0),
        time_scale=1.0,
        energy_scale=1.0,
        mobility=n if mobility is None else mobility,
        is_driven=is_driven,
    )


def strike(dynamics: ContactDynamics, states) -> tuple[np.ndarray, np.ndarray]:
    """Return the impulses of a strike, and which contacts have struck."""
    impulses = np.zeros(len(states))
    has_struck = resolve_impacts(dynamics, np.array(states), impulses)
    return impulses, has_struck


def test_a_stop_reverses_the_rate_that_leads_into_it_and_no_other():
    places = [LOW, LOW, LOW, HIGH, HIGH, 0.5]
    rates = [-3.0, 0.0, 3.0, 2.0, -2.0, 7.0]
    dynamics = motion(places, rates)
    impulses, has_struck = strike(dynamics, [0, HELD, 0, 0, 0, 0])
    assert has_struck.tolist() == [True, False, False, True, False, False]
    np.testing.assert_array_equal(dynamics.rates, rates)
    after = dynamics.rates + dynamics.compliance @ impulses
    np.testing.assert_allclose(after, [3.0 * RESTITUTION, 0.0, 3.0, -2.0 * RESTITUTION, -2.0, 7.0], rtol=1e-15)
    lost = 0.5 * MASS * (dynamics.rates @ dynamics.rates - after @ after)
    assert dissipated_by_impulses(dynamics, impulses) == pytest.approx(lost, rel=1e-14)


def test_a_strike_passes_through_a_contact_that_rests_and_moves_what_is_free():
    """Three outputs of two weights: the difference of the places of both is the third; it may not shrink below its stop."""
    jacobian = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])
    compliance = jacobian @ jacobian.T / MASS
    weights = np.array([3.0, 3.0])  # both move together, the second one reaches its high stop
    dynamics = motion([1.0, HIGH, LOW], jacobian @ weights, compliance=compliance, mobility=2)
    impulses, has_struck = strike(dynamics, [0, 0, HELD])
    assert has_struck.tolist() == [False, True, False]
    after = weights + jacobian.T @ impulses / MASS
    np.testing.assert_allclose(after, -3.0 * RESTITUTION * np.ones(2), rtol=1e-14)  # what rests stays at rest
    impulses, has_struck = strike(dynamics, [0, 0, 0])
    # Not held, the lower weight goes on into the upper one, and both strike until nothing approaches anything.
    assert has_struck.tolist() == [False, True, True]
    rates = jacobian @ (weights + jacobian.T @ impulses / MASS)
    assert rates[1] <= 0.0
    assert rates[2] >= 0.0


@pytest.mark.parametrize("side", [-1, 1])
def test_small_bounces_end_after_the_sum_of_their_times(side):
    gravity, friction, heights = 9.81, 8.0, np.array([0.5, 2.0]) * MIN_REBOUND_HEIGHT
    departing, returning = gravity + friction / MASS, gravity - friction / MASS
    rebounds = np.sqrt(2 * departing * heights)
    dynamics = motion([AT_STOPS[side]] * 2, -side * rebounds, [side * gravity] * 2, friction=[friction] * 2)
    impulses, durations = np.zeros(2), np.zeros(2)
    assert settle_final_bounces(dynamics, np.zeros(2, dtype=np.int64), np.array([True, True]), impulses, durations)
    np.testing.assert_allclose(impulses, [side * MASS * rebounds[0], 0.0], rtol=1e-14)  # the higher one goes on
    assert durations[0] == pytest.approx(zeno_time(rebounds[0], departing, returning, RESTITUTION), rel=1e-12)
    assert durations[1] == 0.0
    none, struck = np.zeros(2), np.array([False, False])
    assert not settle_final_bounces(dynamics, np.zeros(2, dtype=np.int64), struck, none, none)


def test_a_contact_that_is_held_takes_no_part_in_the_bounces_of_another_one():
    """It stays at rest, also without friction; the other one ends as if it were alone."""
    side, gravity, rebound = -1, 9.81, np.sqrt(9.81 * MIN_REBOUND_HEIGHT)
    alone = motion([LOW], [rebound], [-gravity])
    both = motion([LOW, LOW], [rebound, 0.0], [-gravity, -gravity])
    results = []
    for dynamics, states, struck in ((alone, [0], [True]), (both, [0, HELD], [True, False])):
        impulses, durations = np.zeros(len(states)), np.zeros(len(states))
        assert settle_final_bounces(dynamics, np.array(states), np.array(struck), impulses, durations)
        results.append((impulses, durations))
    np.testing.assert_allclose(results[1][0], [results[0][0][0], 0.0], atol=1e-15)
    assert results[1][1].tolist() == [results[0][1][0], 0.0]
    assert results[0][0][0] == pytest.approx(side * MASS * rebound)


def test_no_force_along_a_reading_holds_it_at_its_turning_point():
    """There its compliance vanishes: it goes on with its acceleration, and friction does not stop it."""
    dynamics = motion([0.5], [0.0], [3.0], compliance=[[0.0]], friction=[100.0])
    assert states_of(dynamics) != [HELD]
    assert states_of(motion([0.5], [0.0], [3.0], friction=[100.0])) == [HELD]


def states_of(dynamics: ContactDynamics, *released: int) -> list[int]:
    states, is_released = np.zeros(len(dynamics.values), dtype=np.int64), np.isin(np.arange(len(dynamics.values)), released)
    select_contact_states(dynamics, is_released, states)
    return states.tolist()


def test_what_is_at_rest_is_held_within_the_limit_of_friction_and_slides_beyond():
    accelerations = [0.9, -0.9, 1.1, -1.1, 0.0]  # the friction of 4 N holds 1 m/s2
    assert states_of(motion([0.5] * 5, [0.0] * 5, accelerations, friction=[MASS] * 5)) == [HELD, HELD, 1, -1, HELD]
    assert states_of(motion([0.5] * 3, [2.0, -2.0, 2.0], [0.0] * 3, friction=[MASS, MASS, 0.0])) == [1, -1, 0]
    assert HELD not in states_of(motion([0.5] * 2, [0.0] * 2, [0.5, -0.5], friction=[MASS] * 2), 0, 1)  # they have just been released


@pytest.mark.parametrize(("ratio", "state"), [(0.9, HELD), (1.1, 1), (-0.9, HELD), (-1.1, -1)])
def test_what_is_pressed_is_held_by_friction_up_to_its_share_of_the_pressure(ratio, state):
    dynamics = motion([LOW, 0.5], [0.0, 0.0], [-9.81, ratio * 0.3 * 9.81])
    dynamics.contacts["normal"][1] = 0
    dynamics.contacts["friction_coefficient"][1] = 0.3
    assert states_of(dynamics) == [HELD, state]


@pytest.mark.parametrize("side", [-1, 1])
def test_a_stop_holds_what_pushes_against_it(side):
    place, pushes = AT_STOPS[side], np.array([5.0, -5.0]) * side
    assert states_of(motion([place] * 2, [0.0] * 2, pushes)) == [HELD, 0]
    assert states_of(motion([place] * 2, [0.0] * 2, pushes, friction=[MASS] * 2)) == [HELD, -side]
    assert states_of(motion([place] * 2, [0.0] * 2, 0.1 * pushes, friction=[MASS] * 2)) == [HELD, HELD]


def test_no_more_is_held_than_can_move():
    """Two outputs of one weight: the friction of one holds for both, and the sum of both is the limit."""
    compliance = np.ones((2, 2)) / MASS
    for acceleration, is_held in ((1.9, True), (-1.9, True), (2.1, False), (-2.1, False)):
        dynamics = motion([0.5] * 2, [0.0] * 2, [acceleration] * 2, compliance=compliance, friction=[MASS] * 2, mobility=1)
        states = states_of(dynamics)
        assert states.count(HELD) == is_held
        direction = int(math.copysign(1, acceleration))
        assert [state for state in states if state != HELD] == [direction] * (2 - is_held)


def test_events_say_what_comes_to_rest_and_what_leaves_and_where():
    previous, now = [0, HELD, 1, HELD, HELD, 0], [HELD, 0, HELD, -1, HELD, 0]
    dynamics = motion([LOW, HIGH, 0.5, 0.5, 0.5, 0.5], [0.0] * 6, friction=[0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    log, durations = make_event_log(9), np.array([0.0, 0.0, 0.25, 0.0, 0.0, 0.0])
    record_hold_changes(dynamics, np.array(previous), np.array(now), 3.0, durations, log)
    events = [(event.subject, str(event.kind), event.time) for event in make_events(log, list("abcdef"))]
    assert events == [("a", "rests on its stop", 3.0), ("b", "leaves its stop", 3.0), ("c", "sticks", 3.25), ("d", "slips", 3.0)]
    log = make_event_log(1)  # counts what it has no room for
    record_hold_changes(dynamics, np.array(previous), np.array(now), 3.0, durations, log)
    assert [event.subject for event in make_events(log, list("abcdef"))] == ["a"]
    assert log.counts[0] == 4
    # Where one held output stops everything, the others with friction rest too; a driven mechanism goes on.
    for is_driven, subjects in ((False, ["a", "b"]), (True, ["a"])):
        dynamics = motion([0.5] * 3, [0.0] * 3, friction=[1.0, 1.0, 0.0], mobility=1, is_driven=is_driven)
        log = make_event_log(9)
        record_hold_changes(dynamics, np.array([1, 1, 0]), np.array([HELD, 1, 0]), 3.0, np.zeros(3), log)
        assert [event.subject for event in make_events(log, list("abc"))] == subjects


def test_a_spring_is_taut_where_it_is_stretched_and_at_its_free_length_where_it_lengthens():
    stretches = np.array([0.1, -0.1, 0.0, 0.0, 0.5 * CONTACT_TOLERANCE, -0.5 * CONTACT_TOLERANCE, 2 * CONTACT_TOLERANCE])
    rates = np.array([-3.0, 3.0, 1.0, -1.0, -1.0, 1.0, -1.0])
    dynamics = motion([0.5], [0.0])._replace(stretches=stretches, stretch_rates=rates)
    segments = np.array([1, 1, 0, 0, 1, 0, 0])
    has_changed = update_spring_segments(dynamics, segments)
    assert segments.tolist() == [1, 0, 1, 0, 0, 1, 1]
    assert has_changed.tolist() == [False, True, True, False, True, True, True]


def test_event_logs_differ_by_their_largest_delay_and_states_beside_events_are_not_compared():
    times = np.linspace(0.0, 2.0, 5)
    strike_at = [Event(time=time, kind=EventKind.IMPACT, subject="lift") for time in (0.5, 1.5, 2.5)]
    later, other = [replace(event, time=event.time + 0.1) for event in strike_at], replace(strike_at[0], subject="arm")
    delay, is_near_event = compare_event_logs(strike_at, later, times, 0.01)
    assert delay == pytest.approx(0.1, abs=1e-15)
    assert is_near_event.tolist() == [False, True, False, True, False]
    assert compare_event_logs(strike_at, strike_at, times, 0.01)[0] == 0.0
    # one that is missing counts to the nearest of its kind and subject, or to the end
    assert compare_event_logs(strike_at[1:2], [], times, 0.01)[0] == pytest.approx(0.5, abs=1e-15)
    assert compare_event_logs([], [other], times, 0.01)[0] == pytest.approx(1.5, abs=1e-15)
    assert compare_event_logs(strike_at[2:], [], times, 0.01)[0] == 0.0  # after the end

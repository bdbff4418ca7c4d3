"""Bounces against a stop, of which infinitely many take a finite time; impacts with friction: Coulomb's law, energy, and a reference."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from governor_mechanism.mechanics.contact.impacts import dissipated_by_impulses, resolve_impacts, zeno_time
from governor_mechanism.mechanics.contact.rules import ContactDynamics
from governor_mechanism.mechanics.dynamics.contacts import CONTACT_DTYPE
from governor_mechanism.types import NO_INDEX


@pytest.mark.parametrize(("deceleration", "return_acceleration"), [(9.81, 9.81), (12.0, 7.0), (12.0, 0.5)])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
def test_the_time_until_rest_is_the_sum_of_all_bounces(deceleration, return_acceleration, restitution):
    """Friction brakes the way out and the way back: the speed at the stop falls also between impacts."""
    speed, total = 2.0, 0.0
    while speed > 1e-18:
        rise, height = speed / deceleration, 0.5 * speed**2 / deceleration
        fall = (2 * height / return_acceleration) ** 0.5
        total += rise + fall
        speed = restitution * return_acceleration * fall
    assert zeno_time(2.0, deceleration, return_acceleration, restitution) == pytest.approx(total, rel=1e-13)  # rounding of the sum


def test_without_an_acceleration_back_only_the_first_rise_counts():
    assert zeno_time(2.0, 4.0, 0.0, 0.5) == 0.5


@dataclass
class Strike:
    """A part that strikes: compliance of gap and slip (their coupling is the eccentricity), friction, restitution, both rates."""

    compliance: np.ndarray
    friction: float
    restitution: float
    rates: np.ndarray

    def dynamics(self, n: int = 1) -> ContactDynamics:
        """Return n such parts, which do not touch each other."""
        contacts = np.zeros(2 * n, dtype=CONTACT_DTYPE)
        contacts["low"], contacts["high"] = np.tile([0.0, -math.inf], n), math.inf
        contacts["scale"], contacts["restitution"] = 1.0, np.tile([self.restitution, 0.0], n)
        contacts["friction_input"], contacts["normal"] = NO_INDEX, NO_INDEX
        contacts["normal"][1::2], contacts["friction_coefficient"][1::2] = np.arange(0, 2 * n, 2), self.friction
        none, compliance = np.zeros(0), np.kron(np.eye(n), self.compliance)
        motion = np.tile([0.0, 1.0], n), np.tile(self.rates, n), np.zeros(2 * n), compliance, np.zeros(2 * n)
        return ContactDynamics(contacts, *motion, none, none, 1.0, 1.0, 2 * n, is_driven=False)

    def impulses(self, n: int = 1) -> np.ndarray:
        """Return the impulses along gap and slip of n such parts."""
        impulses = np.zeros(2 * n)
        resolve_impacts(self.dynamics(n), np.zeros(2 * n, dtype=np.int64), impulses)
        return impulses


@st.composite
def strikes(draw):
    """Draw masses, an eccentricity short of a mechanism without inertia, friction, restitution and rates."""
    gap, slip, eccentricity = draw(st.floats(0.1, 3)), draw(st.floats(0.1, 3)), draw(st.floats(-0.95, 0.95))
    coupling = eccentricity * math.sqrt(gap * slip)
    rates = np.array([-draw(st.floats(0.1, 2)), draw(st.floats(-2, 2))])
    return Strike(np.array([[gap, coupling], [coupling, slip]]), draw(st.floats(0, 3)), draw(st.floats(0, 1)), rates)


@given(strikes(), st.integers(1, 2))
@example(Strike(np.array([[0.5, 0.35], [0.35, 1.0]]), 0.5, 1.0, np.array([-1.0, 5e-324])), 1)  # times a slope, this slip rounds to 0
def test_no_impact_gains_energy_and_friction_is_within_its_limit(strike, n):
    impulses = strike.impulses(n)
    after = strike.rates + strike.compliance @ impulses[:2]
    np.testing.assert_allclose(impulses[2:], impulses[:-2], rtol=1e-12)  # two equal parts, far from each other
    assert dissipated_by_impulses(strike.dynamics(n), impulses) >= -1e-12
    assert impulses[0] > 0.0
    assert after[0] >= -1e-12
    assert abs(impulses[1]) <= strike.friction * impulses[0] * (1 + 1e-9) + 1e-12


def follow_rates(strike: Strike) -> np.ndarray:
    """Follow the rates over the normal impulse with events of scipy; return the impulses along gap and slip."""
    state, impulse, work_taken = np.array([*strike.rates, 0.0, 0.0]), 0.0, None
    coupling, by_slip = strike.compliance[0, 1], strike.compliance[1, 1]
    while True:
        sticks = state[1] == 0.0 and abs(coupling) <= strike.friction * by_slip
        ratio = -coupling / by_slip if sticks else -math.copysign(strike.friction, state[1] or coupling)
        slopes = strike.compliance @ [1.0, ratio] * [1.0, not sticks]
        sense = np.sign(state[1])
        stop = lambda p, y, sense=sense: y[1] * sense if sense else 1.0  # noqa: E731
        part_end = (lambda p, y: y[0]) if work_taken is None else (lambda p, y: y[2] - (1 - strike.restitution**2) * work_taken)  # noqa: B023
        stop.terminal = part_end.terminal = True
        stop.direction, part_end.direction = -1, 1
        solution = solve_ivp(
            lambda p, y, slopes=slopes, ratio=ratio: [*slopes, y[0], ratio],
            (impulse, 1e4),
            state,
            events=[stop, part_end],
            rtol=1e-12,
            atol=1e-14,
        )
        impulse, state = solution.t[-1], solution.y[:, -1].copy()
        if len(solution.t_events[0]):
            state[1] = 0.0
        if len(solution.t_events[1]):
            if work_taken is not None or strike.restitution == 0.0:
                return np.array([impulse, state[3]])
            work_taken, state[0] = state[2], 0.0


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
@pytest.mark.parametrize(
    ("coupling", "friction", "slip"),
    [(0.9, 0.3, 1.0), (0.9, 0.3, -0.4), (-0.9, 2.0, 0.5), (0.9, 2.0, 0.5), (0.9, 0.5, 0.05), (0.9, 1.0, 0.0), (0.0, 0.4, 0.2)],
    ids=["slides", "turns back", "stops", "jams and stops", "stops and turns", "sticks", "central"],
)
def test_an_impact_follows_the_rates_as_the_normal_force_acts(restitution, coupling, friction, slip):
    strike = Strike(np.array([[1.0, coupling], [coupling, 1.2]]), friction, restitution, np.array([-1.0, slip]))
    np.testing.assert_allclose(strike.impulses(), follow_rates(strike), rtol=1e-10, atol=1e-12)


def test_newtons_restitution_would_gain_energy_where_the_sliding_stops():
    """With impulses along a gap that ends at -e times its rate, and a slip that sticks at the end."""
    strike = Strike(np.array([[1.0, 0.9], [0.9, 1.0]]), 3.0, 1.0, np.array([-1.0, -1.0]))
    newton = np.linalg.solve(strike.compliance, [2.0, -1.0])
    assert abs(newton[1]) < strike.friction * newton[0]
    assert dissipated_by_impulses(strike.dynamics(), newton) < -2.0
    assert dissipated_by_impulses(strike.dynamics(), strike.impulses()) > 0.0
    two = strike.impulses(2)  # at once: without restitution
    assert dissipated_by_impulses(strike.dynamics(2), two) > 0.0
    np.testing.assert_allclose((strike.compliance @ two[:2])[0] + strike.rates[0], 0.0, atol=1e-12)


def test_what_cannot_move_bears_no_strike_and_what_cannot_slide_no_friction():
    """As parts that drives move, or guides hold."""
    np.testing.assert_array_equal(Strike(np.zeros((2, 2)), 0.3, 0.5, np.array([-1.0, 0.5])).impulses(), 0.0)
    held = Strike(np.array([[2.0, 0.0], [0.0, 0.0]]), 0.3, 0.5, np.array([-1.0, 0.0]))
    np.testing.assert_allclose(held.impulses(), [0.75, 0.0])

"""Two rotors that a gear joins: balances of momentum and energy, and a stiff, damped shaft in the limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.governed_engine import geared_rotors as closed
from governor_mechanism.closed_form.governed_engine.geared_rotors import GearedRotors
from governor_mechanism.errors import MechanismError

ROTORS = st.builds(
    GearedRotors, first_inertia=st.floats(0.1, 10), second_inertia=st.floats(0.1, 10), ratio=st.floats(0.2, 5) | st.floats(-5, -0.2)
)
SPEEDS = st.floats(-50, 50)


@given(ROTORS, SPEEDS, SPEEDS)
def test_momentum_and_energy_of_engagement(rotors: GearedRotors, first: float, second: float) -> None:
    speeds = {"first_speed": first, "second_speed": second}
    after, impulse = closed.engaged_speed(rotors, **speeds), closed.engagement_impulse(rotors, **speeds)
    # each side is a few roundings of terms up to 1e5
    assert_allclose(rotors.first_inertia * (after - first), -rotors.ratio * impulse, atol=1e-9)
    assert_allclose(rotors.second_inertia * (rotors.ratio * after - second), impulse, atol=1e-9)
    before = (rotors.first_inertia * first**2 + rotors.second_inertia * second**2) / 2
    assert_allclose(before - rotors.referred_inertia * after**2 / 2, closed.engagement_loss(rotors, **speeds), atol=1e-8)


def test_a_slipping_clutch_ends_at_the_engaged_speed() -> None:
    rotors, torques = GearedRotors(first_inertia=2.0, second_inertia=0.3, ratio=-2.5), {"first_torque": 0.0, "second_torque": 0.0}
    first, second, friction = 10.0, 4.0, 5.0

    def right_side(_: float, speeds: np.ndarray) -> list[float]:
        passed = friction * (rotors.ratio * speeds[0] - speeds[1])
        return [-rotors.ratio * passed / rotors.first_inertia, passed / rotors.second_inertia]

    run = solve_ivp(right_side, (0, 5), [first, second], method="DOP853", rtol=1e-12, atol=1e-12)
    expected = closed.engaged_speed(rotors, first_speed=first, second_speed=second)
    # the slip has decayed by exp(-160); the integrator leaves 1e-11
    assert_allclose(run.y[:, -1], [expected, rotors.ratio * expected], rtol=1e-10)
    assert closed.geared_acceleration(rotors, **torques) == closed.transmitted_torque(rotors, **torques) == 0


@given(ROTORS, SPEEDS, SPEEDS)
def test_both_rotors_obey_newton_under_torques(rotors: GearedRotors, first: float, second: float) -> None:
    torques = {"first_torque": first, "second_torque": second}
    acceleration, passed = closed.geared_acceleration(rotors, **torques), closed.transmitted_torque(rotors, **torques)
    assert_allclose(rotors.first_inertia * acceleration, first - rotors.ratio * passed, atol=1e-9)
    assert_allclose(rotors.second_inertia * rotors.ratio * acceleration, second + passed, atol=1e-9)


def test_refusals() -> None:
    with pytest.raises(MechanismError, match="some inertia"):
        GearedRotors(first_inertia=0.0, second_inertia=1.0, ratio=0.0)
    with pytest.raises(MechanismError, match="second_inertia must be 0"):
        GearedRotors(first_inertia=1.0, second_inertia=-1.0, ratio=1.0)

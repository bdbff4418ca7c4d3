"""Closed forms of the governor whose weights rub on a drum: the balance of its torques, and its run-up."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.closed_form import friction_governor as closed
from governor_mechanism.closed_form.friction_governor import FrictionGovernor

GOVERNORS = st.builds(
    FrictionGovernor,
    weights=st.integers(1, 6), mass=st.floats(0.01, 2.0), radius=st.floats(0.01, 0.5), drum=st.floats(0.02, 0.6),
    friction=st.floats(0.05, 0.6), rubbing_speed=st.floats(1.0, 80.0),
)  # fmt: skip


def test_weights_press_by_the_excess_of_their_centrifugal_force():
    governor = FrictionGovernor(weights=3, mass=0.2, radius=0.05, drum=0.06, friction=0.25, rubbing_speed=20.0)
    # A weight presses with 0.2 kg x 0.05 m x (30^2 - 20^2) / s2 = 5 N; three rub with 0.25 of it at 0.06 m.
    assert closed.braking_torque(governor, speed=30.0) == pytest.approx(3 * 0.25 * 5.0 * 0.06, rel=1e-15)
    assert closed.braking_torque(governor, speed=np.array([0.0, 20.0])).tolist() == [0.0, 0.0]


@given(GOVERNORS, st.floats(0.1, 50.0))
def test_the_steady_speed_balances_the_torque(governor, torque):
    speed = closed.steady_speed(governor, torque=torque)
    assert closed.braking_torque(governor, speed=speed) == pytest.approx(
        torque, rel=1e-9, abs=1e-12 * governor.torque_coefficient * speed**2
    )


@given(GOVERNORS, st.floats(0.1, 50.0), st.floats(0.01, 5.0), st.floats(0.05, 2.0))
def test_the_run_up_starts_where_the_weights_press_and_obeys_the_torques(governor, torque, inertia, share):
    state = {"torque": torque, "inertia": inertia}
    end = closed.steady_speed(governor, torque=torque)
    assert closed.speed_at(governor, time=0.0, **state) == pytest.approx(governor.rubbing_speed, rel=1e-12)
    time = share * inertia / (governor.torque_coefficient * end)  # in time constants
    step = 1e-3 * time
    before, here, after = closed.speed_at(governor, time=time + step * np.arange(-1, 2), **state)
    assert (1 - 1e-12) * governor.rubbing_speed <= here <= end
    excess = torque - closed.braking_torque(governor, speed=here)
    rounding = 1e-14 * inertia * end / step
    assert inertia * (after - before) / (2 * step) == pytest.approx(excess, rel=1e-4, abs=rounding + 1e-12 * torque)


def test_the_run_up_ends_at_the_steady_speed():
    governor = FrictionGovernor(weights=2, mass=0.5, radius=0.1, drum=0.12, friction=0.3, rubbing_speed=10.0)
    end = closed.speed_at(governor, time=1e3, torque=4.0, inertia=0.2)
    assert end == pytest.approx(closed.steady_speed(governor, torque=4.0), rel=1e-15)

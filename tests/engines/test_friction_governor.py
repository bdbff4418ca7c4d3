"""A friction governor: torque of its weights on the drum, steady speed and the way there, against the closed form."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.friction_governor import FrictionGovernor, braking_torque, speed_at, steady_speed
from governor_mechanism.errors import MechanismError

GOVERNOR = FrictionGovernor(weights=2, mass=0.2, radius=0.06, drum=0.04, friction=0.3, rubbing_speed=600 * math.tau / 60)
TORQUE = 0.5
INERTIA = 2e-3 + 2 * (1e-4 + 0.2 * 0.06**2)


def test_the_steady_speed_is_that_at_which_the_torque_of_the_weights_balances_the_drive():
    speed = steady_speed(GOVERNOR, torque=TORQUE)
    assert braking_torque(GOVERNOR, speed=speed) == pytest.approx(TORQUE, rel=1e-14)
    assert GOVERNOR.torque_coefficient == pytest.approx(2 * 0.3 * 0.2 * 0.06 * 0.04, rel=1e-15)  # n mu m r R
    np.testing.assert_array_equal(braking_torque(GOVERNOR, speed=np.array([0.0, 62.8])), [0.0, 0.0])
    times = np.linspace(0.0, 0.5, 2001)
    rates = np.gradient(speed_at(GOVERNOR, time=times, torque=TORQUE, inertia=INERTIA), times, edge_order=2)
    speeds = speed_at(GOVERNOR, time=times, torque=TORQUE, inertia=INERTIA)
    np.testing.assert_allclose(INERTIA * rates, TORQUE - braking_torque(GOVERNOR, speed=speeds), atol=1e-5)
    with pytest.raises(MechanismError, match="torque"):
        steady_speed(GOVERNOR, torque=0.0)


def test_the_shipped_governor_comes_to_its_steady_speed_as_the_closed_form():
    run = gm.run("friction_governor", accuracy=1e-8)
    speeds = run.rates["shaft_angle"]
    assert run.outcome is gm.Outcome.DONE
    np.testing.assert_allclose(speeds, speed_at(GOVERNOR, time=run.times, torque=TORQUE, inertia=INERTIA), rtol=1e-8)
    assert speeds[-1] == pytest.approx(steady_speed(GOVERNOR, torque=TORQUE), rel=2e-4)
    push, rub = run.readings["contact.shoe_1.force"], run.readings["contact.shoe_1.friction"]
    np.testing.assert_allclose(push, 0.2 * 0.06 * (speeds**2 - GOVERNOR.rubbing_speed**2), atol=1e-6)
    np.testing.assert_allclose(np.abs(rub), 0.3 * push, atol=1e-6)
    np.testing.assert_allclose(2 * np.abs(rub) * 0.04, braking_torque(GOVERNOR, speed=speeds), atol=1e-7)
    lost = np.trapezoid(braking_torque(GOVERNOR, speed=speeds) * speeds, run.times)
    assert run.energy.dissipated_energy[-1] == pytest.approx(lost, rel=1e-4)
    assert run.energy.drift < 1e-8


@pytest.mark.parametrize(("torque", "friction"), [(0.1, 0.3), (1.0, 0.15)])
def test_another_torque_or_friction_has_another_speed(torque, friction):
    scene = gm.load("friction_governor").replace(
        {"dimensions.torque": f"{torque} N m", "dimensions.friction": friction, "run.duration": 2.0}
    )
    run = gm.run(scene, times=np.array([0.0, 2.0]))
    governor = FrictionGovernor(**vars(GOVERNOR) | {"friction": friction})
    assert run.rates["shaft_angle"][-1] == pytest.approx(speed_at(governor, time=2.0, torque=torque, inertia=INERTIA), rel=1e-6)

"""Where a motion leaves its table at a bound of the coordinate: few steps, the exact time, and no end where it turns back before."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import governor_mechanism as gm
from governor_mechanism.model.results.records import Outcome


def fall_time(mass):
    """Return the time (s) in which the shipped Porter governor with a sleeve of a mass (kg) falls until arms and links are in line."""
    arm, offset, ball, speed, gravity, start = 0.3, 0.04, 5.0, 4.0 * math.pi, 9.81, math.radians(40.0)

    def potential(angle):
        return -2 * (ball + mass) * gravity * arm * np.cos(angle) - ball * (speed * (offset + arm * np.sin(angle))) ** 2

    def reciprocal_rate(root):  # the angle is the start less the square of the root, so that the integrand is regular
        angle = start - root**2
        inertia = 2 * ball * arm**2 + mass * (2 * arm * math.sin(angle)) ** 2
        return 2 * root / math.sqrt(2 * (potential(start) - potential(angle)) / inertia)

    # Near the start the difference of the potentials cancels, to 1e-16 / 1e-7; that part of the time is linear in the root.
    first = 3e-4
    return quad(reciprocal_rate, first, math.sqrt(start), epsabs=1e-13, epsrel=1e-13)[0] + first * reciprocal_rate(first)


@pytest.mark.parametrize("mass", [70.0, 75.0, 85.0])
def test_a_fall_to_a_change_point_ends_in_few_steps_at_the_time_of_the_energy_integral(mass):
    """The steps shrink before that point, and the table ends before it, where rounding grows; the rest of the travel is extrapolated."""
    scene = gm.load("porter").replace({"dimensions.sleeve_mass": mass, "run.duration": 2.0, "run.accuracy": 1e-8})
    run = gm.run(scene, engine="reduced", certify=False)
    assert run.outcome is Outcome.LEFT_RANGE
    assert run.cost.steps < 40  # 27, and half as many more
    assert run.cost.evaluations["table pieces"] < 35  # 23, likewise
    time = float(run.detail.rpartition("t = ")[2].removesuffix(" s"))
    # Nine digits are printed; the accuracy promises 1e-8 of the characteristic time, 1 / (4 pi rad/s).
    assert time == pytest.approx(fall_time(mass), abs=1.3e-9)


@pytest.mark.parametrize("start", [89.985, 89.9855, 89.99])
def test_a_motion_that_turns_back_just_before_its_bound_does_not_leave_the_range(start):
    """The arms swing up to 89.998 or 89.9935 degrees, nearer to the horizontal than a table reaches: another engine follows them."""
    changes = {"spindle.speed": 1000.0, "start": {"arm_angle": math.radians(start)}, "run.duration": 0.05}
    scene = gm.load("porter").replace(changes)
    assert gm.run(scene, engine="reduced").outcome is Outcome.DEAD_CENTRE
    run = gm.run(scene)
    assert run.outcome is Outcome.DONE
    assert run.cost.engine == "multibody"
    assert math.degrees(run.readings["arm_angle"].max()) < 90.0

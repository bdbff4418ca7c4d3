"""Bounces against a stop, of which infinitely many take a finite time."""

import pytest

from governor_mechanism.mechanics.contact.impacts import zeno_time


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

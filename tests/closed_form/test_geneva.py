"""The Geneva wheel in closed form: printed peaks, derivatives, entry at rest, refusals."""

import math

import numpy as np
import pytest

from governor_mechanism.closed_form.geneva import acceleration_ratio, engaged_angle, speed_ratio, wheel_angle


@pytest.mark.parametrize("slots", [3, 4, 6, 8])
def test_the_wheel_turns_by_a_slot_from_rest_to_rest(slots):
    ends = np.array([-1, 1]) * engaged_angle(slots)
    np.testing.assert_allclose(wheel_angle(slots, driver_angle=ends), np.array([-1, 1]) * math.pi / slots, rtol=1e-14)
    np.testing.assert_allclose(speed_ratio(slots, driver_angle=ends), 0, atol=1e-15)


@pytest.mark.parametrize("slots", [3, 4, 6, 8])
def test_speed_and_acceleration_are_derivatives(slots):
    angle, h = np.linspace(-0.95, 0.95, 39) * engaged_angle(slots), 1e-5
    for function, derivative in ((wheel_angle, speed_ratio), (speed_ratio, acceleration_ratio)):
        above, below = (function(slots, driver_angle=angle + sign * h) for sign in (1, -1))
        np.testing.assert_allclose((above - below) / (2 * h), derivative(slots, driver_angle=angle), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("slots", "speed", "acceleration"), [(4, 2.414, 5.41), (6, 1.0, 1.35)])
def test_peaks_are_those_of_handbooks(slots, speed, acceleration):
    angle = np.linspace(-1, 1, 20_001) * engaged_angle(slots)
    peaks = [np.max(ratio(slots, driver_angle=angle)) for ratio in (speed_ratio, acceleration_ratio)]
    assert peaks[0] == pytest.approx(speed, abs=0.0005)  # half a unit of the last digit
    assert peaks[1] == pytest.approx(acceleration, abs=0.005)
    assert peaks[0] == pytest.approx(math.sin(math.pi / slots) / (1 - math.sin(math.pi / slots)), rel=1e-12)

"""The disc cam in closed form: laws of lift, derivatives, and the least speed of lift-off against a search."""

import math

import numpy as np
import pytest

from governor_mechanism.closed_form.disc_cam import CamRise, contact_force, lift_at, lift_off_share, lift_off_speed
from refusing import refuses

LAWS = ["cycloidal", "harmonic"]


def rise_of(law, **values):
    return CamRise(law=law, **({"lift": 0.015, "angle": 2.1, "mass": 0.4, "stiffness": 2000.0, "preload": 24.0} | values))


@pytest.mark.parametrize("law", LAWS)
def test_a_rise_begins_and_ends_at_rest_and_its_derivatives_are_those_of_differences(law):
    rise, share, h = rise_of(law), np.linspace(0.05, 0.95, 19), 1e-5
    assert [lift_at(rise, share=one) for one in (0.0, 0.5, 1.0)] == pytest.approx([0, 0.0075, 0.015], abs=1e-17)
    assert [lift_at(rise, share=one, derivative=1) for one in (0.0, 1.0)] == pytest.approx([0, 0], abs=1e-17)
    for k in range(3):
        above, below = (lift_at(rise, share=share + sign * h, derivative=k) for sign in (1, -1))
        exact = lift_at(rise, share=share, derivative=k + 1)
        np.testing.assert_allclose((above - below) / (2 * h * rise.angle), exact, atol=1e-9)


def test_known_peaks_of_velocity_and_acceleration():
    """2 h / beta and 2 pi h / beta^2 of the cycloidal law, pi h / 2 beta and pi^2 h / 2 beta^2 of the harmonic one."""
    peaks = {"cycloidal": (2, 2 * math.pi), "harmonic": (math.pi / 2, math.pi**2 / 2)}
    for law, factors in peaks.items():
        rise, share = rise_of(law), np.linspace(0, 1, 4001)
        for k, factor in enumerate(factors, start=1):
            assert np.abs(lift_at(rise, share=share, derivative=k)).max() == pytest.approx(factor * rise.lift / rise.angle**k, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("stiffness", [0.0, 300.0, 2000.0, 1e5])
def test_at_the_speed_of_lift_off_the_least_force_is_zero(law, stiffness):
    rise, share = rise_of(law, stiffness=stiffness), np.linspace(0, 1, 20_001)
    speed = lift_off_speed(rise)
    assert np.min(contact_force(rise, share=share, speed=speed)) == pytest.approx(0, abs=1e-7 * (24 + stiffness * 0.015))  # the grid
    assert np.min(contact_force(rise, share=share, speed=1.01 * speed)) < 0
    first = lift_off_share(rise, speed=1.01 * speed)
    force = contact_force(rise, share=share, speed=1.01 * speed)
    assert first == pytest.approx(share[np.flatnonzero(force < 0)[0]], abs=1e-4)


def test_without_spring_and_with_its_own_weight_an_eccentric_lifts_off_at_the_root_of_g_over_its_eccentricity():
    rise = rise_of("harmonic", stiffness=0.0, angle=math.pi, preload=0.4 * 9.81)
    assert lift_off_speed(rise) == pytest.approx(math.sqrt(9.81 / 0.0075), rel=1e-12)


def test_wrong_values_are_refused():
    refuses("'cycloidal' or 'harmonic'; got 'parabolic'", rise_of, "parabolic")
    for name in ("lift", "angle", "mass"):
        refuses(name, rise_of, "harmonic", **{name: 0.0})
    refuses("preload", rise_of, "harmonic", preload=-1.0)
    refuses("derivative must be", lift_at, rise_of("harmonic"), share=0.5, derivative=4)
    refuses("stays on the cam up to", lift_off_share, rise_of("harmonic"), speed=1.0)

"""Closed forms of Stephenson's link motion: Zeuner's law, the exact position, and the law as the limit of small eccentrics."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.closed_form import stephenson as closed
from governor_mechanism.errors import MechanismError
from reference import stephenson as printed

GEAR = closed.LinkGear(radius=0.06, rod=1.2, advance=math.radians(30), link_radius=1.2, half_link=0.15, hanger=0.5)
TURN = np.linspace(0.0, math.tau, 24, endpoint=False)
"""Twenty-four angles resolve the first harmonic exactly up to the eleventh."""


def first_harmonic(values):
    harmonic = 2 * np.fft.rfft(values)[1] / len(values)
    return harmonic.real, -harmonic.imag


@pytest.mark.parametrize("ratio", printed.FIRST_ORDER_AMPLITUDES)
def test_amplitudes_of_the_first_order_law(ratio):
    found = closed.first_order_amplitudes(GEAR, offset_ratio=ratio)
    np.testing.assert_allclose(found, printed.FIRST_ORDER_AMPLITUDES[ratio], atol=1e-13)  # printed to twelve digits


def test_in_full_gear_the_law_is_that_of_one_eccentric():
    displacement = closed.first_order_displacement(GEAR, crank_angle=TURN, offset_ratio=1.0)
    np.testing.assert_allclose(displacement, 0.06 * np.sin(TURN + math.radians(30)), atol=1e-15)


@pytest.mark.parametrize("gear", printed.SMALL_ECCENTRIC_RATIOS)
def test_small_eccentrics_follow_the_law_up_to_the_finite_link(gear):
    """The ratios are printed to four decimals; the law is taken at the mean die offset."""
    small = replace(GEAR, radius=1e-5)
    position = closed.link_position(small, crank_angle=TURN, gear=gear)
    law = closed.first_order_amplitudes(small, offset_ratio=float(np.mean(position.die_offset)) / small.half_link)
    for found, expected, ratio in zip(first_harmonic(position.valve), law, printed.SMALL_ECCENTRIC_RATIOS[gear], strict=True):
        if ratio is not None:
            assert abs(found / expected - ratio) < 2e-4  # upper and lower gear differ by 1e-4


@pytest.mark.parametrize("gear", [1, 0.5, -1])
def test_crossed_rods_of_small_eccentrics_follow_the_law(gear):
    """The forward eccentric drives the lower pin: the sine term changes its sign against open rods."""
    small = replace(GEAR, radius=1e-5, crossed=True)
    position = closed.link_position(small, crank_angle=TURN, gear=gear)
    law = closed.first_order_amplitudes(small, offset_ratio=float(np.mean(position.die_offset)) / small.half_link)
    # The law takes the rods for long: what it leaves out is of the size (c / l)^2 / 2 = 0.8 %.
    np.testing.assert_allclose(first_harmonic(position.valve), law, rtol=0.01)


def test_the_distance_from_the_limit_is_of_first_order_in_the_eccentricity():
    def sine_amplitude(radius):
        return first_harmonic(closed.link_position(replace(GEAR, radius=radius), crank_angle=TURN, gear=1.0).valve)[1] / radius

    limit = sine_amplitude(1e-6)
    differences = np.array([abs(sine_amplitude(radius) - limit) for radius in (0.04, 0.02, 0.01, 0.005)])
    ratios = differences[:-1] / differences[1:]
    assert np.all(np.diff(differences) < 0)
    assert 1.8 < ratios[-1] < 4.2  # between first and second order: harmonics of odd powers cancel in part


def test_crossed_rods_mirror_the_variation_of_the_lead():
    """Zeuner: with open rods the lead grows toward mid gear, with crossed rods it shrinks."""
    open_rods, crossed_rods = (
        np.array([closed.first_order_amplitudes(replace(GEAR, crossed=crossed), offset_ratio=ratio)[0] for ratio in (0.0, 1.0)])
        for crossed in (False, True)
    )
    assert open_rods[0] - open_rods[1] == pytest.approx(crossed_rods[1] - crossed_rods[0], rel=1e-14)
    for crossed, sign in ((False, 1.0), (True, -1.0)):
        exact = [closed.link_position(replace(GEAR, crossed=crossed), crank_angle=np.array([0.0, math.pi]), gear=gear) for gear in (0, 1)]
        leads = [float(one.valve[0] - one.valve[1]) / 2 for one in exact]
        assert sign * (leads[0] - leads[1]) > 0.005


def test_a_mirrored_gear_has_the_mirrored_motion():
    """Without its hanger's side, the gear is symmetric: with a long hanger, back gear is forward gear run backward."""
    long_hanger = replace(GEAR, hanger=1e6)
    forward = closed.link_position(long_hanger, crank_angle=TURN, gear=0.7)
    backward = closed.link_position(long_hanger, crank_angle=-TURN, gear=-0.7)
    # the arc of a hanger of 1000 km departs from its tangent by 1e-8 m
    np.testing.assert_allclose(forward.valve, backward.valve, atol=1e-7)
    np.testing.assert_allclose(forward.die_offset, -np.asarray(backward.die_offset), atol=1e-7)


@given(
    st.builds(
        closed.LinkGear,
        radius=st.floats(0.01, 0.08),
        rod=st.floats(0.9, 1.6),
        advance=st.floats(0.0, 0.9),
        link_radius=st.floats(0.8, 1.6),
        half_link=st.floats(0.1, 0.2),
        setback=st.floats(0.0, 0.05),
        suspension_x=st.floats(-0.05, 0.05),
        suspension_y=st.floats(-0.15, 0.15),
        hanger=st.floats(0.4, 0.8),
        crossed=st.booleans(),
    ),
    st.floats(0.0, math.tau),
    st.floats(-1.0, 1.0),
)
def test_rods_hanger_and_arc_keep_their_lengths(gear, crank_angle, lever):
    """The places of the pins, by complex numbers, from those of die and link that the closed form returns."""
    position = closed.link_position(gear, crank_angle=crank_angle, gear=lever)
    turn = complex(math.cos(position.link_angle), math.sin(position.link_angle))
    die_turn = np.exp(1j * position.die_offset / gear.link_radius)
    middle = position.valve + gear.link_radius * turn * (1.0 - die_turn)  # from the die along the arc, which is on the valve line
    behind = gear.setback + gear.link_radius - math.sqrt(gear.link_radius**2 - gear.half_link**2)
    for side, angle in ((1, gear.advance), (-1, math.pi - gear.advance)):  # the forward and the backward eccentric
        pin = middle + turn * complex(-behind, (-side if gear.crossed else side) * gear.half_link)
        eccentric = 1j * gear.radius * np.exp(-1j * (crank_angle + angle))
        assert abs(pin - eccentric) == pytest.approx(gear.rod, abs=1e-12)
    # the hanger's fixed end is right above the suspension of a level link, with the die at the pin of the gear
    level = math.sqrt(gear.rod**2 - gear.half_link**2) + behind + gear.suspension_x
    raised = lever * gear.link_radius * math.asin(gear.half_link / gear.link_radius) * (-1 if gear.crossed else 1)
    fixed_end = complex(level, gear.suspension_y - raised + gear.hanger)
    suspension = middle + turn * complex(gear.suspension_x, gear.suspension_y)
    assert abs(suspension - fixed_end) == pytest.approx(gear.hanger, abs=1e-12)


@pytest.mark.parametrize("crossed", [False, True])
def test_small_eccentrics_in_full_gear_move_the_valve_as_the_forward_one_does(crossed):
    long_rods = replace(GEAR, radius=1e-5, rod=50.0, link_radius=50.0, hanger=50.0, crossed=crossed)
    valve = closed.link_position(long_rods, crank_angle=TURN, gear=1.0).valve
    # rods of fifty metres leave out the square of half the link over their length
    np.testing.assert_allclose(valve - np.mean(valve), 1e-5 * np.sin(TURN + GEAR.advance), atol=1e-7)


def test_a_gear_without_position_is_refused():
    for changes in ({"radius": 0.5, "hanger": 0.05}, {"radius": 2.0}):  # the hanger does not reach; the rods do not meet
        for degrees in (0, 90, -90):
            with pytest.raises(MechanismError, match=f"the link cannot be assembled at a crank angle of {degrees} deg in gear 1"):
                closed.link_position(replace(GEAR, **changes), crank_angle=math.radians(degrees), gear=1.0)

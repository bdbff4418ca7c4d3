"""Quantities of a sweep against exact solutions, what is chosen by default, and rows that lack a number."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ellipk

import governor_mechanism as gm
from governor_mechanism.studies.sweep.quantities import parse_quantities
from governor_mechanism.studies.sweep.rules import (
    SETTLED_RATIO,
    STATISTICS,
    ReadingSamples,
    RunNumbers,
    Taken,
    find_turning_points,
    mean_value,
)
from governor_mechanism.studies.sweep.run import choose_quantities


def oscillation(n_per_period, phase=0.4, *, is_smooth=True):
    """An oscillation of period 1 with a harmonic, mean 0.3; its turning points are those of the sum of both cosines."""
    times = np.arange(int(4.2 * n_per_period) + 1) / (n_per_period + 0.37)  # no whole number of times in a period
    values = 0.3 + np.cos(math.tau * times + phase) + 0.1 * np.cos(2 * (math.tau * times + phase))
    rates = -math.tau * (np.sin(math.tau * times + phase) + 0.2 * np.sin(2 * (math.tau * times + phase)))
    return ReadingSamples(times, values, rates, 1e-6, is_smooth)


@pytest.mark.parametrize(("is_smooth", "order"), [(True, 8), (False, 4)])
def test_turning_points_converge_with_the_order_of_their_polynomial(is_smooth, order):
    """Both cosines are extreme at the same times: the amplitude is 1 and the period 1."""
    errors = []
    for n_per_period in (15, 30):
        worst_amplitude = worst_frequency = 0.0
        for phase in np.linspace(0.0, 1.0, 12):  # an error depends on where between two times an extremum is
            points = find_turning_points(oscillation(n_per_period, phase, is_smooth=is_smooth))
            start, end, n_periods = points.whole_oscillations()
            worst_amplitude = max(worst_amplitude, abs(points.amplitude(0.0) - 1.0))
            worst_frequency = max(worst_frequency, abs(n_periods / (end - start) - 1.0))
        errors.append((worst_amplitude, worst_frequency))
    # Half the step; the next order still adds some at 15 times in a period, hence the factor 2. Times are one order worse.
    assert errors[1][0] < 2 * errors[0][0] / 2**order
    assert errors[1][1] < 2 * errors[0][1] / 2 ** (order - 1)
    assert max(errors[1]) < (1e-7 if is_smooth else 1e-3)


def test_a_mean_is_that_over_whole_oscillations():
    samples = oscillation(40)
    assert mean_value(samples, find_turning_points(samples)) == pytest.approx(0.3, abs=1e-7)  # cubics at 40 points a period


def test_noise_and_rest_are_no_oscillation():
    times = np.linspace(0.0, 1.0, 101)
    noise = 1e-9 * np.random.default_rng(1).standard_normal((2, 101))
    assert not find_turning_points(ReadingSamples(times, noise[0], noise[1], 1e-6, True)).times.size
    assert not find_turning_points(ReadingSamples(times, np.ones(101), np.zeros(101), 1e-6, True)).times.size
    wave = ReadingSamples(times, np.sin(20 * times) + noise[0], 20 * np.cos(20 * times) + noise[1], 1e-6, True)
    assert find_turning_points(wave).is_upper.tolist() == [True, False, True, False, True, False]


def test_the_frequency_of_a_pendulum_is_the_exact_one():
    """Released from the horizontal: period 4 K(sin 45 deg) sqrt(l / g), amplitude 90 deg about the vertical."""
    found = gm.sweep("pendulum_iftomm", {"effects.gravity": [9.81, 5.0]}, ["mean angle", "amplitude of angle", "frequency of angle"])
    for row, gravity in zip(found.rows, (9.81, 5.0), strict=True):
        mean, amplitude, frequency = row.numbers
        exact = math.sqrt(gravity) / (4.0 * ellipk(0.5))
        assert frequency == pytest.approx(exact, rel=1e-6)  # the accuracy of the scene
        assert (mean, amplitude) == pytest.approx((-math.pi / 2, math.pi / 2), abs=1e-6)
    assert list(found.units.values())[1:] == ["rad", "rad", "Hz"]


def test_a_damped_governor_settles_at_its_equilibrium():
    scene = gm.load("porter_dashpot").replace({"effects.dashpot.sleeve": "150 N s/m"})
    speeds = [12.0, 12.8]
    found = gm.sweep(scene, {"spindle.speed": speeds})
    assert [one.name for one in found.quantities] == ["settled arm_angle"]
    assert "(chosen because friction or dashpots damp the motion)" in str(found)
    for speed, settled in zip(speeds, found.column("settled arm_angle"), strict=True):
        stable = [one for one in gm.equilibria(scene, spindle_speed=speed) if one.stable]
        assert min(abs(one.coordinate - settled) for one in stable) < SETTLED_RATIO


def turning(angles, speeds, times):
    scene = gm.load("slider_crank_torque")
    return RunNumbers(SimpleNamespace(scene=scene, times=times, readings={"crank": angles}, rates={"crank": speeds}))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_speed_of_a_crank_fluctuates_as_its_exact_motion(direction):
    """A phase 10 t + 0.02 sin(20 t): speed 10 + 0.4 cos(20 t), so that the coefficient is 2 * 0.4 / 10."""
    times = np.linspace(0.0, 2.0, 801)
    numbers = turning(direction * (10 * times + 0.02 * np.sin(20 * times)), direction * (10 + 0.4 * np.cos(20 * times)), times)
    taken = Taken(numbers, "crank", False, 1.0, 1e-6)
    # A parabola through three of 125 points of a wave misses its peak by some 1e-7 of its height.
    assert STATISTICS["speed fluctuation"].take(taken) == pytest.approx(0.08, abs=1e-6)
    assert STATISTICS["mean speed"].take(taken) == pytest.approx(10.0, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "chosen", "reason"),
    [
        ("porter", "frequency of arm_angle", "nothing damps"),
        ("porter_dashpot", "settled arm_angle", "damp the motion"),
        ("porter_cyclic", "amplitude of arm_angle", "fluctuates"),
        ("porter_dry_friction", "max arm_angle", "changes until the run ends"),
        ("porter_ramp", "min arm_angle", "the speed of the spindle changes"),
        ("air_engine", "speed fluctuation", "gas drives"),
        ("slider_crank_torque", "mean speed of crank_angle", "a crank turns"),
        ("slider_crank", "span crosshead_distance", "drivers prescribe"),
        ("quick_return", "span ram_position", "drivers prescribe"),
        ("stephenson_halfway", "span die_slip", "valve"),
        ("watt_engine_stable", "settled governor.arm_angle", "damp the motion"),
    ],
)
def test_what_characterises_the_motion_is_chosen_with_a_reason(name, chosen, reason):
    scene = gm.load(name)
    names, given_reason = choose_quantities(scene)
    assert chosen in names
    assert reason in given_reason
    assert all(one.unit is not None for one in parse_quantities(scene, names, None, certify=False))


def test_rows_that_do_not_settle_or_oscillate_say_so_and_keep_their_other_numbers():
    found = gm.sweep(
        "porter", {"start.arm_angle": ["equilibrium", "40 deg"]}, ["settled arm_angle", "frequency of arm_angle", "final arm_angle"]
    )
    assert [row.outcome for row in found.rows] == ["no_oscillation", "not_settled"]
    assert np.isnan([row.numbers for row in found.rows]).tolist() == [[False, True, False], [True, False, False]]
    assert found.ok
    assert "1 of 2 rows did not settle: arm_angle still changes in the last 20% of the run" in str(found)
    assert "1 of 2 rows made no whole oscillation" in str(found)
    assert [one["count"] for one in found.as_json()["endings"]] == [1, 1]


def test_refusals_that_differ_in_numbers_alone_are_told_once():
    found = gm.sweep(
        "hartnell", {"dimensions.ball_mass": ["2.9 kg", "2.95 kg", "3 kg"], "effects.spring.sleeve.rate": ["15 N/mm"]}, ["final arm_angle"]
    )
    assert len({row.message for row in found.rows}) == 3
    assert len(found.endings) == 1
    assert f"all 3 rows could not be run; the first at 2.9 kg, 15000 N/m: {found.rows[0].message}" in str(found)

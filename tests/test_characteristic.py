"""The speed curve and the equilibria of any mechanism of mobility one, against tables, closed forms and laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.characteristic import find_equilibria, speed_curve, standing_band
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.equations.reduction import Reduction
from reference.zehnder import CROSSED_MARKS, FRICTION_BAND, SNAP, TABLES
from scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene, random_governor

POINTS_AND_LINKS = {name: table for name, table in TABLES.items() if "arm_mass" not in table["dimensions"]}
IMPROVED = {"arm": SNAP["arm"], "offset": SNAP["offset"], "ball_mass": SNAP["ball_mass"]}


def scene_of(dimensions, speed=10.0):
    return governor_scene(dimensions, speed=speed, angle=0.6)


def close(found, expected):
    # Printed to twelve digits; assembly to 1e-13, which steep places of the curve magnify: 1e-9, as asked.
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", POINTS_AND_LINKS)
def test_every_row_of_the_tables_is_met(name):
    table = POINTS_AND_LINKS[name]
    rows = np.array(table["rows"])
    reduction = Reduction(scene_of(table["dimensions"]))
    along = reduction.at(np.radians(rows[:, 0]))
    square = 2 * along.potential_slope / along.spindle_slope
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
    frequency = stiffness / along.inertia
    whole = table["rest_inertia"] + along.spindle
    close(np.sqrt(square), rows[:, 1])
    close(stiffness, rows[:, 3])
    close(along.inertia, rows[:, 4])
    close(frequency, rows[:, 5])
    close(frequency + square * along.spindle_slope**2 / (whole * along.inertia), rows[:, 6])


def test_the_jumping_governor_has_its_two_equilibria_and_its_fold():
    scene = scene_of(IMPROVED)
    for degrees, speed, _, squared in SNAP["rows"]:
        rests = find_equilibria(scene, speed)
        near = min(rests, key=lambda rest: abs(rest.coordinate - math.radians(degrees)))
        if abs(degrees - SNAP["least_stable_deg"]) > 1:  # at the fold itself two flow together
            assert math.degrees(near.coordinate) == pytest.approx(degrees, abs=1e-7)  # speeds in twelve digits
            assert near.frequency**2 - near.growth_rate**2 == pytest.approx(squared, rel=1e-8)
            assert near.stable == (squared > 0)
    ((angle, speed),) = speed_curve(scene).folds
    assert math.degrees(angle) == pytest.approx(SNAP["least_stable_deg"], abs=1e-9)
    assert speed == pytest.approx(SNAP["lowest_speed"], abs=1e-9)  # asked


def test_below_the_fold_there_is_no_rest_and_above_there_are_two():
    scene = scene_of(CROSSED)
    lowest = CROSSED_MARKS["lowest_speed"]
    assert find_equilibria(scene, lowest * (1 - 1e-6)) == ()
    pair = find_equilibria(scene, lowest * (1 + 1e-6))  # closer together than the points of the scan
    assert [rest.stable for rest in pair] == [False, True]
    ((angle, speed),) = speed_curve(scene).folds
    assert speed == pytest.approx(lowest, abs=1e-9)
    assert math.degrees(angle) == pytest.approx(CROSSED_MARKS["least_stable_deg"], abs=1e-7)


def test_the_standing_band_is_zehnders():
    angle = np.radians([FRICTION_BAND["arm_angle_deg"]])
    band = standing_band(scene_of(PORTER), angle, FRICTION_BAND["resistance"], "sleeve_lift")
    expected = [FRICTION_BAND[name] for name in ("falling_speed", "rising_speed", "insensitivity_exact")]
    np.testing.assert_allclose([part[0] for part in band], expected, rtol=1e-10)  # asked
    with pytest.raises(gm.MechanismError, match="even on a spindle that stands"):
        standing_band(scene_of(PORTER), angle, 1e4, "sleeve_lift")


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_stiffness_is_half_the_inertias_slope_times_the_speeds(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    reduction = Reduction(scene_of(dimensions))
    step = 1e-3
    along = reduction.at(angle + step * np.arange(-2, 3))
    square = 2 * along.potential_slope / along.spindle_slope
    slope = (8 * (square[3] - square[1]) - (square[4] - square[0])) / (12 * step)
    stiffness = along.potential_bend[2] - 0.5 * square[2] * along.spindle_bend[2]
    # Differences of fourth order: step^4 / 30 of a fifth derivative that may reach thousands near a dead centre.
    scale = abs(along.potential_bend[2]) + abs(0.5 * square[2] * along.spindle_bend[2])
    assert stiffness == pytest.approx(0.5 * along.spindle_slope[2] * slope, abs=1e-6 * scale)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_every_equilibrium_is_one_and_both_witnesses_find_the_same(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    governor = closed.PendulumGovernor(**dimensions)
    speed = float(closed.equilibrium_speed(governor, arm_angle=angle))
    scene = scene_of(dimensions, speed)
    rests = find_equilibria(scene, speed)
    assert any(rest.coordinate == pytest.approx(angle, abs=1e-9) for rest in rests)
    for rest in rests:
        here = Reduction(scene).at([rest.coordinate], rest.poses)
        force = here.potential_slope[0] - 0.5 * speed**2 * here.spindle_slope[0]
        assert abs(force) < 1e-10 * abs(here.potential_slope[0])  # Newton ends at rounding
        expected = float(closed.small_oscillation_squared(governor, arm_angle=rest.coordinate, spindle_speed=speed))
        assert rest.frequency**2 - rest.growth_rate**2 == pytest.approx(expected, rel=1e-7, abs=1e-7 * speed**2)


@pytest.mark.parametrize("dimensions", [PORTER, WATT, CROSSED, EXTENDED, UNCROSSED_LINKS])
def test_the_curve_is_the_closed_forms(dimensions):
    curve = speed_curve(scene_of(dimensions), 101)
    inner = curve.held & (curve.coordinate > curve.coordinate[0] + 0.02) & (curve.coordinate < 1.5)
    expected = closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=curve.coordinate[inner])
    np.testing.assert_allclose(curve.speed[inner], expected, rtol=1e-9)
    assert np.all(np.isfinite(curve.speed))
    assert curve.high_end.startswith(("the arms stand at 90", "the link stands at 90"))


def test_a_free_spindle_adds_its_own_inertia_to_the_curve():
    free = speed_curve(gm.load("porter_free_spindle"), 51)
    given = speed_curve(replace(gm.load("porter"), effects=gm.load("porter").effects), 51)
    np.testing.assert_allclose(free.speed, given.speed, rtol=1e-12)
    assert np.all(free.free_frequency_squared[1:] < given.free_frequency_squared[1:])  # J0 unknown counts as none


def test_speeds_and_points_that_are_none_are_refused():
    for speed in (math.nan, math.inf, "fast"):
        with pytest.raises(gm.MechanismError, match="spindle's speed must be"):
            gm.equilibria("porter", speed)
    with pytest.raises(gm.MechanismError, match="2 points or more"):
        gm.speed_curve("porter", 1)


def test_equilibria_of_what_has_no_single_coordinate_are_refused():
    with pytest.raises(gm.MechanismError, match="mobility one without drives"):
        gm.equilibria("quick_return", 1.0)
    with pytest.raises(gm.MechanismError, match="travel of 'crank_angle' is not known"):
        gm.equilibria("four_bar_chain", 1.0)

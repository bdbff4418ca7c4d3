"""The speed curve and the equilibria of any mechanism of mobility one, against tables, closed forms and laws."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.engines.initial_state import stable_equilibrium_poses
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.curves import PolynomialCurve
from governor_mechanism.model.joints import CurveSlot
from governor_mechanism.model.output_variables import Limit, LineAngle
from governor_mechanism.model.part import Start
from governor_mechanism.statics.equilibria import find_equilibria, find_equilibria_or_empty
from governor_mechanism.statics.speed_curve import compute_insensitivity_band, compute_speed_curve, equilibrium_speed_at
from governor_scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene, random_governor
from reference import EQUILIBRIUM_TABLES, zehnder
from scene_parts import body_point, ground_point, link, make_mechanism, point_mass, slider, spring, x_reading

POINTS_AND_LINKS = {name: table for name, table in EQUILIBRIUM_TABLES.items() if "arm_mass" not in table["dimensions"]}
IMPROVED = {"arm": zehnder.FOLD_JUMP["arm"], "offset": zehnder.FOLD_JUMP["offset"], "ball_mass": zehnder.FOLD_JUMP["ball_mass"]}


def scene_of(dimensions, speed=10.0):
    return governor_scene(dimensions, speed=speed, angle=0.6)


def close(found, expected):
    # Printed to twelve digits; assembly to 1e-13, which steep places of the curve magnify: 1e-9, as asked.
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", POINTS_AND_LINKS)
def test_every_row_of_the_tables_is_met(name):
    table = POINTS_AND_LINKS[name]
    rows = np.array(table["rows"])
    reduction = SingleDofReduction(scene_of(table["dimensions"]))
    along = reduction.evaluate(np.radians(rows[:, 0]))
    square = 2 * along.potential_derivative / along.spindle_inertia_derivative
    stiffness = along.potential_second_derivative - 0.5 * square * along.spindle_inertia_second_derivative
    frequency = stiffness / along.inertia
    whole = table["rest_inertia"] + along.spindle_inertia
    close(np.sqrt(square), rows[:, 1])
    close(stiffness, rows[:, 3])
    close(along.inertia, rows[:, 4])
    close(frequency, rows[:, 5])
    close(frequency + square * along.spindle_inertia_derivative**2 / (whole * along.inertia), rows[:, 6])


def test_the_jumping_governor_has_its_two_equilibria_and_its_fold():
    scene = scene_of(IMPROVED)
    for degrees, speed, _, squared in zehnder.FOLD_JUMP["rows"]:
        rests = find_equilibria(scene, speed)
        near = min(rests, key=lambda rest: abs(rest.coordinate - math.radians(degrees)))
        if abs(degrees - zehnder.FOLD_JUMP["least_stable_deg"]) > 1:  # at the fold itself two flow together
            assert math.degrees(near.coordinate) == pytest.approx(degrees, abs=1e-7)  # speeds in twelve digits
            assert near.frequency**2 - near.divergence_rate**2 == pytest.approx(squared, rel=1e-8)
            assert near.stable == (squared > 0)
    ((angle, speed),) = compute_speed_curve(scene).folds
    assert math.degrees(angle) == pytest.approx(zehnder.FOLD_JUMP["least_stable_deg"], abs=1e-9)
    assert speed == pytest.approx(zehnder.FOLD_JUMP["lowest_speed"], abs=1e-9)  # asked


def test_below_the_fold_there_is_no_rest_and_above_there_are_two():
    scene = scene_of(CROSSED)
    lowest = zehnder.CROSSED_MARKS["lowest_speed"]
    with pytest.raises(gm.MechanismError, match=r"has no equilibrium in its travel, .* speeds from 135\.615 rpm"):
        find_equilibria(scene, lowest * (1 - 1e-6))
    pair = find_equilibria(scene, lowest * (1 + 1e-6))  # closer together than the points of the scan
    assert [rest.stable for rest in pair] == [False, True]
    ((angle, speed),) = compute_speed_curve(scene).folds
    assert speed == pytest.approx(lowest, abs=1e-9)
    assert math.degrees(angle) == pytest.approx(zehnder.CROSSED_MARKS["least_stable_deg"], abs=1e-7)


def test_the_standing_band_is_zehnders():
    angle = np.radians([zehnder.FRICTION_BAND["arm_angle_deg"]])
    band = compute_insensitivity_band(scene_of(PORTER), angle, zehnder.FRICTION_BAND["resistance"])
    expected = [zehnder.FRICTION_BAND[name] for name in ("falling_speed", "rising_speed", "insensitivity_exact")]
    found = [band.falling_speed[0], band.rising_speed[0], band.insensitivity[0]]
    np.testing.assert_allclose(found, expected, rtol=1e-10)  # asked
    held = compute_insensitivity_band(scene_of(PORTER), angle, 1e4)
    assert held.falling_speed[0] == 0.0  # held even on a spindle that stands
    with pytest.raises(gm.MechanismError, match="must not be negative"):
        compute_insensitivity_band(scene_of(PORTER), angle, -1.0)


def test_the_band_lies_about_the_curve_and_along_it():
    curve = gm.speed_curve("porter", 51, resistance=40.0)
    band = curve.insensitivity_band
    assert np.all((band.falling_speed < curve.speed) & (curve.speed < band.rising_speed))
    # In Zehnder's rhombus the insensitivity is the same everywhere: W / ((M + m) g), exactly taken.
    np.testing.assert_allclose(band.insensitivity[1:-1], zehnder.FRICTION_BAND["insensitivity_exact"], rtol=1e-9)
    none = gm.speed_curve("porter", 51, resistance=0.0).insensitivity_band
    np.testing.assert_allclose(none.falling_speed, none.rising_speed, rtol=1e-15)


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
@pytest.mark.parametrize("way", ["up", "down"])
def test_the_jump_takes_its_time(engine, way):
    """Undamped from rest: up from 25 to 40 degrees, down from the fold to 25 degrees."""
    jump = zehnder.FOLD_JUMP[way]
    start = zehnder.FOLD_JUMP["stops_deg"][0] if way == "up" else zehnder.FOLD_JUMP["least_stable_deg"]
    stop, sign = (zehnder.FOLD_JUMP["stops_deg"][1], 1.0) if way == "up" else (zehnder.FOLD_JUMP["stops_deg"][0], -1.0)
    scene = scene_of(IMPROVED, speed=jump["speed"]).with_changes(start=Start(values={"arm_angle": math.radians(start)}))
    run = gm.run(scene, engine=engine, times=[jump["time"]], accuracy=1e-10)
    assert run.outcome.ok
    rate = run.rates["arm_angle"][0]
    late = (run.readings["arm_angle"][0] - math.radians(stop)) / rate
    assert abs(late) < 1e-7  # s, asked
    assert rate == pytest.approx(sign * jump["arrival_rate"], abs=1e-8)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_stiffness_is_half_the_inertias_slope_times_the_speeds(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    reduction = SingleDofReduction(scene_of(dimensions))
    step = 1e-3
    along = reduction.evaluate(angle + step * np.arange(-2, 3))
    square = 2 * along.potential_derivative / along.spindle_inertia_derivative
    slope = (8 * (square[3] - square[1]) - (square[4] - square[0])) / (12 * step)
    stiffness = along.potential_second_derivative[2] - 0.5 * square[2] * along.spindle_inertia_second_derivative[2]
    # Differences of fourth order: step^4 / 30 of a fifth derivative that may reach thousands near a dead centre.
    scale = abs(along.potential_second_derivative[2]) + abs(0.5 * square[2] * along.spindle_inertia_second_derivative[2])
    assert stiffness == pytest.approx(0.5 * along.spindle_inertia_derivative[2] * slope, abs=1e-6 * scale)


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_every_equilibrium_is_one_and_both_witnesses_find_the_same(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    governor = closed.PendulumGovernor(**dimensions)
    speed = float(closed.equilibrium_speed(governor, arm_angle=angle))
    scene = scene_of(dimensions, speed)
    rests = find_equilibria(scene, speed)
    assert any(rest.coordinate == pytest.approx(angle, abs=1e-9) for rest in rests)
    for rest in rests:
        here = SingleDofReduction(scene).evaluate([rest.coordinate])
        force = here.potential_derivative[0] - 0.5 * speed**2 * here.spindle_inertia_derivative[0]
        assert abs(force) < 1e-10 * abs(here.potential_derivative[0])  # Newton ends at rounding
        expected = float(closed.squared_oscillation_frequency(governor, arm_angle=rest.coordinate, spindle_speed=speed))
        assert rest.frequency**2 - rest.divergence_rate**2 == pytest.approx(expected, rel=1e-7, abs=1e-7 * speed**2)


@pytest.mark.parametrize("dimensions", [PORTER, WATT, CROSSED, EXTENDED, UNCROSSED_LINKS])
def test_the_curve_is_the_closed_forms(dimensions):
    curve = compute_speed_curve(scene_of(dimensions), 101)
    inner = curve.has_equilibrium & (curve.coordinate > curve.coordinate[0] + 0.02) & (curve.coordinate < 1.5)
    expected = closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=curve.coordinate[inner])
    np.testing.assert_allclose(curve.speed[inner], expected, rtol=1e-9)
    assert np.all(np.isfinite(curve.speed))
    assert curve.high_end_message.startswith(("the arms are at 90", "the link is at 90"))


def test_a_free_spindle_adds_its_own_inertia_to_the_curve():
    free = compute_speed_curve(gm.load("porter_free_spindle"), 51)
    given = compute_speed_curve(gm.load("porter").with_changes(effects=gm.load("porter").effects), 51)
    np.testing.assert_allclose(free.speed, given.speed, rtol=1e-12)
    assert np.all(free.free_frequency_squared[1:] < given.free_frequency_squared[1:])  # J0 unknown counts as none


def test_speeds_and_points_that_are_none_are_refused():
    for speed in (math.nan, math.inf, "fast"):
        with pytest.raises(gm.MechanismError, match=r"spindle's speed (must be|is an angular speed)"):
            gm.equilibria("porter", speed)
    with pytest.raises(gm.MechanismError, match="needs 2 to 1,000,000 points"):
        gm.speed_curve("porter", 1)


def test_equilibria_of_what_has_no_single_coordinate_are_refused():
    with pytest.raises(gm.MechanismError, match="one degree of freedom and without drives"):
        gm.equilibria("quick_return", 1.0)


def with_mechanism(mechanism):
    """A turning scene with gravity around a mechanism of one's own."""
    return scene_of(WATT).with_changes(machine="custom", dimensions={}, mechanism=mechanism, start=Start())


def guided_ball(slopes, *, low=0.05, high=0.5):
    """A ball of 1 kg on a guide whose slope is x times a polynomial: the square of its equilibrium speed over g."""
    ball = body_point("ball")
    curve = PolynomialCurve(coefficients=(0.0, 0.0, *(slope / (k + 2) for k, slope in enumerate(slopes))))
    guide = CurveSlot(name="guide", first=ground_point(), second=ball, curve=curve)
    return ball_scene(guide, x_reading("ball", "radius"), (0.2, 0.0, 0.0), size=high, limits=[radius_limit(low, high)])


def ball_scene(joint, reading, place, **options):
    """A ball of 1 kg on one joint."""
    return with_mechanism(make_mechanism([point_mass("ball", 1.0)], [joint], [reading], [place], **options))


def radius_limit(low, high):
    return Limit(reading="radius", low=low, high=high, low_message="the inner end", high_message="the outer end")


def sprung_ball(stiffness, free_length, anchor, height):
    """A ball of 1 kg on a level slide through the spindle axis, on a spring from a point over the slide."""
    slide, pull = slider("slide", ground_point(), body_point("ball")), ground_point(anchor, height)
    loads = [spring("spring", pull, body_point("ball"), stiffness, free_length)]
    return ball_scene(slide, x_reading("ball", "radius"), (0.5, 0.0, 0.0), loads=loads, limits=[radius_limit(0.01, 1.5)])


@settings(max_examples=80)
@given(anchor=st.floats(0.3, 0.9), height=st.floats(0.02, 0.3), free_length=st.floats(0.1, 0.6), share=st.floats(0.05, 0.6))
def test_none_of_up_to_three_equilibria_is_missed(anchor, height, free_length, share):
    """k (1 - L0 / L) (x - a) = m w^2 x; squared it is a quartic, whose roots are found without us."""
    k, square = 100.0, 100.0 * share
    line = np.polynomial.Polynomial([-k * anchor, k - square])
    away = np.polynomial.Polynomial([-anchor, 1.0])
    quartic = line**2 * (away**2 + height**2) - (k * free_length) ** 2 * away**2
    roots = np.array([root.real for root in quartic.roots() if abs(root.imag) < 1e-7])
    lengths = np.hypot(roots - anchor, height)
    true = np.abs(k * (1 - free_length / lengths) * (roots - anchor) - square * roots) < 1e-5 * k
    expected = np.sort(roots[true & (roots > 0.011) & (roots < 1.499)])
    assume(np.all(np.diff(expected) > 1e-3))  # the roots of a quartic lose half their digits where two meet
    edge = np.abs(roots[true][:, np.newaxis] - np.array([0.01, 1.5]))
    assume(not np.any(edge < 2e-3))
    found = find_equilibria_or_empty(sprung_ball(k, free_length, anchor, height), math.sqrt(square))
    np.testing.assert_allclose([rest.coordinate for rest in found], expected, atol=1e-9)
    kinds = [rest.stable for rest in found]
    assert all(one != other for one, other in itertools.pairwise(kinds))  # they take turns


def test_three_equilibria_are_found_where_there_are_three():
    found = find_equilibria_or_empty(sprung_ball(100.0, 0.4, 0.5, 0.05), math.sqrt(5.0))
    assert [rest.stable for rest in found] == [True, False, True]


def test_a_nearly_astatic_rest_says_how_little_it_is_worth():
    """w^2 = g (10 + s (x - 0.2)): a relative change of speed moves it by 20 / s metres."""
    for slope in (1.0, 1e-3, 1e-6):
        scene = guided_ball([10.0 - 0.2 * slope, slope])
        (rest,) = find_equilibria(scene, math.sqrt(10.0 * scene.gravity))
        assert rest.sensitivity == pytest.approx(20.0 / slope, rel=1e-6)
        assert rest.coordinate == pytest.approx(0.2, abs=rest.uncertainty)
        assert rest.uncertainty < 1e-11 / slope


def test_an_astatic_governor_rests_over_a_continuum():
    scene = gm.load("parabolic")
    (rest,) = gm.equilibria(scene)
    assert rest.astatic
    assert not rest.stable
    assert rest.extent == pytest.approx((0.05, 0.25), rel=1e-4)  # the ends of the guide, but for a hair
    assert rest.frequency == rest.divergence_rate == 0.0
    curve = gm.speed_curve(scene)
    assert curve.astatic.all()
    assert not curve.stable.any()
    assert curve.folds == ()
    with pytest.raises(gm.MechanismError, match="astatic, with equilibria at 120 rpm"):
        gm.equilibria(scene, scene.spindle.speeds[0] * 1.001)
    with pytest.raises(gm.MechanismError, match="not unique: at 120 rpm the mechanism is astatic"):
        stable_equilibrium_poses(scene)


def conical_pendulum():
    """A ball on an arm pivoted on the spindle axis: over 90 degrees turning drives it back down."""
    ball, pivot = body_point("ball"), ground_point()
    angle = LineAngle(name="arm_angle", quantity="angle", start=pivot, end=ball)
    return ball_scene(link("arm", pivot, ball, 0.4), angle, (0.2, -0.2, 0.0), size=0.4)


def test_no_speed_holds_a_mechanism_beyond_the_pole_of_its_curve():
    scene = conical_pendulum()
    curve = gm.speed_curve(scene)
    assert curve.poles == pytest.approx((math.pi / 2,), abs=1e-12)
    assert curve.low_end_message == curve.high_end_message == "the mass centre of 'ball' reaches the spindle axis"
    np.testing.assert_array_equal(curve.has_equilibrium, curve.coordinate < math.pi / 2)
    with pytest.raises(gm.MechanismError, match="beyond the pole of the speed curve at 90 deg"):
        equilibrium_speed_at(scene, np.array([math.pi / 2 + 0.1]))
    with pytest.raises(gm.MechanismError, match="has a pole at 90 deg"):
        find_equilibria(scene, math.sqrt(scene.gravity / 0.4) * 0.999)  # below the least, sqrt(g / l)


def test_without_a_spindle_gravity_alone_says_where_it_rests():
    rests = gm.equilibria("pendulum_iftomm")
    assert [math.degrees(rest.coordinate) for rest in rests] == pytest.approx([-270, -90], abs=1e-9)
    assert [rest.stable for rest in rests] == [False, True]
    assert rests[1].frequency == pytest.approx(math.sqrt(9.81), rel=1e-12)

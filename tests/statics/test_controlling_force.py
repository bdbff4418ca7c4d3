"""Controlling force, effort, power and sensitiveness of governors, against textbooks, closed forms and laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.output_variables import Limit, PointCoordinate
from governor_mechanism.model.part import Start
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene, random_governor
from hartung_scenes import PAPER_DIMENSIONS, hartung_scene
from reference import hartung
from scene_parts import body_point, ground_point, make_mechanism, pin, point_mass, slider, spring, x_reading, y_reading

RPM = math.pi / 30
G = 9.81


def scene_of(dimensions):
    return governor_scene(dimensions, speed=12.0, angle=0.7)


def porter(arm, ball, sleeve):
    """A Porter governor with all arms of one length, hung on the axis."""
    return scene_of({"arm": arm, "offset": 0.0, "ball_mass": ball, "sleeve_mass": sleeve})


def angles_of(arm, *radii):
    return tuple(math.asin(radius / arm) for radius in radii)


# Closed forms, written out from the textbooks.


@pytest.mark.parametrize("dimensions", [PORTER, CROSSED, EXTENDED, UNCROSSED_LINKS])
def test_a_pendulum_governor_has_the_textbooks_controlling_force(dimensions):
    """C = tan(a) (m g + (M g / 2) (b / l) (1 + tan(b) / tan(a))) with arm angle a, link angle b and joint at b of the arm l."""
    angles = np.radians([25.0, 35.0, 45.0])
    arm, joint = dimensions["arm"], dimensions.get("arm_joint", dimensions["arm"])
    link, lug = dimensions.get("link", joint), dimensions.get("lug_offset", dimensions["offset"])
    link_tangent = np.tan(np.arcsin((dimensions["offset"] + joint * np.sin(angles) - lug) / link))
    ball, sleeve = dimensions["ball_mass"] * G, dimensions["sleeve_mass"] * G
    expected = np.tan(angles) * ball + 0.5 * sleeve * joint / arm * (np.tan(angles) + link_tangent)
    curve = compute_controlling_force(scene_of(dimensions), angles)
    np.testing.assert_allclose(curve.force, expected, rtol=1e-11)  # assembly to rounding, times a condition below 100
    np.testing.assert_allclose(curve.radius, dimensions["offset"] + arm * np.sin(angles), rtol=1e-12)
    np.testing.assert_allclose(curve.equivalent_mass, dimensions["ball_mass"], rtol=1e-11)
    assert curve.n_balls == 2


def test_watts_controlling_force_is_that_of_a_conical_pendulum():
    curve = compute_controlling_force(scene_of(WATT), [0.5, 0.9])
    np.testing.assert_allclose(curve.force, WATT["ball_mass"] * G * np.tan([0.5, 0.9]), rtol=1e-12)


def test_the_hartung_governor_has_dubois_controlling_force():
    """C = P + (Q / 2) (b / a) sin(g + x) / cos(x) + G tan(x) with the spring P linear in the radius."""
    angles = np.radians([-12.0, 0.0, 13.0])
    a, b, lever = hartung.GOVERNOR["weight_arm"], hartung.GOVERNOR["sleeve_arm"], hartung.GOVERNOR["angle"]
    radius = hartung.GOVERNOR["fulcrum_radius"] - a * np.sin(angles)
    spring = PAPER_DIMENSIONS["spring_preload"] + PAPER_DIMENSIONS["spring_rate"] * (radius - PAPER_DIMENSIONS["preload_radius"])
    weights = 0.5 * hartung.GOVERNOR["sleeve_mass"] * (b / a) * np.sin(lever + angles) / np.cos(angles) + hartung.GOVERNOR[
        "weight_mass"
    ] * np.tan(angles)
    curve = compute_controlling_force(hartung_scene(PAPER_DIMENSIONS), angles)
    assert (curve.radius_name, curve.n_balls) == ("weight_radius", 2)
    np.testing.assert_allclose(curve.radius, radius, rtol=1e-12)
    np.testing.assert_allclose(curve.force, spring + weights * hartung.GRAVITY, rtol=1e-11)


# Printed examples.


def test_the_range_of_speed_of_khurmis_porter_governor():
    """R. S. Khurmi, Theory of Machines, example 18.3: 177 and 204.4 rpm, range 27.4; with friction of 20 N 172 and 210 rpm."""
    between = {"arm_angle": angles_of(0.25, 0.15, 0.2)}
    ends = compute_controlling_force(porter(0.25, 5.0, 30.0), between=between, resistance=20.0).working_range
    found = np.array([*ends.speed, ends.range_of_speed, ends.falling_speed[0], ends.rising_speed[1]]) / RPM
    # The book rounds the speeds to 0.1 rpm and those with friction to 1 rpm.
    np.testing.assert_allclose(found, [176.9, 204.3, 27.4, 172.0, 210.0], atol=0.5)
    np.testing.assert_allclose(found[:3], [176.9, 204.3, 27.4], atol=0.06)
    assert ends.sensitiveness == pytest.approx(27.4 / (0.5 * (176.9 + 204.3)), abs=0.0006)


def test_sarkars_friction_doubles_the_range_of_speed():
    """B. K. Sarkar, Theory of Machines, example 7.6: friction of 14.9 N, with which the range of speed is 14.9 rpm.

    It is that with which the governor rises from the low end at the very speed at which it falls from the high end.
    """
    scene, low = porter(0.3, 5.0, 25.0), math.radians(30.0)
    high = math.acos(math.cos(low) - 0.05 / (2 * 0.3))
    ends = compute_controlling_force(scene, between={"arm_angle": (low, high)}, resistance="14.9 N").working_range
    assert ends.lift == pytest.approx(0.05, rel=1e-12)
    assert ends.range_of_speed_with_resistance / RPM == pytest.approx(14.9, abs=0.05)  # printed digits
    # 0.05 N of the printed friction are 0.05 / ((m + M) g) / 2 of the speed.
    assert ends.rising_speed[0] == pytest.approx(ends.falling_speed[1], rel=2 * 0.05 / (30 * G))


def lever_governor(*, ball_mass, ball_arm, sleeve_arm, pivot, low, high, stiffness, free_length):
    """Half of a weightless Hartnell governor: a right-angled bell crank, upright over its pivot, under a spring at the sleeve."""
    travel = Limit(reading="ball_radius", low=low, high=high, low_message="the inner end", high_message="the outer end")
    return make_mechanism(
        [Body(name="lever", mass=ball_mass), point_mass("sleeve", 0.0)],
        [
            pin("pivot", ground_point(pivot), body_point("lever", y=-ball_arm)),
            slider("roller", body_point("sleeve"), body_point("lever", -sleeve_arm, -ball_arm)),
            slider("guide", ground_point(), body_point("sleeve"), math.pi / 2),
        ],
        [x_reading("lever", "ball_radius"), y_reading("sleeve", "sleeve_lift")],
        [(pivot, ball_arm, 0.0), (0.0, 0.0, 0.0)],
        loads=[spring("spring", ground_point(y=1.0), body_point("sleeve"), stiffness, free_length)],
        size=ball_arm,
        limits=[travel],
    )


def hartnell_scene(low, high, speeds, *, ball_mass, ball_arm, sleeve_arm, pivot):
    """The governor with the spring of two speeds (rad/s) at two radii by the textbook's rule, and the spring of both halves.

    S = 2 C a / b at each end; the stiffness is the difference over the lift, and the compression the lower force over the stiffness.
    """
    forces = [2 * ball_mass * speed**2 * radius * ball_arm / sleeve_arm for speed, radius in zip(speeds, (low, high), strict=True)]
    stiffness = (forces[1] - forces[0]) / ((high - low) * sleeve_arm / ball_arm)
    compression = forces[0] / stiffness
    free_length = 1.0 - (low - pivot) * sleeve_arm / ball_arm + compression
    sizes = {"ball_mass": ball_mass, "ball_arm": ball_arm, "sleeve_arm": sleeve_arm, "pivot": pivot}
    mechanism = lever_governor(**sizes, low=low, high=high, stiffness=0.5 * stiffness, free_length=free_length)
    effects = tuple(one for one in gm.load("porter").effects if one.key == "centrifugal")
    scene = gm.load("porter").with_changes(machine="custom", dimensions={}, mechanism=mechanism, start=Start(), effects=effects)
    return scene, stiffness, compression


def test_khurmis_hartnell_governor_has_a_linear_law():
    """R. S. Khurmi, Theory of Machines, example 18.14: 9.2 N/mm and 61 mm for 400 and 420 rpm at 80 and 120 mm.

    The obliquity of equal arms at a right angle cancels, so that the law is a straight line and its speed between the ends follows.
    """
    low, high = 0.08, 0.12
    scene, stiffness, compression = hartnell_scene(
        low, high, (400 * RPM, 420 * RPM), ball_mass=2.0, ball_arm=0.1, sleeve_arm=0.1, pivot=0.1
    )
    assert stiffness / 1e3 == pytest.approx(9.2, abs=0.05)
    assert compression * 1e3 == pytest.approx(61, abs=0.5)
    radii = np.array([0.081, 0.1, 0.119])
    curve = compute_controlling_force(scene, radii)
    ends = [2.0 * (rpm * RPM) ** 2 * radius for rpm, radius in ((400, low), (420, high))]
    line = ends[0] + (ends[1] - ends[0]) * (radii - low) / (high - low)
    assert curve.n_balls == 1  # half a governor: one lever
    np.testing.assert_allclose(curve.force, line, rtol=1e-10)
    np.testing.assert_allclose(curve.force_slope, (ends[1] - ends[0]) / (high - low), rtol=1e-9)
    np.testing.assert_allclose(curve.speed, np.sqrt(line / (2.0 * radii)), rtol=1e-10)
    assert curve.stable.all()  # its line meets the axis at a positive radius
    twice = compute_controlling_force(scene, radii, balls=2)
    np.testing.assert_allclose(twice.force, 0.5 * line, rtol=1e-10)


def test_bevans_spring_governor_between_its_printed_speeds():
    """Th. Bevan, The Theory of Machines, chapter 13, example 3: 300 rpm at 3 in and 6 % more at 4.5 in; printed 308 rpm at 3.5 in."""
    inch, ball = 0.0254, 3 * 0.45359237
    scene, *_ = hartnell_scene(
        3 * inch, 4.5 * inch, (300 * RPM, 318 * RPM), ball_mass=ball, ball_arm=4 * inch, sleeve_arm=4 * inch, pivot=3.75 * inch
    )
    curve = compute_controlling_force(scene, [3.5 * inch])
    assert curve.speed[0] / RPM == pytest.approx(308, abs=0.5)
    ends = compute_controlling_force(scene, points=5).working_range
    assert ends.limited_by == "travel"
    # The ends are sampled 1e-5 of the travel inside it.
    assert ends.sensitiveness == pytest.approx(18 / 309, rel=1e-4)


# Effort and power.


@pytest.mark.parametrize("change", [0.01, 0.1])
def test_effort_and_power_of_the_rhombus_are_bevans(change):
    """Porter's rhombus: effort c (m + M) g and power 4 c^2 / (1 + 2 c) (m + M) g h with c^2 neglected beside 2 c; here it is not."""
    ball, sleeve, arm, angle = 5.0, 25.0, 0.25, math.radians(35.0)
    effort = compute_controlling_force(porter(arm, ball, sleeve), [angle], speed_change=change).effort
    weight, height = (ball + sleeve) * G, arm * math.cos(angle)
    assert effort.effort[0] == pytest.approx((change + change**2 / 2) * weight, rel=1e-11)
    lift = 2 * height * (1 - 1 / (1 + change) ** 2)  # the height is g (1 + M / m) / w^2
    assert effort.lift[0] == pytest.approx(lift, rel=1e-9)
    assert effort.power[0] == pytest.approx(effort.effort[0] * lift, rel=1e-9)
    assert effort.power[0] == pytest.approx(4 * change**2 / (1 + 2 * change) * weight * height, rel=1.5 * change)  # the neglected terms


def test_the_speed_change_of_the_whole_range_lifts_the_sleeve_over_it():
    """R. S. Khurmi, Theory of Machines, example 18.2: from 150 to 200 mm the sleeve of arms of 250 mm rises by 2 (200 - 150) mm."""
    scene, (low, high) = porter(0.25, 5.0, 25.0), angles_of(0.25, 0.15, 0.2)
    ends = compute_controlling_force(scene, between={"arm_angle": (low, high)}).working_range
    np.testing.assert_allclose(ends.speed / RPM, [164, 189], atol=0.5)  # printed to 1 rpm
    change = ends.speed[1] / ends.speed[0] - 1
    effort = compute_controlling_force(scene, [low], speed_change=change).effort
    assert effort.lift[0] == pytest.approx(0.1, rel=1e-9)
    assert ends.lift == pytest.approx(0.1, rel=1e-11)
    # Both balls rise by 50 mm, the sleeve by 100 mm.
    assert ends.work_capacity == pytest.approx(2 * 5 * G * 0.05 + 25 * G * 0.1, rel=1e-11)


def test_the_effort_to_first_order_is_the_controlling_force_over_the_sleeve():
    """Two balls' change of centrifugal force, 2 p C, led to the sleeve: the effort is its half, (2 C dr / ds) p."""
    scene, change = scene_of(UNCROSSED_LINKS), 1e-6
    curve = compute_controlling_force(scene, np.radians([30.0, 30.001]), speed_change=change)
    slope = np.diff(curve.radius)[0] / np.diff(curve.sleeve)[0]
    assert curve.effort.effort[0] == pytest.approx(2 * curve.force[0] * slope * change, rel=1e-4)  # a difference over 1.7e-5 rad


def test_where_the_arms_hang_in_line_the_effort_is_its_limit():
    """At the dead centre load and lift of the sleeve vanish together; the rhombus keeps p (m + M) g."""
    scene = porter(0.3, 5.0, 20.0)
    curve = compute_controlling_force(scene, points=50)
    np.testing.assert_allclose(curve.effort.effort, 0.01005 * 25 * G, rtol=1e-6)  # V' and s' are small differences there


# Laws.


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_slopes_of_force_and_speed_line_differ_by_the_stiffness(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    scene, step = scene_of(dimensions), 1e-3
    curve = compute_controlling_force(scene, angle + step * np.arange(-2, 3))
    np.testing.assert_allclose(curve.force, curve.equivalent_mass * curve.speed**2 * curve.radius, rtol=1e-10)
    along = SingleDofReduction(scene).evaluate([angle])
    stiffness = along.stiffness_terms(curve.speed[2] ** 2).sum(axis=0)[0]
    radius_slope = dimensions["arm"] * math.cos(angle)
    magnitude = abs(curve.force_slope[2]) + abs(curve.speed_line_slope[2])
    assert curve.force_slope[2] - curve.speed_line_slope[2] == pytest.approx(stiffness / (2 * radius_slope**2), abs=1e-10 * magnitude)
    assert curve.speed_line_slope[2] == pytest.approx(curve.force[2] / curve.radius[2], rel=1e-9)  # points: rays through the origin
    assert curve.stable[2] == (stiffness > 0)
    # Differences of fourth order of force and radius: step^4 / 30 of a fifth derivative that may reach thousands near a dead centre.
    rise = [(8 * (f[3] - f[1]) - (f[4] - f[0])) for f in (curve.force, curve.radius)]
    assert curve.force_slope[2] == pytest.approx(rise[0] / rise[1], abs=1e-6 * magnitude)


@pytest.mark.parametrize("name", ["porter_heavy_rods", "hartung_corrected", "watt_crossed", "haug_governor"])
def test_speeds_and_stability_are_those_of_the_speed_curve(name):
    scene = gm.load(name)
    options = {"against": "collar_height", "radius": "ball_radius", "balls": 2} if name == "haug_governor" else {}
    if name == "haug_governor":
        scene = with_ball_radius(scene)
    curve, speeds = gm.controlling_force(scene, points=60, **options), gm.speed_curve(scene, 60)
    np.testing.assert_allclose(curve.speed, speeds.speed, rtol=1e-12)
    np.testing.assert_array_equal(curve.stable, speeds.stable)
    inner = slice(1, -1)
    stiff = (curve.force_slope > curve.speed_line_slope)[inner]
    np.testing.assert_array_equal(stiff[curve.has_equilibrium[inner]], speeds.stable[inner][curve.has_equilibrium[inner]])
    balanced = curve.equivalent_mass * curve.speed**2 * curve.radius
    np.testing.assert_allclose(balanced[curve.has_equilibrium], curve.force[curve.has_equilibrium], rtol=1e-9)


def with_ball_radius(scene):
    """Haug's governor with the distance of the ball from the spindle as a reading."""
    mechanism = scene.part.mechanism
    ball = PointCoordinate(name="ball_radius", quantity="length", point=Point(body="arm"), direction_x=1.0, direction_y=0.0)
    return scene.with_changes(mechanism=replace(mechanism, readings=(*mechanism.readings, ball)))


def test_resistance_shifts_the_controlling_force_by_its_share_at_the_ball():
    """Rhombus: dr / ds = cos(a) / (2 sin(a)), so that C changes by W tan(a) for both balls; its speeds are those of the band."""
    scene, angles = porter(0.25, 5.0, 30.0), np.radians([30.0, 45.0])
    curve = compute_controlling_force(scene, angles, resistance="20 N")
    np.testing.assert_allclose(curve.rising_force - curve.force, 20.0 * np.tan(angles), rtol=1e-11)
    np.testing.assert_allclose(curve.force - curve.falling_force, 20.0 * np.tan(angles), rtol=1e-11)
    band = gm.insensitivity_band(scene, angles, 20.0)
    np.testing.assert_allclose(band.rising_speed, np.sqrt(curve.rising_force / (5.0 * curve.radius)), rtol=1e-11)


def test_the_area_under_the_controlling_force_is_the_work_capacity():
    ends = gm.controlling_force("hartung_corrected").working_range
    radius = gm.controlling_force("hartung_corrected", np.linspace(*ends.coordinate, 2001))
    area = 2 * np.trapezoid(radius.force, radius.radius)
    assert area == pytest.approx(ends.work_capacity, rel=1e-6)  # trapezia: 1 / (12 n^2) of the second derivative


def test_the_astatic_governor_is_its_own_speed_line_and_cannot_regulate():
    """The parabola x^2 = c y has C = (1 + M / m) 2 m g r / c: a ray. At any other speed it runs to an end of its guide."""
    curve = gm.controlling_force("parabolic", points=41)
    np.testing.assert_allclose(curve.force / curve.radius, 2 * 5.0 * G / 0.621225507207, rtol=1e-12)
    np.testing.assert_allclose(curve.force_slope, curve.speed_line_slope, rtol=1e-10)
    assert curve.astatic.all()
    assert not curve.stable.any()
    assert curve.working_range.sensitiveness == pytest.approx(0.0, abs=1e-12)
    assert not curve.effort.has_lift.any()
    assert not curve.effort.power.any()
    np.testing.assert_allclose(curve.effort.effort, 0.01005 * 0.5 * 5.0 * G * 2, rtol=1e-11)  # (m + M) g, as of the rhombus


# Working range and refusals.


def test_the_working_range_is_that_of_the_stops_or_the_given_one():
    scene = gm.load("hartung_corrected")
    ends = gm.controlling_force(scene, points=2).working_range
    assert ends.limited_by == "stops"
    assert ends.radius[0] < ends.radius[1]
    given_ends = gm.controlling_force(scene, points=2, between={"lever_angle": ("5 deg", "-5 deg")}).working_range
    np.testing.assert_allclose(np.degrees(given_ends.coordinate), [5.0, -5.0], rtol=1e-12)  # inner end first
    by_lift = gm.controlling_force(scene, points=2, between={"sleeve_lift": given_ends.sleeve}).working_range
    np.testing.assert_allclose(by_lift.speed, given_ends.speed, rtol=1e-11)
    assert gm.controlling_force("porter", points=2).working_range is None  # it reaches both dead centres
    assert not gm.controlling_force("watt_improved", points=2).working_range.stable  # equal speeds at both ends, a fold between


def test_a_mechanism_without_balls_says_what_is_missing():
    with pytest.raises(gm.MechanismError, match=r'add one to \[readings\], such as ball_radius = \{ x = "ball.centre" \}'):
        gm.controlling_force("haug_governor", against="collar_height")
    with pytest.raises(gm.MechanismError, match="needs both effects, gravity and centrifugal"):
        gm.controlling_force("pendulum_iftomm")

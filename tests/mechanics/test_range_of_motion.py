"""Ranges of motion traced by continuation, against closed-form limits of the machines and geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.continuation import PathContinuation
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.range_of_motion import RANGE_END_MARGIN, find_range_of_motion, trace_range_of_motion
from governor_mechanism.model.joints import Distance, Gear, Pin, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import Limit, LineAngle
from governor_scenes import CROSSED, governor_scene, random_governor
from scene_parts import body_angle, body_point, ground_point, make_mechanism, pin, point_mass, rotating_body, x_reading, y_reading


def unlimited(mechanism):
    """Return the mechanism without the limit of its leading coordinate, which must then be traced."""
    other_limits = tuple(limit for limit in mechanism.limits if limit.reading != mechanism.coordinate)
    return replace(mechanism, limits=other_limits)


def test_a_given_limit_is_used():
    mechanism = gm.load("porter").part.mechanism
    motion_range = find_range_of_motion(mechanism, rotates_with_spindle=True)
    limit = mechanism.limits[0]
    margin = RANGE_END_MARGIN * (limit.high - limit.low)
    assert (motion_range.low, motion_range.high) == (limit.low + margin, limit.high - margin)
    assert (motion_range.low_message, motion_range.high_message) == (limit.low_message, limit.high_message)


@pytest.mark.long
@settings(max_examples=25)
@example(seed=448698)  # the balls reach the axis just after the change point
@given(seed=st.integers(0, 2**32 - 1))
def test_the_traced_range_of_a_governor_ends_where_its_geometry_ends(seed):
    """The machine computes its limits in closed form; continuation knows only the joints."""
    dimensions, _ = random_governor(np.random.default_rng(seed))
    mechanism = governor_scene(dimensions, speed=10.0, angle=0.6).part.mechanism
    traced = trace_range_of_motion(unlimited(mechanism), rotates_with_spindle=True)
    limit = mechanism.limits[0]
    margin = RANGE_END_MARGIN * (traced.high - traced.low)
    # Joints closed to 1e-13 locate a change point, or a turning point near one, to a root of that: 3e-7.
    assert traced.low - margin == pytest.approx(limit.low, abs=1e-5)
    # At 90 degrees the arms alone could continue: only a limit, or the links, stop them.
    assert traced.high + margin >= limit.high - 1e-5


def four_bar(*, crank, coupler, rocker, ground, coordinate="crank", start=math.pi / 2):
    """Return a four-bar linkage in a fixed plane; angles of the bars from the ground line."""
    crank_pin = crank * np.array([math.cos(start), math.sin(start)])
    across = math.hypot(ground - crank_pin[0], crank_pin[1])
    angle = math.atan2(-crank_pin[1], ground - crank_pin[0]) + math.acos((coupler**2 + across**2 - rocker**2) / (2 * coupler * across))
    joint = crank_pin + coupler * np.array([math.cos(angle), math.sin(angle)])
    rocker_angle = math.atan2(joint[1], joint[0] - ground)
    bodies = [rotating_body(name, 1.0, 0.01) for name in ("crank", "coupler", "rocker")]
    joints = [
        pin("A", ground_point(), body_point("crank")),
        pin("B", body_point("crank", crank), body_point("coupler")),
        pin("C", body_point("coupler", coupler), body_point("rocker", rocker)),
        pin("D", body_point("rocker"), ground_point(ground)),
    ]
    sketch = [(0.0, 0.0, start), (*crank_pin.tolist(), angle), (ground, 0.0, rocker_angle)]
    mechanism = make_mechanism(bodies, joints, [body_angle("crank"), body_angle("rocker")], sketch, size=ground)
    return replace(mechanism, coordinate=coordinate)


def test_a_crank_rotates_fully_and_its_rocker_turns_back():
    linkage = {"crank": 0.1, "coupler": 0.4, "rocker": 0.3, "ground": 0.4}
    crank = find_range_of_motion(four_bar(**linkage), rotates_with_spindle=False)
    assert crank.high - crank.low == pytest.approx(2 * math.pi, rel=3 * RANGE_END_MARGIN)
    assert crank.low_message == crank.high_message == "full rotation: half a turn from the initial guess"
    rocker = find_range_of_motion(four_bar(**linkage, coordinate="rocker"), rotates_with_spindle=False)
    # Crank and coupler in line: the law of cosines.
    ends = [math.pi - math.acos((0.4**2 + 0.3**2 - reach**2) / (2 * 0.4 * 0.3)) for reach in (0.4 - 0.1, 0.4 + 0.1)]
    margin = RANGE_END_MARGIN * (rocker.high - rocker.low)
    assert sorted([rocker.low - margin, rocker.high + margin]) == pytest.approx(sorted(ends), abs=1e-9)
    assert rocker.high_message.startswith("turning point: rocker turns back; beyond it, joint ")
    assert "stays open by" in rocker.high_message


def test_a_double_rocker_turns_back_where_coupler_and_rocker_are_in_line():
    motion_range = find_range_of_motion(four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4), rotates_with_spindle=False)
    end = math.acos((0.4**2 + 0.3**2 - 0.55**2) / (2 * 0.4 * 0.3))
    assert (motion_range.low, motion_range.high) == pytest.approx((-end, end), abs=1e-4)
    assert motion_range.high_message.startswith("turning point: crank turns back; beyond it, joint ")


def test_the_range_of_a_parallelogram_ends_at_its_change_points():
    motion_range = find_range_of_motion(gm.load("four_bar_chain").part.mechanism, rotates_with_spindle=False)
    assert (motion_range.low, motion_range.high) == pytest.approx((0.0, math.pi), abs=1e-4)
    assert "change point" in motion_range.low_message
    assert "change point" in motion_range.high_message


def slide(start):
    """Return a block on a horizontal bar."""
    bar = Slider(name="bar", first=ground_point(), second=body_point("block"), angle=0.0)
    return make_mechanism([point_mass("block", 1.0)], [bar], [x_reading("block")], [(start, 0.0, 0.0)], size=0.1)


@pytest.mark.parametrize("rotates", [False, True])  # a body that starts on the axis may leave it
def test_an_unbounded_slide_is_traced_up_to_the_maximum_length(rotates):
    mechanism = slide(0.0)
    motion_range = find_range_of_motion(mechanism, rotates_with_spindle=rotates)
    assert (motion_range.low, motion_range.high) == pytest.approx((-5.0, 5.0), rel=1e-4)
    assert "followed over a length of 50 length scales" in motion_range.high_message
    points = PathContinuation(mechanism, rotates_with_spindle=rotates).find_end(1.0).points
    assert len(points) < 100  # the steps grow on a straight path
    assert np.all(np.diff([point.arc_length for point in points]) > 0)


def test_a_mechanism_without_range_of_motion_is_refused():
    mechanism = gm.load("quick_return").part.mechanism
    with pytest.raises(gm.MechanismError, match="mobility 0"):
        find_range_of_motion(mechanism, rotates_with_spindle=False)
    arm = Distance(name="arm", first=ground_point(), second=body_point("ball"), length=0.4)
    pendulum = make_mechanism([point_mass("ball", 1.0)], [arm], [y_reading("ball", "height")], [(0.0, -0.4, 0.0)], size=0.4)
    with pytest.raises(gm.MechanismError, match="turning point in the initial guess"):
        find_range_of_motion(pendulum, rotates_with_spindle=False)


def pendulum_between(*, low, high):
    """Return a ball on an arm of 0.4 m, between angles -1.5 and 1.5 (initial guess 0.2) and between two values of x."""
    pivot, ball = ground_point(), body_point("ball")
    return make_mechanism(
        [point_mass("ball", 1.0)],
        [Distance(name="arm", first=pivot, second=ball, length=0.4)],
        [LineAngle(name="angle", quantity="angle", start=pivot, end=ball), x_reading("ball")],
        [(0.4 * math.sin(0.2), -0.4 * math.cos(0.2), 0.0)],
        size=0.4,
        limits=[
            Limit(reading="angle", low=-1.5, high=1.5, low_message="far left", high_message="far right"),
            Limit(reading="x", low=low, high=high, low_message="the left wall", high_message="the right wall"),
        ],
    )


def test_limits_of_other_readings_restrict_the_range_exactly_and_give_its_messages():
    motion_range = find_range_of_motion(pendulum_between(low=-0.1, high=0.3), rotates_with_spindle=False)
    assert motion_range.ends == pytest.approx((-math.asin(0.25), math.asin(0.75)), abs=1e-12)
    assert (motion_range.low_message, motion_range.high_message) == ("the left wall", "the right wall")
    motion_range = find_range_of_motion(pendulum_between(low=-1.0, high=0.3), rotates_with_spindle=False)
    assert motion_range.ends == pytest.approx((-1.5, math.asin(0.75)), abs=1e-12)
    assert (motion_range.low_message, motion_range.high_message) == ("far left", "the right wall")


def test_limits_that_leave_no_range_are_refused():
    with pytest.raises(gm.MechanismError, match=r"no range of motion: .* 'x' must lie within 1 to 2"):
        find_range_of_motion(pendulum_between(low=1.0, high=2.0), rotates_with_spindle=False)


def geared(ratio):
    wheels = [Body(name=name, mass=1.0, second_moments=SecondMoments(xx=0.01)) for name in ("a", "b")]
    first, second = body_point("a"), body_point("b", -0.1)
    joints = [
        Pin(name="A", first=ground_point(), second=first),
        Pin(name="B", first=ground_point(0.3), second=second),
        Gear(name="gear", first=first, second=second, ratio=ratio),
    ]
    return make_mechanism(wheels, joints, [body_angle("a", "turn")], [(0.0, 0.0, 0.0), (0.4, 0.0, 0.0)], size=0.3)


@pytest.mark.long
def test_a_period_ends_where_the_poses_repeat_and_not_before():
    motion_range = find_range_of_motion(geared(1 / 3), rotates_with_spindle=False)
    assert (motion_range.low, motion_range.high, motion_range.period) == pytest.approx((-3 * math.pi, 3 * math.pi, 6 * math.pi))
    assert motion_range.low_message == motion_range.high_message == "closed motion after 3 turns: 1.5 turns from the initial guess"
    endless = find_range_of_motion(geared(math.sqrt(2)), rotates_with_spindle=False)
    assert endless.period == 0.0
    assert "followed over a length of 50 length scales" in endless.high_message


def test_the_path_predicts_the_assembled_poses():
    mechanism = four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4)  # the crank turns back at both ends
    motion_range = find_range_of_motion(mechanism, rotates_with_spindle=False)
    values = np.linspace(motion_range.low, motion_range.high, 501)
    solver = CoordinateSolver(mechanism)
    predicted = motion_range.path.predict_poses(values)
    nodes, is_solved = solver.try_solve_nodes(predicted, values)
    poses = nodes[:, 0]
    assert is_solved.all()
    assert np.max(np.abs(poses - predicted)) < 1e-3
    assert np.max(np.abs(solver.equations.residuals(poses))) < 1e-12
    # One at a time, on the branch of the initial guess, the same.
    for value in (-1.2, 0.1, 1.4):
        assembled = solver.solve_at_coordinate(value)
        together = solver.solve_nodes(motion_range.path.predict_poses(np.array([value])), np.array([value]))
        np.testing.assert_allclose(together[0, 0], assembled, atol=1e-12)


@pytest.mark.parametrize("start", [math.pi / 2, 3.0])
def test_a_turn_later_the_crank_alone_has_turned_wherever_the_motion_begins(start):
    path = find_range_of_motion(four_bar(crank=0.1, coupler=0.3, rocker=0.25, ground=0.3, start=start), rotates_with_spindle=False).path
    angles = start + np.array([-0.4, -0.1])
    change = path.predict_poses(angles + math.tau) - path.predict_poses(angles)
    np.testing.assert_allclose(change, np.broadcast_to([[0, 0, math.tau], [0, 0, 0], [0, 0, 0]], change.shape), atol=1e-12)


def test_equilibria_at_both_ends_of_a_period_are_one():
    turning = find_range_of_motion(four_bar(crank=0.1, coupler=0.4, rocker=0.3, ground=0.4), rotates_with_spindle=False)
    low, high = turning.low, turning.high
    extents = [(low, low), (low + 1e-9, low + 2e-9), (0.1, 0.3), (high, high), (high + 1.0, high + 1.0)]
    assert turning.find_distinct(extents, 1e-8) == [2, 3]  # the second is that of the high end too
    assert turning.find_distinct(extents, 1e-10) == [1, 2, 3]
    bounded = find_range_of_motion(pendulum_between(low=-1.0, high=1.0), rotates_with_spindle=False)
    assert bounded.find_distinct([(-1.6, -1.6), (-1.5, -1.5), (1.4, 1.6), (1.4, 1.7)], 1e-4) == [1, 2]


def test_a_range_in_the_turning_plane_ends_where_a_mass_centre_reaches_the_axis():
    """The balls, not the sleeve, which is always on the axis."""
    mechanism = unlimited(governor_scene(CROSSED, speed=1.0, angle=0.5).part.mechanism)
    motion_range = find_range_of_motion(mechanism, rotates_with_spindle=True)
    assert motion_range.ends[0] == pytest.approx(-math.asin(CROSSED["offset"] / CROSSED["arm"]), abs=1e-9)
    assert motion_range.low_message in [f"the mass centre of '{side} ball' reaches the spindle axis" for side in ("left", "right")]
    fixed = find_range_of_motion(mechanism, rotates_with_spindle=False)
    assert fixed.ends[0] < motion_range.ends[0]
    assert find_range_of_motion(slide(0.4), rotates_with_spindle=True).ends[0] == pytest.approx(0.0, abs=1e-12)


def test_whole_turns_are_removed_from_the_angle_of_a_line_alone():
    pendulum = find_range_of_motion(pendulum_between(low=-1.0, high=1.0), rotates_with_spindle=False)
    values = np.array([0.3, 0.3 + math.tau, 0.3 - 2 * math.tau, 2.0, 1.4, -1.4])
    np.testing.assert_allclose(pendulum.unwrap_values(values), [0.3, 0.3, 0.3, 2.0, 1.4, -1.4], atol=1e-14)
    rocker = find_range_of_motion(four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4), rotates_with_spindle=False)
    np.testing.assert_array_equal(rocker.unwrap_values(values), values)
    crank = find_range_of_motion(four_bar(crank=0.1, coupler=0.4, rocker=0.3, ground=0.4), rotates_with_spindle=False)
    turned = crank.unwrap_values(values)
    assert np.all((turned >= crank.low) & (turned <= crank.high))
    np.testing.assert_allclose(np.exp(1j * turned), np.exp(1j * values), atol=1e-14)


def test_a_motion_is_traced_up_to_limits_of_other_readings():
    mechanism = unlimited(pendulum_between(low=-0.1, high=0.3))
    motion_range = find_range_of_motion(mechanism, rotates_with_spindle=False)
    assert motion_range.ends == pytest.approx((-math.asin(0.25), math.asin(0.75)), abs=1e-9)
    assert (motion_range.low_message, motion_range.high_message) == ("the left wall", "the right wall")
    # Its path has all points that were found, each once.
    continuation = PathContinuation(mechanism, rotates_with_spindle=False)
    low_end, high_end = continuation.find_end(-1.0), continuation.find_end(1.0)
    expected = sorted({point.value for end in (low_end, high_end) for point in end.points})
    np.testing.assert_array_equal(motion_range.path.values, expected)

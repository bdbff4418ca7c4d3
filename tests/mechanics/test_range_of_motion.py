"""The travel of mechanisms, found by following them, against the closed limits of the machines and geometry."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.batched_assembly import BatchedPositionSolver
from governor_mechanism.mechanics.kinematics.continuation import PathContinuation
from governor_mechanism.mechanics.kinematics.range_of_motion import RANGE_END_MARGIN, find_range_of_motion, trace_range_of_motion
from governor_mechanism.model.joints import GROUND, Distance, Gear, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, Limit, LineAngle, PointCoordinate
from governor_scenes import governor_scene, random_governor


def unlimited(mechanism):
    """Without the limit of its leading coordinate: it has to be found."""
    kept = tuple(limit for limit in mechanism.limits if limit.reading != mechanism.coordinate)
    return replace(mechanism, limits=kept)


def test_a_limit_that_is_given_is_taken():
    mechanism = gm.load("porter").part.mechanism
    travel = find_range_of_motion(mechanism, rotates_with_spindle=True)
    limit = mechanism.limits[0]
    hair = RANGE_END_MARGIN * (limit.high - limit.low)
    assert (travel.low, travel.high) == (limit.low + hair, limit.high - hair)
    assert (travel.low_message, travel.high_message) == (limit.low_message, limit.high_message)


@settings(max_examples=25, deadline=None)
@example(seed=448698)  # balls come to the axis right behind the change point
@given(seed=st.integers(0, 2**32 - 1))
def test_a_governor_followed_goes_as_far_as_its_geometry_allows(seed):
    """The machine works its limits out in closed form; following knows only the joints."""
    dimensions, _ = random_governor(np.random.default_rng(seed))
    mechanism = governor_scene(dimensions, speed=10.0, angle=0.6).part.mechanism
    found = trace_range_of_motion(unlimited(mechanism), rotates_with_spindle=True)
    limit = mechanism.limits[0]
    hair = RANGE_END_MARGIN * (found.high - found.low)
    # Joints closed to 1e-13 leave a fork, or a dead centre beside one, open by some roots of that: 3e-7.
    assert found.low - hair == pytest.approx(limit.low, abs=1e-5)
    # At 90 degrees the arms alone could go on: only a limit, or the links, stop them.
    assert found.high + hair >= limit.high - 1e-5


def four_bar(*, crank, coupler, rocker, ground, coordinate="crank"):
    """A linkage in the fixed plane; angles of the bars from the ground line."""
    start = math.pi / 2
    knee = np.array([0.0, crank])
    across = np.hypot(ground, crank)
    angle = math.atan2(-crank, ground) + math.acos((coupler**2 + across**2 - rocker**2) / (2 * coupler * across))
    joint = knee + coupler * np.array([math.cos(angle), math.sin(angle)])
    lean = math.atan2(joint[1], joint[0] - ground)
    slender = SecondMoments(xx=0.01)
    bodies = tuple(Body(name=name, mass=1.0, second_moments=slender) for name in ("crank", "coupler", "rocker"))
    return Mechanism(
        bodies=bodies,
        joints=(
            Pin(name="A", first=Point(body=GROUND), second=Point(body="crank")),
            Pin(name="B", first=Point(body="crank", x=crank), second=Point(body="coupler")),
            Pin(name="C", first=Point(body="coupler", x=coupler), second=Point(body="rocker", x=rocker)),
            Pin(name="D", first=Point(body="rocker"), second=Point(body=GROUND, x=ground)),
        ),
        readings=tuple(BodyAngle(name=name, quantity="angle", body=name) for name in ("crank", "rocker")),
        coordinate=coordinate,
        length_scale=ground,
        initial_guess=((0.0, 0.0, start), (*knee.tolist(), angle), (ground, 0.0, lean)),
    )


def test_a_crank_rocker_turns_round_and_its_rocker_turns_back():
    linkage = {"crank": 0.1, "coupler": 0.4, "rocker": 0.3, "ground": 0.4}
    crank = find_range_of_motion(four_bar(**linkage), rotates_with_spindle=False)
    assert crank.high - crank.low == pytest.approx(2 * math.pi, rel=3 * RANGE_END_MARGIN)
    assert crank.low_message == crank.high_message == "it turns all the way round: half a turn from the sketch"
    rocker = find_range_of_motion(four_bar(**linkage, coordinate="rocker"), rotates_with_spindle=False)
    # Crank and coupler in line: the law of cosines.
    ends = [math.pi - math.acos((0.4**2 + 0.3**2 - reach**2) / (2 * 0.4 * 0.3)) for reach in (0.4 - 0.1, 0.4 + 0.1)]
    hair = RANGE_END_MARGIN * (rocker.high - rocker.low)
    assert sorted([rocker.low - hair, rocker.high + hair]) == pytest.approx(sorted(ends), abs=1e-9)
    assert rocker.high_message.startswith("dead centre: rocker turns back; beyond, joint ")
    assert "stays open by" in rocker.high_message


def test_a_rocker_that_cannot_turn_round_is_stopped_where_coupler_and_rocker_are_in_line():
    travel = find_range_of_motion(four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4), rotates_with_spindle=False)
    end = math.acos((0.4**2 + 0.3**2 - 0.55**2) / (2 * 0.4 * 0.3))
    assert (travel.low, travel.high) == pytest.approx((-end, end), abs=1e-4)
    assert travel.high_message.startswith("dead centre: crank turns back; beyond, joint ")


def test_a_parallelogram_ends_where_it_may_fold_over():
    travel = find_range_of_motion(gm.load("four_bar_chain").part.mechanism, rotates_with_spindle=False)
    assert (travel.low, travel.high) == pytest.approx((0.0, math.pi), abs=1e-4)
    assert "change point" in travel.low_message
    assert "change point" in travel.high_message


def test_a_slide_without_end_is_followed_far_and_says_so():
    block = Body(name="block", mass=1.0, can_rotate=False)
    mechanism = Mechanism(
        bodies=(block,),
        joints=(Slider(name="bar", first=Point(body=GROUND), second=Point(body="block"), angle=0.0),),
        readings=(PointCoordinate(name="way", quantity="length", point=Point(body="block"), direction_x=1.0, direction_y=0.0),),
        coordinate="way",
        length_scale=0.1,
        initial_guess=((0.0, 0.0, 0.0),),
    )
    travel = find_range_of_motion(mechanism, rotates_with_spindle=False)
    assert travel.high == pytest.approx(5.0, rel=1e-4)
    assert "followed no farther than 50 machine sizes" in travel.high_message
    assert len(PathContinuation(mechanism, rotates_with_spindle=False).find_end(1.0).points) < 100  # it strides out where nothing curves


def test_what_has_no_travel_is_refused():
    mechanism = gm.load("quick_return").part.mechanism
    with pytest.raises(gm.MechanismError, match="mobility 0"):
        find_range_of_motion(mechanism, rotates_with_spindle=False)
    still = Body(name="ball", mass=1.0, can_rotate=False)
    pendulum = Mechanism(
        bodies=(still,),
        joints=(Distance(name="arm", first=Point(body=GROUND), second=Point(body="ball"), length=0.4),),
        readings=(PointCoordinate(name="height", quantity="length", point=Point(body="ball"), direction_x=0.0, direction_y=1.0),),
        coordinate="height",
        length_scale=0.4,
        initial_guess=((0.0, -0.4, 0.0),),
    )
    with pytest.raises(gm.MechanismError, match="dead centre in the sketch"):
        find_range_of_motion(pendulum, rotates_with_spindle=False)


def pendulum_between(*, low, high):
    """A ball on an arm of 0.4 m at any angle from -1.5 to 1.5, sketched at 0.2, and within these heights."""
    pivot, ball = Point(body=GROUND), Point(body="ball")
    return Mechanism(
        bodies=(Body(name="ball", mass=1.0, can_rotate=False),),
        joints=(Distance(name="arm", first=pivot, second=ball, length=0.4),),
        readings=(
            LineAngle(name="angle", quantity="angle", start=pivot, end=ball),
            PointCoordinate(name="x", quantity="length", point=ball, direction_x=1.0, direction_y=0.0),
        ),
        coordinate="angle",
        length_scale=0.4,
        initial_guess=((0.4 * math.sin(0.2), -0.4 * math.cos(0.2), 0.0),),
        limits=(
            Limit(reading="angle", low=-1.5, high=1.5, low_message="far left", high_message="far right"),
            Limit(reading="x", low=low, high=high, low_message="the left wall", high_message="the right wall"),
        ),
    )


def test_a_travel_is_cut_exactly_where_other_readings_meet_their_limits_and_each_end_is_told():
    travel = find_range_of_motion(pendulum_between(low=-0.1, high=0.3), rotates_with_spindle=False)
    assert travel.ends == pytest.approx((-math.asin(0.25), math.asin(0.75)), abs=1e-12)
    assert (travel.low_message, travel.high_message) == ("the left wall", "the right wall")
    travel = find_range_of_motion(pendulum_between(low=-1.0, high=0.3), rotates_with_spindle=False)
    assert travel.ends == pytest.approx((-1.5, math.asin(0.75)), abs=1e-12)
    assert (travel.low_message, travel.high_message) == ("far left", "the right wall")


def test_limits_that_leave_no_travel_are_refused():
    with pytest.raises(gm.MechanismError, match=r"no travel: .* 'x' must lie within 1 to 2"):
        find_range_of_motion(pendulum_between(low=1.0, high=2.0), rotates_with_spindle=False)


def geared(ratio):
    wheels = tuple(Body(name=name, mass=1.0, second_moments=SecondMoments(xx=0.01)) for name in ("a", "b"))
    first, second = Point(body="a"), Point(body="b", x=-0.1)
    return Mechanism(
        bodies=wheels,
        joints=(
            Pin(name="A", first=Point(body=GROUND), second=first),
            Pin(name="B", first=Point(body=GROUND, x=0.3), second=second),
            Gear(name="gear", first=first, second=second, ratio=ratio),
        ),
        readings=(BodyAngle(name="turn", quantity="angle", body="a"),),
        coordinate="turn",
        length_scale=0.3,
        initial_guess=((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)),
    )


def test_a_turn_ends_where_the_poses_come_again_and_not_before():
    travel = find_range_of_motion(geared(1 / 3), rotates_with_spindle=False)
    assert (travel.low, travel.high, travel.period) == pytest.approx((-3 * math.pi, 3 * math.pi, 6 * math.pi))
    assert travel.low_message == travel.high_message == "it comes round after 3 turns: 1.5 turns from the sketch"
    endless = find_range_of_motion(geared(math.sqrt(2)), rotates_with_spindle=False)
    assert endless.period == 0.0
    assert "followed no farther than 50 machine sizes" in endless.high_message


def test_a_track_expects_the_poses_that_are_there():
    mechanism = four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4)  # the crank turns back at both ends
    travel = find_range_of_motion(mechanism, rotates_with_spindle=False)
    values = np.linspace(travel.low, travel.high, 501)
    closing = BatchedPositionSolver(mechanism)
    expected = travel.path.predict_poses(values)
    poses, sure = closing.try_solve(expected, values)
    assert sure.all()
    assert np.max(np.abs(poses - expected)) < 1e-3
    assert np.max(closing.position_solver.equations.gap(poses)) < 1e-12
    # One at a time, from the sketch's own branch, the same.
    for value in (-1.2, 0.1, 1.4):
        near = closing.position_solver.solve_at_coordinate(value)
        np.testing.assert_allclose(closing.solve(travel.path.predict_poses(np.array([value])), np.array([value]))[0], near, atol=1e-12)

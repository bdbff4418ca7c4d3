"""The travel of mechanisms, found by following them, against the closed limits of the machines and geometry."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.batched_assembly import Closing
from governor_mechanism.mechanics.kinematics.continuation import Walk
from governor_mechanism.mechanics.kinematics.range_of_motion import HAIR, find_travel, followed_travel
from governor_mechanism.model.joints import GROUND, Distance, Gear, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, BodyAngle, Coordinate, Limit, LineAngle, Mechanism, SecondMoments
from scenes import governor_scene, random_governor


def unlimited(mechanism):
    """Without the limit of its leading coordinate: it has to be found."""
    kept = tuple(limit for limit in mechanism.limits if limit.reading != mechanism.coordinate)
    return replace(mechanism, limits=kept)


def test_a_limit_that_is_given_is_taken():
    mechanism = gm.load("porter").part.mechanism
    travel = find_travel(mechanism, turning=True)
    limit = mechanism.limits[0]
    hair = HAIR * (limit.high - limit.low)
    assert (travel.low, travel.high) == (limit.low + hair, limit.high - hair)
    assert (travel.below, travel.above) == (limit.below, limit.above)


@settings(max_examples=25, deadline=None)
@example(seed=448698)  # balls come to the axis right behind the change point
@given(seed=st.integers(0, 2**32 - 1))
def test_a_governor_followed_goes_as_far_as_its_geometry_allows(seed):
    """The machine works its limits out in closed form; following knows only the joints."""
    dimensions, _ = random_governor(np.random.default_rng(seed))
    mechanism = governor_scene(dimensions, speed=10.0, angle=0.6).part.mechanism
    found = followed_travel(unlimited(mechanism), turning=True)
    limit = mechanism.limits[0]
    hair = HAIR * (found.high - found.low)
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
    bodies = tuple(Body(name=name, mass=1.0, moments=slender) for name in ("crank", "coupler", "rocker"))
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
        size=ground,
        sketch=((0.0, 0.0, start), (*knee.tolist(), angle), (ground, 0.0, lean)),
    )


def test_a_crank_rocker_turns_round_and_its_rocker_turns_back():
    linkage = {"crank": 0.1, "coupler": 0.4, "rocker": 0.3, "ground": 0.4}
    crank = find_travel(four_bar(**linkage), turning=False)
    assert crank.high - crank.low == pytest.approx(2 * math.pi, rel=3 * HAIR)
    assert crank.below == crank.above == "it turns all the way round: half a turn from the sketch"
    rocker = find_travel(four_bar(**linkage, coordinate="rocker"), turning=False)
    # Crank and coupler in line: the law of cosines.
    ends = [math.pi - math.acos((0.4**2 + 0.3**2 - reach**2) / (2 * 0.4 * 0.3)) for reach in (0.4 - 0.1, 0.4 + 0.1)]
    hair = HAIR * (rocker.high - rocker.low)
    assert sorted([rocker.low - hair, rocker.high + hair]) == pytest.approx(sorted(ends), abs=1e-9)
    assert rocker.above.startswith("dead centre: rocker turns back; beyond, joint ")
    assert "stays open by" in rocker.above


def test_a_rocker_that_cannot_turn_round_is_stopped_where_coupler_and_rocker_are_in_line():
    travel = find_travel(four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4), turning=False)
    end = math.acos((0.4**2 + 0.3**2 - 0.55**2) / (2 * 0.4 * 0.3))
    assert (travel.low, travel.high) == pytest.approx((-end, end), abs=1e-4)
    assert travel.above.startswith("dead centre: crank turns back; beyond, joint ")


def test_a_parallelogram_ends_where_it_may_fold_over():
    travel = find_travel(gm.load("four_bar_chain").part.mechanism, turning=False)
    assert (travel.low, travel.high) == pytest.approx((0.0, math.pi), abs=1e-4)
    assert "change point" in travel.below
    assert "change point" in travel.above


def test_a_slide_without_end_is_followed_far_and_says_so():
    block = Body(name="block", mass=1.0, turns=False)
    mechanism = Mechanism(
        bodies=(block,),
        joints=(Slider(name="bar", first=Point(body=GROUND), second=Point(body="block"), angle=0.0),),
        readings=(Coordinate(name="way", quantity="length", point=Point(body="block"), along_x=1.0, along_y=0.0),),
        coordinate="way",
        size=0.1,
        sketch=((0.0, 0.0, 0.0),),
    )
    travel = find_travel(mechanism, turning=False)
    assert travel.high == pytest.approx(5.0, rel=1e-4)
    assert "followed no farther than 50 machine sizes" in travel.above
    assert len(Walk(mechanism, turning=False).end(1.0).stations) < 100  # it strides out where nothing curves


def test_what_has_no_travel_is_refused():
    mechanism = gm.load("quick_return").part.mechanism
    with pytest.raises(gm.MechanismError, match="mobility 0"):
        find_travel(mechanism, turning=False)
    still = Body(name="ball", mass=1.0, turns=False)
    pendulum = Mechanism(
        bodies=(still,),
        joints=(Distance(name="arm", first=Point(body=GROUND), second=Point(body="ball"), length=0.4),),
        readings=(Coordinate(name="height", quantity="length", point=Point(body="ball"), along_x=0.0, along_y=1.0),),
        coordinate="height",
        size=0.4,
        sketch=((0.0, -0.4, 0.0),),
    )
    with pytest.raises(gm.MechanismError, match="dead centre in the sketch"):
        find_travel(pendulum, turning=False)


def pendulum_between(*, low, high):
    """A ball on an arm of 0.4 m at any angle from -1.5 to 1.5, sketched at 0.2, and within these heights."""
    pivot, ball = Point(body=GROUND), Point(body="ball")
    return Mechanism(
        bodies=(Body(name="ball", mass=1.0, turns=False),),
        joints=(Distance(name="arm", first=pivot, second=ball, length=0.4),),
        readings=(
            LineAngle(name="angle", quantity="angle", start=pivot, end=ball),
            Coordinate(name="x", quantity="length", point=ball, along_x=1.0, along_y=0.0),
        ),
        coordinate="angle",
        size=0.4,
        sketch=((0.4 * math.sin(0.2), -0.4 * math.cos(0.2), 0.0),),
        limits=(
            Limit(reading="angle", low=-1.5, high=1.5, below="far left", above="far right"),
            Limit(reading="x", low=low, high=high, below="the left wall", above="the right wall"),
        ),
    )


def test_a_travel_is_cut_exactly_where_other_readings_meet_their_limits_and_each_end_is_told():
    travel = find_travel(pendulum_between(low=-0.1, high=0.3), turning=False)
    assert travel.ends == pytest.approx((-math.asin(0.25), math.asin(0.75)), abs=1e-12)
    assert (travel.below, travel.above) == ("the left wall", "the right wall")
    travel = find_travel(pendulum_between(low=-1.0, high=0.3), turning=False)
    assert travel.ends == pytest.approx((-1.5, math.asin(0.75)), abs=1e-12)
    assert (travel.below, travel.above) == ("far left", "the right wall")


def test_limits_that_leave_no_travel_are_refused():
    with pytest.raises(gm.MechanismError, match=r"no travel: .* 'x' must lie within 1 to 2"):
        find_travel(pendulum_between(low=1.0, high=2.0), turning=False)


def geared(ratio):
    wheels = tuple(Body(name=name, mass=1.0, moments=SecondMoments(xx=0.01)) for name in ("a", "b"))
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
        size=0.3,
        sketch=((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)),
    )


def test_a_turn_ends_where_the_poses_come_again_and_not_before():
    travel = find_travel(geared(1 / 3), turning=False)
    assert (travel.low, travel.high, travel.period) == pytest.approx((-3 * math.pi, 3 * math.pi, 6 * math.pi))
    assert travel.below == travel.above == "it comes round after 3 turns: 1.5 turns from the sketch"
    endless = find_travel(geared(math.sqrt(2)), turning=False)
    assert endless.period == 0.0
    assert "followed no farther than 50 machine sizes" in endless.above


def test_a_track_expects_the_poses_that_are_there():
    mechanism = four_bar(crank=0.3, coupler=0.25, rocker=0.3, ground=0.4)  # the crank turns back at both ends
    travel = find_travel(mechanism, turning=False)
    values = np.linspace(travel.low, travel.high, 501)
    closing = Closing(mechanism)
    expected = travel.track.expected(values)
    poses, sure = closing.near(expected, values)
    assert sure.all()
    assert np.max(np.abs(poses - expected)) < 1e-3
    assert np.max(closing.assembler.equations.gap(poses)) < 1e-12
    # One at a time, from the sketch's own branch, the same.
    for value in (-1.2, 0.1, 1.4):
        near = closing.assembler.poses(value)
        np.testing.assert_allclose(
            closing.at(travel.track.expected(np.array([value])), np.array([value]))[0], near, atol=1e-12
        )

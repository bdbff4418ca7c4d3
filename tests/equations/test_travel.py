"""The travel of mechanisms, found by following them, against the closed limits of the machines and geometry."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.equations.travel import HAIR, find_travel, followed_travel
from governor_mechanism.joints import GROUND, Distance, Pin, Point, Slider
from governor_mechanism.mechanism import Body, BodyAngle, Coordinate, Mechanism, SecondMoments
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
    assert travel.high == pytest.approx(5.0, rel=0.01)
    assert "followed no farther than 50 machine sizes" in travel.above


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

"""Contacts that stay far cost no steps; several rollers on one body: as single ones, and by name where two touch at once."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import FLOOR, GRAVITY, ball_document, contact_document, readings_of, start_of
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of
from governor_mechanism.model.events import EventKind
from scene_documents import between, pin

FAR = {"name": "c", "first": "rod_3.end", "radius": 0.02, "second": "block"}


def chain_document(contacts):
    """A chain of three rods that swings above a block, which it never reaches."""
    ends = {"start": [-0.15, 0], "end": [0.15, 0]}
    rods = [{"name": f"rod_{k}", "mass": 1.0, "inertia": 0.01, "at": [0.3 * k - 0.15, 0.0], "points": ends} for k in (1, 2, 3)]
    pins = [pin("ground.O", "rod_1.start"), pin("rod_1.end", "rod_2.start"), pin("rod_2.end", "rod_3.start")]
    far = [[-3, -3], [-2, -3], [-2, -2.5], [-2.5, -2.2], [-3, -2.5]]
    readings, start = {f"angle_{k}": {"angle": f"rod_{k}"} for k in (1, 2, 3)}, {"angle_1": 0.0, "angle_2": 0.3, "angle_3": 0.5}
    document = contact_document(far, rods, contacts, readings, start, pins, (1.0, 0.1), size=1.0)
    document["run"]["accuracy"] = 1e-7
    return document


def test_a_contact_that_stays_far_changes_no_bit_and_costs_no_evaluation():
    near, far = (gm.run(gm.Scene.from_dict(chain_document(contacts)), "multibody") for contacts in ([], [FAR]))
    assert not far.events
    assert far.readings["c_gap"].min() > 1.0
    for name, values in near.readings.items():
        np.testing.assert_array_equal(far.readings[name], values)
    assert (far.cost.steps, far.cost.evaluations) == (near.cost.steps, near.cost.evaluations)


def test_steps_are_long_while_a_contact_is_far_and_find_it_again():
    """A ball that is thrown up is far from the floor halfway, where steps are long, and falls back on it."""
    height, speed = 0.02 + 1e-3, 30.0
    run = gm.run(gm.Scene.from_dict(ball_document(FLOOR, (0.0, height), (0.0, speed))), times=[0.0, 6.5])
    strike = (speed + math.sqrt(speed**2 + 2 * GRAVITY * 1e-3)) / GRAVITY
    assert [event.time for event in run.events if event.kind is EventKind.IMPACT] == pytest.approx([strike], rel=1e-12)


HILL = [[-1, -0.3], [1, -0.3], [0.02, -0.11], [-0.02, -0.11]]
"""A hill with a flat top, whose corners are at x = 0.02 and -0.02 m."""


def wheel_document(turn="-110 deg", start=(("c_gap", 0.0), ("turn_rate", 5.0)), outline=HILL, **contact):
    """A wheel with rollers, on an axle that slides up and down above a hill; one roller goes up the hill and down again."""
    wheel = {"name": "wheel", "mass": 2.0, "inertia": 0.1, "angle": turn, "points": {"tip": [0.1, 0]}}
    slide = between("slider", "ground.O", "wheel.centre", angle="90 deg")
    contacts = [{"name": "c", "first": "wheel.tip", "radius": 0.05, "second": "block", **contact}]
    readings = {"height": {"y": "wheel.centre"}, "turn": {"angle": "wheel"}}
    return contact_document(outline, [wheel], contacts, readings, {"turn": turn, **dict(start)}, [slide], (0.2, 0.01))


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_rollers_on_one_body_move_it_as_the_one_that_touches(friction):
    """The steps of both end at the corners of the hill: none is cut by an error that a jump of the curvature makes."""
    scenes = [gm.Scene.from_dict(wheel_document(friction=friction, **repeat)) for repeat in ({}, {"repeat": 3})]
    one, three = (gm.run(scene, certify=False) for scene in scenes)
    assert one.readings["turn"][-1] > math.radians(-70)
    assert EventKind.SEPARATION not in [event.kind for event in one.events]
    for name, values in one.readings.items():
        np.testing.assert_allclose(three.readings[name], values, atol=1e-12, err_msg=name)
    assert three.cost.rejected == one.cost.rejected


def test_two_rollers_of_a_body_that_touch_at_once_end_the_run_by_name():
    flat, start = [[-1, -0.3], [1, -0.3], [1, -0.11], [-1, -0.11]], {"height": -0.01, "turn_rate": 0.0}
    run = gm.run(gm.Scene.from_dict(wheel_document(0.0, start, flat, repeat=2)))
    assert run.outcome is gm.Outcome.STALLED
    assert "more rollers" in run.detail
    assert "at_once" in run.detail
    assert run.events[0].time == pytest.approx(math.sqrt(2 * 0.05 / GRAVITY), rel=1e-9)


TABLE = [[-1, -0.3], [1, -0.3], [1, -0.2], [-1, -0.2]]


def drum_document(turn, repeat, at_once, **keys):
    """A drum with pins, six of them named, that falls on a table in the plane, and one contact of them all."""
    return drum_with([drum_contact("pins", 0, repeat=repeat, at_once=at_once, **keys)], turn)


def drum_with(contacts, turn):
    """The drum with these contacts of its pins."""
    points = {f"pin_{k}": [0.1 * math.cos(math.pi / 3 * k), 0.1 * math.sin(math.pi / 3 * k)] for k in range(6)}
    drum = {"name": "drum", "mass": 2.0, "inertia": 0.01, "at": [0.0, 0.0], "angle": turn, "points": points}
    start = start_of((0.0, 0.0, turn), (0.0, 0.0, 0.0))
    document = contact_document(TABLE, [drum], contacts, readings_of("drum"), start, run=(0.6, 0.05))
    document["run"]["readings"] = [f"contact.{one['name']}" for one in contacts]
    return document


def drum_contact(name, number, **more):
    """The contact of a pin."""
    return {"name": name, "first": f"drum.pin_{number}", "radius": 0.01, "second": "block", **more}


def test_a_drum_rests_on_two_of_its_pins_at_once():
    run = gm.run(gm.Scene.from_dict(drum_document(0.0, 6, 2)))
    assert run.outcome is gm.Outcome.DONE
    assert {event.time for event in run.events} == {run.events[0].time}
    fall = 0.2 - 0.01 - 0.1 * math.cos(math.pi / 6)
    assert run.events[0].time == pytest.approx(math.sqrt(2 * fall / GRAVITY), rel=1e-10)
    assert run.readings["y"][-1] == pytest.approx(-fall, rel=1e-12)
    rest = run.times > run.events[0].time
    np.testing.assert_allclose(run.readings["contact.pins.force"][rest], 2.0 * GRAVITY, rtol=1e-12)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_drum_that_tips_from_pin_to_pin_moves_as_with_a_contact_for_each_pin(friction):
    """It strikes with one pin, tips over, and strikes with the next one while that one rests."""
    single = drum_with([drum_contact(f"pin_{k}", k, friction=friction) for k in range(6)], 0.2)
    dealt = drum_document(0.2, 6, 2, friction=friction)
    dealt_run, single_run = (gm.run(gm.Scene.from_dict(one), certify=False) for one in (dealt, single))
    assert [event.kind for event in dealt_run.events].count(EventKind.IMPACT) >= 2
    events, expected = (run.events for run in (dealt_run, single_run))
    assert [one.kind for one in events] == [one.kind for one in expected]
    np.testing.assert_allclose([one.time for one in events], [one.time for one in expected], atol=1e-11)
    for name in ("x", "y", "turn"):
        np.testing.assert_allclose(dealt_run.readings[name], single_run.readings[name], atol=1e-10)


def test_more_rollers_at_once_than_there_are_are_refused():
    with pytest.raises(gm.MechanismError, match="at_once is at most the number of the rollers, 6; found 7"):
        gm.Scene.from_dict(drum_document(0.0, 6, 7))


def test_one_roller_and_one_at_once_are_the_defaults():
    written, plain = (gm.Scene.from_dict(drum_with([drum_contact("pins", 0, **more)], 0.1)) for more in ({"repeat": 1, "at_once": 1}, {}))
    assert written.mechanism.readings == plain.mechanism.readings


@pytest.mark.parametrize(("n_pins", "at_once", "n_groups"), [(6, 2, 2), (5, 2, 3), (7, 3, 4), (9, 3, 3), (5, 5, 5), (3, 2, 3)])
def test_no_group_of_rollers_has_two_that_follow_one_another(n_pins, at_once, n_groups):
    scene = gm.Scene.from_dict(drum_document(0.1, n_pins, at_once))
    groups = [
        {round(math.atan2(one.y, one.x) / math.tau * n_pins) % n_pins for one in (gap.roller, *gap.others)}
        for gap in outline_gaps_of(scene)
    ]
    assert len(groups) == n_groups
    assert sorted(number for group in groups for number in group) == list(range(n_pins))
    for group in groups:
        assert all((number + step) % n_pins not in group for number in group for step in range(1, min(at_once, n_pins)))


def test_a_drum_with_an_odd_number_of_pins_rests_on_the_last_and_the_first_one():
    """Its pins 4 and 0 are below; they strike at once, and bear half of the weight each."""
    run = gm.run(gm.Scene.from_dict(drum_document(-math.pi / 2 + math.pi / 5, 5, 2)))
    assert run.outcome is gm.Outcome.DONE
    fall = 0.2 - 0.01 - 0.1 * math.cos(math.pi / 5)
    assert run.events[0].time == pytest.approx(math.sqrt(2 * fall / GRAVITY), rel=1e-10)
    assert len({event.subject for event in run.events}) == 2
    assert run.readings["y"][-1] == pytest.approx(-fall, rel=1e-12)
    assert run.readings["contact.pins.force"][-1] == pytest.approx(2.0 * GRAVITY, rel=1e-12)

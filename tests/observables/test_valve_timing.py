"""Valve events of a user's own gear: those of the slide valve where it is one, ports that never open, several openings, refusals."""

import copy
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.observables.valve_motion import find_event_angles, find_port_timings, reverse_crank, valve_motion_of
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.problems import ProblemCode
from refusing import refuses

ECCENTRIC, ROD, ADVANCE = 0.06, 1.8, math.radians(30.0)


OWN_GEAR = tomllib.loads(Path(__file__).with_name("own_gear.toml").read_text(encoding="utf-8"))


def own_gear(valve: dict | None = None, **changes) -> dict:
    """The slide valve slide_valve_30 as a document of a user's own mechanism, with some tables replaced."""
    document = copy.deepcopy(OWN_GEAR)
    document["body"][0]["points"]["eccentric"] = [ECCENTRIC * math.sin(ADVANCE), -ECCENTRIC * math.cos(ADVANCE)]
    document["valve"] |= valve or {}
    return document | changes


def timing_of(valve: dict | None = None, **changes):
    return gm.valve_timing(parse_scene_document(own_gear(valve, **changes)))


def rows_of(timing):
    return np.array([(row.simulated, row.simulated_stroke) for row in timing.rows])


@pytest.mark.parametrize("centre", ["equal leads", "middle of extremes", ROD])
def test_a_slide_valve_of_the_users_own_has_the_events_of_the_machine(centre):
    """The middle between the extremes of an eccentric is at the length of its rod."""
    setting = "equal leads" if centre == "equal leads" else "middle of extremes"
    document = copy.deepcopy(dict(gm.load("slide_valve_30").document))
    document["dimensions"] = {**document["dimensions"], "setting": setting}
    expected, found = gm.valve_timing(parse_scene_document(document)), timing_of({"centre": centre})
    assert [row.name for row in found.rows] == [row.name for row in expected.rows]
    np.testing.assert_allclose(rows_of(found), rows_of(expected), rtol=0, atol=1e-12)  # rounding of lengths near 2 m, over the eccentric
    np.testing.assert_allclose(found.leads, expected.leads, rtol=0, atol=1e-14)
    assert found.travel == pytest.approx(0.12, abs=1e-12)
    assert not any(row.has_theory for row in found.rows)


def test_the_crank_angle_counts_from_the_dead_centre_wherever_the_crank_starts():
    started = own_gear()
    started["body"][0]["angle"], started["body"][0]["at"] = "130 deg", [0, 0]
    np.testing.assert_allclose(
        rows_of(gm.valve_timing(parse_scene_document(started))), rows_of(timing_of()), rtol=0, atol=1e-12
    )  # the same lengths, assembled elsewhere


def test_a_mirrored_engine_that_turns_backward_has_the_same_events():
    mirrored = own_gear()
    x, y = mirrored["body"][0]["points"]["eccentric"]
    mirrored["body"][0]["points"]["eccentric"] = [x, -y]
    scene = parse_scene_document(mirrored)
    backward = copy.deepcopy(mirrored)
    backward["joint"][1]["rate"] = "-30 rpm"
    expected = rows_of(timing_of())
    np.testing.assert_allclose(rows_of(gm.valve_timing(parse_scene_document(backward))), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(rows_of(gm.valve_timing(reverse_crank(scene))), expected, rtol=0, atol=1e-12)
    assert np.max(np.abs(rows_of(gm.valve_timing(scene)) - expected)) > 1.0  # against its rotation it is another engine


def test_inside_admission_swaps_the_directions_of_the_valve():
    """With an eccentric opposite to that of outside admission; the rod's error term then acts at the other end."""
    opposite = own_gear({"admission": "inside", "centre": "middle of extremes"})
    opposite["body"][0]["points"]["eccentric"] = [-c for c in opposite["body"][0]["points"]["eccentric"]]
    inside, outside = gm.valve_timing(parse_scene_document(opposite)), timing_of({"centre": "middle of extremes"})
    assert inside.largest_openings == pytest.approx(outside.largest_openings, abs=1e-12)
    # Opposite eccentrics: the valve is where the other one is, mirrored, half a turn later.
    events = {row.name: row.simulated for row in outside.rows}
    for row in inside.rows:
        end, kind = row.name.rsplit(" ", 1)
        other = f"{'head' if end == 'crank end' else 'crank'} end {kind}"
        same_ray = math.remainder(row.simulated - events[other] - math.pi, math.tau)
        assert abs(same_ray) < 1e-12


@pytest.mark.parametrize(
    ("valve", "statement"),
    [
        ({"steam_lap": "70 mm"}, "the steam port of the crank end never opens: it stays covered by 9.2"),
        ({"exhaust_lap": "-70 mm"}, "the exhaust port of the head end never closes"),
    ],
)
def test_a_port_that_never_opens_or_never_closes_is_stated(valve, statement):
    found = timing_of(valve)
    assert len(found.rows) == 4
    assert any(sentence.startswith(statement) for sentence in found.statements), found.statements
    assert found.statements[0] in str(found)
    assert len(found.statements) == 2


def test_a_valve_that_moves_twice_in_a_turn_opens_its_ports_twice():
    document = own_gear({"centre": "middle of extremes"})
    document["body"].append({"name": "second shaft", "mass": 1, "disc": {"radius": 0.1}, "points": {"eccentric": [0.06, 0]}})
    document["joint"] += [
        {"type": "pin", "name": "bearing", "first": "ground.O", "second": "second shaft.origin"},
        {"type": "gear", "name": "gear", "first": "crank", "second": "second shaft", "ratio": 2},
    ]
    document["link"][1] |= {"first": "second shaft.eccentric"}
    scene = parse_scene_document(document)
    timings = find_port_timings(scene)
    assert all(len(port.openings) == len(port.closings) == 2 for port in timings)
    assert not find_event_angles(scene)
    for port in timings:
        for angles in (port.openings, port.closings):
            assert angles[1] - angles[0] == pytest.approx(math.pi, abs=1e-12)  # the same half a turn later
    assert "opens 2 times in a turn, at" in str(gm.valve_timing(scene))


def test_a_valve_at_rest_has_no_events():
    """Its eccentric has run into the shaft."""
    still = own_gear({"centre": ROD})
    still["body"][0]["points"]["eccentric"] = [0, 0]
    timing = gm.valve_timing(parse_scene_document(still))
    assert not timing.rows
    assert timing.travel < 1e-14
    assert [sentence.split(":")[0].split()[-2:] for sentence in timing.statements] == [["never", "opens"]] * 4


def test_without_a_piston_there_are_angles_from_the_zero_of_the_crank_and_no_strokes():
    document = own_gear()
    document["valve"].pop("piston")
    document["body"].pop(1)
    document["joint"].pop(2)
    document["link"].pop(0)
    document["readings"].pop("piston")
    found, expected = gm.valve_timing(parse_scene_document(document)), timing_of()
    np.testing.assert_allclose(rows_of(found)[:, 0], rows_of(expected)[:, 0], rtol=0, atol=1e-12)
    assert not any(row.has_stroke for row in found.rows)
    assert found.as_json()["events"][0]["simulated_stroke"] is None
    assert "stroke" not in str(found).splitlines()[1]


def test_a_second_driver_stands_still_where_it_starts():
    """The valve guide is driven across its line: the events are those of a guide at rest in its first position."""
    moving = own_gear({"crank": "engine"})
    moving["body"].append({"name": "frame", "mass": 1, "turns": False, "at": [0, 0.02]})
    moving["joint"] += [
        {"type": "driven_slide", "name": "lift", "first": "ground.O", "second": "frame.origin", "angle": "90 deg", "rate": "10 mm/s"},
        {"type": "slider", "name": "frame guide", "first": "ground.O", "second": "frame.origin", "angle": "90 deg"},
    ]
    moving["joint"][3] |= {"first": "frame.origin"}
    still = own_gear()
    still["ground"]["P"] = [0, 0.02]
    still["joint"][3] |= {"first": "ground.P"}
    found, expected = (gm.valve_timing(parse_scene_document(document)) for document in (moving, still))
    np.testing.assert_allclose(rows_of(found), rows_of(expected), rtol=0, atol=1e-12)
    turned = own_gear({"crank": "engine"})
    turned["body"].append({"name": "lever", "mass": 1, "rod": {"length": 0.5}, "at": [0, 0.02]})
    turned["joint"] += [
        {"type": "pin", "name": "pivot", "first": ["ground", 0, 0.02], "second": "lever.start"},
        {"type": "driven_turn", "name": "tilt", "first": "ground", "second": "lever", "rate": "20 deg/s"},
    ]
    turned["joint"][3] |= {"first": "lever.start"}
    np.testing.assert_allclose(rows_of(gm.valve_timing(parse_scene_document(turned))), rows_of(expected), rtol=0, atol=1e-12)


def test_derivatives_by_the_crank_angle_are_those_of_the_readings():
    motion = valve_motion_of(parse_scene_document(own_gear()))
    angles, step = np.linspace(0.1, 6.0, 9), 1e-4
    before, at, after = (motion.evaluate(angles + change) for change in (-step, 0.0, step))
    for name in ("valve", "piston"):
        first = (after.readings[name] - before.readings[name]) / (2 * step)
        second = (after.derivatives[name] - before.derivatives[name]) / (2 * step)
        np.testing.assert_allclose(at.derivatives[name], first, atol=1e-8)  # step^2 / 6 of third derivatives near 0.3 m
        np.testing.assert_allclose(at.second_derivatives[name], second, atol=1e-8)


def test_a_crank_that_cannot_turn_fully_is_refused():
    short = own_gear()
    short["link"][1]["length"] = 0.055  # shorter than the eccentric, but long enough at the start
    short["body"][2]["at"] = [0.05, 0]
    refuses("valve events need a crank that turns fully: ", gm.valve_timing, parse_scene_document(short))


def test_a_valve_that_the_crank_does_not_hold_is_refused():
    loose = own_gear()
    loose["link"].pop(1)
    refuses("besides that of the crank: 1", gm.valve_timing, parse_scene_document(loose))


def test_a_motion_that_repeats_after_two_turns_is_refused():
    slow = own_gear()
    slow["body"].append({"name": "second shaft", "mass": 1, "disc": {"radius": 0.1}, "points": {"eccentric": [0.06, 0]}})
    slow["joint"] += [
        {"type": "pin", "name": "bearing", "first": "ground.O", "second": "second shaft.origin"},
        {"type": "gear", "name": "gear", "first": "crank", "second": "second shaft", "ratio": 0.5},
    ]
    refuses("repeats in every turn", gm.valve_timing, parse_scene_document(slow))


LEVER = {"type": "driven_turn", "name": "lever", "first": "crosshead", "second": "crank", "rate": 1}

REFUSED = [
    ({"reading": "vlave"}, "valve.reading", ProblemCode.UNKNOWN_NAME, "\"vlave\" is not a reading.*Did you mean 'valve'"),
    (
        {"piston": "crank_angle"},
        "valve.piston",
        ProblemCode.WRONG_QUANTITY,
        '"crank_angle" is an angle; it must be a length, as valve or piston',
    ),
    ({"steam_lap": "24 kg"}, "valve.steam_lap", ProblemCode.WRONG_QUANTITY, "is a length"),
    ({"exhaust_lap": "5 deg"}, "valve.exhaust_lap", ProblemCode.WRONG_QUANTITY, "is a length"),
    ({"centre": "equal lead"}, "valve.centre", ProblemCode.WRONG_QUANTITY, 'or write "equal leads" or "middle of extremes"'),
    ({"admission": "outer"}, "valve.admission", ProblemCode.UNKNOWN_NAME, "known are outside, inside"),
    (
        {"crank": "engin"},
        "valve.crank",
        ProblemCode.UNKNOWN_NAME,
        "is no driver that turns a body; these are engine.*Did you mean 'engine'",
    ),
    ({"laps": 1}, "valve.laps", ProblemCode.UNKNOWN_KEY, "known keys are reading, steam_lap"),
    ({"reverser": {"key": "a.b"}}, "valve.reverser.forward", ProblemCode.MISSING_KEY, "its value in full forward gear"),
    ({"reverser": {"key": "a.b", "forward": True, "back": 1}}, "valve.reverser.forward", ProblemCode.WRONG_TYPE, "must be a number in SI"),
]


@pytest.mark.parametrize(
    ("valve", "key", "code", "sentence"), REFUSED, ids=lambda value: next(iter(value)) if isinstance(value, dict) else ""
)
def test_mistakes_of_the_table_are_told_at_their_keys(valve, key, code, sentence):
    with pytest.raises(MechanismError, match=sentence) as caught:
        parse_scene_document(own_gear(valve))
    assert {(problem.key, problem.code) for problem in caught.value.problems} >= {(key, code)}


def test_a_valve_needs_a_driven_crank_and_its_name_if_there_are_several():
    undriven = own_gear()
    undriven["joint"].pop(1)
    refuses(r'valve: valve events need a crank that is driven; add a .* "driven_turn"', parse_scene_document, undriven)
    with pytest.raises(MechanismError, match=r"valve\.crank is missing: 'engine', 'lever' turn bodies"):
        parse_scene_document(own_gear(joint=[*own_gear()["joint"], LEVER]))


def test_a_mistake_of_a_joint_or_a_reading_is_not_told_again_for_the_valve():
    broken = own_gear()
    broken["joint"][1] |= {"rate": "30 kg"}
    with pytest.raises(MechanismError) as caught:
        parse_scene_document(broken)
    assert len(caught.value.problems) == 1
    unread = own_gear()
    unread["readings"]["valve"] = {"x": "valv.centre"}
    with pytest.raises(MechanismError) as caught:
        parse_scene_document(unread)
    assert len(caught.value.problems) == 1


def test_a_gear_without_a_reverser_is_not_compared():
    refuses("the valve names nothing that reverses it", gm.valve_gears, [parse_scene_document(own_gear())])
    refuses("needs a mechanism with a slide valve", gm.valve_gears, ["porter"])
    with pytest.raises(MechanismError, match=r"vary: .*lever"):
        gm.valve_gears([parse_scene_document(own_gear({"reverser": {"key": "joint.lever.start", "forward": 1, "back": -1}}))])

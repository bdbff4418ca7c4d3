"""A mechanism under the hand: what may be changed, what is undone, and that each answer is the run of its scene."""

import json
import re
import tomllib
from base64 import b64decode
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import unpack_numbers
from governor_mechanism.live.conversation import respond
from governor_mechanism.live.describing import describe_outcome, show_whole_run
from governor_mechanism.live.grips import TRAVEL_SAMPLES, find_grips
from governor_mechanism.live.quantities import find_quantities, split_quantity
from governor_mechanism.live.session import LEAST_HELD_STEPS, Session, write_scene
from governor_mechanism.model.events import EventKind
from governor_mechanism.render.style import colour_rules


def open_session(name, duration, output_interval=None):
    """A session of a shipped scene that runs shortly."""
    return Session(
        gm.load(name).replace({"run.duration": duration} | ({"run.output_interval": output_interval} if output_interval else {}))
    )


@pytest.fixture
def session():
    return open_session("scott_russell", "0.2 s")


def test_quantities_are_those_of_the_file_in_its_units():
    found = find_quantities(gm.load("porter").document, 0.3)
    assert (found["dimensions.arm"].value, found["dimensions.arm"].unit) == (300.0, "mm")
    assert (found["spindle.speed"].value, found["spindle.speed"].unit, found["spindle.speed"].group) == (120.0, "rpm", "spindle")
    assert found["dimensions.arm"].write(320.0) == "320 mm"
    assert not any(key.startswith(("run.accuracy", "title", "law.")) for key in found)


@pytest.mark.parametrize("name", ["jansen", "porter", "governed_engine", "hartung_dubois", "stephenson_arc_middle", "slide_valve_30"])
def test_a_quantity_written_back_leaves_the_scene_as_it_is(name):
    scene = gm.load(name)
    for key, quantity in find_quantities(scene.document, 1.0).items():
        written = quantity.write(quantity.value)
        assert split_quantity(written) == (quantity.value, quantity.unit)
        assert scene.replace({key: written}) == scene


def test_an_answer_is_the_run_of_the_changed_scene(session):
    session.change({"dimensions.crank": 1.1})
    state = session.describe(session.solve())
    run = gm.run(gm.load("scott_russell").replace({"run.duration": "0.2 s", "dimensions.crank": "1.1 m"}))
    assert not state["problem"]
    for reading in state["readings"]:
        assert reading["value"] == run.readings[reading["name"]][-1]
        assert reading["error"] == run.reading_errors[reading["name"]]
        assert reading["estimate"].rpartition(" ")[2] == reading["text"].rpartition(" ")[2]  # in the same unit


def test_a_drag_is_undone_at_once_and_redone(session):
    first = session.document
    for value in (1.05, 1.1, 1.15):
        session.change({"dimensions.crank": value}, is_last=value == 1.15)
    session.change({"body.crank.mass": 2.0})
    last = session.document
    session.undo()
    assert session.find_quantities()["dimensions.crank"].value == 1.15
    session.undo()
    assert session.document == first
    session.undo()  # there is nothing more
    session.redo()
    session.redo()
    assert session.document == last
    session.reset()
    assert session.document == first
    session.undo()
    assert session.document == last


def test_an_impossible_geometry_is_a_sentence_and_the_last_possible_state(session):
    session.change({"body.rod.mass": 1.0})
    possible = session.solve()
    session.change({"run.duration": -1.0})
    state = session.solve()
    assert "duration" in state.problem
    assert state.run is possible.run
    session.undo()
    assert session.solve().problem == ""


def test_what_is_no_quantity_is_refused(session):
    for key in ("title", "dimensions.nothing"):
        with pytest.raises(gm.MechanismError, match="no quantity of this scene"):
            session.change({key: 1.0})


def test_a_pivot_follows_the_hand_in_the_picture():
    session = open_session("jansen", "0.1 s")
    state = session.describe(session.solve())
    (grip,) = (one for one in state["grips"] if one["name"] == "pivot B")
    scale = show_whole_run(session.run)[0].views[0].picture.scale
    values = {one.key: one.value for one in session.find_quantities().values()}
    moved = {key: values[key] + 100.0 * right - 50.0 * down for key, right, down in grip["effects"]}
    session.change(moved)
    assert session.solve().problem == ""
    assert moved["dimensions.across"] == pytest.approx(38.0 - 1e3 * 100.0 / scale, rel=1e-12)  # the pivot lies at -across, -down
    assert moved["dimensions.down"] == pytest.approx(7.8 - 1e3 * 50.0 / scale, rel=1e-12)


def test_a_pulled_ball_moves_where_the_motion_starts():
    scene = gm.load("porter").replace({"run.duration": "0.1 s"})
    run = gm.run(scene)
    view = show_whole_run(run)[0].views[0]
    grip, sleeve = find_grips(run, view)
    ((key, right, down),) = grip.effects
    assert (key, grip.start) == ("start.arm_angle", pytest.approx(40.0, rel=1e-12))
    assert sleeve.name == "sleeve"
    changed = gm.run(scene.replace({key: f"{40.0 + 2.0 * right + down} deg"}))
    names = [body.name for body in scene.mechanism.bodies]
    body = names.index(grip.name)
    assert abs(run.poses[0, body, 0]) > 0.1  # no sleeve
    before, after = (np.array(view.picture.place(one.poses[0, body, :2])) for one in (run, changed))
    displacement = after - before  # that part of the hand's motion (2, 1) along the path of the ball
    assert displacement @ displacement == pytest.approx(displacement @ [2.0, 1.0], rel=1e-3)


@pytest.mark.parametrize("name", ["porter", "hartung_dubois", "slider_crank_torque"])
def test_what_is_pulled_along_its_travel_is_where_a_run_from_there_starts(name):
    scene = gm.load(name).replace({"run.duration": "10 ms", "run.output_interval": "10 ms"})
    session = Session(scene)
    session.describe(session.solve())
    travel = session.find_travel()["travel"]
    low, high = travel["values"]
    sample = 40
    session.change({travel["key"]: low + sample / (TRAVEL_SAMPLES - 1) * (high - low)})
    run = session.solve().run
    view = show_whole_run(run, session._boxes)[0].views[0]
    names = [body.name for body in scene.mechanism.bodies]
    for track in travel["tracks"]:
        if body := track.get("name"):
            shown = [unpack_numbers(track[axis], TRAVEL_SAMPLES)[sample] for axis in "xy"]
            assert shown == pytest.approx(view.picture.place(run.poses[0, names.index(body), :2]), abs=1.0)  # places are rounded to 1


def test_a_travel_ends_at_stops_and_at_dead_centres_and_closes_after_a_turn():
    def travel_of(scene):
        session = Session(scene.replace({"run.duration": "10 ms", "run.output_interval": "10 ms"}))
        return session.find_travel()["travel"]

    porter = gm.load("porter")
    assert travel_of(porter)["values"] == pytest.approx((0.0, 90.0), abs=1e-2)
    assert travel_of(porter)["ends"][1] == "Arm angle 90 deg: the arms are at 90 degrees to the spindle (dead centre)."
    stopped = travel_of(porter.replace({"effects.stops": {"sleeve_lift": ["100 mm", "160 mm"]}}))
    assert stopped["ends"] == ("Sleeve lift 100 mm: a stop.", "Sleeve lift 160 mm: a stop.")
    lifts = gm.kinematics(porter, "arm_angle", [f"{value} deg" for value in stopped["values"]]).readings["sleeve_lift"]
    assert 0.100 < lifts[0] < 0.102
    assert 0.158 < lifts[1] < 0.160
    turning = travel_of(gm.load("slider_crank_torque"))
    assert turning["is_closed"]
    assert np.ptp(turning["values"]) == pytest.approx(2 * np.pi, rel=1e-12)
    for name in ("jansen", "governed_engine", "watt_clearance"):  # driven, of two parts, of two coordinates
        assert travel_of(gm.load(name)) is None


def test_a_start_in_equilibrium_becomes_a_number_where_it_is_pulled():
    session = open_session("hartung_dubois", "10 ms", "1 ms")
    assert session.document["start"]["lever_angle"] == "equilibrium"
    session.change({"start.lever_angle": 5.0})
    assert session.document["start"]["lever_angle"] == "5 deg"
    assert session.solve().run.readings["lever_angle"][0] == pytest.approx(np.radians(5.0), rel=1e-12)
    assert session.find_changes() == {"start.lever_angle": 5.0}


def test_a_run_that_locks_takes_few_steps_while_a_hand_holds_it():
    session = open_session("jansen", "2 s")
    usual = session.run.cost.steps
    session.change({"dimensions.crank": 17.0}, is_last=False)  # its joints stay open from 0.98 s on
    held = session.solve()
    assert (held.run.outcome, held.run.times[-1]) == (gm.Outcome.STEP_LIMIT, 0.98)
    assert held.run.cost.steps < 10 * max(usual, LEAST_HELD_STEPS)
    assert "while you hold it: from there on it needs many steps, as where it locks" in session.describe(held)["accuracy"]
    session.change({"dimensions.crank": 15.5})
    assert session.solve().run.outcome is gm.Outcome.DONE


def test_a_run_that_takes_long_goes_to_the_shown_time_while_a_hand_moves(monkeypatch):
    session = open_session("porter", "2 s")
    monkeypatch.setattr("governor_mechanism.live.session.HELD_TIME", 0.5 * session.run.cost.wall_time)
    session.shown_time = 0.4
    session.change({"dimensions.sleeve_mass": 21.0}, is_last=False)
    brief, whole = session.solve(is_brief=True), session.solve()
    assert brief.run.times[-1] == pytest.approx(0.4, abs=1e-12)
    assert (session.describe_moment(brief)["readingsAt"], whole.run.times[-1]) == ("At t = 0.4 s", 2.0)
    errors = brief.run.reading_errors["arm_angle"] + whole.run.reading_errors["arm_angle"]
    assert brief.run.readings["arm_angle"][-1] == pytest.approx(whole.run.readings["arm_angle"][len(brief.run.times) - 1], abs=errors)
    session.shown_time = 1.5  # more than half of the time that there is
    session.change({"dimensions.sleeve_mass": 22.0}, is_last=False)
    assert 0.9 < session.solve(is_brief=True).run.times[-1] < 1.1


def test_a_brief_run_is_drawn_in_the_proportions_of_the_whole_one(monkeypatch):
    session = Session(gm.load("slider_crank_torque"))
    whole = session.describe(session.solve())["data"]["views"][0]
    monkeypatch.setattr("governor_mechanism.live.session.HELD_TIME", 0.0)
    session.change({"start.crank_rate": 1e-6}, is_last=False)
    brief = session.solve(is_brief=True)
    assert len(brief.run.times) == 2
    moment = session.describe_moment(brief)["moment"]["views"][0]
    assert [one["role"] for one in moment["shapes"]] == [one["role"] for one in whole["shapes"]]
    still = [(one["points"], other["points"]) for one, other in zip(whole["shapes"], moment["shapes"], strict=True) if "track" not in one]
    assert still
    assert all(before == after for before, after in still)


def test_a_moment_is_drawn_without_a_search_for_events_and_shows_what_strikes(monkeypatch):
    scene = gm.load("porter").replace({"effects.stops": {"arm_angle": ["30 deg", "50 deg"]}, "run.duration": "1 s"})
    session = Session(scene)
    session.describe(session.solve())
    impact = next(one for one in session.run.events if one.kind is EventKind.IMPACT)
    session.shown_time = float(session.run.times[np.searchsorted(session.run.times, impact.time)])
    session.change({"run.duration": 0.9}, is_last=False)
    snapshot = session.solve()
    whole = session.describe(snapshot)["data"]["views"][0]["shapes"]

    def fail(*arguments):
        raise AssertionError

    monkeypatch.setattr("governor_mechanism.observables.run_result.DeferredMotionAnalysis._sample", fail)
    moment = session.describe_moment(session.solve(is_brief=True))["moment"]["views"][0]["shapes"]
    assert "burst" in {one["role"] for one in moment}
    assert "burst" in {one["role"] for one in whole}


def test_the_equilibria_follow_a_hand_that_moves():
    session = open_session("porter", "0.1 s")
    session.describe(session.solve())
    session.change({"spindle.speed": 130.0}, is_last=False)
    moment = session.describe_moment(session.solve(is_brief=True))
    assert moment["equilibria"] == session.describe(session.solve())["equilibria"]
    assert "At 130 rpm" in moment["equilibria"]["sentences"]


def test_a_governor_shows_its_equilibria_and_the_curve_as_opened():
    session = open_session("porter", "0.1 s")
    state = session.describe(session.solve())
    assert "stable equilibrium" in state["equilibria"]["sentences"]
    assert "as opened" not in state["equilibria"]["picture"]
    session.change({"dimensions.sleeve_mass": 25.0})
    assert "as opened" in session.describe(session.solve())["equilibria"]["picture"]


def test_dry_friction_shows_the_speeds_between_which_it_holds():
    scene = gm.load("porter_dry_friction").replace({"run.duration": "0.1 s"})
    session = Session(scene)
    equilibria = session.describe(session.solve())["equilibria"]
    (found,) = gm.equilibria(scene)
    band = gm.insensitivity_band(scene, [found.coordinate], "40 N")
    low, high = (f"{60 / (2 * np.pi) * speed[0]:.4g} rpm" for speed in (band.falling_speed, band.rising_speed))
    assert f"Dry friction holds it there between {low} and {high}" in equilibria["sentences"]
    assert "held by friction" in equilibria["picture"]
    known = set(re.findall(r"(--c-\w+):", colour_rules()))
    unknown = [name for name, colour in re.findall(r"var\((--c-\w+)(, #\w+)?\)", equilibria["picture"]) if name not in known and not colour]
    assert not unknown  # the browser would paint them black


def test_a_saved_scene_is_the_opened_file_with_the_changed_values_alone_changed(tmp_path):
    source = Path(gm.load("jansen").source).read_text(encoding="utf-8")
    session = open_session("jansen", "4 s")
    assert write_scene(source, session.document) == source
    session.change({"dimensions.crank": 16.0, "body.shank.mass": 60.0, "ground.O.2": 0.001})
    saved = write_scene(source, session.document).splitlines()
    changed = [(old, new) for old, new in zip(source.splitlines(), saved, strict=True) if old != new]
    assert len(changed) == 3
    assert all(old.partition("#")[2] == new.partition("#")[2] for old, new in changed)
    path = tmp_path / "mine.toml"
    path.write_text("\n".join(saved), encoding="utf-8")
    assert gm.load(path).document == session.document
    assert gm.Scene.from_dict(tomllib.loads(write_scene(None, session.document))) == gm.load(path)


def ask(session, **message):
    """What the page that asks hears."""
    answer = respond(session, json.dumps(message))
    return answer() if callable(answer) else answer


def test_another_assembly_is_taken_and_undone():
    session = open_session("quick_return", "0.1 s")
    state = session.describe(session.solve())
    assert state["inspections"] == ["assemblies"]
    found = ask(session, action="assemblies")["assemblies"]
    assert (found["count"], found["taken"]) == (2, 2)
    assert ask(session, action="assemble", assembly=1) is None
    assert session.solve().run.readings["lever_angle"][0] == gm.run(gm.Scene.from_dict(session.document)).readings["lever_angle"][0]
    assert ask(session, action="assemblies")["assemblies"]["taken"] == 1
    session.undo()
    assert ask(session, action="assemblies")["assemblies"]["taken"] == 2
    session.change({"run.duration": 0.2})
    session.change({"run.duration": 0.1})
    assert ask(session, action="assemble", assembly=9) is None
    assert "assembl" in session.solve().problem


def test_a_valve_gear_tells_its_events_and_shows_zeuners_diagram():
    scene = gm.load("slide_valve_30").replace({"run.duration": "0.1 s"})
    session = Session(scene)
    assert session.describe(session.solve())["inspections"] == ["valve"]
    session.change({"dimensions.outside_lap": 20.0})
    session.solve()
    valve = ask(session, action="valve")["valve"]
    assert valve["timing"] == str(gm.valve_timing(scene.replace({"dimensions.outside_lap": "20 mm"}))).partition("\n")[2]
    assert b64decode(valve["picture"]).startswith(b"\x89PNG")
    assert "has none" in ask(Session(gm.load("scott_russell")), action="valve")["refused"]


def test_changes_are_those_from_the_opened_scene(session):
    assert session.find_changes() == {}
    session.change({"dimensions.crank": 1.1})
    session.change({"body.rod.mass": 2.5})
    session.change({"dimensions.crank": 1.0})
    assert session.find_changes() == {"body.rod.mass": 2.5}


def test_two_runs_are_drawn_to_one_scale_by_their_frames():
    session = open_session("scott_russell", "0.2 s")
    first = session.describe(session.solve())
    ((scale, left, top),) = first["frames"]
    picture = show_whole_run(session.run)[0].views[0].picture
    assert picture.place(np.array([0.3, 0.2])) == pytest.approx([scale * (0.3 - left), scale * (top - 0.2)])


def test_a_long_cause_of_an_early_end_is_one_sentence():
    run = gm.run("slider_crank", times=[0.0, 0.1])
    cause = "the mechanism comes to a configuration in which " + "one more of its many joints " * 8 + "locks it"
    assert f"{cause}; " in describe_outcome(replace(run, outcome=gm.Outcome.STALLED, detail=cause))


def test_quantities_of_couplings_change_too():
    session = open_session("governed_engine", "0.2 s")
    found = session.find_quantities()
    assert found["coupling.throttle_rod.table.2.1"].words == "throttle rod table reading 2"
    session.change({"coupling.gear.ratio": 1.1, "coupling.throttle_rod.table.2.2": 0.7})
    expected = gm.load("governed_engine").replace({"coupling.gear.ratio": 1.1, "coupling.throttle_rod.table.2.2": 0.7})
    assert session.solve().run.scene.couplings == expected.couplings

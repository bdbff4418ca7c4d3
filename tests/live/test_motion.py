"""A motion that goes on: it is the run of the whole time, whatever changes acts from the present state, and a moment is one of the run."""

import json

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.live.conversation import respond
from governor_mechanism.live.motion import MAX_DURATION
from governor_mechanism.live.session import Session


@pytest.fixture
def session():
    one = Session(gm.load("porter").replace({"run.duration": "2 s"}))
    one.describe(one.solve())
    return one


def reading(piece, name):
    """Value and error of a reading at the end of a piece."""
    (found,) = [one for one in piece["readings"] if one["name"] == name]
    return found["value"], found["error"]


def test_a_motion_in_pieces_is_the_run_of_the_whole_time(session):
    time = 0.5
    for k in range(4):
        piece = session.extend_motion("tab", time, 0.3, is_new=k == 0)
        assert (piece["start"], piece["stop"]) == pytest.approx((time, time + 0.3), abs=1e-12)
        assert not piece["note"]
        assert not piece["isOver"]
        time = piece["stop"]
    whole = gm.run("porter", times=[0.0, time])
    value, error = reading(piece, "arm_angle")
    assert value == pytest.approx(whole.readings["arm_angle"][-1], abs=20 * (error + 1e-7))  # errors of the pieces add up
    assert "pieces add up to" in piece["accuracy"]
    json.dumps(piece, allow_nan=False)


def test_a_change_acts_from_the_present_state_on(session):
    session.extend_motion("tab", 0.0, 0.5, is_new=True)
    session.change({"spindle.speed": 140.0})
    piece = session.extend_motion("tab", 0.3, 0.2, is_new=False)
    state = gm.run("porter", times=[0.0, piece["start"]]).state()
    expected = gm.run(gm.load("porter").replace({"spindle.speed": "140 rpm"}), times=[0.0, 0.2], start=state)
    assert piece["start"] == pytest.approx(0.3, abs=0.01)  # a reported time of the piece before
    assert reading(piece, "arm_angle")[0] == pytest.approx(expected.readings["arm_angle"][-1], abs=1e-6)
    assert reading(piece, "spindle_speed")[0] == pytest.approx(140 * np.pi / 30)


def test_other_dimensions_begin_again_and_say_so(session):
    session.extend_motion("tab", 0.0, 0.5, is_new=True)
    session.change({"dimensions.arm": 310.0})
    piece = session.extend_motion("tab", 0.5, 0.2, is_new=False)
    assert piece["start"] == 0.0
    assert piece["note"].startswith("The motion starts again from the start of the scene: the state to start from does not fit")


def test_a_pulled_ball_moves_from_where_it_is_let_go(session):
    session.change({"start.arm_angle": 35.0})
    piece = session.extend_motion("tab", 0.0, 0.2, is_new=True)
    expected = gm.run(gm.load("porter").replace({"start.arm_angle": "35 deg"}), times=[0.0, 0.2])
    assert reading(piece, "arm_angle")[0] == pytest.approx(expected.readings["arm_angle"][-1], abs=1e-6)


def test_tabs_have_motions_of_their_own(session):
    first = session.extend_motion("one", 0.0, 0.2, is_new=True)
    session.extend_motion("two", 1.0, 0.4, is_new=True)
    again = session.extend_motion("one", first["stop"], 0.2, is_new=False)
    assert again["start"] == first["stop"]


@pytest.mark.parametrize("name", ["jansen", "hartung_dubois", "governed_engine", "stephenson_arc_middle"])
def test_machines_of_all_kinds_go_on(name):
    one = Session(gm.load(name).replace({"run.duration": "1 s"} if name != "governed_engine" else {}))
    one.describe(one.solve())
    piece = one.extend_motion("tab", 0.2, 0.1, is_new=True)
    piece = one.extend_motion("tab", piece["stop"], 0.1, is_new=False)
    assert piece["stop"] == pytest.approx(0.4)
    assert piece["data"]["views"]
    assert piece["plots"]["plots"]
    json.dumps(piece, allow_nan=False)


def test_the_work_of_a_request_is_bounded(session):
    piece = session.extend_motion("tab", 0.0, 1e9, is_new=True)
    assert piece["stop"] == MAX_DURATION


def test_a_motion_is_asked_for_by_a_message(session):
    message = {"action": "extend", "tab": "tab", "time": 0.0, "duration": 0.1, "isNew": True, "number": 7}
    answer = respond(session, json.dumps(message))()
    assert answer["motion"]["number"] == 7
    assert answer["motion"]["stop"] == pytest.approx(0.1)
    assert "a finite number" in respond(session, json.dumps(message | {"time": "now"}))["refused"]


def test_a_moment_is_one_of_the_run_in_the_box_of_the_picture_before(session):
    before = session.describe(session.solve())
    session.shown_time = 0.7
    session.change({"dimensions.arm": 330.0}, is_last=False)
    snapshot = session.solve()
    moment = session.describe_moment(snapshot)
    assert moment["number"] == snapshot.number
    assert "data" not in moment
    assert moment["moment"]["times"] == {"start": 0.7, "stop": 0.7, "count": 1}
    assert moment["frames"] == before["frames"]
    assert [view["width"] for view in moment["moment"]["views"]] == [view["width"] for view in before["data"]["views"]]
    held = session.describe(snapshot)
    assert held["frames"] == before["frames"]  # nothing is rescaled under a hand
    session.change({"dimensions.arm": 330.0})
    assert session.describe(session.solve())["frames"] != before["frames"]


def test_a_moment_of_a_refused_state_has_no_picture(session):
    session.change({"dimensions.ball_mass": -1.0})
    moment = session.describe_moment(session.solve())
    assert moment["problem"]
    assert "moment" not in moment


def test_what_cannot_go_on_is_a_sentence(session):
    session.change({"dimensions.ball_mass": -1.0})
    piece = session.extend_motion("tab", 0.0, 0.1, is_new=True)
    assert "ball_mass" in piece["problem"]  # and the motion is that of the last possible scene
    session.reset()
    session.change({"spindle.speed": 900.0})
    with pytest.raises(gm.MechanismError, match="does not go on"):
        go_on(session, 20)


def go_on(session, count):
    """Let a motion go on from its end, again and again."""
    for k in range(count):
        session.extend_motion("end", 1e9 if k else 0.0, 0.5, is_new=k == 0)


def test_a_piece_is_drawn_from_a_second_of_film_before_it_where_a_point_leaves_a_trail():
    for name, trail in (("jansen", 1.0), ("slider_crank", 0.0)):
        session = Session(gm.load(name).replace({"run.duration": "2 s"}))
        session.describe(session.solve())
        session.extend_motion("tab", 2.0, 0.4, is_new=True)
        motion = session.extend_motion("tab", 2.4, 0.4, is_new=False)
        times = motion["data"]["times"]
        assert (times["start"], times["stop"]) == pytest.approx((2.4 - trail, 2.8), rel=1e-12)  # in true time
        assert (motion["start"], bool(motion["data"]["views"][0]["trails"])) == (pytest.approx(2.4, rel=1e-12), trail > 0.0)
        assert len(motion["frames"]) == len(motion["data"]["views"])

"""The live page in a notebook: from Python, by the messages of its widget, and as a picture where nothing can move."""

import html
import json
import re
import sys
import time
import tomllib

import pytest

import governor_mechanism as gm
from governor_mechanism.live.describing import show_whole_run
from governor_mechanism.notebook.exploration import make_widget
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import shapes_of
from refusing import refuses

WAITING_TIME = 60.0
"""Longest time (s) for an answer on a busy machine."""


class Widgets:
    """Stands for the module anywidget: what a widget was made with, and what it sends."""

    class AnyWidget:
        def __init__(self, **fields):
            self.fields, self.sent, self.hear = fields, [], None

        def on_msg(self, hear):
            self.hear = hear

        def send(self, text):
            self.sent.append(json.loads(text))

        def wait_for(self, key):
            deadline = time.monotonic() + WAITING_TIME
            while not (found := [one for one in self.sent if key in one]):
                assert time.monotonic() < deadline
                time.sleep(0.01)
            return found[-1]


@pytest.fixture
def scene():
    return gm.load("scott_russell").replace({"run.duration": "0.2 s"})


def assert_drawn_as_its_film(view):
    """The page of a view has the same parts in the same frame as the film of its scene."""
    run, (shown, _) = gm.run(view.scene), show_whole_run(view._session.run)
    for data in shown.parts:
        film = FrameData(run, data.part, (float(run.times[0]), float(run.times[-1])), run.times[:1])
        assert data.drawing.bounds == film.drawing.bounds
        assert list(shapes_of(data.drawing.fixed, None)) == list(shapes_of(film.drawing.fixed, None))
        moving = (list(shapes_of(one.drawing.moving, one.moment_at(0))) for one in (data, film))
        assert next(moving) == next(moving)


@pytest.mark.parametrize("name", ["porter", "hartung_dubois", "slider_crank", "stephenson_arc_middle", "jansen"])
def test_a_machine_is_drawn_as_its_film_draws_it(name):
    assert_drawn_as_its_film(gm.explore(name))


def test_a_drawing_grows_with_the_travel_of_the_changed_motion():
    view = gm.explore("porter", "start.arm_angle")
    before = show_whole_run(view._session.run)[0].parts[0].drawing.bounds
    view.set("start.arm_angle", "50 deg")
    assert view.problem == ""
    assert show_whole_run(view._session.run)[0].parts[0].drawing.bounds[1] > before[1] + 0.01
    assert_drawn_as_its_film(view)


def test_what_is_set_is_the_scene():
    view = gm.explore("porter", "arm")
    view.set("arm", 0.32)
    view.set("spindle.speed", "125 rpm")
    text = view.scene.to_toml()
    assert 'arm = "320 mm"' in text
    assert 'speed = "125 rpm"' in text
    assert gm.Scene.from_dict(tomllib.loads(text)) == view.scene
    assert view.scene == gm.load("porter").replace({"dimensions.arm": "320 mm", "spindle.speed": "125 rpm"})
    view.undo()
    view.undo()
    assert view.scene == gm.load("porter")


def test_impossible_values_are_a_sentence_and_the_scene_stays():
    view = gm.explore("slider_crank", "connecting_rod")
    before = view.scene
    view.set("connecting_rod", "200 mm")
    assert "connecting_rod (200 mm) must be longer than crank (300 mm)" in view.problem
    assert view.scene is before
    view.set("connecting_rod", "900 mm")
    assert view.problem == ""
    assert view.scene.part.dimensions["connecting_rod"] == 0.9


def test_requested_quantities_are_offered_alone_with_their_ranges():
    view = gm.explore("porter", "arm=200 mm:0.4", "effects.dashpot.sleeve=10 N s/m:50 N s/m", "link")
    assert view.quantities["effects.dashpot.sleeve"] == "30 N s/m"
    assert view.quantities["dimensions.link"] == "300 mm"
    state = view._session.describe(view._session.solve())
    assert len(state["quantities"]) == 3 < len(view.quantities)
    ends = {one["key"]: (one["low"], one["high"]) for one in state["quantities"]}
    assert ends["dimensions.arm"] == pytest.approx((200.0, 400.0))
    assert ends["effects.dashpot.sleeve"] == pytest.approx((10.0, 50.0))
    assert ends["dimensions.link"] == pytest.approx((150.0, 600.0))
    assert state["grips"] == []  # the start is not offered
    assert view.scene.effects[-1].linear == 30.0  # the middle of what the scene does not give
    assert repr(view) == "Exploration('Porter governor, open arms'; arm 300 mm, effects.dashpot.sleeve 30 N s/m, link 300 mm)"


def test_a_dimension_of_a_custom_machine_is_what_its_unit_says(scene):
    view = gm.explore(scene, "crank=0.5 m:2000 mm")
    view.set("crank", "1200 mm")
    assert view.quantities["dimensions.crank"] == "1.2 m"
    view.set("crank", 1.1)
    assert view.scene == scene.replace({"dimensions.crank": "1.1 m"})
    refuses("is a length", view.set, "crank", "3 kg")
    (offered,) = view._session.describe(view._session.solve())["quantities"]
    assert (offered["low"], offered["high"]) == pytest.approx((0.5, 2.0))


def test_a_part_of_a_scene_has_short_names_too():
    view = gm.explore("governed_engine", "arm")
    view.set("arm", "310 mm")
    assert view.scene == gm.load("governed_engine").replace({"part.governor.dimensions.arm": "310 mm"})
    view = gm.explore("quick_return", "lever=390 mm:410 mm")
    assert repr(view).endswith("lever 400 mm)")


def test_wrong_values_are_refused():
    view = gm.explore("porter", "arm")
    refuses("Did you mean 'arm'", view.set, "arn", 0.3)
    refuses("is a length", view.set, "arm", "3 kg")
    refuses("no quantity of this scene", view.set, "dimensions.crank", 0.3)
    assert view.scene == gm.load("porter")


def test_without_the_extra_a_notebook_shows_a_picture_and_how_to_install_it(monkeypatch, scene):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    bundle = gm.explore(scene)._repr_mimebundle_()
    assert set(bundle) == {"text/html", "text/plain"}
    assert '<img src="data:image/png;base64,' in bundle["text/html"]
    assert "pip install 'governor-mechanism[notebook]'" in html.unescape(bundle["text/html"])


def test_messages_of_the_widget_are_those_of_the_web_socket(scene):
    view = gm.explore(scene)
    widget = make_widget(Widgets, view._session, "Scott Russell")
    page = widget.fields["page"]
    assert "connect-src" not in page
    assert "new WebSocket" not in page
    assert not re.search(r"(src|href)=\"http", page)
    widget.hear(widget, '{"action": "hello"}', [])
    assert widget.wait_for("quantities")["number"] == 0
    widget.sent.clear()
    widget.hear(widget, json.dumps({"action": "change", "values": {"dimensions.crank": 1.1}}), [])
    state = widget.wait_for("quantities")
    assert view.scene.part.dimensions["crank"] == 1.1
    assert {one["name"]: one["value"] for one in state["readings"]} == {name: values[-1] for name, values in view.run.readings.items()}
    widget.hear(widget, json.dumps({"action": "change", "values": {"dimensions.crank": 1.15}, "isLast": False}), [])
    assert "data" not in widget.wait_for("moment")  # a hand moves: the plots follow later
    widget.sent.clear()
    widget.hear(widget, json.dumps({"action": "change", "values": {"dimensions.crank": 1.1}, "isLast": True}), [])
    assert "moment" not in widget.wait_for("data")
    widget.hear(widget, "{", [])
    assert "JSON" in widget.wait_for("refused")["refused"]
    widget.hear(widget, '{"action": "export", "ending": "csv"}', [])
    assert widget.wait_for("file")["file"]["name"] == "scene.csv"
    widget.sent.clear()
    view.set("crank", 1.2)  # from Python, too
    assert {one["key"]: one["value"] for one in widget.wait_for("quantities")["quantities"]}["dimensions.crank"] == 1.2


def test_a_notebook_gets_the_widget(scene):
    pytest.importorskip("anywidget")
    bundle = gm.explore(scene)._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert "run this cell in a notebook" in bundle["text/html"]

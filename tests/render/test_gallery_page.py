"""The gallery shows a picture, the words and the command of each scene, and leads to its page."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

from governor_mechanism.render.page.views import show_run
from governor_mechanism.render.page.writer import POSTER_MOMENT, draw_poster, make_gallery
from stub_run import GOVERNOR_DIMENSIONS, fake_run


@pytest.fixture(scope="module")
def run():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], title="Porter's <governor>", duration=1.0)


def test_the_index_leads_to_each_page_and_asks_for_nothing(run):
    text = make_gallery([("porter", run), ("other", run)], "Two & two")
    assert re.findall(r'<a href="([^"]*)"', text) == ["porter.html", "other.html"]
    assert "run porter <span>--film html</span>" in text
    assert text.count("<h3>Porter&#x27;s &lt;governor&gt;</h3>") == 2
    assert "<h1>Two &amp; two</h1>" in text
    assert re.findall(r"<h2>(.*?)</h2>", text) == ["Governors"]
    assert "http" not in re.sub(r'http-equiv="', "", text)


def test_the_picture_has_the_balls_where_the_run_has_them(run):
    times = np.array([POSTER_MOMENT])
    view = show_run(run, None, (0.0, 1.0), times, 1.0).views[0]
    picture = ElementTree.fromstring(draw_poster(view))
    balls = [element for element in picture if element.get("class") == "role-ball"]
    drawn = sorted([float(ball.get("cx")), float(ball.get("cy"))] for ball in balls)
    # The angle of the arms of `fake_run` at that time; the picture has whole units.
    angle = np.radians(40.0 + 8.0 * np.sin(2 * np.pi / 1.7 * POSTER_MOMENT))
    expected = [[side * (0.04 + 0.3 * np.sin(angle)), -0.3 * np.cos(angle)] for side in (-1, 1)]
    assert_allclose(drawn, view.picture.place(np.array(expected)), atol=0.51)

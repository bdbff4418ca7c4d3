"""What a notebook shows of runs, scenes, curves, studies and films."""

from __future__ import annotations

import base64
import re
from xml.etree import ElementTree

import numpy as np
import pytest

import governor_mechanism as gm
from files.saved_runs import saved_run
from governor_mechanism.errors import MechanismError
from governor_mechanism.notebook.html import CURVE_HEIGHT, CURVE_WIDTH, draw_small_curve


def parsed(html):
    """The elements of HTML that is XML too."""
    return ElementTree.fromstring(f"<page>{html}</page>")


@pytest.mark.parametrize("scene", ["porter_dry_friction", "governed_engine_mean_torque"])
def test_a_run_shows_how_it_ended_and_all_its_readings(scene):
    run = saved_run(scene)
    page = parsed(run._repr_html_())
    rows = [[cell.text for cell in row] for row in page.iter("tr")]
    assert [row[0] for row in rows[1:]] == list(run.readings)
    assert len(page.findall(".//polyline")) == len(run.readings)
    text = " ".join(page.itertext())
    assert run.message in text
    assert run.scene.title in text
    angle = next(row for row in rows if row[-1] == "°")
    assert float(angle[4]) == pytest.approx(np.degrees(run.readings[angle[0]][-1]), rel=1e-5)  # six digits are shown


def test_a_scene_shows_its_machines_and_dimensions():
    text = " ".join(parsed(gm.load("governed_engine_mean_torque")._repr_html_()).itertext())
    for words in ("pendulum_governor", "arm 300 mm", "governor.sleeve_lift", "dashpot.sleeve_lift"):
        assert words in text


def test_a_small_curve_keeps_the_extremes_of_a_fast_oscillation():
    values = np.zeros(10_000)
    values[4321], values[8765] = 1.0, -1.0
    (line,) = parsed(draw_small_curve(values, 0.0)).iter("polyline")
    points = np.array([pair.split(",") for pair in line.get("points").split()], dtype=float)
    assert (points[:, 1].min(), points[:, 1].max()) == (2.0, CURVE_HEIGHT - 2.0)
    assert (points[:, 0].min(), points[:, 0].max()) == (2.0, CURVE_WIDTH - 2.0)
    assert draw_small_curve(np.full(5, np.inf), 0.0) == ""


def test_a_film_shows_itself_and_stands_for_its_path(tmp_path):
    run = saved_run("slide_valve_30")
    film = run.film(tmp_path / "valve.gif", size=320, frames_per_second=5, stop=0.4)
    content = re.search('base64,([^"]*)', film._repr_html_())[1]
    with open(film, "rb") as stream:
        assert base64.b64decode(content) == stream.read()
    film.path.unlink()
    assert "no longer there" in film._repr_html_()


def test_a_figure_of_chosen_readings_shows_itself(tmp_path):
    run = saved_run("porter_dry_friction")
    figure = run.plot("arm_angle", "rate of arm_angle")
    assert [axes.texts[0].get_text() for axes in figure.axes] == ["arm angle, deg", "rate of arm angle, deg/s"]
    for axes, values in zip(figure.axes, (run.readings["arm_angle"], run.rates["arm_angle"]), strict=True):
        np.testing.assert_allclose(axes.lines[0].get_ydata(), np.degrees(values), rtol=1e-15)
    assert figure.save_png(tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(MechanismError, match="Did you mean 'arm_angle'"):
        run.plot("arm_angel")


def test_a_study_shows_its_text():
    report = gm.crosscheck("slider_crank")
    page = parsed(report._repr_html_())
    assert "".join(page.itertext()) == str(report)

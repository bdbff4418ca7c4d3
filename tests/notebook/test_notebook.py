"""What a notebook shows of runs, scenes, curves, studies and films."""

import base64
import html
import inspect
import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest
import rich.console

import governor_mechanism as gm
from governor_mechanism.notebook.result_table import CURVE_HEIGHT, CURVE_WIDTH, draw_small_curve
from governor_mechanism.units.text_table import format_table
from refusing import refuses
from saved_runs import saved_run


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


def test_a_scene_of_ones_own_shows_its_bodies_and_joints():
    scene = gm.load("quick_return")
    text = " ".join(parsed(scene._repr_html_()).itertext())
    assert all(one.name in text for one in (*scene.mechanism.bodies, *scene.mechanism.joints))


def test_tables_are_text_in_a_notebook_too(monkeypatch):
    """There rich would show a table at once, and the text of a result would lack it."""
    outside = format_table(["a", "b"], [["1", "2"]])
    monkeypatch.setattr(rich.console, "_is_jupyter", lambda: True)
    assert format_table(["a", "b"], [["1", "2"]]) == outside
    assert outside.split() == ["a", "b", "1", "2"]


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
    assert [axes.texts[0].get_text() for axes in figure.axes] == ["Arm angle [deg]", "Rate of arm angle [deg/s]"]
    for axes, values in zip(figure.axes, (run.readings["arm_angle"], run.rates["arm_angle"]), strict=True):
        np.testing.assert_allclose(axes.lines[0].get_ydata(), np.degrees(values), rtol=1e-15)
    assert figure.save(tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert figure._repr_png_().startswith(b"\x89PNG")
    refuses("Did you mean 'arm_angle'", run.plot, "arm_angel")


def test_a_study_shows_its_text():
    report = gm.crosscheck("slider_crank")
    assert "".join(parsed(report._repr_html_()).itertext()) == str(report)


def quantities_of(html):
    """The cells of each row of a page, by the text of the first one."""
    rows = ([("".join(cell.itertext()), cell) for cell in row] for row in parsed(html).iter("tr"))
    return {row[0][0]: row for row in rows}


def test_every_public_result_has_a_page():
    """Exceptions, engines, clients of a cluster, builders, options and words have none."""
    pages = ("_repr_html_", "_repr_png_", "_repr_mimebundle_")
    without = {
        name for name in gm.__all__ if inspect.isclass(owner := getattr(gm, name)) and not any(hasattr(owner, page) for page in pages)
    }
    exceptions = {name for name in without if issubclass(getattr(gm, name), Exception)}
    descriptions = {"ClusterClient", "Engine", "FilmOptions", "FourBarLinkage", "MechanismBuilder", "MotionState", "Outcome"}
    assert without - exceptions <= descriptions | {"SynthesisedLinkage"}  # a row of a synthesis


def test_a_result_shows_its_quantities():
    equilibrium = gm.equilibria("porter")[0]
    rows = quantities_of(equilibrium._repr_html_())
    assert float(rows["readings: sleeve lift"][2][0]) == pytest.approx(equilibrium.readings["sleeve_lift"], rel=1e-5)  # six digits
    curve = gm.speed_curve("porter", points=20)
    row = quantities_of(curve._repr_html_())["equilibrium speed"]
    assert row[1][1].find(".//polyline") is not None
    speeds = curve.speed * 30 / math.pi
    ends = [float(text.removesuffix(" rpm")) for text in row[2][0].split(" to ")]
    assert ends == pytest.approx([speeds.min(), speeds.max()], rel=1e-5)
    motion = gm.kinematics("slider_crank", "crank_angle", np.linspace(0.0, 1.0, 11))
    assert html.escape(str(motion)) in motion._repr_html_()  # with mobility and dead centres, which have no row
    forces = quantities_of(gm.controlling_force("porter", points=20)._repr_html_())
    assert forces["effort: speed change"][2][0] == "0.01"
    assert quantities_of(gm.load("porter").mechanism._repr_html_())["bodies"][2][0] == "right ball, left ball, sleeve"


def test_results_that_print_show_their_text():
    for result in (gm.load("porter").describe(), gm.linearise("porter")):
        assert "".join(parsed(result._repr_html_()).itertext()) == str(result)

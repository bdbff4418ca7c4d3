"""Options of films on the command line."""

from __future__ import annotations

import re

import pytest
from typer.testing import CliRunner

import governor_mechanism as gm
from governor_mechanism.cli.film_options import gather_film_options
from governor_mechanism.cli.main import app
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film.options import FilmLayout, FilmView
from governor_mechanism.render.film.timing import select_time_span

DEFAULTS = dict(
    layout=FilmLayout.MACHINE_AND_PLOTS,
    readings=None,
    no_footer=False,
    labels=False,
    forces=False,
    traces=False,
    start=None,
    stop=None,
    slow_down=None,
    theme=Theme.LIGHT,
)


def gather(**changes):
    return gather_film_options(**{**DEFAULTS, **changes})


def test_nothing_is_passed_on_by_default():
    assert gather() == {}


def test_options_have_the_names_and_units_of_films():
    given = gather(readings="arm_angle, rate of arm_angle", no_footer=True, forces=True, start="500 ms", stop="2", layout=FilmLayout.WIDE)
    expected = {
        "readings": ["arm_angle", "rate of arm_angle"],
        "footer": False,
        "forces": True,
        "start": 0.5,
        "stop": 2.0,
        "layout": "wide",
    }
    assert given == expected


def test_one_theme_is_for_figures_and_films():
    assert gather(theme=Theme.DARK) == {"theme": "dark"}
    # A film has a ground in any case, and a page follows the reader's screen.
    assert gather(theme=Theme.TRANSPARENT) == {}
    assert gather(theme=Theme.DARK, is_page=True) == {}


def test_a_time_in_another_unit_is_refused():
    with pytest.raises(MechanismError, match="--start"):
        gather(start="2 mm")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--readings", "arm_angel"], "no reading 'arm_angel'.*Did you mean 'arm_angle'"),
        (["--film", "html", "--fps", "30"], "takes no frames per second"),
        (["--film", "html", "--labels"], "leave labels out"),
        (["--start", "20 s"], r"within the run, 0\.\.10 s"),
        (["--seconds", "2 s", "--stop", "3 s"], r"within the run, 0\.\.2 s"),
        (["--slow-down", "0"], "above 0"),
        (["--slow-down", "1000"], "at most 3600 s"),
        (["--part", "governer"], "Did you mean 'governor'"),
        (["--view", "both", "--film", "svg"], "turning plane only"),
        (["--exaggerate", "0"], "at least 1"),
        (["--set", "effects.clearance=1 mm", "--exaggerate", "3"], "have a clearance"),
    ],
)
def test_what_a_film_does_not_take_is_refused_before_the_simulation(options, message, monkeypatch, tmp_path):
    monkeypatch.setattr(gm, "run", lambda *arguments, **named: pytest.fail("simulated"))
    result = CliRunner().invoke(app, ["run", "porter", "--out", str(tmp_path), *options])
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.output.split()))


@pytest.mark.parametrize(
    ("scene", "options", "message"),
    [
        ("slider_crank", ["--view", "both"], r"nothing shown does \(slider_crank\); leave view out"),
        ("slider_crank", ["--exaggerate", "3"], "drivers prescribe"),
        ("governed_engine", ["--view", "both"], "does not take view"),
        ("governed_engine", ["--part", "governor", "--exaggerate", "3"], "one part"),
    ],
)
def test_what_a_scene_does_not_show_is_refused_before_the_simulation(scene, options, message, monkeypatch, tmp_path):
    monkeypatch.setattr(gm, "run", lambda *arguments, **named: pytest.fail("simulated"))
    result = CliRunner().invoke(app, ["run", scene, "--out", str(tmp_path), *options])
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.output.split()))


@pytest.mark.parametrize(("options", "message"), [(["--readings", "arm_angel"], "'arm_angle'"), (["--start", "20 s"], "within the run")])
def test_a_comparison_refuses_what_its_film_does_not_take_before_the_simulation(options, message, monkeypatch, tmp_path):
    monkeypatch.setattr(gm, "compare", lambda *arguments, **named: pytest.fail("simulated"))
    result = CliRunner().invoke(app, ["compare", "porter", "watt", "--out", str(tmp_path), *options])
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.output.split()))


def test_the_film_of_one_part_of_a_scene_is_chosen():
    assert gather(part="governor", view=FilmView.BOTH, exaggerate=2.0) == {"part": "governor", "view": "both", "exaggerate": 2.0}


def test_a_refused_film_leaves_no_folder(tmp_path):
    result = CliRunner().invoke(app, ["run", "slider_crank", "--view", "both", "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert not list(tmp_path.iterdir())


def test_a_film_of_one_instant_is_refused():
    with pytest.raises(MechanismError, match=r"start and stop are both 2 s; a film shows what happens between two times"):
        select_time_span((0.0, 4.0), 2.0, 2.0)

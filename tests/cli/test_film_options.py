"""Options of films on the command line."""

from __future__ import annotations

import inspect
import re

import pytest
from typer.testing import CliRunner

import governor_mechanism as gm
from governor_mechanism.cli.film_options import COMMAND_WORDS, gather_film_options, in_command_words
from governor_mechanism.cli.main import app
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film.options import FilmLayout, FilmView
from governor_mechanism.render.film.timing import select_time_span
from governor_mechanism.render.film_option_error import PYTHON_WORDS, FilmOptionError

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
    given = gather(
        readings="arm_angle, rate of arm_angle,arm_angle", no_footer=True, forces=True, start="500 ms", stop="2", layout=FilmLayout.WIDE
    )
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
        (["--readings", "arm_angel"], "--readings: .* no reading 'arm_angel'.*Did you mean 'arm_angle'"),
        (["--readings", " , "], "--readings needs names with commas between, as in arm_angle,sleeve_lift; found ' , '"),
        (["--readings", "a,b,c,d,e"], "at most 4 readings, and --readings names 5: a, b, c, d, e; leave some out"),
        (["--readings", "arm_angle", "--layout", "machine"], "the --layout 'machine' plots no readings; leave --readings out, or choose"),
        (["--layout", "square"], "'--layout': .*'square' is not one of 'machine', 'machine.plots', 'wide'"),
        (["--theme", "blue"], "'--theme': .*'blue' is not one of 'light', 'dark'"),
        (["--film", "avi"], "'--film': .*'avi' is not one of 'gif', 'mp4'"),
        (["--size", "100"], "--size must lie between 320 and 4320 pixels; found 100"),
        (["--fps", "0.5"], "--fps must be 1 to 50; got 0.5"),
        (["--film", "html", "--fps", "30"], "takes no --fps; leave it out"),
        (["--film", "html", "--labels", "--no-footer"], "leave --no-footer and --labels out, or choose --film gif"),
        (["--start", "20 s"], r"--start and --stop must lie within the run, 0\.\.10 s, in this order; got 20 and 10 s"),
        (["--start", "2 s", "--stop", "2 s"], r"--start and --stop are both 2 s; .* 0\.\.10 s"),
        (["--stop", "soon"], '--stop is a time; "soon" has no number'),
        (["--seconds", "2 s", "--stop", "3 s"], r"within the run, 0\.\.2 s"),
        (["--slow-down", "0"], "--slow-down must be a number above 0, .*; got 0"),
        (["--slow-down", "1000"], "--slow-down 1000 makes a film of 10000 s; at most 3600 s: show less by --start and --stop"),
        (["--part", "governer"], "--part: .*Did you mean 'governor'"),
        (["--view", "above"], "'--view': .*'above' is not one of 'plane', 'outside', 'both'"),
        (["--view", "both", "--film", "svg"], "turning plane only; leave --view out, or choose --film gif"),
        (["--view", "outside", "--labels", "--traces"], "--labels and --traces are drawn on .* choose the --view 'both'"),
        (["--exaggerate", "0"], "--exaggerate must be a number of at least 1, .*; got 0"),
        (["--exaggerate", "2", "--forces"], "--forces are .* which --exaggerate does not show; leave one of the two out"),
        (["--set", "effects.clearance=1 mm", "--exaggerate", "3"], "--exaggerate needs .* have a clearance; leave --exaggerate out"),
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
        ("slider_crank", ["--view", "both"], r"the --view 'both' shows .* nothing shown does \(slider_crank\); leave --view out"),
        ("slider_crank", ["--exaggerate", "3"], "drivers prescribe"),
        ("governed_engine", ["--view", "both"], "does not take --view; .* by --part"),
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


def test_every_word_of_a_message_stands_for_an_option_of_the_command():
    """A name that the command line does not know would be one that its user cannot type."""
    words = {PYTHON_WORDS[name]: word for name, word in COMMAND_WORDS.items() if name in inspect.signature(gm.film).parameters}
    assert set(words) == set(PYTHON_WORDS) - {"use_gif"}
    options = {name for command in app.registered_commands if command.callback.__name__ == "run" for name in find_option_names(command)}
    assert set(words.values()) <= options


def find_option_names(command):
    help_text = CliRunner().invoke(app, [command.name or command.callback.__name__, "--help"], terminal_width=300).output
    return set(re.findall(r"--[a-z][a-z-]*", help_text))


def test_an_error_while_the_film_is_drawn_names_the_option_too():
    with pytest.raises(MechanismError, match=r"^--size of a film must be 320 to 4320 pixels; got 7$"), in_command_words():
        raise FilmOptionError("{size} of a film must be {least} to {most} pixels; got {found}", least=320, most=4320, found=7)


def test_the_film_of_one_part_of_a_scene_is_chosen():
    assert gather(part="governor", view=FilmView.BOTH, exaggerate=2.0) == {"part": "governor", "view": "both", "exaggerate": 2.0}


def test_a_refused_film_leaves_no_folder(tmp_path):
    result = CliRunner().invoke(app, ["run", "slider_crank", "--view", "both", "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert not list(tmp_path.iterdir())


def test_a_film_of_one_instant_is_refused():
    with pytest.raises(MechanismError, match=r"start and stop are both 2 s; a film shows what happens between two times"):
        select_time_span((0.0, 4.0), 2.0, 2.0)

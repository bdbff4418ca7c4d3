"""Options of films on the command line."""

import re

import pytest

import governor_mechanism as gm
from command_line import invoke
from governor_mechanism.cli.options import COMMAND_WORDS, FILM_PARAMETERS, gather_film_options, in_command_words
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import PYTHON_WORDS, FilmLayout, FilmOptionError, FilmOptions, FilmView, Theme
from governor_mechanism.render.film.timing import select_time_span

DEFAULTS = {one.name: one.default for one in FILM_PARAMETERS}
OTHERS = dict(film="gif", no_film=False, theme=Theme.LIGHT)


def gather(**changes):
    return gather_film_options({**DEFAULTS, **OTHERS, **changes})


def test_without_options_a_command_makes_the_film_of_the_function():
    assert gather() == FilmOptions()


def test_options_have_the_names_and_units_of_films():
    given = gather(
        readings="arm_angle, rate of arm_angle,arm_angle", footer=True, forces=True, start="500 ms", stop="2", layout=FilmLayout.WIDE
    )
    readings = ("arm_angle", "rate of arm_angle")
    assert given == FilmOptions(readings=readings, footer=False, forces=True, start=0.5, stop=2.0, layout="wide")


def test_one_theme_is_for_figures_and_films():
    assert gather(theme=Theme.DARK) == FilmOptions(theme="dark")
    # A film has a ground in any case, and a page follows the reader's screen.
    assert gather(theme=Theme.TRANSPARENT) == FilmOptions()
    assert gather(theme=Theme.DARK, film="html") == FilmOptions()


def test_a_time_in_another_unit_is_refused(tmp_path):
    result = invoke("run", "porter", "--out", str(tmp_path), "--start", "2 mm")
    assert result.exit_code == 2
    assert '--start is a time; "2 mm" is a length' in " ".join(result.output.split())


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
        (["--size", "100"], "--size must be 320 to 4320 pixels; got 100"),
        (["--size", "99999x99999"], "--size must be 320 to 4320 pixels; got 99999"),
        (["--size", "1000x720"], "--size '1000x720' has a width of its own: a film is square, or 16:9 as 1280x720"),
        (["--size", "1280x720", "--layout", "machine"], "--size '1280x720' is 16:9, and --layout machine is not; leave one of them out"),
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
        (["--layers", "velocity,pols"], "--layers of a film are velocity, acceleration, poles; got 'pols'. Did you mean 'poles'"),
        (["--layers", "poles", "--view", "outside"], "--layers are drawn on the turning plane"),
        (["--layers", "poles", "--exaggerate", "2"], "--layers are those of the true motion, which --exaggerate does not show"),
        (["--exaggerate", "2", "--forces"], "--forces are .* which --exaggerate does not show; leave one of the two out"),
        (["--set", "effects.clearance=1 mm", "--exaggerate", "3"], "--exaggerate needs .* have a clearance; leave --exaggerate out"),
    ],
)
def test_what_a_film_does_not_take_is_refused_before_the_simulation(options, message, monkeypatch, tmp_path):
    monkeypatch.setattr(gm, "run", lambda *arguments, **named: pytest.fail("simulated"))
    result = invoke("run", "porter", "--out", str(tmp_path), *options)
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
    result = invoke("run", scene, "--out", str(tmp_path), *options)
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.output.split()))


@pytest.mark.parametrize(("options", "message"), [(["--readings", "arm_angel"], "'arm_angle'"), (["--start", "20 s"], "within the run")])
def test_a_comparison_refuses_what_its_film_does_not_take_before_the_simulation(options, message, monkeypatch, tmp_path):
    monkeypatch.setattr(gm, "compare", lambda *arguments, **named: pytest.fail("simulated"))
    result = invoke("compare", "porter", "watt", "--out", str(tmp_path), *options)
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.output.split()))


@pytest.mark.parametrize("command", ["run", "compare"])
def test_every_option_of_a_film_stands_for_one_of_the_command(command):
    """A name in a message that the command line does not know would be one that its user cannot type."""
    assert COMMAND_WORDS.keys() == PYTHON_WORDS.keys()
    words = {COMMAND_WORDS[name] for name in PYTHON_WORDS if name != "use_gif"}
    help_text = invoke(command, "--help", terminal_width=300).output
    assert words <= set(re.findall(r"--[a-z][a-z-]*", help_text))


def test_an_error_while_the_film_is_drawn_names_the_option_too():
    with pytest.raises(MechanismError, match=r"^--size must be 320 to 4320 pixels; got 7$"), in_command_words():
        raise FilmOptionError("{size} must be {least} to {most} pixels; got {found}", least=320, most=4320, found=7)


def test_the_film_of_one_part_of_a_scene_is_chosen():
    chosen = gather(part="governor", view=FilmView.BOTH, exaggerate=2.0)
    assert chosen == FilmOptions(part="governor", view="both", exaggerate=2.0)


def test_a_refused_film_leaves_no_folder(tmp_path):
    result = invoke("run", "slider_crank", "--view", "both", "--out", str(tmp_path / "out"))
    assert result.exit_code == 2
    assert not list(tmp_path.iterdir())


def test_a_film_of_one_instant_is_refused():
    with pytest.raises(MechanismError, match=r"start and stop are both 2 s; a film shows what happens between two times"):
        select_time_span((0.0, 4.0), 2.0, 2.0)


@pytest.mark.parametrize(
    ("words", "size", "layout"),
    [("720", 720, "machine+plots"), ("720x720", 720, "machine+plots"), ("1280x720", 720, "wide"), ("854 x 480", 480, "wide")],
)
def test_a_size_is_written_as_width_and_height(words, size, layout):
    for options in (gather(size=words), FilmOptions(size=words)):
        assert (options.size, options.layout) == (size, layout)


@pytest.mark.parametrize("text", ["big", "", "320x", "640x480", "-320", "9" * 5000])
def test_a_size_that_no_film_has_is_refused(text):
    with pytest.raises(MechanismError, match="--size"):
        gather(size=text)
    with pytest.raises(MechanismError, match=r"^size"):
        FilmOptions(size=text)

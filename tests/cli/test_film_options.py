"""Options of films on the command line."""

import re

import pytest

from command_line import invoke
from governor_mechanism.cli.options import COMMAND_WORDS, FILM_PARAMETERS, gather_film_options, in_command_words
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import PYTHON_WORDS, FilmLayout, FilmOptionError, FilmOptions, FilmView, Theme
from governor_mechanism.render.film.timing import select_time_span
from refusing import refuses

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
    refuses("--size", gather, size=text)
    refuses(r"^size", FilmOptions, size=text)

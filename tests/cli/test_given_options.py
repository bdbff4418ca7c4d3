"""What the user gives on the command line counts or is refused: twice, empty, without effect; messages name options as typed."""

import io
import sys
from collections.abc import Iterator
from typing import Any

import pytest
import typer.main

import governor_mechanism as gm
from command_line import invoke
from governor_mechanism.cli.compare import split_changes
from governor_mechanism.cli.main import app, main
from refusing import refuses


@pytest.fixture(autouse=True)
def no_simulation(monkeypatch):
    """Refusals come before any run."""
    monkeypatch.setattr(gm, "run", lambda *arguments, **named: pytest.fail("simulated"))


def list_commands(command: Any = None, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield each command with the words that call it."""
    command = command or typer.main.get_command(app)
    inner = getattr(command, "commands", None)
    if inner is None:
        yield words, command
        return
    for name, one in inner.items():
        yield from list_commands(one, (*words, name))


COMMANDS = [pytest.param(words, command, id=" ".join(words)) for words, command in list_commands()]


@pytest.mark.parametrize(("words", "command"), COMMANDS)
def test_an_option_with_one_value_is_given_once(words, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = [one for one in command.params if one.param_type_name == "option" and not one.multiple and not one.is_eager]
    single = {one.is_flag: one for one in options}.values()  # one look at the words finds all: a flag and a value
    assert single
    for option in single:
        result = invoke(*words, *2 * [option.opts[0], *([] if option.is_flag else ["1"])])
        assert result.exit_code == 2, result.output
        assert f"{option.opts[0]} is given twice, and counts once; give it once" in result.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("words", "command"), COMMANDS)
def test_an_empty_value_is_refused(words, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with_value = [one for one in command.params if one.param_type_name == "option" and not one.is_flag]
    for option in {one.multiple: one for one in with_value}.values():
        result = invoke(*words, option.opts[0], " ")
        assert result.exit_code == 2
        assert f"{option.opts[0]} is empty" in result.stderr
    assert not list(tmp_path.iterdir())


def test_a_refused_command_line_is_one_object_of_json():
    assert '"--engine is given twice' in invoke("run", "porter", "--engine", "a", "--engine", "b", "--json").stdout
    assert "SCENE is empty" in invoke("describe", "").stderr


def test_a_change_may_be_for_one_of_the_compared_scenes():
    assert split_changes(["a=1", "2:b.c=2:3", " 1:d=x"], 2) == [["a=1", "d=x"], ["a=1", "b.c=2:3"]]
    for number in ("0", "3"):
        refuses("numbered from 1 to 2", split_changes, [f"{number}:a=1"], 2)


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["describe", "porter", "--set", "title=Müllers Regler"], "M?llers Regler"),
        (["describe", "porter", "--set", "title=Müllers Regler", "--json"], "M\\u00fcllers Regler"),
        (["describe", "müller"], "m?ller"),
        (["describe", "m\udcff"], "m?"),
        (["design", "hartung", "--wire", "1 Fuß"], "1 Fu?"),
        (["errata", "--help"], "Usage"),
    ],
)
def test_a_character_that_the_output_lacks_is_a_question_mark(words, found, monkeypatch):
    """As with PYTHONIOENCODING=ascii, on both streams, and for the name of a file that is no UTF-8."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="strict") for _ in range(2)]
    monkeypatch.setattr(sys, "stdout", streams[0])
    monkeypatch.setattr(sys, "stderr", streams[1])
    monkeypatch.setattr(sys, "argv", ["governor-mechanism", *words])
    with pytest.raises(SystemExit):
        main()
    written = b"".join(stream.buffer.getvalue() for stream in streams if stream.flush() is None).decode("ascii")
    assert found in written

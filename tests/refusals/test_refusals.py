"""What is refused, in a sentence: wrong arguments of functions and wrong command lines, from the tables beside this file."""

import math
import re
import shlex
import tomllib
from pathlib import Path
from pydoc import locate
from typing import Any

import pytest

import governor_mechanism as gm
from command_line import invoke
from contact_scenes import ball_document, outlines_document
from governor_mechanism.studies.design.hartung import HartungInputs, design_hartung
from governor_mechanism.units.expressions import ARITHMETIC, Expression, Measured, unit_of_kind

TABLES = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(Path(__file__).parent.glob("*.toml"))}
COMMANDS = TABLES.pop("command_line")
LINES = {words: sentences for table in COMMANDS.values() for words, sentences in table.items()}


def says(text: str, sentence: str) -> bool:
    """Return whether a text holds a sentence, in which "…" stands for any words, and "^" before it for the beginning of the text."""
    parts = (re.escape(part.strip()) for part in sentence.removeprefix("^").split("…"))
    return bool(re.search("^" * sentence.startswith("^") + ".*".join(parts), text, re.DOTALL))


def decode(value: Any) -> Any:
    """Return a value of a table with None for the word "None"."""
    if isinstance(value, dict):
        return {key: decode(one) for key, one in value.items()}
    return [decode(one) for one in value] if isinstance(value, list) else None if value == "None" else value


NAMES = {"crank": Measured(0.5, unit_of_kind("length")), "mass": Measured(2.0, unit_of_kind("mass"))}
CALLS = {
    "replace": lambda scene, values: gm.load(scene).replace(values),
    "explore": lambda scene, keys: gm.explore(scene, *keys),
    "ball": lambda **given: gm.Scene.from_dict(ball_document(place=(0.0, 0.05), **given)),
    "two outlines": lambda **given: gm.Scene.from_dict(outlines_document(**given)),
    "crosscheck": lambda **given: gm.crosscheck("porter", lambda arm_angle: arm_angle, **given),
    "design_hartung": lambda **inputs: design_hartung(HartungInputs(**inputs)),
    "evaluate": lambda text: Expression(text).evaluate(NAMES.__getitem__, ARITHMETIC),
}
"""What is called in another way than by the names of its arguments."""

ROWS = [
    pytest.param(table, call, *row, id=f"{name} {number}")
    for tables in TABLES.values()
    for name, table in tables.items()
    for call in table.get("calls", [table.get("call")])
    for number, row in enumerate(table["refused"], 1)
]


@pytest.mark.parametrize(("table", "call", "values", "sentence"), ROWS)
def test_wrong_arguments_are_refused(table, call, values, sentence):
    """The values of a row are added to those given for the whole table, or they are one argument; a row may name its function.

    Of a module, its functions are called with the record that a table describes.
    """
    own = {table["argument"]: values} if "argument" in table else dict(values)
    call = own.pop("call", call)
    module = locate(table["module"]) if "module" in table else gm
    function = CALLS.get(call) or getattr(module, call, None) or locate(call)
    records = [getattr(module, name)(**dimensions) for name, dimensions in table.get("of", {}).items()]
    with pytest.raises(gm.MechanismError) as caught:
        function(*records, **decode(table.get("given", {}) | own))
    told = str(caught.value)
    assert says(told, sentence), told
    assert table.get("never said", "\n" * 100) not in told
    assert len(caught.value.problems) <= table.get("at most", math.inf)


@pytest.mark.parametrize("words", LINES)
def test_a_wrong_command_line_is_told_before_anything_is_simulated_or_written(words, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in () if words in COMMANDS["by the run itself"] else ("run", "compare"):
        monkeypatch.setattr(gm, name, lambda *arguments, **named: pytest.fail("simulated"))
    result = invoke(*shlex.split(words))
    told = " ".join(result.output.split())
    sentences = LINES[words]
    assert all(says(told, sentence) for sentence in ([sentences] if isinstance(sentences, str) else sentences)), told
    assert (result.exit_code, "Traceback" in told, list(tmp_path.iterdir())) == (2, False, [])
    assert result.stdout == "" or "--json" in words

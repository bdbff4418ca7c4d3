"""Wrong scene files, each with the code and the key of every mistake, and messages: tables in text files.

A case begins with "=== base: name". Then come the tables of the base that the case changes: "+ [table]" before lines that are added to it,
"= [table]" before all its lines, "- [table]" if it is left out; "top" stands for the lines above all tables. With the base "whole" the
lines are the file. Lines "! code: key" are its mistakes in their order; lines "> message" are among what it is answered.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

SCENE_HEADER = 'title = "A Porter governor"\nmachine = "pendulum_governor"\n'
DIMENSIONS = {"arm": '"300 mm"', "offset": '"40 mm"', "ball_mass": '"5 kg"', "sleeve_mass": '"20 kg"'}
DEFAULT_TABLES = {
    "effects": "gravity = true\ncentrifugal = true",
    "spindle": 'speed = "120 rpm"',
    "start": 'arm_angle = "40 deg"',
    "run": 'duration = "10 s"\noutput_interval = "10 ms"\naccuracy = 1e-6\nengine = "auto"',
}
TOP = 'title = "A crank"\nmachine = "custom"\n'
GROUND = "[ground]\nO = [0, 0]\n"
BODY = '[[body]]\nname = "crank"\nmass = "2 kg"\nrod = { length = "100 mm" }\n'
JOINT = '[[joint]]\ntype = "pin"\nname = "A"\nfirst = "ground.O"\nsecond = "crank.start"\n'
SPINDLE = '[spindle]\nspeed = "120 rpm"\n'
PARABOLIC_DIMENSIONS = 'double_parameter = 0.6\ninner_radius = 0.05\nouter_radius = 0.25\nball_mass = "1 kg"\nsleeve_mass = "4 kg"'


def scene_text(top: str = SCENE_HEADER, dimensions: str | None = None, /, **tables: str | None) -> str:
    """The Porter scene, with some tables written otherwise; None leaves a table out."""
    contents = {"dimensions": format_dimensions() if dimensions is None else dimensions, **DEFAULT_TABLES, **tables}
    return top + "".join(f"\n[{name}]\n{text}\n" for name, text in contents.items() if text is not None)


def format_dimensions(**changed: str | None) -> str:
    """The Porter's dimensions, with some written otherwise; None leaves one out."""
    return "\n".join(f"{key} = {value}" for key, value in {**DIMENSIONS, **changed}.items() if value is not None)


def with_effects(*lines: str, start: str | None = DEFAULT_TABLES["start"], spindle: str = DEFAULT_TABLES["spindle"]) -> str:
    """The Porter scene with more effects."""
    return scene_text(effects="\n".join([DEFAULT_TABLES["effects"], *lines]), start=start, spindle=spindle)


def custom_scene(*more: str, top: str = TOP, ground: str = GROUND, body: str = BODY, joint: str = JOINT) -> str:
    """A rod pinned at one end, with some tables written otherwise, and more of them."""
    return "\n".join([top, ground, body, joint, *more])


def body_with(*lines: str, name: str = "crank", mass: str | None = '"2 kg"') -> str:
    """A body of that mass, with these lines."""
    told = [] if mass is None else [f"mass = {mass}"]
    return "\n".join(["[[body]]", f'name = "{name}"', *told, *lines, ""])


def joint_table(kind: str, *lines: str, name: str = "A", ends: tuple[str, str] = ("ground.O", "crank.start")) -> str:
    """A joint between two points."""
    first, second = ends
    return "\n".join(["[[joint]]", f'type = "{kind}"', f'name = "{name}"', f'first = "{first}"', f'second = "{second}"', *lines, ""])


def force_table(kind: str, *lines: str) -> str:
    """A force."""
    return "\n".join(["[[force]]", f'type = "{kind}"', 'name = "load"', *lines, ""])


BASES = {
    "porter": scene_text(),
    "watt": scene_text(SCENE_HEADER, format_dimensions(sleeve_mass=None)),
    "parabolic": scene_text('machine = "parabolic_governor"\n', PARABOLIC_DIMENSIONS, start=None),
    "crank": custom_scene(),
}


@dataclass(frozen=True)
class Case:
    """The text of a file, the code and the key of every mistake, and some messages."""

    text: str
    mistakes: list[tuple[str, str]]
    messages: list[str]


def read_cases(name: str) -> dict[str, Case]:
    """Return the cases of a text file of this folder, by name."""
    blocks = re.split(r"^=== ", Path(__file__).with_name(f"{name}.txt").read_text(encoding="utf-8"), flags=re.MULTILINE)
    found: dict[str, Case] = {}
    for block in blocks[1:]:
        title, *lines = block.rstrip("\n").split("\n")
        base, _, case = title.partition(": ")
        mistakes = [line[2:] for line in lines if line.startswith("! ")]
        changes = [line for line in lines if not line.startswith(("! ", "> "))]
        text = "\n".join(changes) if base == "whole" else _change(BASES[base], changes)
        pairs = [(code, key) for code, _, key in (mistake.partition(": ") for mistake in mistakes)]
        found[case] = Case(text + "\n", pairs, [line[2:] for line in lines if line.startswith("> ")])
    return found


def each_case(name: str) -> pytest.MarkDecorator:
    """Return the decorator of a test of every case of a text file."""
    cases = read_cases(name)
    return pytest.mark.parametrize("case", cases.values(), ids=cases)


def _change(base: str, lines: list[str]) -> str:
    """Return the text of a scene with other tables."""
    tables: dict[str, list[str]] = {}
    name = "top"
    for line in filter(None, base.split("\n")):
        name = line if line.startswith("[") else name
        tables.setdefault(name, []).append(line)
    for line in lines:
        if change := re.fullmatch(r"([-+=]) (top|\[\[?\S+\]\]?)", line):
            name = change[2]
            if change[1] == "-":
                del tables[name]
            elif change[1] == "=":
                tables[name] = [] if name == "top" or name.startswith("[[") else [name]
        else:
            tables[name].append(line)
    return "\n".join("\n".join(table) for table in tables.values())

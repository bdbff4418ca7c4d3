"""Every machine has a page that names all its dimensions, readings, effects and shipped scenes, and the source of its formulas."""

import dataclasses
import re
from functools import cache

import pytest

from documentation_pages import ROOT, load_script
from generators.readings import SPINDLE_READINGS, find_reading_units
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.scenes.library import catalogue_scenes, shipped_scenes
from governor_mechanism.units.fields import fields_of

FOLDER = ROOT / "docs" / "machines"
CUSTOM = "custom"
ROW = re.compile(r"^\|(.*)\|$", flags=re.MULTILINE)


@cache
def page(machine: str) -> str:
    return (FOLDER / f"{machine}.md").read_text(encoding="utf-8")


def section(text: str, title: str) -> str:
    found = re.search(rf"^## {title}$(.*?)(?=^## |\Z)", text, flags=re.DOTALL | re.MULTILINE)
    assert found, f"there is no section {title!r}"
    return found[1]


def units(text: str, heading: str) -> dict[str, str]:
    """Return the units of the words in code of the column with this heading."""
    rows = [[cell.strip() for cell in row.split("|")] for row in ROW.findall(text)]
    first = next(k for k, row in enumerate(rows) if heading in row)
    index, unit_index = rows[first].index(heading), rows[first].index("unit")
    return {row[index].strip("`"): row[unit_index] for row in rows[first + 1 :] if re.fullmatch(r"`[a-z_]+`", row[index])}


def plain_unit(unit: str) -> str:
    return "" if unit in ("1", "-") else unit.replace("^2", "²")


@cache
def machines_of_scenes() -> dict[str, set[str]]:
    """Return the machines of each shipped scene."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in shipped_scenes().items()}
    return {name: set(re.findall(r'^machine = "(\w+)"', text, flags=re.MULTILINE)) for name, text in texts.items()}


@cache
def readings_of_machines() -> dict[str, dict[str, str]]:
    """Return the unit of each reading of each machine."""
    return {machine: {name: plain_unit(unit) for name, unit in units.items()} for machine, units in find_reading_units().items()}


@pytest.mark.parametrize("machine", MACHINES)
def test_the_table_of_dimensions_has_every_key_with_its_unit_and_no_other(machine):
    expected = {name: plain_unit(declared.unit) for name, declared in fields_of(MACHINES[machine]).items()}
    assert units(section(page(machine), "Dimensions"), "key") == expected


@pytest.mark.parametrize("machine", MACHINES)
def test_the_table_of_readings_has_every_reading_with_its_unit_and_no_other(machine):
    spindle = {name: unit for name, (unit, _) in SPINDLE_READINGS.items()} if MACHINES[machine].plane == TURNING_PLANE else {}
    assert units(section(page(machine), "Readings"), "reading") == readings_of_machines()[machine] | spindle


@pytest.mark.parametrize("machine", MACHINES)
def test_effects_that_change_its_bodies_are_named_with_their_keys(machine):
    text = section(page(machine), "Effects")
    for effect in MACHINES[machine].supported_effects:
        assert f"`{effect.key}`" in text
        assert all(f"`{field.name}`" in text for field in dataclasses.fields(effect))


@pytest.mark.parametrize("machine", [*MACHINES, CUSTOM])
def test_every_shipped_scene_is_named(machine):
    scenes = {name for name, machines in machines_of_scenes().items() if machine in machines}
    assert scenes <= set(re.findall(r"[a-z]\w+", section(page(machine), "Shipped scenes")))


def test_every_shipped_scene_is_run_on_a_page_by_a_command_and_no_other():
    text = "".join(path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md"))
    run = set(re.findall(r"^(?:governor-mechanism |\| `)run (\w+)", text, flags=re.MULTILINE))
    assert run - set(catalogue_scenes()) == set(shipped_scenes())


def test_the_index_links_to_every_page():
    links = set(re.findall(r"\]\((\w+)\.md\)", page("index")))
    assert links == {path.stem for path in FOLDER.glob("*.md")} - {"index"}
    assert {*MACHINES, CUSTOM} <= links


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.md")), ids=lambda path: path.stem)
def test_formulas_have_a_source_with_its_year_or_chapter(path):
    text = path.read_text(encoding="utf-8")
    if "$$" in text:
        source = re.search(r"^Source: .*?(?=\n\n)", section(text, "Equations"), flags=re.DOTALL | re.MULTILINE)
        assert source
        assert re.search(r"\((?:Mannheim )?1[89]\d\d\)|chapter \d+", source[0])


def test_the_sketches_are_those_of_their_script(tmp_path, monkeypatch):
    script = load_script(FOLDER / "sketches.py")
    monkeypatch.setattr(script, "FOLDER", tmp_path)
    script.draw_all()
    folders = tmp_path, FOLDER / "sketches"
    drawn, tracked = ({path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.svg")} for folder in folders)
    assert drawn == tracked
    shown = {name for path in FOLDER.glob("*.md") for name in re.findall(r"\(sketches/(\w+\.svg)\)", path.read_text(encoding="utf-8"))}
    assert shown == set(tracked)

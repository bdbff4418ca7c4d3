"""The generated reference names everything that the code has, and every link of the documentation leads somewhere."""

import dataclasses
import html
import re
from functools import cache
from pathlib import Path

import pytest

import governor_mechanism as gm
import made_from
from documentation_pages import PAGES, ROOT
from generators import gallery
from generators.api import api_files, api_page
from generators.catalogue import catalogue_page
from generators.commands import commands_index, commands_pages, commands_text, list_commands
from generators.effects_and_engines import effects_and_engines_page
from generators.gallery import gallery_page, scenes_without_description
from generators.markdown import anchor, escape, table
from generators.readings import SPINDLE_READINGS, find_reading_units, readings_page
from generators.scene_file import scene_file_index, scene_file_pages, scene_file_text
from generators.splitting import index_of, split_sections, write_pages
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.engines.selection import ENGINES
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.scenes.json_schema import scene_schema
from governor_mechanism.scenes.library import list_catalogue_entries, load_scene, shipped_scenes
from governor_mechanism.units.quantities import QUANTITY_KINDS
from navigation import link_made_examples, list_entries

INCLUDED = {
    "scene_file": scene_file_text, "effects_and_engines": effects_and_engines_page, "commands": commands_text,
    "readings": readings_page, "api": api_page, "gallery": gallery_page, "catalogue": catalogue_page,
}  # fmt: skip
"""Text that a page includes, by the name of the page."""


@cache
def text_of(name):
    return INCLUDED[name]()


def section(text, heading):
    """Text under a heading, up to the next one of any level."""
    return re.split(r"^#+ ", text.partition(f"# {heading}\n")[2], maxsplit=1, flags=re.MULTILINE)[0]


def keys_of(schema):
    """All keys that a JSON schema names, except those that the user names."""
    if isinstance(schema, list):
        return {key for one in schema for key in keys_of(one)}
    if not isinstance(schema, dict):
        return set()
    own = set(schema["properties"]) if isinstance(schema.get("properties"), dict) else set()
    return own | {key for one in schema.values() for key in keys_of(one)}


def keys_by_heading():
    """Keys of the JSON schema of scenes by the heading of the section that documents them."""
    tables = scene_schema()["definitions"]
    coupled, body = tables["coupled_scene"]["properties"], tables["body"]["items"]["properties"]
    found = {f"`{name}`": set(tables[f"dimensions_{name}"]["properties"]) for name in MACHINES}
    found |= {f"`{name}`": keys_of(effect) for name, effect in tables["effects"]["properties"].items()}
    found |= {f"`[{name}]`": set(tables[name]["properties"]) for name in ("run", "spindle", "valve", "law")}
    found |= {"an equation of a law": keys_of(tables["law"]["properties"]["proves"])}
    found |= {f"`[[{name}]]`": set(tables[name]["items"]["properties"]) for name in ("body", "link", "contact")}
    found |= {f"`{name}` of a body": keys_of(body[name]) for name in ("rod", "disc", "plate", "moments")}
    found |= {"`[readings]`": keys_of(tables["readings"]), "`assembly` as a table": keys_of(tables["assembly"])}
    found |= {"`[events.NAME]`": keys_of(tables["events"]), "`[load]`": keys_of(coupled["load"]), "Several parts": set(coupled)}
    top = set(tables["scene_slide_valve"]["properties"])
    found |= {"Top level": top - {"dimensions"}, "A mechanism of one's own": set(tables["scene_custom"]["properties"]) - top}
    typed = {"joint": tables["joint"]["items"], "force": tables["force"]["items"], "coupling": coupled["coupling"]["additionalProperties"]}
    for kind, schema in typed.items():
        for case in schema["allOf"]:
            name, keys = case["if"]["properties"]["type"]["const"], set(case["then"]["properties"])
            found[f"{kind} `{name}`"] = keys - ({"type"} if kind == "coupling" else {"type", "name"})
    return found


def test_the_scene_file_text_has_every_key_of_the_schema_in_its_section():
    text, found = text_of("scene_file"), keys_by_heading()
    for heading, keys in found.items():
        part = section(text, heading)
        # A key is the first cell of a row; those of the readings are in the last cell of their kind.
        pattern = r"`([a-z_]+)`" if heading == "`[readings]`" else r"^\| `([a-z_]+)` \|"
        assert keys <= set(re.findall(pattern, part, flags=re.MULTILINE)), heading
    named_by_headings = {"dimensions", "type", *(effect.key for effect in EFFECTS)}
    assert keys_of(scene_schema()) - named_by_headings <= set().union(*found.values())
    assert all("`type`" in section(text, heading) for heading in ("`[[joint]]`", "`[[force]]`", "`[coupling.NAME]`"))
    assert all(kind.name.partition(" ")[2] in text for kind in QUANTITY_KINDS.values())


@pytest.mark.parametrize("name", MACHINES)
def test_every_dimension_has_unit_and_meaning(name):
    rows = [line.split(" | ") for line in section(text_of("scene_file"), f"`{name}`").splitlines() if line.startswith("| `")]
    assert len(rows) == len(dataclasses.fields(MACHINES[name]))
    for row in rows:
        key, values, _, meaning = row
        assert values, key
        assert len(meaning.rstrip(" |")) > 5, key


def test_every_key_has_a_meaning():
    bare = re.findall(r"^\| `(\w+)` \|.*\|  \|$", text_of("scene_file"), flags=re.MULTILINE)
    assert set(bare) <= {"machine"}, "what has no meaning needs a description in the code"


def test_effects_engines_and_machines():
    text = text_of("effects_and_engines")
    for effect in EFFECTS:
        (row,) = re.findall(rf"^\| \[`{effect.key}`\].*$", text, flags=re.MULTILINE)
        answers = [cell.strip() for cell in row.strip("|").split(" | ")][-len(ENGINES) :]
        assert answers == ["yes" if effect in engine.effects else "no" for engine in ENGINES.values()]
    assert all(f"`{name}`" in text for name in (*ENGINES, *MACHINES))


def test_every_command_and_option_is_listed():
    text = text_of("commands")
    for name, command in list_commands():
        part = section(text, name)
        options = {word for one in command.params for word in one.opts if word.startswith("--") and word != "--help"}
        assert options <= set(re.findall(r"--[a-z-]+", part)), name
        assert f"governor-mechanism {name}" in part


def test_every_reading_has_a_meaning():
    units = find_reading_units()
    for name, machine in MACHINES.items():
        assert set(units[name]) == set(machine.reading_meanings), name
        assert set(re.findall(r"^\| `(\w+)`", section(text_of("readings"), f"`{name}`"), flags=re.MULTILINE)) == set(units[name])
    assert set(SPINDLE_READINGS) <= set(re.findall(r"`(\w+)`", text_of("readings")))


def test_every_public_name_has_a_page_and_a_sentence():
    files = api_files()
    assert {Path(name).stem for name in files} == set(gm.__all__)
    assert len({name.lower() for name in files}) == len(files)  # on a disk that does not know capitals too
    for name in gm.__all__:
        (row,) = re.findall(rf"^\| \[`{name}`\].*$", text_of("api"), flags=re.MULTILINE)
        assert len(row.rpartition(") | ")[2].rstrip(" |")) > 10, name


def test_the_gallery_has_every_scene_with_its_page():
    text = text_of("gallery")
    pages = gallery.scene_pages()
    assert scenes_without_description() == []
    for name in shipped_scenes():
        assert f"<pre>governor-mechanism open {name}</pre>" in text
        assert f'"pages/{name}.html"' in text
        assert f'"_generated/scenes/{name}.html#scene-file"' in text
        assert f"models/{name}.toml\n:language: toml" in pages[f"scenes/{name}.md"]
    # Its film has no words; that its motion is magnified, the card says.
    magnified = re.findall(r'"pages/(\w+)\.webp" alt=""><span class="note">motion magnified 10 ×<', text)
    assert magnified == ["porter_cyclic", "porter_cyclic_damped"]


def test_the_gallery_offers_what_its_scenes_have():
    text = text_of("gallery")
    for name, values in {"machine": ["hartung", gallery.OWN_MECHANISM], "effect": ["dry friction", "free spindle", "contact"]}.items():
        choices = text.partition(f'data-filter="{name}"')[2].partition("</select>")[0]
        for value in values:
            assert f"<option>{html.escape(value)}</option>" in choices
            shown = re.findall(rf'<article class="scene" id="scene-(\w+)"[^>]*data-{name}="([^"]*)"', text)
            assert any(html.escape(value) in listed.split("|") for _, listed in shown)
    assert gallery.list_effects(load_scene("porter")) == []
    assert gallery.list_effects(load_scene("disc_cam")) == ["contact"]
    assert gallery.list_studies(load_scene("stephenson_reversing")) == [gallery.VALVE_EVENTS]


def test_a_page_shows_the_best_film_there_is(tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "DOCS", tmp_path / "docs")
    for path in ("renders/porter.gif", "renders/watt.gif", "renders/gallery/watt.gif"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    (tmp_path / "docs").mkdir()
    shown = {name: gallery.show_scene(name, "A & B") for name in ("porter", "watt", "proell")}
    assert "](../../../renders/porter.gif)" in shown["porter"]
    assert "](../../../renders/gallery/watt.gif)" in shown["watt"]
    assert shown["proell"] == '<img src="../../pages/proell.gif" alt="Film of the scene proell: A &amp; B">'
    assert gallery.show_scene("porter_cyclic", "A").endswith("\n\n*motion magnified 10 ×*")


def test_drawings_are_made_again_when_the_code_that_draws_changes(tmp_path, monkeypatch):
    """And not when anything else does, as when Python compiles that code."""
    code = tmp_path / "render"
    (code / "film").mkdir(parents=True)
    (code / "film" / "painters.py").write_text("size = 1", encoding="utf-8")
    monkeypatch.setattr(made_from, "DRAWING", (code,))
    monkeypatch.setattr(made_from, "MADE_FROM", tmp_path / "made_from")
    digest = made_from.digest_drawing.__wrapped__
    assert not made_from.is_made_from("porter", digest())
    made_from.keep_digest("porter", digest())
    (code / "painters.pyc").write_bytes(b"compiled")
    assert made_from.is_made_from("porter", digest())
    (code / "film" / "painters.py").write_text("size = 2", encoding="utf-8")
    assert not made_from.is_made_from("porter", digest())


INDEXES = {"scene_file": scene_file_index, "commands": commands_index}
"""What a page includes instead of a whole text, whose sections have pages of their own."""


@cache
def generated_pages():
    """Text of the generated pages by their path in docs/_generated."""
    return {**api_files(), **gallery.scene_pages(), **scene_file_pages(), **commands_pages()}


def whole_text(path):
    """Text of a page with what it includes."""
    text = path.read_text(encoding="utf-8")
    if "```{include}" not in text:
        return text
    return text + (INDEXES[path.stem]() if path.stem in INDEXES else text_of(path.stem))


def headings(text):
    """Anchors of a text."""
    plain = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    return {anchor(heading) for heading in re.findall(r"^#+ (.+)$", plain, flags=re.MULTILINE)}


def links(page, text):
    """Targets of the links and pictures of a text, without code."""
    text = re.sub(r"^```.*?^```|`[^`\n]*`", "", text, flags=re.DOTALL | re.MULTILINE)
    return [target for target in re.findall(r"\]\(([^)\s]+)\)", text) if not re.match(r"https?:|mailto:", target)]


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page):
    for target in links(page, whole_text(page)):
        name, _, part = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        made = name.partition("_generated/")[2]
        if made.startswith("examples"):  # sphinx-gallery makes a page of each script and of each folder
            script = ROOT / "docs" / made
            assert script.with_suffix(".py").is_file() or (script.name == "index.rst" and script.parent.is_dir()), target
            continue
        if made:
            assert made in generated_pages(), target
            assert not part or part in headings(generated_pages()[made]), target
            continue
        # a site has no page of a folder but that of the examples
        assert path.is_file() or (path.is_dir() and (page.parent == ROOT or path.name == "examples")), target
        assert path.is_relative_to(ROOT), target
        assert not part or part in headings(whole_text(path)), target


def test_links_of_generated_pages_lead_somewhere():
    texts = generated_pages()
    for place, text in texts.items():
        for target in links(place, text) if place.endswith(".md") else ():
            name, _, part = target.partition("#")
            goal = (ROOT / "docs" / "_generated" / place).parent / name if name else ROOT / "docs" / "_generated" / place
            goal = goal.resolve()
            made = goal.relative_to(ROOT / "docs" / "_generated").as_posix() if "_generated" in goal.parts else ""
            assert made in texts or (not made and goal.is_file()), f"{place}: {target}"
            assert not part or part in headings(texts[made] if made else whole_text(goal)), f"{place}: {target}"


def test_a_text_becomes_pages():
    text = (
        "## `[a]`\n\nFirst one. See [b](#deep) and [c](other.md).\n\n## B\n\n| x |\n\n### Deep\n\nWords, [a](#a).\n\n## C\n\n### D\n\nd\n"
    )
    sections = [*split_sections(text, deeper=("C",))]
    assert [(one.name, one.summary) for one in sections] == [("a", "First one."), ("b", ""), ("c", ""), ("d", "d")]
    pages = write_pages(sections, "parts", "reference/home.md")
    assert "See [b](b.md#deep) and [c](../../reference/other.md)." in pages["parts/a.md"]
    assert pages["parts/b.md"].startswith("# B\n")
    assert "\n## Deep\n\nWords, [a](a.md#a)." in pages["parts/b.md"]
    assert pages["parts/d.md"] == "# D\n\n\nd\n\n"
    assert "[`[a]`](../_generated/parts/a.md) | First one. |" in index_of(sections, "parts", "part")


def test_navigation_follows_the_links_of_an_index(tmp_path):
    for name in ("index.md", "b.md", "a.md", "c.md", "part/index.md", "notes/n.ipynb", "other/index.md", "other/x.md"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    listed = "[c](c.md) is a link of a sentence\n\n- [a](a.md)\n- [made](_generated/x/index.rst)\n\n"
    text = "[b](b.md), [here](index.md#x), [a notebook](notes/n.ipynb), [x](other/x.md), [part](part/index.md), [web](https://b.org/b.md)"
    entries = ["a", "_generated/x/index", "c", "b", "notes/n", "part/index", "other/index"]
    assert list_entries(tmp_path / "index.md", listed + text, tmp_path) == entries


def test_links_to_scripts_of_examples_lead_to_their_pages():
    text = "[all](examples/), [one](../examples/studies/gate.py), [file](examples/ruff.toml)"
    expected = "[all](_generated/examples/index.rst), [one](../_generated/examples/studies/gate.rst), [file](examples/ruff.toml)"
    assert link_made_examples(text) == expected


def test_tables_keep_their_cells():
    assert escape("a|b * <c>") == r"a\|b \* \<c>"
    assert table(("x", "y"), [["1", "2"]]) == "| x | y |\n| --- | --- |\n| 1 | 2 |\n"
    assert anchor("`[[body]]`") == "body"
    assert anchor("How machines are checked") == "how-machines-are-checked"


def test_the_catalogue_lists_every_classic_mechanism_with_its_law_and_source():
    for name, entry in list_catalogue_entries().items():
        row = next(line for line in text_of("catalogue").splitlines() if line.startswith(f"| `{name}` |"))
        assert escape(entry.source) in row
        assert escape(entry.law)[1:] in row
        assert all(f"`{one}`" in row for one in entry.dimensions)

"""Scenes written and changed in Python: the same documents, checks and messages as those of scene files; and their text in TOML."""

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from numbers import Integral, Real
from typing import Any, Final

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.quantities import format_value

_TABLES_OF_TABLES: Final = ("part", "coupling")
"""Tables of parts and couplings by name; each of them has a heading of its own, and so have the tables of a part."""

_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that TOML reads without quotation marks."""


def format_scene_toml(document: Mapping[str, Any], comment: str = "") -> str:
    """Return the document of a scene as the text of a TOML file; raise MechanismError if a value has no form in TOML."""
    lines = [*(f"# {line}" for line in comment.splitlines()), *_format_tables("", document)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _format_tables(heading: str, table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table: its values, and then what has a heading of its own."""
    has_headings = not heading or heading in _TABLES_OF_TABLES or (heading.partition(".")[0] == "part" and heading.count(".") == 1)
    nested = {key: value for key, value in table.items() if has_headings and (isinstance(value, Mapping) or _is_table_list(value))}
    own_lines = [f"{_format_key(key)} = {format_toml_value(value)}" for key, value in table.items() if key not in nested]
    if heading and (own_lines or not nested):
        yield from ("", f"[{heading}]")
    yield from own_lines
    for key, value in nested.items():
        name = f"{heading}.{_format_key(key)}" if heading else _format_key(key)
        if isinstance(value, Mapping):
            yield from _format_tables(name, value)
            continue
        for item in value:
            yield from ("", f"[[{name}]]", *(f"{_format_key(one)} = {format_toml_value(inner)}" for one, inner in item.items()))


def _is_table_list(value: Any) -> bool:
    """Return whether a value is a list of tables, which is written with double brackets."""
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _format_key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _format_text(key)


def _format_text(text: str) -> str:
    """Return a text in quotation marks; TOML also escapes the character DEL, which JSON leaves as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def format_toml_value(value: Any) -> str:
    """Return a value as TOML in one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_format_key(key)} = {format_toml_value(item)}" for key, item in value.items()) + " }" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(format_toml_value, value))}]"
    if isinstance(value, str):
        return _format_text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    raise MechanismError(f"a scene file cannot hold {format_value(value)}; it holds text, numbers, true, false, lists and tables")


def replace_document_value(table: Any, key: str, value: Any, table_key: str = "") -> Any:
    """Return a copy of a table with a value at a dotted key, sharing unchanged tables; MechanismError if a key leads through none."""
    # An item of a list is selected by its name or by its number, counted from 1.
    name, dot, remaining_key = key.partition(".")
    item_key = f"{table_key}.{name}" if table_key else name

    def changed(item: Any) -> Any:
        return replace_document_value(item, remaining_key, value, item_key) if dot else value

    if isinstance(table, list | tuple):
        item_index = find_item(table, name, table_key)
        return [*table[:item_index], changed(table[item_index]), *table[item_index + 1 :]]
    if isinstance(table, Mapping):
        nested = table.get(name, False)
        return {**table, name: changed({} if nested is False else nested)}  # a key that is switched off may be replaced by a table
    found = format_value(table)
    raise MechanismError(f"{item_key} cannot be varied: in this scene {table_key} is {found}, not a table; vary {table_key}")


def remove_document_key(table: Any, key: str) -> Any:
    """Return a copy of a document without a dotted key; raise MechanismError if it has no such key, or no table that the key belongs to."""
    table_key, _, name = key.rpartition(".")
    owner: Any = table
    passed = list[str]()
    for part in filter(None, table_key.split(".")):
        owner_key = ".".join(passed)
        owner = owner[find_item(owner, part, owner_key)] if isinstance(owner, list | tuple) else owner.get(part)
        passed.append(part)
        if not isinstance(owner, Mapping | list | tuple):
            raise MechanismError(f"{key} cannot be left out: this scene has no table {'.'.join(passed)}{_nearest_key(table, key)}")
    if isinstance(owner, list | tuple):
        removed = find_item(owner, name, table_key)
        return replace_document_value(table, table_key, [item for index, item in enumerate(owner) if index != removed])
    if name not in owner:
        keys = f"{table_key or 'its top level'} has {', '.join(map(str, owner)) or 'no keys'}"
        raise MechanismError(f"{key} cannot be left out: this scene does not have it; {keys}{_nearest_key(table, key)}")
    remaining = {one: value for one, value in owner.items() if one != name}
    return replace_document_value(table, table_key, remaining) if table_key else remaining


def parse_scene_with(document: Mapping[str, Any], values: Iterable[tuple[str, Any]]) -> Scene:
    """Return the scene of a document with these values at these keys; raise MechanismError as the parser does."""
    # The number of an assembly is that of the document: where the values change the order, it follows
    # the nearest branch.
    changed = document
    keys: set[str] = set()
    for key, value in values:
        keys.add(key.partition(".")[0])
        _require_known_dimension(changed, key)
        changed = replace_document_value(changed, key, value)
    number = _written_number(document)
    if number is None or "assembly" in keys:
        return parse_scene_document(changed)
    return _follow_assembly(document, changed, number)


def _follow_assembly(document: Mapping[str, Any], changed: Mapping[str, Any], number: int) -> Scene:
    """Return the scene of a changed document in the assembly nearest to the one before, with a note if its number is another."""
    from governor_mechanism.scenes.custom.parser import find_nearest_number  # few scenes have several assemblies

    scene = parse_scene_document(changed)
    before = _parse_numbered(format_scene_toml(document))
    if before is None:
        return scene
    nearest = find_nearest_number(changed, scene.part, scene.start, before.part.mechanism.initial_guess)
    if nearest == number:
        return scene
    scene = parse_scene_document(_with_number(changed, nearest))
    mechanism = scene.part.mechanism
    note = f"with the changed values assembly {number} has the number {nearest}: it follows the nearest branch"
    return scene.with_changes(mechanism=replace(mechanism, notes=(*mechanism.notes, note)))


def _written_number(document: Mapping[str, Any]) -> int | None:
    """Return the number of the assembly that a scene file writes; None if it writes none."""
    written = document.get("assembly")
    take = written.get("take") if isinstance(written, Mapping) else written
    return take if isinstance(take, int) else None


def _with_number(document: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return a document that takes another assembly."""
    written = document.get("assembly")
    return {**document, "assembly": {**written, "take": number} if isinstance(written, Mapping) else number}


@lru_cache(maxsize=4)
def _parse_numbered(text: str) -> Scene | None:
    """Return the scene of a text in TOML, or None if it has mistakes; kept, since each row of a sweep asks for it."""
    with suppress(MechanismError):
        return parse_scene_document(tomllib.loads(text))
    return None


def _require_known_dimension(document: Mapping[str, Any], key: str) -> None:
    """Raise MechanismError if a key names a dimension that a custom machine with dimensions does not have: nothing would follow it."""
    table_key, _, name = key.rpartition(".")
    owner: Any = document
    for part in filter(None, table_key.split(".")[:-1]):
        owner = owner.get(part) if isinstance(owner, Mapping) else None
    if not table_key.endswith("dimensions") or not isinstance(owner, Mapping) or owner.get("machine") != CUSTOM_MACHINE:
        return
    known = owner.get("dimensions")
    if isinstance(known, Mapping) and name not in known:
        raise MechanismError(f"{key} is no dimension of this scene; they are {', '.join(map(str, known))}.{did_you_mean(name, known)}")


def find_item(items: Sequence[Any], name: str, key_path: str) -> int:
    """Return the index of an item that is named by its name or its number; `key_path` is where the items are, for the message."""
    if name.isdecimal() and 1 <= int(name) <= len(items):
        return int(name) - 1
    names = [str(item["name"]) for item in items if isinstance(item, Mapping) and "name" in item]
    if names.count(name) == 1:
        return next(k for k, item in enumerate(items) if isinstance(item, Mapping) and item.get("name") == name)
    known_names = f"named {', '.join(names)}, or " if names else ""
    raise MechanismError(f"{key_path} has no {format_value(name)}; its items are {known_names}1 to {len(items)}{did_you_mean(name, names)}")


def _nearest_key(table: Any, key: str) -> str:
    """Return a hint at the key of the document that is nearest to a dotted key; "" if none is near."""
    return f".{hint}" if (hint := did_you_mean(key, _keys_of(table))) else ""


def _keys_of(table: Any, start: str = "") -> Iterator[str]:
    """Yield the dotted keys of a document; items of lists are named as `_find_item` finds them."""
    items: Iterable[tuple[Any, Any]] = table.items() if isinstance(table, Mapping) else ()
    if isinstance(table, list | tuple):
        items = [(item["name"], item) for item in table if isinstance(item, Mapping) and "name" in item]
    for name, item in items:
        yield f"{start}{name}"
        yield from _keys_of(item, f"{start}{name}.")


def check_start(scene: Scene) -> Scene:
    """Return a scene whose mechanism can be assembled at its start, or raise MechanismError: a wrong start is a mistake of the scene."""
    try:
        initial_state(scene)
    except MechanismError as error:
        prefix = f"{scene.source}: " if scene.source else ""
        raise MechanismError(*(f"{prefix}{problem}" for problem in error.problems)) from None
    return scene


def make_scene(document: Mapping[str, Any]) -> Scene:
    """Return the scene of a document, checked like a file; see `Scene.from_dict`."""
    return check_start(parse_scene_document(document))


def replace_values(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return a copy of a scene with other values at dotted keys; see `Scene.replace`."""
    if not isinstance(values, Mapping) or not all(isinstance(key, str) and key for key in values):
        raise MechanismError(f'replace takes values by key, as {{"dimensions.arm": "320 mm"}}; found {format_value(values)}')
    document = document_of(scene, "replace")
    for key in [key for key, value in values.items() if value is None]:
        document = remove_document_key(document, key)
    return check_start(parse_scene_with(document, [(key, value) for key, value in values.items() if value is not None]))


def scene_to_toml(scene: Scene) -> str:
    """Return the text of the scene file of a scene; see `Scene.to_toml`."""
    return format_scene_toml(document_of(scene, "to_toml"))


def document_of(scene: Scene, user: str) -> Mapping[str, Any]:
    """Return the document of a scene; raise MechanismError if it describes another one. `user` is the method that needs it."""
    cure = "use Scene.from_dict, load or replace"
    if not scene.document:
        raise MechanismError(f"{user} needs the document of the scene, and this scene was composed of objects; {cure}")
    if parse_scene_document(scene.document) != scene:
        raise MechanismError(f"{user} needs the document of the scene, and this scene was changed without it, as by with_changes; {cure}")
    return scene.document

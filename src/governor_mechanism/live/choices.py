"""Words and switches of a scene that a person may choose: its engine, its effects, and every true or false of its file."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import ENGINE_CHOICES, Scene
from governor_mechanism.scenes.changed_document import replace_document_value
from governor_mechanism.scenes.effect_tables import SLEEVE_LIFT_NAME
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

ENGINE_KEY: Final = "run.engine"
"""Key of the engine."""

EFFECTS_KEY: Final = "effects"
"""Table of the effects."""

Value = str | bool
"""What is chosen."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A word or a switch of a scene file.

    Attributes
    ----------
    key
        Dotted key.
    words
        What it is.
    value
        The word, or whether it is on.
    options
        Words to choose from; empty for a switch.
    """

    key: str
    words: str
    value: Value
    options: tuple[str, ...] = ()


def find_choices(document: Mapping[str, Any], scene: Scene) -> dict[str, Choice]:
    """Return the choices of the document of a scene by key."""
    engine = document.get("run", {}).get("engine", ENGINE_CHOICES[0])
    found = [Choice(key=ENGINE_KEY, words="engine", value=engine, options=ENGINE_CHOICES)]
    if len(scene.parts) == 1:
        found += _find_effects(document.get(EFFECTS_KEY, {}), scene.part)
    return {one.key: one for one in found}


def choose(document: Mapping[str, Any], scene: Scene, key: str, value: Value, kept: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the document of a scene with another choice; `kept` are the effects of an earlier one, by their keys.

    Raises MechanismError for a key that is no choice, or a value that it cannot have.
    """
    choices = find_choices(document, scene)
    choice = choices.get(key)
    if choice is None:
        raise MechanismError(f"{key!r} is no choice of this scene; it has {', '.join(choices)}")
    allowed = choice.options or (True, False)
    if value not in allowed or isinstance(value, bool) == bool(choice.options):
        raise MechanismError(f"{choice.words} is one of {', '.join(map(str, allowed))}; found {format_value(value)}")
    table, _, name = key.partition(".")
    if value is True:
        effect = next(one for one in EFFECTS if one.key == name)
        value = kept.get(name) or _default_value(effect, scene.part)
    owner = document if table in document else {**document, table: {}}
    changed: Mapping[str, Any] = replace_document_value(owner, key, value)
    return changed


def _find_effects(given: Mapping[str, Any], part: Part) -> Iterator[Choice]:
    """Yield the effects of a part that the file has, and those that it may have with the default values that they declare."""
    for effect in EFFECTS:
        is_on = effect.key in given and given[effect.key] is not False
        if effect.key in given or _default_value(effect, part) is not None:
            yield Choice(key=f"{EFFECTS_KEY}.{effect.key}", words=effect.key.replace("_", " "), value=is_on)


def _default_value(effect: type[Effect], part: Part) -> Any:
    """Return the value of an effect whose fields all have defaults, as a file writes it; None if it needs more than a switch."""
    declared = fields_of(effect)
    if effect.changes_bodies_of or any(one.is_required for one in declared.values()) or len(effect.value_fields) > 1:
        return None
    if not issubclass(effect, OutputEffect):
        return True if part.turns or not effect.loads_turning_bodies else None
    value = declared[effect.value_fields[0]] if effect.value_fields else None
    if value is None or value.sign == "positive" or value.built:  # a file does not write it as 0
        return None
    names = [reading.name for reading in part.mechanism.readings]
    reading = part.mechanism.reading(SLEEVE_LIFT_NAME if SLEEVE_LIFT_NAME in names else part.mechanism.coordinate)
    kind = value.along(reading.quantity).kind
    return {reading.name: f"0 {QUANTITY_KINDS[kind].si_unit}"}

"""[effects] of a scene file, from the keys that the effects declare. Slow to import: pydantic.

Effects along readings are tables keyed by reading, in the units of the quantity of the reading. The validation context
is the `ReadingQuantities` of the mechanism.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from typing import Annotated, Any, ClassVar, Final, TypeVar

from pydantic import Field, PlainValidator, ValidationInfo, create_model

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.scene_keys import FLAG_KIND, RESTITUTION_KIND, Derivation, SceneKey, scene_keys_of
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.loads import depends_on_readings, parse_load
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import SIGNS, check_bool, parse_number, parse_si, parse_time_points
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

ReadingQuantities = Mapping[str, str] | None
"""Quantities of the readings, "length" or "angle", by name; None if they are not known."""

SLEEVE_ALIAS, SLEEVE_LIFT_NAME = "sleeve", "sleeve_lift"
"""Short name of a reading of governors, and its name."""

NO_END: Final = "none"
"""Word for the end of a range that does not exist."""

_Parsed = TypeVar("_Parsed")


def _example(key: SceneKey, quantity: str) -> str:
    """Return a valid value of a key along a quantity, quoted."""
    examples = key.examples or (QUANTITY_KINDS[key.kind_along(quantity)].example,)
    return f'"{examples[-1] if quantity == "angle" else examples[0]}"'


def _effect_example(effect: type[Effect], quantity: str) -> str:
    """Return a valid value of an effect."""
    keys = scene_keys_of(effect)
    if len(effect.value_fields) == 1:
        return _example(keys[effect.value_fields[0]], quantity)
    if effect.value_fields:
        return f"[{', '.join(_example(keys[name], quantity) for name in effect.value_fields)}]"
    shown = [name for name, key in keys.items() if key.examples] or _required_fields(effect)
    return f"{{ {', '.join(f'{name} = {_example(keys[name], quantity)}' for name in shown)} }}"


def _required_fields(effect: type[Effect]) -> list[str]:
    keys = scene_keys_of(effect)
    return [field.name for field in dataclasses.fields(effect) if field.default is dataclasses.MISSING and field.name in keys]


def _parse_key(key: SceneKey, quantity: str, value: object) -> Any:
    """Return the value of a key along a quantity."""
    if key.kind == FLAG_KIND:
        return check_bool(value)
    if key.kind == RESTITUTION_KIND:
        return parse_number(value, 0, 1, reason=" (speed after over speed before an impact)")
    kind = key.kind_along(quantity)
    if key.is_program:
        return _parse_program(key, kind, value)
    return parse_si(value, kind, sign=key.sign, bounded=key.bounded, hint=key.hint)


def _parse_program(key: SceneKey, kind: str, value: Any) -> InputFunction:
    """Return a load from a value, a list of [time, value], or a function of a reading."""
    if depends_on_readings(value):
        return parse_load(value, kind, kind)
    times, values = parse_time_points(value, kind, kind)
    has_sign, requirement = SIGNS[key.sign]
    for i, number in enumerate(values):
        if not has_sign(number):
            is_list = isinstance(value, list | tuple)
            location, found = (f", point {i + 1}:", value[i][1]) if is_list else ("", value)
            raise mistake(ProblemCode.OUT_OF_RANGE, f"{KEY}{location} {requirement}{key.reason}; found {format_value(found)}")
    return InputFunction(times=times, values=values)


class EffectTable(SceneFileTable):
    """A table of the arguments of an effect."""

    effect: ClassVar[type[Effect]]
    quantity: ClassVar[str]

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[Problem]:
        """Yield fields given twice, or missing although they may be computed from other keys."""
        for derivation in cls.effect.derivations:
            hint = f"write {derivation.field} = {_example(scene_keys_of(cls.effect)[derivation.field], cls.quantity)}"
            yield from _derivation_problems(values, derivation, hint if cls.quantity == "angle" else "")
            if derivation.field in _required_fields(cls.effect) and not values.keys() & {derivation.field, *derivation.kinds}:
                alternative = "" if cls.quantity == "angle" else f", or {', '.join(derivation.kinds)}"
                yield Problem(f"{KEY}: {derivation.field} is missing; {hint}{alternative}", ProblemCode.MISSING_KEY)

    def build(self, **arguments: Any) -> Effect:
        """Return the effect, its fields given or computed; `arguments` are the other fields."""
        values = self.given_values()
        for derivation in self.effect.derivations:
            given = {name: values.pop(name) for name in derivation.kinds if name in values}
            if given:
                values[derivation.field] = derivation.function(**given)
        return self.effect(**values, **arguments)


def _derivation_problems(values: Mapping[str, Any], derivation: Derivation, hint_along_angle: str) -> Iterator[Problem]:
    """Yield the problem of keys from which a field follows: given with the field, not along a length, or incomplete."""
    given = [key for key in derivation.kinds if key in values]
    needed = [key for key in derivation.kinds if key not in (derivation.function.__kwdefaults__ or {})]
    text = ""
    if given and derivation.field in values:
        text = f"{KEY}: {derivation.field} cannot be combined with {', '.join(given)}, from which it follows; leave one of the two out"
    elif given and hint_along_angle:
        text = f"{KEY} is an angle and cannot have {', '.join(given)}; {hint_along_angle}"
    elif given and (missing := [key for key in needed if key not in values]):
        text = f"{KEY} lacks {', '.join(missing)}; {', '.join(needed)} are all needed"
    if text:
        yield Problem(text, ProblemCode.CONFLICT)


@cache
def _table_model(effect_key: str, quantity: str) -> type[EffectTable]:
    """Return the model of a table of an effect, along a reading of a quantity, with the keys that the effect declares."""
    effect = next(effect for effect in EFFECTS if effect.key == effect_key)
    keys = {name: key for name, key in scene_keys_of(effect).items() if name not in effect.common_keys}
    derived = {derivation.field for derivation in effect.derivations}
    required = set(_required_fields(effect)) - derived
    for derivation in effect.derivations:
        keys |= {name: SceneKey(kind) for name, kind in derivation.kinds.items()}
    fields: dict[str, Any] = {}
    for name, key in keys.items():
        field = Field(None)
        if name in required:
            meaning = key.meaning or QUANTITY_KINDS[key.kind_along(quantity)].name
            field = Field(..., description=f"{meaning}, as {_example(key, quantity)}")
        fields[name] = (Annotated[Any, PlainValidator(partial(_parse_key, key, quantity))], field)
    model = create_model(f"{effect.__name__}Table", __base__=EffectTable, **fields)
    model.effect, model.quantity = effect, quantity
    model.example = "" if effect.value_fields else _effect_example(effect, quantity)
    return model


def _build_effect(effect: type[Effect], quantity: str, value: Any, **arguments: Any) -> Effect:
    """Return an effect from its value along a quantity; `arguments` are the fields given elsewhere."""
    names, keys = effect.value_fields, scene_keys_of(effect)
    has_table = len(names) + len(effect.common_keys) < len(keys)
    if not names or (has_table and isinstance(value, Mapping)):
        return validate(_table_model(effect.key, quantity), value).build(**arguments)
    if len(names) == 1:
        key = keys[names[0]]
        if not key.is_program:
            key = dataclasses.replace(key, sign="positive", hint=key.hint or "; leave it out if there is none")
        return effect(**{names[0]: _parse_key(key, quantity, value)}, **arguments)
    return _build_from_range(effect, quantity, value, **arguments)


def _build_from_range(effect: type[Effect], quantity: str, value: Any, **arguments: Any) -> Effect:
    """Return an effect from the two ends of a range; a missing end has the default of its field."""
    names, keys = effect.value_fields, scene_keys_of(effect)
    if not isinstance(value, list | tuple) or len(value) != 2:
        text = f'{KEY} must be [{", ".join(names)}], with "{NO_END}" for a missing end; found {format_value(value)}'
        raise mistake(ProblemCode.WRONG_TYPE, f"{text}; write {_effect_example(effect, quantity)}")
    collector, ends = ProblemCollector(), dict[str, float]()
    for name, end in zip(names, value, strict=True):
        if end != NO_END:
            with collector.at():
                ends[name] = parse_si(end, keys[name].kind_along(quantity), f"{KEY}, {name} end")
    collector.raise_if_failed()
    try:
        return effect(**ends, **arguments)
    except MechanismError as error:
        raise mistake(ProblemCode.OUT_OF_RANGE, f"{KEY}: {error}; found {format_value(value)}") from error


def _parse_single_effect(effect: type[Effect], value: object) -> tuple[Effect, ...]:
    """Return an effect that acts along no reading, as a tuple, which is empty if it is switched off."""
    may_be_true = bool(effect.value_fields) and not _required_fields(effect)
    if not scene_keys_of(effect) or (may_be_true and isinstance(value, bool)):
        return (effect(),) if check_bool(value) else ()
    if value is False:
        return ()
    if value is True and effect.value_fields:
        (key,) = (scene_keys_of(effect)[name] for name in effect.value_fields)
        text = f"{KEY} is {key.meaning}; found true; write {effect.key} = {_effect_example(effect, '')}"
        raise mistake(ProblemCode.WRONG_TYPE, text)
    collector, effects = ProblemCollector(), tuple[Effect, ...]()
    with collector.at():
        effects = (_build_effect(effect, "", value),)
    if may_be_true and collector.has_failed:
        hint = f"; {effect.key} may also be true ({_default_text(effect)}) or false"
        collector.problems = [Problem(f"{problem}{hint}", problem.code) for problem in collector.problems]
    collector.raise_if_failed()
    return effects


def _default_text(effect: type[Effect]) -> str:
    """Return the value with its unit that stands for true."""
    (name,) = effect.value_fields
    return f"{getattr(effect(), name):g} {QUANTITY_KINDS[scene_keys_of(effect)[name].kind].si_unit}"


def _parse_output_effects(effect: type[Effect], value: object, quantities: ReadingQuantities) -> tuple[Effect, ...]:
    """Return the effects of a table with one entry per reading, and fields that all have in common."""
    if value is False:
        return ()
    table = _require_readings(effect, value, quantities)
    collector, common, effects = ProblemCollector(), dict[str, Any](), dict[str, Effect]()
    for name in [name for name in effect.common_keys if name in table]:
        with collector.at(f"{KEY}.{name}"):
            common[name] = _parse_key(scene_keys_of(effect)[name], "", table.pop(name))
    with collector.at():
        _require_readings(effect, table, quantities)
    for name, given in table.items():
        with collector.at(f"{KEY}.{name}"):
            reading = resolve_reading_name(name, quantities)
            if given is False:
                continue
            if reading in effects:
                raise mistake(ProblemCode.DUPLICATE, f"{KEY} is the same reading as another key; keep one of them")
            effects[reading] = _parse_output_effect(effect, reading, quantities, given, common)
    collector.raise_if_failed()
    return tuple(effects.values())


def _require_readings(effect: type[Effect], value: object, reading_quantities: ReadingQuantities) -> dict[str, Any]:
    """Return the table of an effect, which is not empty."""
    quantities: Mapping[str, str] = reading_quantities or {SLEEVE_LIFT_NAME: "length"}
    name, quantity = (SLEEVE_ALIAS, "length") if SLEEVE_LIFT_NAME in quantities else next(iter(quantities.items()))
    example = f"write {effect.key} = {{ {name} = {_effect_example(effect, quantity)} }}"
    if not isinstance(value, Mapping):
        text = f"{KEY} must be a table with the readings on which it acts; found {format_value(value)}; {example}"
        raise mistake(ProblemCode.WRONG_TYPE, text)
    if not value:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY} has no reading to act on; {example}")
    return {str(name): given for name, given in value.items()}


def _parse_output_effect(
    effect: type[Effect], reading: str, quantities: ReadingQuantities, value: Any, common: Mapping[str, Any]
) -> Effect:
    """Return the effect on a reading."""
    return parse_by_quantity(
        reading, quantities, value, lambda name, quantity, given: _build_effect(effect, quantity, given, reading=name, **common)
    )


def parse_by_quantity(reading: str, quantities: ReadingQuantities, value: Any, make: Callable[[str, str, Any], _Parsed]) -> _Parsed:
    """Return what `make` parses for the quantity of a reading; of an unknown quantity, the result with the fewest problems."""
    refusals: list[MechanismError] = []
    for quantity in ("length", "angle") if quantities is None else (quantities[reading],):
        try:
            return make(reading, quantity, value)
        except MechanismError as error:
            refusals.append(error)
    raise min(refusals, key=lambda refusal: len(refusal.problems))


def resolve_reading_name(name: str, quantities: ReadingQuantities, path: str = KEY) -> str:
    """Return the name of a reading, also for the short name of the sleeve's; `path` is where a message finds it."""
    if quantities is None or name in quantities:
        return name
    if name == SLEEVE_ALIAS and SLEEVE_LIFT_NAME in quantities:
        return SLEEVE_LIFT_NAME
    aliases = [SLEEVE_ALIAS] if SLEEVE_LIFT_NAME in quantities else []
    suggestion = did_you_mean(name, [*aliases, *quantities])
    raise mistake(ProblemCode.UNKNOWN_NAME, f"{path} is not a reading; readings are {', '.join(quantities)}.{suggestion}")


def _effect_validator(effect: type[Effect]) -> PlainValidator:
    """Return the validator of the value of an effect; it gives a tuple of effects, empty if it is switched off."""

    def check(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        is_along_readings = issubclass(effect, OutputEffect)
        return _parse_output_effects(effect, value, info.context) if is_along_readings else _parse_single_effect(effect, value)

    return PlainValidator(check)


_EFFECT_FIELDS: dict[str, Any] = {effect.key: (Annotated[tuple[Effect, ...], _effect_validator(effect)], ()) for effect in EFFECTS}

EffectsTable = create_model("EffectsTable", __base__=SceneFileTable, **_EFFECT_FIELDS)
"""[effects]; each key gives a tuple of effects."""


def parse_effects(table: Mapping[str, Any], quantities: ReadingQuantities, collector: ProblemCollector) -> tuple[Effect, ...]:
    """Return the effects that [effects] switches on; keys without a mistake count even if others have one."""
    effects: dict[str, tuple[Effect, ...]] = {}
    for key, value in table.items():
        with collector.at("effects"):
            effects |= validate(EffectsTable, {key: value}, context=quantities).given_values()
    return tuple(effect for key in EffectsTable.model_fields for effect in effects.get(key, ()))

"""[effects] of a scene file, from the keys that the effects declare. Slow to import: pydantic.

Effects along readings are tables keyed by reading, in the units of the quantity of the reading. The validation context
is the `ReadingQuantities` of the mechanism.
"""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from typing import Annotated, Any, ClassVar, Final, TypeVar

from pydantic import Field, PlainValidator, ValidationInfo, create_model

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import FLAG_KIND, RESTITUTION_KIND, Effect, OutputEffect, SceneKey, scene_keys_of
from governor_mechanism.scenes.loads import parse_load
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake, parse_each, wrong_value
from governor_mechanism.scenes.quantities import check_bool, parse_first_fitting, parse_number, parse_si
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import QUANTITY_KINDS

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


def effect_example(effect: type[Effect], quantity: str) -> str:
    """Return a valid value of an effect."""
    keys = scene_keys_of(effect)
    values = [_example(keys[name], quantity) for name in effect.value_fields]
    if values:
        return values[0] if len(values) == 1 else f"[{', '.join(values)}]"
    shown = [name for name, key in keys.items() if key.examples] or [name for name, key in keys.items() if key.is_required]
    return f"{{ {', '.join(f'{name} = {_example(keys[name], quantity)}' for name in shown)} }}"


def _parse_key(key: SceneKey, quantity: str, value: object) -> Any:
    """Return the value of a key along a quantity."""
    if key.kind == FLAG_KIND:
        return check_bool(value)
    if key.kind == RESTITUTION_KIND:
        return parse_number(value, 0, 1, reason=" (speed after over speed before an impact)")
    kind = key.kind_along(quantity)
    if key.is_program:
        return parse_load(value, kind, kind, key.sign, key.reason)
    return parse_si(value, kind, sign=key.sign, bounded=key.bounded, hint=key.hint)


class EffectTable(SceneFileTable):
    """A table of the arguments of an effect."""

    element: ClassVar[type[Effect]]
    quantity: ClassVar[str]

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield fields given twice, or missing although they may be computed from other keys; only along a length."""
        for derivation in cls.element.derivations:
            field, keys, is_angle = derivation.field, list(derivation.kinds), cls.quantity == "angle"
            field_key = scene_keys_of(cls.element)[field]
            given = [key for key in keys if key in values]
            needed = [key for key in keys if key not in (derivation.function.__kwdefaults__ or {})]
            missing = [key for key in needed if key not in values]
            hint = f"write {field} = {_example(field_key, cls.quantity)}"
            if given and field in values:
                yield f"{KEY}: {field} cannot be combined with {', '.join(given)}, from which it follows; leave one of the two out"
            elif given and is_angle:
                yield f"{KEY} is an angle and cannot have {', '.join(given)}; {hint}"
            elif given and missing:
                yield f"{KEY} lacks {', '.join(missing)}; {', '.join(needed)} are all needed"
            elif not given and field not in values and field_key.is_required:
                alternative = "" if is_angle else f", or {', '.join(keys)}"
                yield Problem(f"{KEY}: {field} is missing; {hint}{alternative}", ProblemCode.MISSING_KEY)

    def given_values(self) -> dict[str, Any]:
        """Return the fields of the effect, given or computed."""
        values = super().given_values()
        for derivation in self.element.derivations:
            given = {name: values.pop(name) for name in derivation.kinds if name in values}
            values |= {derivation.field: derivation.function(**given)} if given else {}
        return values


@cache
def _table_model(effect_key: str, quantity: str) -> type[EffectTable]:
    """Return the model of a table of an effect, along a reading of a quantity, with the keys that the effect declares."""
    effect = next(effect for effect in EFFECTS if effect.key == effect_key)
    keys = {name: key for name, key in scene_keys_of(effect).items() if name not in effect.common_keys}
    for derivation in effect.derivations:
        keys |= {name: SceneKey(kind) for name, kind in derivation.kinds.items()}
        keys[derivation.field] = dataclasses.replace(keys[derivation.field], is_required=False)
    fields: dict[str, Any] = {}
    for name, key in keys.items():
        meaning = f"{key.meaning or QUANTITY_KINDS[key.kind_along(quantity)].name}, as {_example(key, quantity)}" if key.is_required else ""
        field = Field(... if meaning else None, description=meaning)
        fields[name] = (Annotated[Any, PlainValidator(partial(_parse_key, key, quantity))], field)
    model = create_model(f"{effect.__name__}Table", __base__=EffectTable, **fields)
    model.element, model.quantity = effect, quantity
    model.example = "" if effect.value_fields else effect_example(effect, quantity)
    return model


def _build_effect(effect: type[Effect], value: Any, quantity: str = "", **arguments: Any) -> Effect:
    """Return an effect from its value along a quantity; `arguments` are the fields given elsewhere."""
    names, keys = effect.value_fields, scene_keys_of(effect)
    if not names or (len(names) + len(effect.common_keys) < len(keys) and isinstance(value, Mapping)):
        built: Effect = validate(_table_model(effect.key, quantity), value).make_element(**arguments)
        return built
    if len(names) == 1:
        key = keys[names[0]]
        if not key.is_program:
            key = dataclasses.replace(key, sign="positive", hint=key.hint or "; leave it out if there is none")
        return effect(**{names[0]: _parse_key(key, quantity, value)}, **arguments)
    ends = _parse_range(effect, quantity, value)
    try:
        return effect(**ends, **arguments)
    except MechanismError as error:
        raise wrong_value(value, str(error), code=ProblemCode.OUT_OF_RANGE, path=f"{KEY}:") from error


def _parse_range(effect: type[Effect], quantity: str, value: Any) -> dict[str, float]:
    """Return the given ends of a range by field."""
    names, keys = effect.value_fields, scene_keys_of(effect)
    if not isinstance(value, list | tuple) or len(value) != 2:
        requirement = f'must be [{", ".join(names)}], with "{NO_END}" for a missing end'
        raise wrong_value(value, requirement, f"; write {effect_example(effect, quantity)}")
    given = {name: end for name, end in zip(names, value, strict=True) if end != NO_END}
    return dict(parse_each(lambda name: (name, parse_si(given[name], keys[name].kind_along(quantity), f"{KEY}, {name} end")), given))


def _parse_single_effect(effect: type[Effect], value: object) -> tuple[Effect, ...]:
    """Return an effect that acts along no reading, or nothing if it is switched off."""
    keys = scene_keys_of(effect)
    may_be_true = bool(effect.value_fields) and not any(key.is_required for key in keys.values())
    if not keys or (may_be_true and isinstance(value, bool)):
        return (effect(),) if check_bool(value) else ()
    if value is False:
        return ()
    name = effect.value_fields[0] if effect.value_fields else ""
    if value is True and name:
        raise wrong_value(value, f"is {keys[name].meaning}", f"; write {effect.key} = {effect_example(effect, '')}")
    try:
        return (_build_effect(effect, value),)
    except MechanismError as error:
        if not may_be_true:
            raise
        default = f"{getattr(effect(), name):g} {QUANTITY_KINDS[keys[name].kind].si_unit}"
        hint = f"; {effect.key} may also be true ({default}) or false"
        raise MechanismError(*(Problem(f"{problem}{hint}", Problem(problem).code) for problem in error.problems)) from error


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
            effects[reading] = parse_by_quantity(reading, quantities, partial(_build_effect, effect, given, reading=reading, **common))
    collector.raise_if_failed()
    return tuple(effects.values())


def _require_readings(effect: type[Effect], value: object, reading_quantities: ReadingQuantities) -> dict[str, Any]:
    """Return the table of an effect, which is not empty."""
    quantities: Mapping[str, str] = reading_quantities or {SLEEVE_LIFT_NAME: "length"}
    name, quantity = (SLEEVE_ALIAS, "length") if SLEEVE_LIFT_NAME in quantities else next(iter(quantities.items()))
    example = f"; write {effect.key} = {{ {name} = {effect_example(effect, quantity)} }}"
    if not isinstance(value, Mapping):
        raise wrong_value(value, "must be a table with the readings on which it acts", example)
    if not value:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY} has no reading to act on{example}")
    return {str(name): given for name, given in value.items()}


def parse_by_quantity(reading: str, quantities: ReadingQuantities, parse: Callable[[str], _Parsed]) -> _Parsed:
    """Return what is parsed for the quantity of a reading; of an unknown quantity, the result with the fewest problems."""
    return parse_first_fitting(("length", "angle") if quantities is None else (quantities[reading],), parse)[1]


def resolve_reading_name(name: str, quantities: ReadingQuantities, path: str = KEY) -> str:
    """Return the name of a reading, also for the short name of the sleeve's; `path` is where a message finds it."""
    if quantities is None or name in quantities:
        return name
    if name == SLEEVE_ALIAS and SLEEVE_LIFT_NAME in quantities:
        return SLEEVE_LIFT_NAME
    suggestion = did_you_mean(name, [*([SLEEVE_ALIAS] if SLEEVE_LIFT_NAME in quantities else []), *quantities])
    raise mistake(ProblemCode.UNKNOWN_NAME, f"{path} is not a reading; readings are {', '.join(quantities)}.{suggestion}")


def _parse_effect(effect: type[Effect], value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    """Return the effects of a key; none if it is switched off."""
    is_along_readings = issubclass(effect, OutputEffect)
    return _parse_output_effects(effect, value, info.context) if is_along_readings else _parse_single_effect(effect, value)


_EFFECT_FIELDS: dict[str, Any] = {effect.key: (Annotated[Any, PlainValidator(partial(_parse_effect, effect))], ()) for effect in EFFECTS}
EffectsTable = create_model("EffectsTable", __base__=SceneFileTable, **_EFFECT_FIELDS)
"""[effects]; each key gives a tuple of effects."""


def parse_effects(table: Mapping[str, Any], quantities: ReadingQuantities, collector: ProblemCollector) -> tuple[Effect, ...]:
    """Return the effects that [effects] switches on; keys without a mistake count even if others have one."""
    effects: dict[str, tuple[Effect, ...]] = {}
    for key, value in table.items():
        with collector.at("effects"):
            effects |= validate(EffectsTable, {key: value}, context=quantities).given_values()
    return tuple(effect for key in EffectsTable.model_fields for effect in effects.get(key, ()))

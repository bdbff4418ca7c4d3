"""[effects] of a scene file, from the keys that the effects declare; those along readings are tables by reading, in its units."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Final, TypeVar

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.coupling.coupled_system import GIVEN_SPEED_CLAUSE
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.scenes.loads import LOAD_TYPES
from governor_mechanism.scenes.quantities import (
    NUMBER_OR_TEXT,
    TEXT,
    VALUE_TYPES,
    Table,
    ValueType,
    check_bool,
    parse_first_fitting,
    parse_name,
    parse_si,
)
from governor_mechanism.units.fields import Declaration, declare, fields_of
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake, parse_each, wrong_value
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

ReadingQuantities = Mapping[str, str] | None
"""Quantities of the readings, "length" or "angle", by name; None if they are not known."""

SLEEVE_ALIAS, SLEEVE_LIFT_NAME = "sleeve", "sleeve_lift"
"""Short name of a reading of governors, and its name."""

NO_END: Final = "none"
"""Word for the end of a range that does not exist."""

_Parsed = TypeVar("_Parsed")


def _example(declared: Declaration, quantity: str) -> str:
    """Return a valid value of a key along a quantity, quoted."""
    one = declared.along(quantity)
    return f'"{one.examples[0] if one.examples else QUANTITY_KINDS[one.kind].example}"'


def effect_example(effect: type[Effect], quantity: str) -> str:
    """Return a valid value of an effect."""
    keys = fields_of(effect)
    values = [_example(keys[name], quantity) for name in effect.value_fields]
    if values:
        return values[0] if len(values) == 1 else f"[{', '.join(values)}]"
    shown = [name for name, key in keys.items() if key.examples] or [name for name, key in keys.items() if key.is_required]
    return f"{{ {', '.join(f'{name} = {_example(keys[name], quantity)}' for name in shown)} }}"


def _read_key(declared: Declaration, quantity: str, value: object) -> Any:
    """Return the value of a key along a quantity."""
    return LOAD_TYPES[declared.form].read(declared.along(quantity), value, None)


def _find_conflicts(effect: type[Effect], quantity: str, values: Mapping[str, Any], context: object) -> Iterator[str]:
    """Yield fields given twice, or missing although they may be computed from other keys; only along a length."""
    for derivation in effect.derivations:
        field = derivation.field
        keys = list(derivation.kinds)
        is_angle = quantity == "angle"
        declared = fields_of(effect)[field]
        given = [key for key in keys if key in values]
        needed = [key for key in keys if key not in (derivation.function.__kwdefaults__ or {})]
        missing = [key for key in needed if key not in values]
        hint = f"write {field} = {_example(declared, quantity)}"
        if given and field in values:
            yield f"{KEY}: {field} cannot be combined with {', '.join(given)}, from which it follows; leave one of the two out"
        elif given and is_angle:
            yield f"{KEY} is an angle and cannot have {', '.join(given)}; {hint}"
        elif given and missing:
            yield f"{KEY} lacks {', '.join(missing)}; {', '.join(needed)} are all needed"
        elif not given and field not in values and declared.is_required:
            alternative = "" if is_angle else f", or {', '.join(keys)}"
            yield Problem(f"{KEY}: {field} is missing; {hint}{alternative}", ProblemCode.MISSING_KEY)


def _make_effect(effect: type[Effect], **given: Any) -> Effect:
    """Return an effect from the values of its table, with the fields that are computed from others."""
    for derivation in effect.derivations:
        arguments = {name: given.pop(name) for name in derivation.kinds if name in given}
        given |= {derivation.field: derivation.function(**arguments)} if arguments else {}
    return effect(**given)


@cache
def _effect_table(effect_key: str, quantity: str) -> Table:
    """Return the table of an effect, along a reading of a quantity, with the keys that the effect declares."""
    effect = next(effect for effect in EFFECTS if effect.key == effect_key)
    fields = {}
    for name, one in fields_of(effect).items():
        declared = one.along(quantity)
        if one.is_required:
            meaning = f"{one.meaning or QUANTITY_KINDS[declared.kind].name}, as {_example(one, quantity)}"
            declared = dataclasses.replace(declared, meaning=meaning)
        if name not in effect.common_keys:
            fields[name] = declared
    for derivation in effect.derivations:
        fields |= {name: declare("quantity", kind, built=True, default=None) for name, kind in derivation.kinds.items()}
        fields[derivation.field] = dataclasses.replace(fields[derivation.field], follows=True)
    return Table(
        make=partial(_make_effect, effect),
        fields=fields,
        types=LOAD_TYPES,
        example="" if effect.value_fields else effect_example(effect, quantity),
        find_conflicts=partial(_find_conflicts, effect, quantity),
    )


def _build_effect(effect: type[Effect], value: Any, quantity: str = "", **arguments: Any) -> Effect:
    """Return an effect from its value along a quantity; `arguments` are the fields given elsewhere."""
    names, keys = effect.value_fields, fields_of(effect)
    if not names or (len(names) + len(effect.common_keys) < len(keys) and isinstance(value, Mapping)):
        built: Effect = _effect_table(effect.key, quantity).build(value, **arguments)
        return built
    if len(names) == 1:
        declared = keys[names[0]]
        if declared.form == "quantity":
            hint = declared.hint or "; leave it out if there is none"
            declared = dataclasses.replace(declared, sign="positive", hint=hint)
        return effect(**{names[0]: _read_key(declared, quantity, value)}, **arguments)
    ends = _parse_range(effect, quantity, value)
    try:
        return effect(**ends, **arguments)
    except MechanismError as error:
        raise wrong_value(value, str(error), code=ProblemCode.OUT_OF_RANGE, path=f"{KEY}:") from error


def _parse_range(effect: type[Effect], quantity: str, value: Any) -> dict[str, float]:
    """Return the given ends of a range by field."""
    names, keys = effect.value_fields, fields_of(effect)
    if not isinstance(value, list | tuple) or len(value) != 2:
        requirement = f'must be [{", ".join(names)}], with "{NO_END}" for a missing end'
        raise wrong_value(value, requirement, f"; write {effect_example(effect, quantity)}")
    given = {name: end for name, end in zip(names, value, strict=True) if end != NO_END}
    return dict(parse_each(lambda name: (name, parse_si(given[name], keys[name].along(quantity).kind, f"{KEY}, {name} end")), given))


def _parse_single_effect(effect: type[Effect], value: object) -> tuple[Effect, ...]:
    """Return an effect that acts along no reading, or nothing if it is switched off."""
    keys = fields_of(effect)
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
    collector = ProblemCollector()
    common = dict[str, Any]()
    effects = dict[str, Effect]()
    for name in [name for name in effect.common_keys if name in table]:
        with collector.at(f"{KEY}.{name}"):
            common[name] = _read_key(fields_of(effect)[name], "", table.pop(name))
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


def _parse_effect(declared: Declaration, value: object, quantities: Any) -> tuple[Effect, ...]:
    """Return the effects of a key; none if it is switched off."""
    effect: type[Effect] = declared.content
    is_along_readings = issubclass(effect, OutputEffect)
    return _parse_output_effects(effect, value, quantities) if is_along_readings else _parse_single_effect(effect, value)


EFFECTS_TABLE: Final = Table(
    make=dict,
    fields={effect.key: declare("effect", content=effect, default=()) for effect in EFFECTS},
    types={"effect": ValueType(_parse_effect)},
)
"""[effects]; each key gives a tuple of effects."""


def parse_effects(table: Mapping[str, Any], quantities: ReadingQuantities, collector: ProblemCollector) -> tuple[Effect, ...]:
    """Return the effects that [effects] switches on; keys without a mistake count even if others have one."""
    effects: dict[str, tuple[Effect, ...]] = {}
    for key, value in table.items():
        with collector.at("effects"):
            effects |= EFFECTS_TABLE.read({key: value}, quantities)
    return tuple(effect for key in EFFECTS_TABLE.fields for effect in effects.get(key, ()))


WATCHED_KINDS: Final = ("length", "angle", "angular_speed")
"""Kinds of quantities that a named crossing may watch."""


@dataclass(frozen=True)
class WatchedReadings:
    """What a named crossing may watch."""

    quantities: ReadingQuantities  # quantities of readings and speeds by name; None while they are not known
    given_speeds: frozenset[str] = frozenset()  # names of speeds that are given, which no crossing may watch

    def resolve(self, name: object) -> str:
        """Return the name of a reading; refuse what is none, or none that a crossing may watch."""
        if not isinstance(name, str):
            raise wrong_value(name, "must be the name of a reading")
        path = f"{KEY} {format_value(name)}"
        if name in self.given_speeds:
            raise mistake(ProblemCode.CONFLICT, f"{path} is {GIVEN_SPEED_CLAUSE}")
        return resolve_reading_name(name, self.quantities, path)

    def kinds_of(self, name: object) -> tuple[str, ...]:
        """Return the kind of quantity of a reading; all that a crossing may watch if the reading is not known."""
        try:
            reading = self.resolve(name)
        except MechanismError:
            return WATCHED_KINDS
        return WATCHED_KINDS if self.quantities is None else (self.quantities[reading],)


def join_watched_readings(watched: Mapping[str, WatchedReadings | None]) -> WatchedReadings:
    """Return what a crossing may watch in all parts, by the start of the names of each part."""
    known = {prefix: one for prefix, one in watched.items() if one is not None}
    quantities = {f"{prefix}{name}": kind for prefix, one in known.items() for name, kind in (one.quantities or {}).items()}
    return WatchedReadings(quantities, frozenset(f"{prefix}{name}" for prefix, one in known.items() for name in one.given_speeds))


def _read_value(declared: Declaration, value: object, context: tuple[WatchedReadings, tuple[str, ...]]) -> float:
    """Return the value in the unit of the reading, or in any if the reading has a mistake."""
    return parse_first_fitting(context[1], lambda kind: parse_si(value, kind))[1]


CROSSING: Final = Table.of(
    NamedCrossing,
    types={
        **VALUE_TYPES,
        "watched reading": ValueType(lambda declared, value, context: context[0].resolve(value), TEXT),
        "watched value": ValueType(_read_value, NUMBER_OR_TEXT),
    },
    example='{ reading = "sleeve_lift", value = "20 mm", direction = "up" }',
)
"""[events.name]; its context is what a crossing may watch, and the kinds of its reading."""


def parse_crossings(table: object, watched: WatchedReadings, collector: ProblemCollector) -> tuple[NamedCrossing, ...]:
    """Return the named crossings without mistakes of [events]; anything but a table is reported with the top level."""

    def parse_crossing(name: str, values: object) -> NamedCrossing:
        own_name = parse_name(name)
        reading = values.get("reading") if isinstance(values, Mapping) else None
        crossing: NamedCrossing = CROSSING.build(values, (watched, watched.kinds_of(reading)), name=own_name)
        return crossing

    return tuple(collector.parse_tables("events", table, parse_crossing))

"""Loads of a scene file: constants, functions of time or readings, harmonics, or sums of these; and couplings, which may add to one."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

from governor_mechanism.model.coupling.couplings import ControlCoupling, Coupling, FollowCoupling, GearCoupling, LoadCoupling, RatioCoupling
from governor_mechanism.model.time_functions import (
    AngleHarmonic,
    Harmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    ReadingFunction,
    TableFunction,
)
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.quantities import Table, parse_table_list
from governor_mechanism.units.fields import Declaration, declare, entry, fields_of, optional_size
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, mistake, parse_each, unknown_name, wrong_value
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

READING_KINDS: Final = ("length", "angle", "angular_speed")
"""Kinds of quantity of what a load may depend on."""

GAIN_KINDS: Final[Mapping[str, Mapping[str, str]]] = {
    "torque": {"length": "torque_per_length", "angle": "torsion_stiffness", "angular_speed": "torsion_damping"},
    "force": {"length": "stiffness", "angle": "force_per_angle", "angular_speed": "force_per_angular_speed"},
    "ratio": {"length": "ratio_per_length", "angle": "ratio_per_angle", "angular_speed": "ratio_per_angular_speed"},
}
"""Kind of a gain by the kind of the load and that of the reading."""

RATIO_LOADS: Final = ("throttle", "cut_off")
"""Last words of the names of loads that are ratios."""

FUNCTION_KEYS: Final = ("table", "gain", "harmonics")
"""Keys of which a function of a reading has one."""


def harmonic_table(kind: str) -> Table:
    """Return the table of a harmonic amplitude * sin(2 pi * frequency * t + phase) of the time."""
    return _harmonic_table(Harmonic, kind, 'frequency = "2 Hz"')


def angle_harmonic_table(kind: str) -> Table:
    """Return the table of a harmonic amplitude * sin(order * angle + phase) of an angle."""
    return _harmonic_table(AngleHarmonic, kind, "order = 2")


@cache
def _harmonic_table(harmonic: type[Harmonic | AngleHarmonic], kind: str, example: str) -> Table:
    written = QUANTITY_KINDS[kind].written_example
    amplitude = replace(fields_of(harmonic)["amplitude"], kinds=(kind,), meaning=f"the amplitude, as {written}")
    fields = fields_of(harmonic) | {"amplitude": amplitude}
    return Table.of(harmonic, fields=fields, example=f"{{ amplitude = {written}, {example} }}")


def parse_harmonics(table: Table, value: object, path: str = KEY) -> tuple[Any, ...]:
    """Return the harmonics of a list of tables."""
    return parse_table_list(table, value, "harmonic", path)


@dataclass(frozen=True, kw_only=True)
class WrittenFunction:
    """A function of a reading as it is written; its units depend on the load."""

    reading: str = entry("label", meaning='the name of the reading, as "sleeve_lift"')
    table: Any = entry("any", default=None, meaning="a list of [reading, value], with straight lines between the points")
    gain: Any = entry("any", default=None, meaning='the value per unit of the reading, as "200 N m/m"')
    about: Any = entry("any", default=0.0, meaning="the reading at which a gain gives zero")
    harmonics: Any = entry("any", default=None, meaning="a list of { amplitude, order, phase }: sines of an angle")
    lag: float = optional_size("time", meaning="the time constant of a first-order lag")

    def build(self, load_kind: str) -> ReadingFunction:
        """Return the function; its values are of the kind of the load."""
        common: dict[str, Any] = {"reading": self.reading, "lag": self.lag}
        if self.harmonics is not None:
            harmonics = parse_harmonics(angle_harmonic_table(load_kind), self.harmonics, f"{KEY}.harmonics")
            return HarmonicFunction(harmonics=harmonics, quantity="angle", **common)
        if self.table is not None:
            path, names = f"{KEY}.table", ("reading", "value")
            fitting = quantities.parse_first_fitting(
                READING_KINDS, lambda kind: quantities.parse_points(self.table, (kind, load_kind), names, path)
            )
            kind, (positions, values) = fitting
            if len(positions) < 2:
                raise mistake(ProblemCode.WRONG_TYPE, f"{path} needs two points or more; found {len(positions)}")
            has_unit = any(isinstance(point[0], str) for point in self.table)
            return TableFunction(positions=positions, values=values, quantity=kind if has_unit else "", **common)
        # The kind whose SI unit is written comes first: pint, which tells the others that they do not fit, is slow to import.
        unlike = {kind: not str(self.gain).endswith(f" {QUANTITY_KINDS[GAIN_KINDS[load_kind][kind]].si_unit}") for kind in READING_KINDS}
        kind, (gain, about) = quantities.parse_first_fitting(
            sorted(READING_KINDS, key=unlike.__getitem__),
            lambda kind: (
                quantities.parse_si(self.gain, GAIN_KINDS[load_kind][kind], f"{KEY}.gain"),
                quantities.parse_si(self.about, kind, f"{KEY}.about"),
            ),
        )
        has_unit = isinstance(self.gain, str) or isinstance(self.about, str)
        return LinearFunction(gain=gain, about=about, quantity=kind if has_unit else "", **common)


_FUNCTION_EXAMPLE: Final = '{ reading = "sleeve_lift", gain = "200 N m/m", about = "20 mm" }'


def _find_function_conflicts(values: Mapping[str, Any], context: object) -> Iterator[str]:
    """Yield a missing function, or more than one."""
    given = [key for key in FUNCTION_KEYS if key in values]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        yield f"{KEY} needs one of {', '.join(FUNCTION_KEYS)}; found {found}; write {_FUNCTION_EXAMPLE}"
    elif "about" in values and given != ["gain"]:
        yield Problem(f"{KEY}.about belongs to a gain; leave it out", ProblemCode.CONFLICT, f"{KEY}.about")


READING_FUNCTION: Final = Table.of(WrittenFunction, example=_FUNCTION_EXAMPLE, find_conflicts=_find_function_conflicts)
"""A function of a reading."""

_TIME_HARMONICS = Table(
    make=dict,
    fields={"harmonics": declare("any", meaning="a list of { amplitude, frequency, phase }: sines of the time")},
    example='{ harmonics = [{ amplitude = "2 N m", frequency = "2 Hz" }] }',
)
"""Harmonics of the time, a sum of amplitude * sin(2 pi * frequency * t + phase)."""


def or_load(schema: quantities.JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a value, a list of [time, value], harmonics, a function, or a list of these."""
    function = {"type": "object", "anyOf": [{"required": ["reading"]}, {"required": ["harmonics"]}]}
    return {"anyOf": [schema, function, {"type": "array", "minItems": 1}]}


def _read_load(declared: Declaration, value: object, context: object) -> InputFunction:
    """Return a load as a function, also where it is constant."""
    return parse_load(value, declared.kind, declared.noun or declared.kind, declared.sign, declared.reason)


def _read_number_or_load(declared: Declaration, value: object, context: object) -> float | InputFunction:
    """Return a quantity in SI, or the function of one that changes with time and readings."""
    if isinstance(value, list | tuple | Mapping):
        return parse_load(value, declared.kind, declared.noun)
    return quantities.parse_si(value, declared.kind, sign=declared.sign)


def _load_schema(declared: Declaration) -> quantities.JsonSchema:
    return or_load(quantities.quantity_schema(declared.kind, declared.sign))


LOAD_TYPES: Final[Mapping[str, quantities.ValueType]] = {
    **quantities.VALUE_TYPES,
    "load": quantities.ValueType(_read_load, _load_schema),
    "number or load": quantities.ValueType(_read_number_or_load, _load_schema),
}
"""How values are written, loads too."""


def parse_load(
    value: Any,
    kind: str,
    name: str,
    sign: str = "any",  # key of quantities.SIGNS, for a load that depends on time alone
    reason: str = "",  # reason for the sign, at the end of the requirement
) -> InputFunction:
    """Return a load: a quantity, a list of [time, quantity], harmonics, a function of a reading, or a list of these, which is their sum."""
    load = _parse_terms(value, kind, name)
    has_sign, requirement = quantities.SIGNS[sign]
    is_points = isinstance(value, list | tuple) and not any(isinstance(item, Mapping) for item in value)
    for i, number in enumerate(load.values if is_points else ()):
        if not has_sign(number):
            raise wrong_value(value[i][1], f"{requirement}{reason}", code=ProblemCode.OUT_OF_RANGE, path=f"{KEY}, point {i + 1}:")
    if not (load.depends_on_readings or all(map(has_sign, load.range_in_time))):
        found = f"it goes down to {load.range_in_time[0]:g}"
        raise wrong_value(value, f"{requirement}{reason}", f": {found}" if load.harmonics else "", code=ProblemCode.OUT_OF_RANGE)
    return load


def _parse_terms(value: Any, kind: str, name: str) -> InputFunction:
    """Return a load of any sign."""
    if isinstance(value, Mapping):
        if "reading" not in value and "harmonics" in value:
            given = _TIME_HARMONICS.read(value)["harmonics"]
            return InputFunction(harmonics=parse_harmonics(harmonic_table(kind), given, f"{KEY}.harmonics"))
        return InputFunction(functions=(READING_FUNCTION.build(value).build(kind),))
    is_list = isinstance(value, list | tuple)
    if is_list and any(isinstance(item, Mapping) for item in value):
        return _add_up(parse_each(lambda item: _parse_terms(item, kind, name), value))
    times, values = quantities.parse_time_points(value, kind, name)
    return InputFunction(times=times, values=values)


def _add_up(loads: Sequence[InputFunction]) -> InputFunction:
    """Return the sum of loads, of which at most one varies with time."""
    varying = [load for load in loads if len(load.values) > 1]
    if len(varying) > 1:
        text = f"{KEY} is a sum of {len(varying)} lists of [time, value]; add them up to one, and list it with the functions of readings"
        raise mistake(ProblemCode.CONFLICT, text)
    constant = sum(load.values[0] for load in loads if len(load.values) == 1)
    base = varying[0] if varying else InputFunction()
    functions = tuple(function for load in loads for function in load.functions)
    harmonics = tuple(harmonic for load in loads for harmonic in load.harmonics)
    values = tuple(value + constant for value in base.values)
    return InputFunction(times=base.times, values=values, harmonics=harmonics, functions=functions)


_TYPE: Final = {"type": declare("any", default="", meaning="gear, follow or control")}
_ENDS: Final = 'first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0'


def _coupling_table(coupling: type[RatioCoupling], name: str, summary: str) -> Table:
    """Return the table of a coupling of two angles."""
    example = f'{{ type = "{name}", {_ENDS} }}'
    return Table.of(coupling, fields=_TYPE | fields_of(coupling), example=example, summary=summary)


_CONTROL_FIELDS: Final = {
    **_TYPE,
    "reading": declare("label", meaning='the reading that is followed, as "governor.sleeve_lift"'),
    "sets": declare("label", default="", meaning='the load to which the function is added, as "engine.torque"; or scales'),
    "scales": declare("label", default="", meaning="the load that is multiplied by the function; or sets"),
    **{key: fields_of(WrittenFunction)[key] for key in ("table", "gain", "about")},
    "lag": replace(fields_of(WrittenFunction)["lag"], form="any"),
}
_CONTROL_EXAMPLE: Final = (
    '{ type = "control", reading = "governor.sleeve_lift", sets = "engine.torque", gain = "-200 N m/m", about = "20 mm" }'
)


def _find_control_conflicts(values: Mapping[str, Any], context: object) -> Iterator[str]:
    """Yield a control of no load, or of two."""
    if ("sets" in values) == ("scales" in values):
        text = f"{KEY} needs one of sets (the load to add the function to) and scales (the load to multiply by it)"
        yield f"{text}; write {_CONTROL_EXAMPLE}"


def _make_control(*, name: str, sets: str = "", scales: str = "", **given: Any) -> ControlCoupling:
    """Return the coupling from the values of its table."""
    target = scales or sets
    # Of functions without units the first kind fits, and of wrong ones that one is what the message expects.
    is_ratio = target.rpartition(".")[2] in RATIO_LOADS
    kinds = ("ratio",) if scales else ("ratio", "torque", "force") if is_ratio else ("torque", "force", "ratio")
    kind, function = quantities.parse_first_fitting(kinds, lambda kind: READING_FUNCTION.build(given).build(kind))
    values = [given["gain"]] if given.get("gain") is not None else [one for row in given.get("table") or () for one in row[1:]]
    quantity_name = kind if any(isinstance(value, str) for value in values) else ""
    return ControlCoupling(name=name, function=function, target=target, scales=bool(scales), quantity=quantity_name)


LOAD: Final = Table.of(
    LoadCoupling,
    types=LOAD_TYPES,
    example='{ angle = "engine.crank_angle", rated_torque = "700 N m", fraction = [[0, 1.0], [5, 1.0], [5, 0.5]] }',
)
"""[load]: what resists the shaft of an engine."""

COUPLING_TABLES: Final[Mapping[str, Table]] = {
    "gear": _coupling_table(GearCoupling, "gear", "A gear or belt between two angles."),
    "follow": _coupling_table(FollowCoupling, "follow", "A spindle that follows an angle without reaction."),
    "control": Table(
        make=_make_control,
        fields=_CONTROL_FIELDS,
        summary="A load that follows a reading.",
        example=_CONTROL_EXAMPLE,
        find_conflicts=_find_control_conflicts,
    ),
}
"""Tables of couplings by their type."""


def parse_coupling(name: str, values: object) -> Coupling:
    """Return a coupling from its table."""
    kind = values.get("type") if isinstance(values, Mapping) else "gear"
    if not isinstance(kind, str) or kind not in COUPLING_TABLES:
        found = f"{format_value(kind)} is unknown" if kind is not None else "is missing"
        raise unknown_name(f"{KEY}.type {found}; types are", kind, COUPLING_TABLES)
    coupling: Coupling = COUPLING_TABLES[kind].build(values, name=name)
    return coupling

"""Loads and couplings of a scene file. Slow to import: pydantic.

A load is a constant, a function of time, harmonics, a function of a reading, or a sum of these; a coupling of type control adds to one.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Final, TypeAlias

from pydantic import Field, PlainValidator

from governor_mechanism.model.coupling.couplings import ControlCoupling, Coupling, FollowCoupling, GearCoupling, LoadCoupling, RatioCoupling
from governor_mechanism.model.time_functions import (
    Harmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    ReadingFunction,
    TableFunction,
)
from governor_mechanism.scenes.harmonics import angle_harmonic_table, harmonic_table, parse_table_list
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, mistake, parse_each, unknown_name, wrong_value
from governor_mechanism.scenes.quantities import (
    SIGNS,
    Label,
    built,
    parse_first_fitting,
    parse_points,
    parse_si,
    parse_time_points,
    quantity,
)
from governor_mechanism.scenes.schema_validator import SchemaValidator, or_load, quantity_schema
from governor_mechanism.scenes.table import SceneFileTable, SceneFileTables, validate
from governor_mechanism.units.quantities import format_value

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


class TimeHarmonicsTable(SceneFileTable):
    """Harmonics of the time, a sum of amplitude * sin(2 pi * frequency * t + phase)."""

    example = '{ harmonics = [{ amplitude = "2 N m", frequency = "2 Hz" }] }'

    harmonics: Any = Field(description="a list of { amplitude, frequency, phase }: sines of the time")

    def build(self, load_kind: str) -> tuple[Harmonic, ...]:
        """Return the harmonics; their amplitudes are of the kind of the load."""
        tables = parse_table_list(harmonic_table(load_kind), self.harmonics, "harmonic", f"{KEY}.harmonics")
        return tuple(table.make_element() for table in tables)


class ReadingFunctionTable(SceneFileTable):
    """A function of a reading."""

    example = '{ reading = "sleeve_lift", gain = "200 N m/m", about = "20 mm" }'

    reading: Label = Field(description='the name of the reading, as "sleeve_lift"')
    table: Any = Field(None, description="a list of [reading, value], with straight lines between the points")
    gain: Any = Field(None, description='the value per unit of the reading, as "200 N m/m"')
    about: Any = Field(0.0, description="the reading at which a gain gives zero")
    harmonics: Any = Field(None, description="a list of { amplitude, order, phase }: sines of an angle")
    lag: Annotated[float, built("time", "not negative")] = Field(0.0, description="the time constant of a first-order lag")

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield a missing function, or more than one."""
        given = [key for key in FUNCTION_KEYS if key in values]
        if len(given) != 1:
            yield f"{KEY} needs one of {', '.join(FUNCTION_KEYS)}; found {' and '.join(given) or 'none'}; write {cls.example}"
        elif "about" in values and given != ["gain"]:
            yield Problem(f"{KEY}.about belongs to a gain; leave it out", ProblemCode.CONFLICT, f"{KEY}.about")

    def build(self, load_kind: str) -> ReadingFunction:
        """Return the function; its values are of the kind of the load."""
        if self.harmonics is not None:
            tables = parse_table_list(angle_harmonic_table(load_kind), self.harmonics, "harmonic", f"{KEY}.harmonics")
            harmonics = tuple(table.make_element() for table in tables)
            return HarmonicFunction(reading=self.reading, lag=self.lag, harmonics=harmonics, quantity="angle")
        if self.table is not None:
            path, names = f"{KEY}.table", ("reading", "value")
            fitting = parse_first_fitting(READING_KINDS, lambda kind: parse_points(self.table, (kind, load_kind), names, path))
            kind, (positions, values) = fitting
            if len(positions) < 2:
                raise mistake(ProblemCode.WRONG_TYPE, f"{path} needs two points or more; found {len(positions)}")
            has_unit = any(isinstance(point[0], str) for point in self.table)
            return TableFunction(reading=self.reading, lag=self.lag, positions=positions, values=values, quantity=kind if has_unit else "")
        kind, (gain, about) = parse_first_fitting(
            READING_KINDS,
            lambda kind: (parse_si(self.gain, GAIN_KINDS[load_kind][kind], f"{KEY}.gain"), parse_si(self.about, kind, f"{KEY}.about")),
        )
        has_unit = isinstance(self.gain, str) or isinstance(self.about, str)
        return LinearFunction(reading=self.reading, lag=self.lag, gain=gain, about=about, quantity=kind if has_unit else "")


def input_function(kind: str, name: str) -> PlainValidator:
    """Return the validator of a load, see `parse_load`."""
    return SchemaValidator(lambda value: parse_load(value, kind, name), json_schema=or_load(quantity_schema(kind)))


def parse_load(value: Any, kind: str, name: str, sign: str = "any", reason: str = "") -> InputFunction:
    """Return a load: a quantity, a list of [time, quantity], harmonics, a function of a reading, or a list of these, which is their sum.

    Parameters
    ----------
    value
        Value as read from TOML.
    kind
        Kind of the load: "torque" or "force".
    name
        Name of the load in messages.
    sign
        Key of SIGNS, for a load that depends on time alone.
    reason
        Reason for the sign, at the end of the requirement.

    Returns
    -------
    InputFunction
        The load.

    Raises
    ------
    MechanismError
        With the problems of the value.
    """
    load = _parse_terms(value, kind, name)
    has_sign, requirement = SIGNS[sign]
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
            return InputFunction(harmonics=validate(TimeHarmonicsTable, value).build(kind))
        return InputFunction(functions=(validate(ReadingFunctionTable, value).build(kind),))
    is_list = isinstance(value, list | tuple)
    if is_list and any(isinstance(item, Mapping) for item in value):
        return _add_up(parse_each(lambda item: _parse_terms(item, kind, name), value))
    times, values = parse_time_points(value, kind, name)
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


RatioCouplingClass: TypeAlias = type[RatioCoupling]
"""Named here, because `type` is a key of the tables below, and Python 3.14 reads annotations within the class."""


class FollowTable(SceneFileTable):
    """A spindle that follows an angle without reaction."""

    element: ClassVar[RatioCouplingClass] = FollowCoupling
    example = '{ type = "follow", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    type: str = Field("", description="gear, follow or control")
    first: Label = Field(description='the angle that is followed, as "engine.crank_angle"')
    second: Label = Field(description='the angle of the spindle that follows, as "governor.spindle_angle"')
    ratio: Annotated[float, built("number", "not zero")] = Field(1.0, description="the speed of the second angle relative to the first")


class GearTable(FollowTable):
    """A gear or belt between two angles."""

    element = GearCoupling
    example = '{ type = "gear", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    first: Label = Field(description='the first angle, as "engine.crank_angle"')
    second: Label = Field(description='the second angle, as "governor.spindle_angle"')
    until: Annotated[float | None, quantity("time", "not negative")] = Field(
        None, description="the time at which the gear lets go; it holds for good by default"
    )


class ControlTable(SceneFileTable):
    """A load that follows a reading."""

    example = '{ type = "control", reading = "governor.sleeve_lift", sets = "engine.torque", gain = "-200 N m/m", about = "20 mm" }'

    type: str = Field("", description="gear, follow or control")
    reading: Label = Field(description='the reading that is followed, as "governor.sleeve_lift"')
    sets: Label = Field("", description='the load to which the function is added, as "engine.torque"; or scales')
    scales: Label = Field("", description="the load that is multiplied by the function; or sets")
    table: Any = Field(None, description="a list of [reading, value], with straight lines between the points")
    gain: Any = Field(None, description='the value per unit of the reading, as "200 N m/m"')
    about: Any = Field(0.0, description="the reading at which a gain gives zero")
    lag: Any = Field(0.0, description="the time constant of a first-order lag")

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield a control of no load, or of two."""
        if ("sets" in values) == ("scales" in values):
            text = f"{KEY} needs one of sets (the load to add the function to) and scales (the load to multiply by it)"
            yield f"{text}; write {cls.example}"

    def make_element(self, **arguments: Any) -> Coupling:
        """Return the coupling."""
        given = {key: value for key, value in self.given_values().items() if key in ("reading", "about", "lag", *FUNCTION_KEYS)}
        target = self.scales or self.sets
        # Of functions without units the first kind fits, and of wrong ones that one is what the message expects.
        is_ratio = target.rpartition(".")[2] in RATIO_LOADS
        kinds = ("ratio",) if self.scales else ("ratio", "torque", "force") if is_ratio else ("torque", "force", "ratio")
        kind, function = parse_first_fitting(kinds, lambda kind: validate(ReadingFunctionTable, given).build(kind))
        values = [self.gain] if self.gain is not None else [value for row in self.table or () for value in row[1:]]
        quantity_name = kind if any(isinstance(value, str) for value in values) else ""
        return ControlCoupling(function=function, target=target, scales=bool(self.scales), quantity=quantity_name, **arguments)


def _parse_fraction(value: Any) -> InputFunction:
    return parse_load(value, "ratio", "fraction", "not negative", ": a load resists")


class LoadTable(SceneFileTable):
    """[load]: what resists the shaft of an engine."""

    element = LoadCoupling
    example = '{ angle = "engine.crank_angle", rated_torque = "700 N m", fraction = [[0, 1.0], [5, 1.0], [5, 0.5]] }'

    angle: Label = Field(description='the angle of the shaft, as "engine.crank_angle"')
    rated_torque: Annotated[float, quantity("torque", "positive")] = Field(description='the torque at full load, as "700 N m"')
    fraction: Annotated[Any, SchemaValidator(_parse_fraction, json_schema=or_load(quantity_schema("ratio", "not negative")))] = Field(
        None, description="the share of the rated torque, over time or as a function of a reading; full load by default"
    )


COUPLING_TABLES: SceneFileTables = {"gear": GearTable, "follow": FollowTable, "control": ControlTable}
"""Tables of couplings by their type."""


def parse_coupling(name: str, values: object) -> Coupling:
    """Return a coupling from its table."""
    kind = values.get("type") if isinstance(values, Mapping) else "gear"
    if not isinstance(kind, str) or kind not in COUPLING_TABLES:
        found = f"{format_value(kind)} is unknown" if kind is not None else "is missing"
        raise unknown_name(f"{KEY}.type {found}; types are", kind, COUPLING_TABLES)
    coupling: Coupling = validate(COUPLING_TABLES[kind], values).make_element(name=name)
    return coupling

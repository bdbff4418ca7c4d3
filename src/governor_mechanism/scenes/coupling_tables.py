"""[coupling.NAME] of a scene file with several parts. Slow to import: pydantic."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field, PlainValidator, TypeAdapter

from governor_mechanism.errors import did_you_mean
from governor_mechanism.model.coupling.couplings import ControlCoupling, Coupling, FollowCoupling, GearCoupling, RatioCoupling
from governor_mechanism.scenes.loads import FUNCTION_KEYS, parse_reading_function
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import check_label, parse_first_fitting, quantity
from governor_mechanism.scenes.table import SceneFileTable, nearest_type, union_by_key, validate
from governor_mechanism.units.quantities import format_value

AngleName = Annotated[str, PlainValidator(check_label)]
"""Name of an angle of a part."""


class CouplingTable(SceneFileTable):
    """[coupling.NAME] of any type."""

    type: str = ""

    def build(self, name: str) -> Coupling:
        """Return the coupling."""
        raise NotImplementedError


class FollowTable(CouplingTable):
    """A spindle that follows an angle without reaction."""

    coupling: ClassVar[type[RatioCoupling]] = FollowCoupling
    example = '{ type = "follow", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    first: AngleName = Field(description='the angle that is followed, as "engine.crank_angle"')
    second: AngleName = Field(description='the angle of the spindle that follows, as "governor.spindle_angle"')
    ratio: Annotated[float, quantity("number", "not zero")] = 1.0

    def build(self, name: str) -> Coupling:
        """Return the coupling."""
        return self.coupling(name=name, **{key: value for key, value in self.given_values().items() if key != "type"})


class GearTable(FollowTable):
    """A gear or belt between two angles."""

    coupling = GearCoupling
    example = '{ type = "gear", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    first: AngleName = Field(description='the first angle, as "engine.crank_angle"')
    second: AngleName = Field(description='the second angle, as "governor.spindle_angle"')
    until: Annotated[float | None, quantity("time", "not negative")] = None


class ControlTable(CouplingTable):
    """A load that follows a reading."""

    example = '{ type = "control", reading = "governor.sleeve_lift", sets = "engine.torque", gain = "-200 N m/m", about = "20 mm" }'

    reading: AngleName = Field(description='the reading that is followed, as "governor.sleeve_lift"')
    sets: AngleName | None = None
    scales: AngleName | None = None
    table: Any = None
    gain: Any = None
    about: Any = 0.0
    lag: Any = 0.0

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[Problem]:
        """Yield a control of no load, or of two."""
        if ("sets" in values) == ("scales" in values):
            text = f"{KEY} needs one of sets (the load to add the function to) and scales (the load to multiply by it)"
            yield Problem(f"{text}; write {cls.example}", ProblemCode.CONFLICT)

    def build(self, name: str) -> Coupling:
        """Return the coupling."""
        given = {key: value for key, value in self.given_values().items() if key in ("reading", "about", "lag", *FUNCTION_KEYS)}
        kinds = ("ratio",) if self.scales else ("torque", "force")
        _, function = parse_first_fitting(kinds, lambda kind: parse_reading_function(given, kind))
        return ControlCoupling(name=name, function=function, target=self.scales or self.sets or "", scales=bool(self.scales))


COUPLING_TABLES: Final[Mapping[str, type[CouplingTable]]] = {"gear": GearTable, "follow": FollowTable, "control": ControlTable}
"""Tables of couplings by their type."""

COUPLING: Final[TypeAdapter[CouplingTable]] = union_by_key(COUPLING_TABLES, lambda values, types: nearest_type(values, types) or "gear")
"""[coupling.NAME] of any type."""


def parse_couplings(table: object, collector: ProblemCollector) -> tuple[Coupling, ...]:
    """Return the couplings of a scene file.

    Parameters
    ----------
    table
        Tables by name.
    collector
        Takes the problems.

    Returns
    -------
    tuple[Coupling, ...]
        The couplings without mistakes.
    """
    return tuple(collector.parse_tables("coupling", table, _parse_coupling))


def _parse_coupling(name: str, values: object) -> Coupling:
    kind = values.get("type") if isinstance(values, Mapping) else None
    if isinstance(values, Mapping) and kind not in list(COUPLING_TABLES):
        suggestion = did_you_mean(kind, list(COUPLING_TABLES)) if isinstance(kind, str) else ""
        found = f"{format_value(kind)} is unknown" if kind is not None else "is missing"
        raise mistake(ProblemCode.UNKNOWN_NAME, f"{KEY}.type {found}; types are {', '.join(COUPLING_TABLES)}.{suggestion}")
    return validate(COUPLING, values).build(name)

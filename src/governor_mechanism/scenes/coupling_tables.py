"""[coupling.NAME] of a scene file with several parts. Slow to import: pydantic."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from governor_mechanism.errors import did_you_mean
from governor_mechanism.model.coupling.couplings import ControlCoupling, Coupling, FollowCoupling, GearCoupling, RatioCoupling
from governor_mechanism.scenes.loads import FUNCTION_KEYS, parse_reading_function
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, mistake
from governor_mechanism.scenes.quantities import Label, parse_first_fitting, quantity
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value


class FollowTable(SceneFileTable):
    """A spindle that follows an angle without reaction."""

    element: ClassVar[type[RatioCoupling]] = FollowCoupling
    example = '{ type = "follow", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    type: str = ""
    first: Label = Field(description='the angle that is followed, as "engine.crank_angle"')
    second: Label = Field(description='the angle of the spindle that follows, as "governor.spindle_angle"')
    ratio: Annotated[float, quantity("number", "not zero")] = 1.0


class GearTable(FollowTable):
    """A gear or belt between two angles."""

    element = GearCoupling
    example = '{ type = "gear", first = "engine.crank_angle", second = "governor.spindle_angle", ratio = 2.0 }'

    first: Label = Field(description='the first angle, as "engine.crank_angle"')
    second: Label = Field(description='the second angle, as "governor.spindle_angle"')
    until: Annotated[float | None, quantity("time", "not negative")] = None


class ControlTable(SceneFileTable):
    """A load that follows a reading."""

    example = '{ type = "control", reading = "governor.sleeve_lift", sets = "engine.torque", gain = "-200 N m/m", about = "20 mm" }'

    type: str = ""
    reading: Label = Field(description='the reading that is followed, as "governor.sleeve_lift"')
    sets: Label = ""
    scales: Label = ""
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

    def make_element(self, **arguments: Any) -> Coupling:
        """Return the coupling."""
        given = {key: value for key, value in self.given_values().items() if key in ("reading", "about", "lag", *FUNCTION_KEYS)}
        kinds = ("ratio",) if self.scales else ("torque", "force")
        _, function = parse_first_fitting(kinds, lambda kind: parse_reading_function(given, kind))
        return ControlCoupling(function=function, target=self.scales or self.sets, scales=bool(self.scales), **arguments)


COUPLING_TABLES: Final[Mapping[str, type[SceneFileTable]]] = {"gear": GearTable, "follow": FollowTable, "control": ControlTable}
"""Tables of couplings by their type."""


def parse_coupling(name: str, values: object) -> Coupling:
    """Return a coupling from its table."""
    kind = values.get("type") if isinstance(values, Mapping) else "gear"
    if not isinstance(kind, str) or kind not in COUPLING_TABLES:
        suggestion = did_you_mean(kind, list(COUPLING_TABLES)) if isinstance(kind, str) else ""
        found = f"{format_value(kind)} is unknown" if kind is not None else "is missing"
        raise mistake(ProblemCode.UNKNOWN_NAME, f"{KEY}.type {found}; types are {', '.join(COUPLING_TABLES)}.{suggestion}")
    coupling: Coupling = validate(COUPLING_TABLES[kind], values).make_element(name=name)
    return coupling

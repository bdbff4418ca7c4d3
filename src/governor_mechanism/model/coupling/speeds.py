"""Speeds of shafts and spindles as readings: rates of angles of the coupled mechanism. No mathematics."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.coupling.coupled_system import SPINDLE_SPEED, CoupledSystem
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.output_variables import BodyAngle, ShaftSpeed

GIVEN_SPEED_CLAUSE: Final = (
    "a speed that is given: when it passes a value is known before the run; watch the speed of a free or geared spindle, or another reading"
)
"""End of the sentence about a crossing of a given speed."""


@dataclass(frozen=True, kw_only=True)
class AngleRate:
    """A speed as a multiple of the rate of an angle.

    Attributes
    ----------
    angle
        Reading of the angle.
    ratio
        Ratio of the speed to the rate of the angle; not 1 for a spindle that follows another shaft.
    """

    angle: str
    ratio: float = 1.0


def find_speeds(system: CoupledSystem) -> dict[str, AngleRate]:
    """Return of what the speeds of shafts and spindles are the rates, by name, but for speeds that are given."""
    mechanism = system.mechanism
    speeds = {one.name: AngleRate(angle=one.reading) for one in mechanism.derived_readings if isinstance(one, ShaftSpeed)}
    angles = {one.body: one.name for one in mechanism.readings if isinstance(one, BodyAngle) and one.reference_body == GROUND}
    spindles = {plane.prefix: plane for plane in system.planes if plane.shaft in angles}
    return speeds | {
        f"{prefix}{SPINDLE_SPEED}": AngleRate(angle=angles[plane.shaft], ratio=plane.ratio) for prefix, plane in spindles.items()
    }


def check_crossings(system: CoupledSystem, crossings: Sequence[NamedCrossing]) -> None:
    """Raise MechanismError for a crossing of what is no reading, or of a speed that is given."""
    speeds, readings = find_speeds(system), [reading.name for reading in system.mechanism.readings]
    outputs = [*readings, *(output.name for output in system.mechanism.internal_outputs), *speeds]
    given_speeds = {f"{plane.prefix}{SPINDLE_SPEED}" for plane in system.planes} - set(speeds)
    problems = []
    for crossing in crossings:
        what, name, known = f"crossing {crossing.name!r}", crossing.reading, [*readings, *speeds]
        if name in given_speeds:
            problems.append(f"{what} watches {name!r}, {GIVEN_SPEED_CLAUSE}")
        elif name not in outputs:
            problems.append(f"{what}: no reading {name!r}; readings are {known}.{did_you_mean(name, known)}")
    if problems:
        raise MechanismError(*problems)

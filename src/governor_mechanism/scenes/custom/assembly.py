"""The key `assembly` of a custom machine: which of the ways in which its joints close is taken."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, NoReturn

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import Part, Start
from governor_mechanism.observables.assemblies.blocks import hold_needed_angles, hold_values
from governor_mechanism.observables.assemblies.enumeration import ClosedConfigurations, enumerate_configurations
from governor_mechanism.scenes.quantities import VALUE_TYPES, ValueType, without_context
from governor_mechanism.scenes.table import Table
from governor_mechanism.units.fields import entry
from governor_mechanism.units.problems import wrong_value
from governor_mechanism.units.quantities import format_quantity

HIGHEST: Final = "highest"
NEAREST: Final = "nearest"
"""Words that choose an assembly, beside its number."""

AS_WRITTEN_TOLERANCE: Final = 1e-9
"""Difference of the chosen poses from the written ones, length scales and rad, below which these are kept as they are."""

Take = int | str
"""Number of an assembly, from 1, or one of the words."""


def parse_take(value: object) -> Take:
    """Return the number of an assembly or a word; refuse anything else."""
    is_number = isinstance(value, int) and not isinstance(value, bool) and value > 0
    if not is_number and value not in (HIGHEST, NEAREST):
        hint = f'a number from 1, "{HIGHEST}", or "{NEAREST}" to the given positions and angles'
        raise wrong_value(value, f"must be {hint}", "; the command assemblies lists them")
    return value  # type: ignore[return-value]


_TAKE_SCHEMA: Final[dict[str, Any]] = {"anyOf": [{"type": "integer", "minimum": 1}, {"enum": [HIGHEST, NEAREST]}]}


@dataclass(frozen=True, kw_only=True)
class WrittenAssembly:
    """The choice of an assembly, and the bodies whose angles are given where neither drives nor start values determine the mechanism."""

    take: Take = entry("take", meaning='the number of the assembly, "highest" or "nearest"')
    at: tuple[str, ...] = entry(
        "names", default=(), meaning="the bodies whose angles hold a free mechanism; by default the first of the file"
    )


ASSEMBLY: Final = Table.of(
    WrittenAssembly, types={"take": without_context(parse_take, _TAKE_SCHEMA), "names": VALUE_TYPES["names"]}, example="{ take = 2 }"
)
"""The key `assembly` as a table."""


def _parse_assembly(value: object) -> WrittenAssembly:
    if isinstance(value, Mapping):
        written: WrittenAssembly = ASSEMBLY.build(value)
        return written
    return WrittenAssembly(take=parse_take(value))


ASSEMBLY_TYPE: Final[ValueType] = without_context(_parse_assembly, {"anyOf": [*_TAKE_SCHEMA["anyOf"], ASSEMBLY.schema()]})
"""How the key is written: a number, a word, or a table."""


def hold_given_values(
    mechanism: Mechanism,
    start: Start,
    given_angles: Mapping[str, float],  # angles that the file writes, by body, rad
    at: tuple[str, ...] = (),
) -> tuple[Mechanism, list[str]]:
    """Return a mechanism that is held where drives, start values and given angles determine it, and in words what holds it."""
    words = [name for name, value in start.values.items() if isinstance(value, str)]
    if words:
        raise MechanismError(f"the assemblies at start.{words[0]} = {start.values[words[0]]!r} are not listed; give a number")
    values = {name: float(value) for name, value in start.values.items()}
    names = [body.name for body in mechanism.bodies]
    if unknown := next((name for name in at if name not in names), ""):
        raise MechanismError(
            f"assembly.at names the unknown body {unknown!r}; bodies are {', '.join(names)}.{did_you_mean(unknown, names)}"
        )
    angles = {body.name: pose[2] for body, pose in zip(mechanism.bodies, mechanism.initial_guess, strict=True) if body.can_rotate}
    order = [name for name in at or given_angles if name in angles]
    held, bodies = hold_needed_angles(hold_values(mechanism, values), [(name, angles[name]) for name in order])
    return held, [
        *(f"{name} = {format_quantity(value, _unit_of(mechanism, name))}" for name, value in values.items()),
        *(f"{name} at {format_quantity(angles[name], 'rad')}" for name in bodies),
    ]


def _unit_of(mechanism: Mechanism, name: str) -> str:
    return "rad" if mechanism.reading(name).quantity == "angle" else "m"


def take_assembly(mechanism: Mechanism, written: WrittenAssembly, start: Start, given_angles: Mapping[str, float]) -> Mechanism:
    """Return a mechanism whose initial configuration is the chosen assembly, with a note if a word and no number chose one of several."""
    held, held_by = hold_given_values(mechanism, start, given_angles, written.at)
    solver = PositionSolver(held)
    configurations = enumerate_configurations(solver)
    count = len(configurations.poses)
    if not count:
        explain_no_assembly(solver)
    index = choose_configuration(configurations, written.take, solver.initial_guess)
    notes = (
        *mechanism.notes,
        *([_note(configurations, index, written.take, held_by)] if isinstance(written.take, str) and count > 1 else []),
    )
    poses = configurations.poses[index]
    if np.max(np.abs(poses - solver.initial_guess) / solver.pose_scales) < AS_WRITTEN_TOLERANCE:
        return replace(mechanism, notes=notes)
    return replace(mechanism, notes=notes, initial_guess=tuple((x, y, angle) for x, y, angle in poses.tolist()))


def find_nearest_number(
    document: Mapping[str, Any],
    part: Part,
    start: Start,
    poses: Any,  # poses (bodies, 3) to which the assembly is nearest, m and rad
) -> int:
    """Return the number of the assembly of a scene that is nearest to some poses."""
    written = document.get("assembly")
    at = tuple(written.get("at", ())) if isinstance(written, Mapping) else ()
    held, _ = hold_given_values(part.mechanism, start, written_angles(document, part.mechanism), at)
    return enumerate_configurations(PositionSolver(held)).find_nearest(np.array(poses)) + 1


def written_angles(document: Mapping[str, Any], mechanism: Mechanism) -> dict[str, float]:
    """Return the initial angles of the bodies whose tables write them, by name, rad."""
    written = {table.get("name") for table in document.get("body", ()) if isinstance(table, Mapping) and "angle" in table}
    return {body.name: pose[2] for body, pose in zip(mechanism.bodies, mechanism.initial_guess, strict=True) if body.name in written}


def explain_no_assembly(solver: PositionSolver) -> NoReturn:
    """Raise MechanismError with the joint that stays open."""
    solver.solve({})
    raise MechanismError("the joints close in no way at the start; change a length or a given value")


def choose_configuration(configurations: ClosedConfigurations, take: Take, guess: Any) -> int:
    """Return the index of an assembly; raise MechanismError for a number above theirs."""
    count = len(configurations.poses)
    if isinstance(take, str):
        return configurations.find_highest() if take == HIGHEST else configurations.find_nearest(guess)
    if take > count:
        ways = "one way" if count == 1 else f"{count} ways"
        found = "" if configurations.complete else " that were found"
        raise MechanismError(f"there is no assembly {take} of {count}: the joints close in {ways}{found} at the start; give 1 to {count}")
    return take - 1


def _note(configurations: ClosedConfigurations, index: int, take: str, held_by: list[str]) -> str:
    """Return the sentence about several assemblies, of which a word chose one."""
    count = len(configurations.poses)
    at_least = "" if configurations.complete else "at least "
    reason = "the highest" if take == HIGHEST else "the nearest to what is given"
    where = f" with {' and '.join(held_by)}" if held_by else ""
    return (
        f"the joints close in {at_least}{count} ways{where}: assembly {index + 1}, {reason}, is taken; "
        f"assembly = 1 to {count} chooses another"
    )

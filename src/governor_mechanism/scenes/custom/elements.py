"""[[joint]], [[link]] and [[force]] of a custom machine."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from governor_mechanism.model import force_elements, joints
from governor_mechanism.model.joints import GROUND
from governor_mechanism.scenes.custom.field_types import CUSTOM_TYPES, PointRegistry
from governor_mechanism.scenes.table import Table
from governor_mechanism.units.fields import Declaration, declare, fields_of
from governor_mechanism.units.problems import Problem, ProblemCode, mistake
from governor_mechanism.units.quantities import format_value

_TYPED_JOINTS: Final = [joint for joint in joints.JOINTS if joint.type_name]

JOINT_TYPES: Final = tuple(joint.type_name for joint in _TYPED_JOINTS)
"""Types of [[joint]]."""

_FORCES: Final[Mapping[str, type[force_elements.ForceElement]]] = {
    "spring": force_elements.Spring,
    "damper": force_elements.Damper,
    "torsion_spring": force_elements.TorsionSpring,
    "torsion_damper": force_elements.TorsionDamper,
    "torque": force_elements.Torque,
    "force": force_elements.Force,
}
FORCE_TYPES: Final = tuple(_FORCES)
"""Types of [[force]]."""


@dataclass(frozen=True, kw_only=True)
class ElementTable(Table):
    """The table of a joint, link or force between two points or bodies, its `first` and `second` end.

    Attributes
    ----------
    one_body_message
        Message about two ends on the same body.
    """

    one_body_message: str = "both ends are of {body}; they must be of two different bodies"

    def read_ends(self, values: object, registry: PointRegistry) -> tuple[dict[str, Any], tuple[str, str]]:
        """Return the values of the keys that are given, and the names of the two bodies; refuse two ends on the same one."""
        given = self.read(values, registry)
        ends = given.get("first", GROUND), given["second" if "second" in given else "point"]
        first, second = (end if isinstance(end, str) else end.body for end in ends)
        if first == second:
            raise mistake(ProblemCode.CONFLICT, self.one_body_message.format(body=format_value(first)))
        return given, (first, second)

    def build(self, values: object, context: Any = None, **arguments: Any) -> Any:
        """Return the joint or force element, by default named after its type and its bodies."""
        given, (first, second) = self.read_ends(values, context)
        kind = given.pop("type", "link").replace("_", " ")
        names = f"{first.partition('.')[0]} and {second.partition('.')[0]}"
        name = given.pop("name", "") or context.reserve_name(f"{kind} of {names}")
        owner: Any = self.make
        if issubclass(owner, joints.Joint):
            defaults = {key: one.default for key, one in self.fields.items() if not one.is_required and not one.follows}
            initial_values = owner.initial_values(defaults | given, context.initial_configuration)
            return owner.create(**{**initial_values, **given, "name": name})
        return owner(**given, name=name)


_NAME: Final = {"name": declare("label", default="", meaning="the name in messages and results; by default the type and the two bodies")}
_POINTS: Final = {name: fields_of(force_elements.Spring)[name] for name in ("first", "second")}
_BODIES: Final = {
    "first": declare("point or body", meaning='the first body or a point of it, as "ground" or "crank.A"'),
    "second": declare("point or body", meaning='the second body or a point of it, as "crank" or "crank.A"'),
}


def _type_key(types: tuple[str, ...]) -> dict[str, Declaration]:
    return {"type": declare("choice", words=types, meaning=f"one of {', '.join(types)}")}


def _joint_table(joint: type[joints.Joint]) -> ElementTable:
    """Return the table of a type of joint; one without a type is a link."""

    def find_conflicts(values: Mapping[str, Any], registry: object) -> Iterator[str]:
        return joint.find_conflicts(values)

    ends = _BODIES if joint.joins_bodies else _POINTS
    fields = {**_NAME, **ends, **(_type_key(JOINT_TYPES) if joint.type_name else {}), **fields_of(joint), **joint.keys}
    return ElementTable(make=joint, fields=fields, types=CUSTOM_TYPES, find_conflicts=find_conflicts)


def _find_missing_component(values: Mapping[str, Any], registry: object) -> Iterator[str]:
    """Yield a force without components."""
    if "x" not in values and "y" not in values:
        yield Problem('x or y is missing; write x = "40 N" for a force along x', ProblemCode.MISSING_KEY)


def _force_table(force: type[force_elements.ForceElement]) -> ElementTable:
    """Return the table of a type of force; the first end of one at a point is the ground."""
    own_fields = fields_of(force)
    ends = _POINTS if own_fields.get("first") == _POINTS["first"] else {}
    table = ElementTable(make=force, fields=_NAME | ends | _type_key(FORCE_TYPES) | own_fields, types=CUSTOM_TYPES)
    if force is not force_elements.Force:
        return table
    message = "point must be of a moving body; a force on the ground has no effect"
    return replace(table, one_body_message=message, find_conflicts=_find_missing_component)


LINK: Final = _joint_table(joints.Distance)
"""[[link]]: a massless bar, by default as long as the initial distance of its ends."""

JOINT_TABLES: Final[Mapping[str, ElementTable]] = {joint.type_name: _joint_table(joint) for joint in _TYPED_JOINTS}
FORCE_TABLES: Final[Mapping[str, ElementTable]] = {name: _force_table(force) for name, force in _FORCES.items()}
"""Tables of [[joint]] and [[force]] by type."""

UNTYPED_JOINT: Final = ElementTable(
    make=joints.Joint, fields=_NAME | _POINTS | _type_key(JOINT_TYPES), types=CUSTOM_TYPES, unknown_key=None
)
UNTYPED_FORCE: Final = ElementTable(make=dict, fields=_NAME | _type_key(FORCE_TYPES), types=CUSTOM_TYPES, unknown_key=None)
"""Joint and force of unknown type; only the common keys are checked."""

"""[[joint]], [[link]] and [[force]] of a custom machine. Slow to import: pydantic."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field, create_model

from governor_mechanism.machines.custom import InitialConfiguration
from governor_mechanism.model import force_elements, joints
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.custom import field_types
from governor_mechanism.scenes.custom.field_types import PointRef, PointRegistry
from governor_mechanism.scenes.loads import input_function
from governor_mechanism.scenes.problems import Problem, ProblemCode, mistake
from governor_mechanism.scenes.quantities import Angle, Label, Length, PositiveLength, built, choice, quantity
from governor_mechanism.scenes.table import SceneFileTable
from governor_mechanism.units.quantities import format_value

_TYPED_JOINTS: Final = [joint for joint in joints.JOINTS if joint.type_name]

JOINT_TYPES: Final = tuple(joint.type_name for joint in _TYPED_JOINTS)
"""Types of [[joint]]."""

FORCE_TYPES: Final = ("spring", "damper", "torsion_spring", "torsion_damper", "torque", "force")
"""Types of [[force]]."""


class ElementTable(SceneFileTable):
    """A joint, link or force between two points or bodies, its `first` and `second` end."""

    one_body_message: ClassVar[str] = "both ends are of {body}; they must be of two different bodies"
    """Message about two ends on the same body."""

    name: Label = Field("", description="the name in messages and results; by default the type and the two bodies")

    @property
    def ends(self) -> tuple[Point | str, Point | str]:
        """The two points or bodies that are connected."""
        given = self.given_values()
        return given.get("first", GROUND), given["second"]

    def initial_values(self, initial: InitialConfiguration) -> Mapping[str, Any]:
        """Return the defaults that follow from the initial configuration, by argument."""
        return {}

    def require_two_bodies(self) -> tuple[str, str]:
        """Return the names of the two bodies; refuse two ends on the same one."""
        first, second = (end if isinstance(end, str) else end.body for end in self.ends)
        if first == second:
            raise mistake(ProblemCode.CONFLICT, self.one_body_message.format(body=format_value(first)))
        return first, second

    def build(self, registry: PointRegistry) -> Any:
        """Return the joint or force element, by default named after its type and its bodies."""
        first, second = self.require_two_bodies()
        kind = str(getattr(self, "type", "link")).replace("_", " ")
        name = self.name or registry.reserve_name(f"{kind} of {first.partition('.')[0]} and {second.partition('.')[0]}")
        return type(self).element(**{**self.initial_values(registry.initial_configuration), **self.given_values(), "name": name})


class _PointTable(ElementTable):
    first: PointRef = Field(description='the point of the first body, as "ground.O" or ["crank", "10 mm", 0]')
    second: PointRef = Field(description='the point of the second body, as "crank.origin" or ["crank", "10 mm", 0]')


class LinkTable(_PointTable):
    """[[link]]: a massless bar, by default as long as the initial distance of its ends."""

    element = joints.Distance
    length: PositiveLength = Field(0.0, description="the length; by default the initial distance of its ends")

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the distance of the ends."""
        distance = initial.distance(self.first, self.second)
        if not self.length and not distance:
            raise mistake(ProblemCode.MISSING_KEY, "length is missing, and the ends of the link coincide initially")
        return {"length": distance}


class JointTable(_PointTable):
    """A joint; the keys of each type are those of its class."""

    joint: ClassVar[type[joints.Joint]] = joints.Joint
    """The class of the joint."""

    type: Annotated[str, choice(JOINT_TYPES)] = Field(description=f"one of {', '.join(JOINT_TYPES)}")

    def initial_values(self, initial: InitialConfiguration) -> Mapping[str, Any]:
        """Return the defaults that follow from the initial configuration."""
        return self.joint.initial_values({name: getattr(self, name) for name in type(self).model_fields}, initial)

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield the problems of keys that exclude each other."""
        for text, is_missing in cls.joint.find_conflicts(values):
            yield Problem(text, ProblemCode.MISSING_KEY) if is_missing else text


class _BodyJointTable(JointTable):
    """A joint whose ends may be bodies without a point."""

    first: field_types.PointOrBodyRef = Field(description='the first body or a point of it, as "ground" or "crank.A"')
    second: field_types.PointOrBodyRef = Field(description='the second body or a point of it, as "crank" or "crank.A"')


_VALUE_TYPES: Final = {
    "curve": field_types.CurveValue,
    "angle motion": field_types.AngleMotion,
    "displacement motion": field_types.DisplacementMotion,
}
"""Types of the values of keys that are no quantities, by their kind."""


def _make_joint_table(joint: type[joints.Joint]) -> type[JointTable]:
    """Return the table of a type of joint, with its keys."""
    fields: dict[str, Any] = {}
    for key in joint.keys:
        value_type = _VALUE_TYPES.get(key.kind) or Annotated[float, quantity(key.kind, key.sign, bounded=key.is_built)]
        default = ... if key.is_required else None if key.kind in _VALUE_TYPES else 0.0
        alias = key.name if key.argument else None
        fields[key.argument or key.name] = value_type, Field(default, alias=alias, description=key.meaning)
    base = _BodyJointTable if joint.joins_bodies else JointTable
    table = create_model(f"{joint.__name__}Table", __base__=base, **fields)
    table.joint = joint
    table.element = joint.create
    return table


class ForceElementTable(ElementTable):
    """Common keys of all forces."""

    type: Annotated[str, choice(FORCE_TYPES)] = Field(description=f"one of {', '.join(FORCE_TYPES)}")


class SpringForceTable(ForceElementTable, _PointTable):
    """Type "spring"."""

    element = force_elements.Spring
    stiffness: Annotated[float, built("stiffness")] = Field(description='the stiffness, as "2 N/mm"')
    free_length: Length = Field(0.0, description="the length without force")


class DamperTable(ForceElementTable, _PointTable):
    """Type "damper"."""

    element = force_elements.Damper
    damping: Annotated[float, built("damping")] = Field(description='the damping, as "120 N s/m"')


class _TorsionTable(ForceElementTable):
    second: field_types.BodyRef = Field(description='the body on which it acts, as "crank"')
    first: field_types.BodyRef = Field(GROUND, description="the body on which the opposite torque acts")


class TorsionSpringForceTable(_TorsionTable):
    """Type "torsion_spring"."""

    element = force_elements.TorsionSpring
    stiffness: Annotated[float, built("torsion_stiffness")] = Field(description='the stiffness, as "3 N m/rad"')
    free_angle: Angle = Field(0.0, description="the relative angle without torque")


class TorsionDamperTable(_TorsionTable):
    """Type "torsion_damper"."""

    element = force_elements.TorsionDamper
    damping: Annotated[float, built("torsion_damping")] = Field(description='the damping, as "0.1 N m s/rad"')


class TorqueTable(ForceElementTable):
    """Type "torque"."""

    element = force_elements.Torque
    second: field_types.BodyRef = Field(alias="body", description='the body on which it acts, as "crank"')
    first: field_types.BodyRef = Field(GROUND, alias="against", description="the body on which the opposite torque acts")
    moment: Annotated[Any, input_function("torque", "moment")] = Field(
        description='the moment, as "5 N m", or over time, as [[0, "5 N m"], [2, "6 N m"]]'
    )


class ForceTable(ForceElementTable):
    """Type "force"; its first end is the ground."""

    element = partial(force_elements.Force, x=InputFunction(), y=InputFunction())
    one_body_message = "point must be of a moving body; a force on the ground has no effect"
    point: PointRef = Field(description='the point at which it acts, as "slider.centre"')
    x: Annotated[Any, input_function("force", "force")] = Field(None, description="the component along x")
    y: Annotated[Any, input_function("force", "force")] = Field(None, description="the component along y, upward")

    @property
    def ends(self) -> tuple[Point | str, Point | str]:
        """The ground and the point."""
        return GROUND, self.point

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield a force without components."""
        if "x" not in values and "y" not in values:
            yield Problem('x or y is missing; write x = "40 N" for a force along x', ProblemCode.MISSING_KEY)


class UntypedJointTable(JointTable, extra="ignore"):
    """A joint of unknown type; only the common keys are checked."""


class UntypedForceTable(ForceElementTable, extra="ignore"):
    """A force of unknown type; only the common keys are checked."""


_FORCES = (SpringForceTable, DamperTable, TorsionSpringForceTable, TorsionDamperTable, TorqueTable, ForceTable)

ElementTables = Mapping[str, type[ElementTable]]
JOINT_TABLES: ElementTables = {"": UntypedJointTable} | {joint.type_name: _make_joint_table(joint) for joint in _TYPED_JOINTS}
FORCE_TABLES: ElementTables = dict(zip(("", *FORCE_TYPES), (UntypedForceTable, *_FORCES), strict=True))
"""Tables of [[joint]] and [[force]] by type."""

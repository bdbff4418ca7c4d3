"""[[joint]], [[link]] and [[force]] of a custom machine. Slow to import: pydantic."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from governor_mechanism.machines.custom import InitialConfiguration
from governor_mechanism.model import force_elements, joints
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.scenes.custom import field_types
from governor_mechanism.scenes.custom.field_types import CurveValue, PointRef, PointRegistry
from governor_mechanism.scenes.loads import input_function
from governor_mechanism.scenes.problems import Problem, ProblemCode, mistake
from governor_mechanism.scenes.quantities import Angle, Label, Length, PositiveLength, built, choice, quantity
from governor_mechanism.scenes.table import SceneFileTable
from governor_mechanism.units.quantities import format_value

JOINT_TYPES: Final = ("pin", "weld", "prismatic", "slider", "arc", "curve", "gear", "rack", "driven_turn", "driven_slide")
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

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
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
        return type(self).element(**self.initial_values(registry.initial_configuration) | self.given_values() | {"name": name})


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
    """Common keys of all joints."""

    type: Annotated[str, choice(JOINT_TYPES)] = Field(description=f"one of {', '.join(JOINT_TYPES)}")


class PinTable(JointTable):
    """Type "pin"."""

    element = joints.Pin


class WeldTable(JointTable):
    """Type "weld"; by default the relative angle is the initial one."""

    element: ClassVar[Callable[..., Any]] = joints.Weld
    relative_angle: Angle = Field(
        0.0, alias="turn", description="the angle of the second body against the first; by default the initial one"
    )

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": initial.relative_angle(self.first, self.second)}


class SliderTable(JointTable):
    """Type "slider"."""

    element: ClassVar[Callable[..., Any]] = joints.Slider
    angle: Angle = Field(description='the direction of the line in the axes of the first body, as "0 deg"')


class PrismaticTable(WeldTable, SliderTable):
    """Type "prismatic"; by default the relative angle is the initial one."""

    element = joints.Prismatic


class ArcTable(JointTable):
    """Type "arc"."""

    element = joints.ArcSlot
    radius: PositiveLength = Field(description='the radius of the slot, as "100 mm"')


class CurveSlotTable(JointTable):
    """Type "curve"."""

    element = joints.CurveSlot
    curve: CurveValue = Field(description="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }")
    angle: Angle = Field(0.0, description="the direction of the x axis of the curve in the axes of the first body")


class _BodyJointTable(JointTable):
    """A joint whose ends may be bodies without a point."""

    first: field_types.PointOrBodyRef = Field(description='the first body or a point of it, as "ground" or "crank.A"')
    second: field_types.PointOrBodyRef = Field(description='the second body or a point of it, as "crank" or "crank.A"')


class GearTable(_BodyJointTable):
    """Type "gear"; by default the offset is the initial one."""

    element = joints.Gear
    ratio: Annotated[float, built("ratio", "not zero")] = Field(
        description="the rotation of the second body per rotation of the first; negative for external gears"
    )
    offset: Angle = Field(
        0.0, description="the angle of the second body where the first has none; by default that of the initial configuration"
    )

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the offset."""
        return {"offset": initial.relative_angle(self.first, self.second, self.ratio)}


class RackTable(_BodyJointTable):
    """Type "rack"; by default the offset is the initial one."""

    element = joints.RackAndPinion
    radius: Annotated[float, built("length", "not zero")] = Field(
        description='the radius of the pinion, as "20 mm"; negative for the opposite direction'
    )
    angle: Angle = Field(0.0, description="the direction in which the rack moves")
    offset: Annotated[float, quantity("length")] = Field(
        0.0, description="the displacement of the rack where the pinion has no angle; by default that of the initial configuration"
    )

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the offset."""
        return {"offset": initial.displacement_along(self.first, self.second, self.angle) - self.radius * initial.poses[self.first.body][2]}


class _DriverTable(JointTable):
    """A driver: a motion, or a constant rate from a start."""

    rate_example: ClassVar[str] = ""

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield a motion given twice or not at all."""
        others = [key for key in ("rate", "start") if key in values]
        if "motion" in values and others:
            yield f"{' and '.join(others)} cannot be combined with motion, which is complete"
        if "motion" not in values and "rate" not in values:
            yield Problem(f"rate or motion is missing; write {cls.rate_example}", ProblemCode.MISSING_KEY)


def _drive(driver: Callable[..., Any], start: float, rate: float = 0.0, motion: Callable[[float], Any] | None = None, **others: Any) -> Any:
    """Return a driver with a motion, by default at a constant rate from the start."""
    return driver(motion=motion(start) if motion else PrescribedMotion.constant_rate(start, rate), **others)


class DrivenTurnTable(_BodyJointTable, _DriverTable):
    """Type "driven_turn"; by default it starts at the initial relative angle."""

    element = partial(_drive, joints.RotationalDriver)
    rate_example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    rate: Annotated[float, quantity("angular_speed")] = Field(
        0.0, description="the constant speed of the second body against the first; instead of motion"
    )
    start: Angle = Field(0.0, description="the relative angle at the start, with a rate; by default the initial one")
    motion: field_types.AngleMotion = Field(
        None, description="the relative angle over time: a list of [time, angle], or a start and a rate with harmonics"
    )

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the start."""
        return {"start": initial.relative_angle(self.first, self.second)}


class DrivenSlideTable(_DriverTable, SliderTable):
    """Type "driven_slide"; by default it starts at the initial displacement."""

    element = partial(_drive, joints.TranslationalDriver)
    rate_example = 'rate = "50 mm/s", or motion = [[0, "0 mm"], [1, "50 mm"]]'
    rate: Annotated[float, quantity("speed")] = Field(0.0, description="the constant speed along the line; instead of motion")
    start: Annotated[float, quantity("length")] = Field(
        0.0, description="the displacement at the start, with a rate; by default the initial one"
    )
    motion: field_types.DisplacementMotion = Field(
        None, description="the displacement over time: a list of [time, length], or a start and a rate with harmonics"
    )

    def initial_values(self, initial: InitialConfiguration) -> dict[str, Any]:
        """Return the start."""
        return {"start": initial.displacement_along(self.first, self.second, self.angle, self.first.body)}


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


_SLOTS_AND_PINS = (PinTable, WeldTable, PrismaticTable, SliderTable, ArcTable, CurveSlotTable)
_TRANSMISSIONS = (GearTable, RackTable, DrivenTurnTable, DrivenSlideTable)
_FORCES = (SpringForceTable, DamperTable, TorsionSpringForceTable, TorsionDamperTable, TorqueTable, ForceTable)

ElementTables = Mapping[str, type[ElementTable]]
JOINT_TABLES: ElementTables = dict(zip(("", *JOINT_TYPES), (UntypedJointTable, *_SLOTS_AND_PINS, *_TRANSMISSIONS), strict=True))
FORCE_TABLES: ElementTables = dict(zip(("", *FORCE_TYPES), (UntypedForceTable, *_FORCES), strict=True))
"""Tables of [[joint]] and [[force]] by type."""

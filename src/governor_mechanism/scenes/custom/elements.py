"""[[joint]], [[link]] and [[force]] of a custom machine. Slow to import: pydantic."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final

from pydantic import ConfigDict, Field, TypeAdapter

from governor_mechanism.machines.custom import InitialConfiguration
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    Gear,
    Pin,
    Point,
    Prismatic,
    RackAndPinion,
    RotationalDriver,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.scenes.custom.bodies import PointRegistry
from governor_mechanism.scenes.custom.motions import AngleMotion, DisplacementMotion
from governor_mechanism.scenes.custom.values import BodyName, CurveValue, PointOrBodyRef, PointRef
from governor_mechanism.scenes.loads import input_function
from governor_mechanism.scenes.problems import Problem, ProblemCode, mistake
from governor_mechanism.scenes.quantities import Angle, Label, Length, PositiveLength, built, choice, quantity
from governor_mechanism.scenes.table import SceneFileTable, nearest_type, union_by_key
from governor_mechanism.units.quantities import format_value

JOINT_TYPES: Final = ("pin", "weld", "prismatic", "slider", "arc", "curve", "gear", "rack", "driven_turn", "driven_slide")
"""Types of [[joint]]."""

FORCE_TYPES: Final = ("spring", "damper", "torsion_spring", "torsion_damper", "torque", "force")
"""Types of [[force]]."""


class ElementTable(SceneFileTable):
    """A joint, link or force. The keys of a subclass are the arguments of its element, unless `arguments` replaces them."""

    element: ClassVar[Callable[..., Any]]
    """Class of the joint or force element."""
    end_keys: ClassVar[tuple[str, ...]] = ("first", "second")
    """Keys of the points or bodies that are connected."""

    name: Label = None

    @property
    def default_name(self) -> str:
        """Name from the type and the connected bodies."""
        ends = [getattr(self, key) for key in self.end_keys]
        bodies = [str(getattr(end, "body", end)) for end in ends]
        kind = str(getattr(self, "type", "link")).replace("_", " ")
        return f"{kind} of {' and '.join(bodies if len(bodies) > 1 else [GROUND, *bodies])}"

    def ends(self, registry: PointRegistry) -> dict[str, Any]:
        """Return the points at which the element acts, by argument."""
        first, second = registry.find_points(*((key, getattr(self, key)) for key in self.end_keys))
        _require_different_bodies(first.body, second.body)
        return {"first": first, "second": second}

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the defaults that follow from the initial configuration, by argument."""
        return {}

    def arguments(self, registry: PointRegistry, first: Point, second: Point) -> dict[str, Any]:
        """Return the other arguments of the element."""
        given = {key: value for key, value in self.given_values().items() if key not in ("name", "type", *self.end_keys)}
        return self.initial_values(registry.initial_configuration, first, second) | given

    def build(self, name: str, registry: PointRegistry) -> Any:
        """Return the joint or force element."""
        ends = self.ends(registry)
        return type(self).element(name=name, **ends, **self.arguments(registry, **ends))


def _require_different_bodies(first: str, second: str) -> None:
    if first == second:
        raise mistake(ProblemCode.CONFLICT, f"both ends are of {format_value(first)}; they must be of two different bodies")


class _PointTable(ElementTable):
    first: PointRef = Field(description='the point of the first body, as "ground.O" or ["crank", "10 mm", 0]')
    second: PointRef = Field(description='the point of the second body, as "crank.origin" or ["crank", "10 mm", 0]')


class LinkTable(_PointTable):
    """[[link]]: a massless bar, by default as long as the initial distance of its ends."""

    element = Distance
    length: PositiveLength = 0.0

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the length."""
        length = self.length or initial.distance(first, second)
        if not length:
            raise mistake(ProblemCode.MISSING_KEY, "length is missing, and the ends of the link coincide initially")
        return {"length": length}


class JointTable(_PointTable):
    """Common keys of all joints."""

    type: Annotated[str, choice(JOINT_TYPES)] = Field(description=f"one of {', '.join(JOINT_TYPES)}")


class PinTable(JointTable):
    """Type "pin"."""

    element = Pin


class WeldTable(JointTable):
    """Type "weld"; by default the relative angle is the initial one."""

    element: ClassVar[Callable[..., Any]] = Weld
    relative_angle: Angle = Field(0.0, alias="turn")

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": initial.relative_angle(first, second)}


class SliderTable(JointTable):
    """Type "slider"."""

    element: ClassVar[Callable[..., Any]] = Slider
    angle: Angle = Field(description='the direction of the line in the axes of the first body, as "0 deg"')


class PrismaticTable(WeldTable, SliderTable):
    """Type "prismatic"; by default the relative angle is the initial one."""

    element = Prismatic


class ArcTable(JointTable):
    """Type "arc"."""

    element = ArcSlot
    radius: PositiveLength = Field(description='the radius of the slot, as "100 mm"')


class CurveSlotTable(JointTable):
    """Type "curve"."""

    element = CurveSlot
    curve: CurveValue = Field(description="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }")
    angle: Angle = 0.0


class _BodyJointTable(JointTable):
    """A joint whose ends may be bodies without a point."""

    first: PointOrBodyRef = Field(description='the first body or a point of it, as "ground" or "crank.A"')
    second: PointOrBodyRef = Field(description='the second body or a point of it, as "crank" or "crank.A"')


class GearTable(_BodyJointTable):
    """Type "gear"; by default the offset is the initial one."""

    element = Gear
    ratio: Annotated[float, built("ratio", "not zero")] = Field(
        description="the rotation of the second body per rotation of the first; negative for external gears"
    )
    offset: Angle = 0.0

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the offset."""
        return {"offset": initial.relative_angle(first, second, self.ratio)}


class RackTable(_BodyJointTable):
    """Type "rack"; by default the offset is the initial one."""

    element = RackAndPinion
    radius: Annotated[float, built("length", "not zero")] = Field(
        description='the radius of the pinion, as "20 mm"; negative for the opposite direction'
    )
    angle: Angle = 0.0
    offset: Annotated[float, quantity("length")] = 0.0

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the offset."""
        return {"offset": initial.displacement_along(first, second, self.angle) - self.radius * initial.poses[first.body][2]}


class _DriverTable(JointTable):
    """A driver: a motion, or a constant rate from a start."""

    rate_example: ClassVar[str] = ""

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[Problem]:
        """Yield a motion given twice or not at all."""
        others = [key for key in ("rate", "start") if key in values]
        if "motion" in values and others:
            yield Problem(f"{' and '.join(others)} cannot be combined with motion, which is complete", ProblemCode.CONFLICT)
        if "motion" not in values and "rate" not in values:
            yield Problem(f"rate or motion is missing; write {cls.rate_example}", ProblemCode.MISSING_KEY)

    def arguments(self, registry: PointRegistry, first: Point, second: Point) -> dict[str, Any]:
        """Return the arguments with the motion, by default at a constant rate from the start."""
        values = super().arguments(registry, first, second)
        start, rate, build_motion = values.pop("start"), values.pop("rate", 0.0), values.pop("motion", None)
        return {"motion": build_motion(start) if build_motion else PrescribedMotion.constant_rate(start, rate), **values}


class DrivenTurnTable(_BodyJointTable, _DriverTable):
    """Type "driven_turn"; by default it starts at the initial relative angle."""

    element = RotationalDriver
    rate_example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    rate: Annotated[float, quantity("angular_speed")] = 0.0
    start: Angle = 0.0
    motion: AngleMotion = None

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the start."""
        return {"start": initial.relative_angle(first, second)}


class DrivenSlideTable(_DriverTable, SliderTable):
    """Type "driven_slide"; by default it starts at the initial displacement."""

    element = TranslationalDriver
    rate_example = 'rate = "50 mm/s", or motion = [[0, "0 mm"], [1, "50 mm"]]'
    rate: Annotated[float, quantity("speed")] = 0.0
    start: Annotated[float, quantity("length")] = 0.0
    motion: DisplacementMotion = None

    def initial_values(self, initial: InitialConfiguration, first: Point, second: Point) -> dict[str, Any]:
        """Return the start."""
        return {"start": initial.displacement_along(first, second, self.angle, first.body)}


class ForceElementTable(ElementTable):
    """Common keys of all forces."""

    type: Annotated[str, choice(FORCE_TYPES)] = Field(description=f"one of {', '.join(FORCE_TYPES)}")


class SpringForceTable(ForceElementTable, _PointTable):
    """Type "spring"."""

    element = Spring
    stiffness: Annotated[float, built("stiffness")] = Field(description='the stiffness, as "2 N/mm"')
    free_length: Length = 0.0


class DamperTable(ForceElementTable, _PointTable):
    """Type "damper"."""

    element = Damper
    damping: Annotated[float, built("damping")] = Field(description='the damping, as "120 N s/m"')


class _BodyForceTable(ForceElementTable):
    """A torque between two bodies."""

    def ends(self, registry: PointRegistry) -> dict[str, Any]:
        """Return the names of the bodies, by argument."""
        first, second = registry.require_bodies(*((key, getattr(self, key)) for key in self.end_keys))
        _require_different_bodies(first, second)
        return {"first": first, "second": second}


class _TorsionTable(_BodyForceTable):
    second: BodyName = Field(description='the body on which it acts, as "crank"')
    first: BodyName = GROUND


class TorsionSpringForceTable(_TorsionTable):
    """Type "torsion_spring"."""

    element = TorsionSpring
    stiffness: Annotated[float, built("torsion_stiffness")] = Field(description='the stiffness, as "3 N m/rad"')
    free_angle: Angle = 0.0


class TorsionDamperTable(_TorsionTable):
    """Type "torsion_damper"."""

    element = TorsionDamper
    damping: Annotated[float, built("torsion_damping")] = Field(description='the damping, as "0.1 N m s/rad"')


class TorqueTable(_BodyForceTable):
    """Type "torque"."""

    element = Torque
    end_keys = ("against", "body")
    body: BodyName = Field(description='the body on which it acts, as "crank"')
    against: BodyName = GROUND
    moment: Annotated[Any, input_function("torque", "moment")] = Field(
        description='the moment, as "5 N m", or over time, as [[0, "5 N m"], [2, "6 N m"]]'
    )


class ForceTable(ForceElementTable):
    """Type "force"."""

    end_keys = ("point",)
    point: PointRef = Field(description='the point at which it acts, as "slider.centre"')
    x: Annotated[Any, input_function("force", "force")] = InputFunction()
    y: Annotated[Any, input_function("force", "force")] = InputFunction()

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[Problem]:
        """Yield a force without components."""
        if "x" not in values and "y" not in values:
            yield Problem('x or y is missing; write x = "40 N" for a force along x', ProblemCode.MISSING_KEY)

    def build(self, name: str, registry: PointRegistry) -> Force:
        """Return the force."""
        point = registry.find_point(self.point, "point")
        if point.body == GROUND:
            raise mistake(ProblemCode.CONFLICT, "point must be of a moving body; a force on the ground has no effect")
        return Force(name=name, point=point, x=self.x, y=self.y)


class UntypedJointTable(JointTable):
    """A joint of unknown type; only the common keys are checked."""

    model_config = ConfigDict(extra="ignore")


class UntypedForceTable(ForceElementTable):
    """A force of unknown type; only the common keys are checked."""

    model_config = ConfigDict(extra="ignore")


_JOINT_TABLES = (PinTable, WeldTable, PrismaticTable, SliderTable, ArcTable, CurveSlotTable)
_BODY_JOINT_TABLES = (GearTable, RackTable, DrivenTurnTable, DrivenSlideTable)
_FORCE_TABLES = (SpringForceTable, DamperTable, TorsionSpringForceTable, TorsionDamperTable, TorqueTable, ForceTable)

JOINT: Final[TypeAdapter[JointTable]] = union_by_key(
    {**dict(zip(JOINT_TYPES, (*_JOINT_TABLES, *_BODY_JOINT_TABLES), strict=True)), "": UntypedJointTable}, nearest_type
)
FORCE: Final[TypeAdapter[ForceElementTable]] = union_by_key(
    {**dict(zip(FORCE_TYPES, _FORCE_TABLES, strict=True)), "": UntypedForceTable}, nearest_type
)
"""[[joint]] and [[force]] of any type."""

"""Force elements between bodies: springs, dampers, gas in cylinders, applied forces and torques. Frozen values without force laws."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.time_functions import InputFunction, StrokeHold
from governor_mechanism.units.fields import class_words, entry, optional_size, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class ForceElement:
    """Base class of a force element between two bodies."""

    name: str  # name in messages and results

    @property
    def bodies(self) -> tuple[str, str]:
        """Names of the two bodies that the element acts between."""
        raise NotImplementedError

    @property
    def displacements(self) -> tuple[Reading, ...]:
        """Outputs along which the force or its components act."""
        raise NotImplementedError

    @property
    def argument(self) -> Reading | None:
        """Output on which the force depends beside its displacement, in place of the rate of that; None for most."""
        return None

    @property
    def loads(self) -> tuple[InputFunction, ...]:
        """Given force or moment, or components of it, one for each displacement; empty for springs and dampers."""
        return tuple(value for value in vars(self).values() if isinstance(value, InputFunction))

    @property
    def factor(self) -> InputFunction | None:
        """What the force by its law is multiplied by, as a throttle; None for most."""
        return None

    @property
    def switch(self) -> InputFunction | None:
        """Coefficient of the law that moves, as a cut-off; None for most."""
        return None

    @property
    def inputs(self) -> tuple[InputFunction, ...]:
        """Loads, factor and switch."""
        return (*self.loads, *(one for one in (self.factor, self.switch) if one is not None))

    @property
    def has_potential(self) -> bool:
        """Whether nothing but the configuration determines the force, if the law has a potential."""
        return self.factor is None and self.switch is None

    @property
    def controlled_parameters(self) -> Mapping[str, str]:
        """Field of each parameter that a control may set though it is no load, by the name of the parameter."""
        return {}

    @property
    def control_unit(self) -> float:
        """Value of the field of a controlled parameter where the parameter is 1, SI."""
        return 1.0

    def __post_init__(self) -> None:
        first, second = self.bodies
        if first == second:
            raise MechanismError(f"force element {self.name!r} acts between body {first!r} and itself; it needs two different bodies")
        require_valid_fields(self, f"{class_words(self)} {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class _PointToPointElement(ForceElement):
    """A force along the line between two points, equal and opposite on both."""

    first: Point = entry("point", meaning='the point of the first body, as "ground.O" or ["crank", "10 mm", 0]')
    second: Point = entry("point", meaning='the point of the second body, as "crank.origin" or ["crank", "10 mm", 0]')

    @property
    def bodies(self) -> tuple[str, str]:
        """Bodies of the two points."""
        return self.first.body, self.second.body

    @property
    def displacements(self) -> tuple[PointDistance]:
        """Distance of the points, along which the force acts."""
        return (PointDistance(name=self.name, quantity="length", first=self.first, second=self.second),)


@dataclass(frozen=True, kw_only=True)
class Spring(_PointToPointElement):
    """A linear spring between two points.

    It pulls the points together with stiffness * (distance - free_length) and pushes them apart when it is shorter.

    Attributes
    ----------
    first, second
        End points.
    stiffness
        Stiffness, N/m; positive.
    free_length
        Distance at zero force, m.
    """

    stiffness: float = quantity("stiffness", built=True, meaning='the stiffness, as "2 N/mm"')
    free_length: float = optional_size("length", meaning="the length without force")


@dataclass(frozen=True, kw_only=True)
class Damper(_PointToPointElement):
    """A linear damper between two points: its force is damping times the rate of their distance and opposes it.

    Attributes
    ----------
    first, second
        End points.
    damping
        Damping coefficient, N s/m; positive.
    """

    damping: float = quantity("damping", built=True, meaning='the damping, as "120 N s/m"')


@dataclass(frozen=True, kw_only=True)
class _RotationalElement(ForceElement):
    """A moment on the second body relative to the first, and the opposite moment on the first."""

    second: str = entry("body", meaning='the body on which it acts, as "crank"')
    first: str = entry("body", default=GROUND, meaning="the body on which the opposite torque acts")

    @property
    def bodies(self) -> tuple[str, str]:
        """The first and the second body."""
        return self.first, self.second

    @property
    def displacements(self) -> tuple[BodyAngle]:
        """Relative angle of the bodies, along which the moment acts."""
        return (BodyAngle(name=self.name, quantity="angle", body=self.second, reference_body=self.first),)


@dataclass(frozen=True, kw_only=True)
class TorsionSpring(_RotationalElement):
    """A linear torsion spring between two bodies. It turns the second body back to free_angle relative to the first.

    Attributes
    ----------
    first, second
        Names of the bodies; the first is the ground by default.
    stiffness
        Stiffness, N m/rad; positive.
    free_angle
        Relative angle at zero moment, rad.
    """

    stiffness: float = quantity("torsion_stiffness", built=True, meaning='the stiffness, as "3 N m/rad"')
    free_angle: float = quantity("angle", sign="any", default=0.0, meaning="the relative angle without torque")


@dataclass(frozen=True, kw_only=True)
class TorsionDamper(_RotationalElement):
    """A linear torsion damper between two bodies: its moment is damping times their relative angular velocity and opposes it.

    Attributes
    ----------
    first, second
        Names of the bodies; the first is the ground by default.
    damping
        Damping coefficient, N m s/rad; positive.
    """

    damping: float = quantity("torsion_damping", built=True, meaning='the damping, as "0.1 N m s/rad"')


@dataclass(frozen=True, kw_only=True)
class Torque(_RotationalElement):
    """A prescribed moment on the second body. The first body takes the opposite moment.

    Attributes
    ----------
    first, second
        Names of the bodies; the first is the ground by default.
    moment
        Moment over time, N m, anticlockwise.
    """

    second: str = entry("body", key="body", meaning='the body on which it acts, as "crank"')
    first: str = entry("body", key="against", default=GROUND, meaning="the body on which the opposite torque acts")
    moment: InputFunction = entry(
        "load", "torque", sign="any", noun="moment", meaning='the moment, as "5 N m", or over time, as [[0, "5 N m"], [2, "6 N m"]]'
    )


@dataclass(frozen=True, kw_only=True)
class MeanGasTorque(Torque):
    """The torque of gas in cylinders averaged over a turn; a throttle sets a part of it."""

    full_torque: float = quantity("torque", sign="any")  # torque with an open throttle, N m

    @property
    def controlled_parameters(self) -> Mapping[str, str]:
        """The throttle, which has the name of the element."""
        return {self.name.rpartition(".")[2]: "moment"}

    @property
    def control_unit(self) -> float:
        """Torque with an open throttle, N m."""
        return self.full_torque


@dataclass(frozen=True, kw_only=True)
class Force(ForceElement):
    """A prescribed force at a point of a body. Its direction is fixed in the plane.

    Attributes
    ----------
    point
        Point of application.
    x, y
        Components along the axes of the plane over time, N.
    """

    point: Point = entry("point", meaning='the point at which it acts, as "slider.centre"')
    x: InputFunction = entry("load", "force", sign="any", default=InputFunction(), meaning="the component along x")
    y: InputFunction = entry("load", "force", sign="any", default=InputFunction(), meaning="the component along y, upward")

    @property
    def bodies(self) -> tuple[str, str]:
        """The ground and the body of the point."""
        return GROUND, self.point.body

    @property
    def displacements(self) -> tuple[PointCoordinate, PointCoordinate]:
        """Coordinates x and y of the point, along which the components act."""
        x, y = (
            PointCoordinate(name=self.name, quantity="length", point=self.point, direction_x=1.0 - k, direction_y=float(k)) for k in (0, 1)
        )
        return x, y


@dataclass(frozen=True, kw_only=True)
class CylinderGas(ForceElement):
    """The gas on one face of a double-acting piston that a crank moves; both faces change their parts at every dead centre.

    Its pressure is constant before or after a travel and follows an isotherm on the other side of it; see `effects.gas_pressure`.
    """

    body: str  # body on which the gas acts: the piston, or without one the crank
    travel: Reading  # travel of the piston, m, 0 at the crank angle 0
    crank_angle: BodyAngle  # crank angle, rad; its multiples of pi are the dead centres
    # what all pressures are multiplied by; None for 1
    throttle: InputFunction | None = entry("load", "ratio", sign="any", default=None)
    # travel at the switch, relative to the stroke, as it moves; None if it is switch_travel
    cut_off: InputFunction | None = entry("load", "ratio", sign="any", default=None)
    # whether the cut-off is read at dead centres alone, and holds for the stroke; if not, it moves until the
    # supply is cut off
    reads_at_dead_centres: bool = True
    area: float = quantity("area", sign="any")  # area of the piston, m2; negative if the gas resists the stroke
    pressure: float = quantity("pressure", sign="any")  # constant pressure, Pa
    volume: float = quantity(sign="any")  # volume at the beginning of a stroke, relative to the swept volume
    change: float = quantity(sign="any")  # its change over the stroke: 1 or -1
    switch_travel: float = quantity(sign="any")  # travel, relative to the stroke, at which isotherm and constant pressure meet
    begins_constant: bool  # whether the constant pressure comes first
    back_pressure: float = quantity("pressure", sign="any", default=0.0)  # pressure on the other face, Pa
    stroke: float = quantity("length")  # stroke, m

    @property
    def bodies(self) -> tuple[str, str]:
        """The ground and the body on which the gas acts."""
        return GROUND, self.body

    @property
    def displacements(self) -> tuple[Reading]:
        """Travel of the piston."""
        return (self.travel,)

    @property
    def argument(self) -> BodyAngle:
        """The crank angle."""
        return self.crank_angle

    @property
    def loads(self) -> tuple[InputFunction, ...]:
        """None: the force follows from a law."""
        return ()

    @property
    def factor(self) -> InputFunction | None:
        """The throttle."""
        return self.throttle

    @cached_property
    def switch(self) -> InputFunction | None:
        """The cut-off that moves, held from the dead centre on, or from the cut-off itself on: the gas behind it is locked in."""
        if self.cut_off is None or self.cut_off.is_constant:
            return self.cut_off
        return replace(self.cut_off, hold=StrokeHold.FROM_DEAD_CENTRE if self.reads_at_dead_centres else StrokeHold.FROM_CUT_OFF)

    @property
    def strokes_differ(self) -> bool:
        """Whether throttle or cut-off moves."""
        return any(not one.is_constant for one in (self.throttle, self.cut_off) if one is not None)

    @property
    def controlled_parameters(self) -> Mapping[str, str]:
        """The cut-off of a gas that is admitted at a constant pressure."""
        return {"cut_off": "cut_off"} if self.begins_constant else {}

    def controlled_default(self) -> InputFunction:
        """Return what a control of the cut-off adds to."""
        return InputFunction(values=(self.switch_travel,))

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Coefficients of the force law."""
        cycle = self.area, self.pressure, self.volume, self.change, self.switch_travel, float(self.begins_constant)
        return (*cycle, self.back_pressure, self.stroke)

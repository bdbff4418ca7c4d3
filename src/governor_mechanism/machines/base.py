"""Base class of machines: declared dimensions, from which a mechanism is built."""

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism, SecondMoments
from governor_mechanism.model.output_variables import Limit, PointCoordinate
from governor_mechanism.model.part import EQUILIBRIUM, TURNING_PLANE
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.types import Vector2
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS

MIN_DIMENSION = 1e-9
"""Smallest magnitude of a dimension, SI: smaller values are mistakes of units, and double precision does not suffice."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Machine(ABC):
    """Base class of machines: dimensions in SI, checked on construction.

    Attributes
    ----------
    name
        Name in scene files.
    plane
        TURNING_PLANE, the default, or FIXED_PLANE.
    driver_dimensions
        Dimensions that prescribe the motion of a driven machine; empty for a machine that [start] sets in motion.
    supported_effects
        Types of the effects that change its bodies, in the order of the arguments of `mechanism`.
    reading_meanings
        What each reading is, by its name: all that the machine may have.
    """

    name: ClassVar[str]
    plane: ClassVar[str] = TURNING_PLANE
    driver_dimensions: ClassVar[tuple[str, ...]] = ()
    supported_effects: ClassVar[tuple[type[Effect], ...]] = ()
    reading_meanings: ClassVar[Mapping[str, str]] = {}

    def __post_init__(self) -> None:
        # Only plausible dimensions can be tested together.
        if problems := [*self._implausible_dimensions()] or [*self.dimension_problems()]:
            raise MechanismError(*problems)

    def _implausible_dimensions(self) -> Iterator[str]:
        """Yield sentences about unknown words and magnitudes outside the plausible range."""
        for name, declared in fields_of(type(self)).items():
            value = getattr(self, name)
            if value is None:
                continue
            if declared.form == "choice":
                if value not in declared.words:
                    yield f"{name} must be one of {', '.join(map(repr, declared.words))}; got {value!r}"
                continue
            is_positive = declared.sign == "positive"
            max_size = QUANTITY_KINDS[declared.kind].largest
            value = max(values_of(value), key=abs)
            if not (MIN_DIMENSION <= (abs(value) or MIN_DIMENSION) <= max_size and (value > 0 or not is_positive)):
                required = "a positive" if is_positive else "a finite"
                yield f"{name} must be {required} number between {MIN_DIMENSION:g} and {max_size:g} in SI; got {value:g}"

    def dimension_problems(self) -> Iterable[str]:
        """Return sentences about dimensions that contradict one another."""
        return ()

    @abstractmethod
    def mechanism(self, *args: Any, **kwargs: Any) -> Mechanism:
        """Build the bodies, joints and readings of this machine; the arguments are its supported effects, or None."""

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Return sentences about effects that this kind of machine does not support."""
        return unsupported_effect_messages(cls.name, effects, cls.supported_effects)

    def mechanism_with_effects(self, effects: Iterable[Effect]) -> Mechanism:
        """Build the mechanism with the effects that change its bodies. Raise MechanismError for effects it does not support."""
        listed = list(effects)
        if problems := [*self.effect_problems(listed), *self.stop_problems(listed)]:
            raise MechanismError(*problems)
        by_type = {type(effect): effect for effect in listed}
        return self.mechanism(*(by_type.get(effect_type) for effect_type in self.supported_effects))

    def stop_problems(self, effects: Iterable[Effect]) -> Sequence[str]:
        """Return sentences about stops that this machine cannot reach."""
        return ()

    def under_gravity(self, find_gravity: Callable[[], float]) -> Self:
        """Return the machine as it is built for the gravity of a scene (m/s2): with springs that are designed for it, if any."""
        del find_gravity  # most machines are the same under any
        return self

    @property
    def is_driven(self) -> bool:
        """Whether drivers prescribe its motion; if not, [start] sets it in motion."""
        return bool(self.driver_dimensions)

    @property
    def default_start(self) -> float | str:
        """Start value of the coordinate, SI, for a scene that gives none."""
        return EQUILIBRIUM

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return sentences about start values at which this machine cannot be assembled."""
        return ()

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions by name, SI, the first value of what changes, also omitted ones: lengths are infinite then."""
        values = {name: getattr(self, name) for name, declared in fields_of(type(self)).items() if declared.form != "choice"}
        return {name: math.inf if value is None else values_of(value)[0] for name, value in values.items()}


def values_of(dimension: float | PrescribedMotion | InputFunction) -> tuple[float, ...]:
    """Return the values of a dimension at the points of its program; of one with harmonics without these."""
    return dimension.values if isinstance(dimension, PrescribedMotion | InputFunction) else (dimension,)


def unit_hint(angle: float, max_angle: float, example: str) -> str:
    """Return a hint at the unit of an implausibly large angle (rad), or an empty string."""
    return f"; a bare number is in rad, so write it with its unit: {example}" if abs(angle) > max_angle else ""


def travel_problems(values: Mapping[str, float | str], travel: Limit, max_angle: float, example: str) -> tuple[str, ...]:
    """Return a sentence about a start angle (rad) outside the travel."""
    angle = values.get(travel.reading)
    if not isinstance(angle, float) or travel.low < angle < travel.high:
        return ()
    return (
        f"start.{travel.reading} ({math.degrees(angle):g} deg) lies outside the travel of this governor, "
        f"{math.degrees(travel.low):.6g} to {math.degrees(travel.high):.6g} deg: "
        f"{travel.low_message if angle <= travel.low else travel.high_message}{unit_hint(angle, max_angle, example)}",
    )


def unsupported_effect_messages(machine: str, effects: Iterable[Effect], supported: tuple[type[Effect], ...] = ()) -> tuple[str, ...]:
    """Return a sentence for each effect that changes bodies and that a machine does not support."""
    return tuple(
        f"the effect {effect.key} is for {effect.changes_bodies_of}; machine {machine!r} does not support it; leave the effect out"
        for effect in effects
        if effect.changes_bodies_of and type(effect) not in supported
    )


def rotate_point(x: float, y: float, angle: float) -> Vector2:
    """Rotate a point about the origin (m, rad)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def x_coordinate(name: str, point: Point, *, sign: float = 1.0, zero: float = 0.0) -> PointCoordinate:
    """Return the reading of the position of a point along x (along -x for a sign of -1), less `zero` (m)."""
    return PointCoordinate(name=name, quantity="length", point=point, direction_x=sign, direction_y=0.0, zero=zero)


def sleeve_lift(point: Point, *, zero: float) -> PointCoordinate:
    """Return the lift of a sleeve as a reading: the height of its point, less `zero` (m)."""
    return PointCoordinate(name="sleeve_lift", quantity="length", point=point, direction_x=0.0, direction_y=1.0, zero=zero)


@dataclass(frozen=True, kw_only=True)
class MassElement:
    """A part of a rigid body."""

    mass: float  # kg
    centre: Vector2 = (0.0, 0.0)  # mass centre, m
    moments: SecondMoments = field(default_factory=SecondMoments)  # about the mass centre


def slender_rod(mass: float, end: Vector2) -> MassElement:
    """Return a slender uniform rod (kg) from the origin to its end (m)."""
    u, v = end
    moments = SecondMoments(xx=mass * u**2 / 12, yy=mass * v**2 / 12, xy=mass * u * v / 12)
    return MassElement(mass=mass, centre=(u / 2, v / 2), moments=moments)


def thin_arc(mass: float, radius: float, half_angle: float) -> MassElement:
    """Return a thin uniform arc (kg) about the origin (m), symmetric about the direction of -x, from -half_angle to half_angle (rad)."""
    centre = -radius * math.sin(half_angle) / half_angle
    half_mean_square = 0.5 * radius**2
    variation = radius**2 * math.sin(2 * half_angle) / (4 * half_angle)
    along = half_mean_square + variation - centre**2
    across = half_mean_square - variation
    return MassElement(mass=mass, centre=(centre, 0.0), moments=SecondMoments(xx=mass * along, yy=mass * across))


def solid_ball(mass: float, centre: Vector2, radius: float) -> MassElement:
    """Return a uniform solid ball (kg) with its centre and radius (m)."""
    moment = mass * radius**2 / 5
    return MassElement(mass=mass, centre=centre, moments=SecondMoments(xx=moment, yy=moment, zz=moment))


def join_elements(elements: Sequence[MassElement]) -> MassElement:
    """Return the rigid body of all elements, with its second moments about the common mass centre."""
    if len(elements) == 1:
        return elements[0]
    mass = sum(part.mass for part in elements)
    x, y = (sum(part.mass * part.centre[axis] for part in elements) / mass for axis in (0, 1))
    moments = SecondMoments(
        xx=sum(part.moments.xx + part.mass * (part.centre[0] - x) ** 2 for part in elements),
        yy=sum(part.moments.yy + part.mass * (part.centre[1] - y) ** 2 for part in elements),
        xy=sum(part.moments.xy + part.mass * (part.centre[0] - x) * (part.centre[1] - y) for part in elements),
        zz=sum(part.moments.zz for part in elements),
    )
    return MassElement(mass=mass, centre=(x, y), moments=moments)

"""The inputs of the design of a Hartnell governor, and what makes them invalid."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design_inputs import design_input, input_kinds
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

RPM = math.pi / 30
"""One revolution per minute in rad/s."""

DEFAULT_LIFT = 0.015
"""Lift of the sleeve without lift and outer_radius, m: that of the textbook's example."""

_MAY_BE_ZERO = ("sleeve_mass", "gravity")


@dataclass(frozen=True, kw_only=True)
class HartnellInputs:
    """Inputs of a design in SI; None stands for what follows from the others.

    Attributes
    ----------
    ball_mass
        Mass of one ball, kg.
    sleeve_mass
        Mass of the sleeve, kg; 0 where it is neglected.
    ball_arm
        Arm of a bell crank from its pivot to the ball, m.
    sleeve_arm
        Arm from the pivot to the roller under the sleeve, m.
    bell_crank_angle
        Angle between the arms, rad.
    pivot_radius
        Distance of the pivots from the spindle axis, m; None for inner_radius: the balls' arms are upright in the lowest position.
    inner_radius
        Distance of the balls from the axis in the lowest position, m.
    outer_radius
        That in the highest position, m; None: it follows from the lift.
    lift
        Lift of the sleeve, m; None: it follows from outer_radius.
    lowest_speed, highest_speed
        Speeds of equilibrium in the lowest and the highest position, rad/s.
    gravity
        Gravitational acceleration, m/s2.
    """

    ball_mass: float = design_input("mass", 2.5)
    sleeve_mass: float = design_input("mass", 0.0)
    ball_arm: float = design_input("length", 0.120)
    sleeve_arm: float = design_input("length", 0.080)
    bell_crank_angle: float = design_input("angle", math.pi / 2)
    pivot_radius: float | None = design_input("length", None)
    inner_radius: float = design_input("length", 0.120)
    outer_radius: float | None = design_input("length", None)
    lift: float | None = design_input("length", None)
    lowest_speed: float = design_input("angular_speed", 290 * RPM)
    highest_speed: float = design_input("angular_speed", 310 * RPM)
    gravity: float = design_input("acceleration", 9.81)


DEFAULT_INPUTS = HartnellInputs()
"""The governor of R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, example 18.13."""


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Lowest and highest position: arm angles from the upright (rad) and that half way up, radii of the balls (m), and the lift (m)."""

    arm_angles: tuple[float, float]
    middle_angle: float
    radii: tuple[float, float]
    lift: float


def resolve_inputs(inputs: HartnellInputs) -> tuple[HartnellInputs, Travel]:
    """Return the inputs with pivots and outer radius or lift filled in, and the travel.

    Parameters
    ----------
    inputs
        The inputs.

    Returns
    -------
    tuple[HartnellInputs, Travel]
        Inputs without None, and the travel.

    Raises
    ------
    MechanismError
        With one sentence per mistake: a value that is not positive, radii in the wrong order, a lift that the arms do not give, or speeds
        that do not rise.
    """
    if problems := [*_sign_problems(inputs)] or [*_contradictions(inputs)]:
        raise MechanismError(*problems)
    placed = replace(inputs, pivot_radius=inputs.inner_radius if inputs.pivot_radius is None else inputs.pivot_radius)
    if problems := [*_place_problems(placed)]:
        raise MechanismError(*problems)
    travel = _find_travel(placed)
    if problem := _speed_problem(placed, travel):
        raise MechanismError(problem)
    return replace(placed, outer_radius=travel.radii[1], lift=travel.lift), travel


def _sign_problems(inputs: HartnellInputs) -> Iterator[str]:
    """Yield a sentence for each input that is not positive, or negative where 0 is allowed."""
    for name, kind in input_kinds(inputs).items():
        value = getattr(inputs, name)
        if value is None or value > 0 or (name in _MAY_BE_ZERO and value == 0):
            continue
        found = format_quantity(value, QUANTITY_KINDS[kind].si_unit).strip()
        yield f"{name} must {'not be negative' if name in _MAY_BE_ZERO else 'be positive'}; got {found}"


def _contradictions(inputs: HartnellInputs) -> Iterator[str]:
    """Yield sentences about two descriptions of the travel, radii in the wrong order, and an impossible bell crank."""
    if inputs.lift is not None and inputs.outer_radius is not None:
        yield "lift and outer_radius are both given, and each determines the other; leave one of them out"
    if inputs.outer_radius is not None and inputs.outer_radius <= inputs.inner_radius:
        yield (
            f"outer_radius ({_mm(inputs.outer_radius)}) must exceed inner_radius ({_mm(inputs.inner_radius)}): "
            "the balls move outward as the sleeve rises; exchange them"
        )
    if inputs.bell_crank_angle >= math.pi:
        yield (
            f"bell_crank_angle ({math.degrees(inputs.bell_crank_angle):.6g} deg) must be less than 180 deg; "
            "bell cranks of a Hartnell governor have about 90 deg"
        )


def _place_problems(inputs: HartnellInputs) -> Iterator[str]:
    """Yield sentences about pivots too near to the axis, and radii that the balls do not reach."""
    pivot = inputs.pivot_radius or 0.0
    if inputs.sleeve_arm >= pivot:
        yield (
            f"sleeve_arm ({_mm(inputs.sleeve_arm)}) must be shorter than pivot_radius ({_mm(pivot)}), "
            "or the rollers would meet on the spindle axis"
        )
    for name in ("inner_radius", "outer_radius"):
        radius = getattr(inputs, name)
        if radius is not None and abs(radius - pivot) >= inputs.ball_arm:
            yield (
                f"{name} ({_mm(radius)}) is out of reach of the balls: their arms of {_mm(inputs.ball_arm)} about pivots at {_mm(pivot)} "
                f"reach from {_mm(max(pivot - inputs.ball_arm, 0.0))} to {_mm(pivot + inputs.ball_arm)}; change it or pivot_radius"
            )


def _find_travel(inputs: HartnellInputs) -> Travel:
    """Return the travel from the outer radius, or from the lift."""
    pivot, angle, arm = inputs.pivot_radius or 0.0, inputs.bell_crank_angle, inputs.sleeve_arm
    low = math.asin((inputs.inner_radius - pivot) / inputs.ball_arm)
    lowest = math.cos(angle - low)
    if not 0 < angle - low < math.pi:
        raise MechanismError(
            f"bell_crank_angle ({math.degrees(angle):.6g} deg) does not fit inner_radius, where the balls' arms lean by "
            f"{math.degrees(low):.6g} deg: the rollers would be above or below their pivots; change one of them"
        )
    end = min(angle, math.pi / 2)
    if inputs.outer_radius is None:
        lift = DEFAULT_LIFT if inputs.lift is None else inputs.lift
        highest = arm * (math.cos(angle - end) - lowest)
        if lift >= highest:
            raise MechanismError(
                f"lift ({_mm(lift)}) is more than the arms give: sleeve arms of {_mm(arm)} raise the sleeve by less than {_mm(highest)} "
                "from the lowest position; reduce lift, or lengthen sleeve_arm"
            )
        high = angle - math.acos(lowest + lift / arm)
    else:
        high = math.asin((inputs.outer_radius - pivot) / inputs.ball_arm)
        if high >= end:
            raise MechanismError(
                f"outer_radius ({_mm(inputs.outer_radius)}) is beyond the dead centre of the rollers, "
                f"{_mm(pivot + inputs.ball_arm * math.sin(end))}; reduce it"
            )
        lift = arm * (math.cos(angle - high) - lowest)
    outer = pivot + inputs.ball_arm * math.sin(high) if inputs.outer_radius is None else inputs.outer_radius
    middle = angle - math.acos(lowest + 0.5 * lift / arm)
    return Travel(arm_angles=(low, high), middle_angle=middle, radii=(inputs.inner_radius, outer), lift=lift)


def _speed_problem(inputs: HartnellInputs, travel: Travel) -> str:
    """Return a sentence about speeds that do not rise with the sleeve; empty if they do."""
    ratio, least = inputs.highest_speed / inputs.lowest_speed, math.sqrt(travel.radii[0] / travel.radii[1])
    is_isochronous = math.isclose(ratio, 1, rel_tol=1e-9)  # the same text in rpm may differ by rounding
    if ratio > 1 and not is_isochronous:
        return ""
    speeds = f"highest_speed ({inputs.highest_speed / RPM:.6g} rpm) over lowest_speed ({inputs.lowest_speed / RPM:.6g} rpm) is {ratio:.6g}"
    if is_isochronous:
        return f"{speeds}: the governor would be isochronous, and stand still anywhere; a stable one needs a ratio above 1"
    needed = (
        f"a spring would need a ratio above {least:.6g}, the root of inner_radius over outer_radius, and a stable governor one above 1"
        if ratio <= least
        else "the governor would be unstable, as its speed falls while the balls move outward; a stable one needs a ratio above 1"
    )
    return f"{speeds}: {needed}; raise highest_speed"


def _mm(length: float) -> str:
    return f"{length * 1e3:.6g} mm"

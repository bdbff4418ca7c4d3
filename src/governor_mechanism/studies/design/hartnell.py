"""Design of a Hartnell governor: the spring for two speeds, by the textbooks' formula and by exact statics.

The textbooks neglect the weight of the balls and the obliquity of the arms. Both springs are held against the exact governor: the textbook
spring gives other speeds at the ends of the lift, the exact one the wanted speeds.

References
----------
R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Hartnell governor".
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.studies.design.skeleton import (
    SPEED_CHANGE,
    Design,
    format_rows,
    refuse,
    relative_range,
    require_valid,
    run_up_steps,
    sentences,
    sleeve_damping,
)
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.fields import optional, quantity

DEFAULT_LIFT = 0.015
"""Lift of the sleeve without lift and outer_radius, m: as in the textbook's example."""

STEP_TIMES = (0, 1, 2, 3, 4, 6)
"""Times of the program of the speed in units of a step, with rises from 1 to 2 and from 3 to 4."""

STEP_PERIODS, STEP_LIMITS = 2.0, (0.5, 30.0)
"""A step in periods of small oscillations half way, and its shortest and longest duration, s."""


@dataclass(frozen=True, kw_only=True)
class HartnellInputs:
    """Inputs of a design in SI; None stands for what follows from the others."""

    ball_mass: float = quantity("mass", default=2.5, meaning="mass of one ball")
    sleeve_mass: float = quantity("mass", default=0.0, meaning="mass of the sleeve; 0 where it is neglected", sign="not negative")
    ball_arm: float = quantity("length", default=0.120, meaning="arm of a bell crank from its pivot to the ball")
    sleeve_arm: float = quantity("length", default=0.080, meaning="arm from the pivot to the roller under the sleeve")
    bell_crank_angle: float = quantity("angle", default=math.pi / 2, meaning="angle between the arms")
    pivot_radius: float | None = optional("length", meaning="distance of the pivots from the spindle axis; by default inner_radius")
    inner_radius: float = quantity("length", default=0.120, meaning="distance of the balls from the axis in the lowest position")
    outer_radius: float | None = optional("length", meaning="distance of the balls in the highest position; it follows from the lift")
    lift: float | None = optional("length", meaning="lift of the sleeve; it follows from outer_radius")
    lowest_speed: float = quantity("angular_speed", default=290 * RPM, meaning="speed of equilibrium in the lowest position")
    highest_speed: float = quantity("angular_speed", default=310 * RPM, meaning="speed of equilibrium in the highest position")
    gravity: float = quantity("acceleration", default=9.81, meaning="gravitational acceleration", sign="not negative")


DEFAULT_INPUTS = HartnellInputs()
"""The governor of R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, example 18.13."""


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Lowest and highest position: arm angles from the upright (rad) and that half way up, radii of the balls (m), and the lift (m)."""

    arm_angles: tuple[float, float]
    middle_angle: float
    radii: tuple[float, float]
    lift: float


@dataclass(frozen=True, kw_only=True)
class SleeveSpring(Recorded):
    """A spring on the sleeve, and what it makes of the exact governor."""

    forces: tuple[float, float]  # its forces in the lowest and the highest position, N
    rate: float  # its rate, N/m
    compression: float  # its initial compression, in the lowest position, m
    # speeds at which the exact governor stands still in the lowest and the highest position under this
    # spring, rad/s
    speeds: tuple[float, float]

    derived = ("sensitiveness",)

    @property
    def sensitiveness(self) -> float:
        """Range of speed over mean speed."""
        return relative_range(self.speeds)


@dataclass(frozen=True, kw_only=True, repr=False)
class HartnellDesign(Design):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs, with what follows from the others.
    travel
        The lowest and the highest position.
    textbook
        The spring by the textbooks' formula.
    exact
        The spring by exact statics.
    textbook_effort
        Mean force at the sleeve half way up for a change of speed of 1 %, by the textbooks' formula, N.
    effort
        The same by exact statics, N.
    warnings
        Warnings, one sentence each.
    """

    inputs: HartnellInputs
    travel: Travel
    textbook: SleeveSpring
    exact: SleeveSpring
    textbook_effort: float
    effort: float
    warnings: tuple[str, ...] = ()

    machine = "hartnell"
    derived = ("power",)

    @property
    def governor(self) -> closed.HartnellGovernor:
        """Dimensions and masses for the closed forms."""
        return build_governor(self.inputs)

    @property
    def power(self) -> float:
        """Effort times lift for a change of speed of 1 %, as the textbooks define it, J."""
        return self.effort * self.travel.lift

    @property
    def spring_table(self) -> str:
        """Both springs, and what they make of the governor."""
        weight = self.inputs.sleeve_mass * self.inputs.gravity
        textbook, exact = ([force + weight for force in spring.forces] for spring in (self.textbook, self.exact))
        values = {"textbook_loads": textbook, "exact_loads": exact, "textbook_power": self.textbook_effort * self.travel.lift}
        return format_rows(self.machine, "springs", self, "llr", **values)

    def scene_values(self) -> Mapping[str, object]:
        """Return what the scene adds: the speed rises from the lowest to the highest in two steps, with stops and a dashpot."""
        inputs = self.inputs
        governor = self.governor
        angle = 0.5 * sum(self.travel.arm_angles)
        lift_derivative = governor.sleeve_arm * math.sin(governor.angle - angle)
        inertia = 2 * governor.ball_mass * governor.ball_arm**2 + governor.sleeve_mass * lift_derivative**2
        frequency = self._natural_frequency(angle)
        step = float(np.clip(STEP_PERIODS * math.tau / frequency, *STEP_LIMITS))
        times = [step * time for time in STEP_TIMES]
        return {
            "sleeve_mass": inputs.sleeve_mass or None,
            "damping": sleeve_damping(inertia, frequency, lift_derivative),
            "speed": run_up_steps(times, inputs.lowest_speed, inputs.highest_speed),
            "duration": round(times[-1], 6),
            "output_interval": step / 50,
        }

    def _natural_frequency(self, angle: float) -> float:
        """Return the frequency (rad/s) of small oscillations at an arm angle (rad) under the mean force of the spring."""
        force = 0.5 * sum(self.exact.forces)
        speed = float(closed.equilibrium_speed(self.governor, arm_angle=angle, spring_force=force))
        load = {"spring_force": force, "spring_rate": self.exact.rate, "spindle_speed": speed}
        return math.sqrt(abs(float(closed.squared_natural_frequency(self.governor, arm_angle=angle, **load))))


def build_governor(inputs: HartnellInputs) -> closed.HartnellGovernor:
    """Return the governor of the closed forms, from inputs without None."""
    names = ("ball_arm", "sleeve_arm", "pivot_radius", "ball_mass", "sleeve_mass", "gravity")
    return closed.HartnellGovernor(angle=inputs.bell_crank_angle, **{name: getattr(inputs, name) for name in names})


def design_hartnell(inputs: HartnellInputs = DEFAULT_INPUTS) -> HartnellDesign:
    """Design the spring of a Hartnell governor for two speeds."""
    resolved, travel = resolve_inputs(inputs)
    governor = build_governor(resolved)
    speeds = (resolved.lowest_speed, resolved.highest_speed)
    weight = resolved.sleeve_mass * resolved.gravity
    textbook_forces = [
        float(closed.textbook_sleeve_force(governor, ball_radius=radius, spindle_speed=speed)) - weight
        for radius, speed in zip(travel.radii, speeds, strict=True)
    ]
    exact_forces = [
        float(closed.spring_force(governor, arm_angle=angle, spindle_speed=speed))
        for angle, speed in zip(travel.arm_angles, speeds, strict=True)
    ]
    textbook_lift = (travel.radii[1] - travel.radii[0]) * resolved.sleeve_arm / resolved.ball_arm
    _require_spring(exact_forces, resolved)
    exact = _make_spring(governor, travel, exact_forces, travel.lift)
    textbook = _make_spring(governor, travel, textbook_forces, textbook_lift)
    is_stable = textbook.speeds[1] > textbook.speeds[0]
    return HartnellDesign(
        inputs=resolved,
        travel=travel,
        textbook=textbook,
        exact=exact,
        textbook_effort=SPEED_CHANGE * (0.5 * sum(textbook_forces) + weight),
        effort=_exact_effort(governor, travel.middle_angle, 0.5 * sum(exact_forces)),
        warnings=tuple(sentences("hartnell", textbook, {"unstable_spring": not is_stable}, wanted=resolved.highest_speed)),
    )


def resolve_inputs(inputs: HartnellInputs) -> tuple[HartnellInputs, Travel]:
    """Return the inputs with pivots and outer radius or lift filled in, and the travel; raise MechanismError with all mistakes."""
    require_valid("hartnell", inputs, _contradictions)
    placed = replace(inputs, pivot_radius=inputs.inner_radius if inputs.pivot_radius is None else inputs.pivot_radius)
    _require_places(placed)
    travel = _find_travel(placed)
    _require_rising_speeds(placed, travel)
    return replace(placed, outer_radius=travel.radii[1], lift=travel.lift), travel


def _contradictions(inputs: HartnellInputs) -> list[str]:
    """Return sentences about two descriptions of the travel, radii in the wrong order, and an impossible bell crank."""
    outer = inputs.outer_radius
    cases = {
        "lift_and_radius": inputs.lift is not None and outer is not None,
        "radii": outer is not None and outer <= inputs.inner_radius,
        "bell_crank": inputs.bell_crank_angle >= math.pi,
    }
    return sentences("hartnell", inputs, cases)


def _require_places(inputs: HartnellInputs) -> None:
    """Raise MechanismError for pivots too near to the axis, and radii that the balls do not reach."""
    pivot = inputs.pivot_radius or 0.0
    radii = {"inner_reach": inputs.inner_radius, "outer_reach": inputs.outer_radius}
    cases = {name: radius is not None and abs(radius - pivot) >= inputs.ball_arm for name, radius in radii.items()}
    reach = {"least": max(pivot - inputs.ball_arm, 0.0), "most": pivot + inputs.ball_arm}
    refuse("hartnell", inputs, {"rollers": inputs.sleeve_arm >= pivot, **cases}, **reach)


def _find_travel(inputs: HartnellInputs) -> Travel:
    """Return the travel from the outer radius, or from the lift."""
    pivot = inputs.pivot_radius or 0.0
    angle = inputs.bell_crank_angle
    arm = inputs.sleeve_arm
    low = math.asin((inputs.inner_radius - pivot) / inputs.ball_arm)
    lowest = math.cos(angle - low)
    refuse("hartnell", inputs, {"lean": not 0 < angle - low < math.pi}, low=low)
    end = min(angle, math.pi / 2)
    if inputs.outer_radius is None:
        lift = DEFAULT_LIFT if inputs.lift is None else inputs.lift
        highest = arm * (math.cos(angle - end) - lowest)
        refuse("hartnell", inputs, {"lift": lift >= highest}, lift=lift, highest=highest)
        high = angle - math.acos(lowest + lift / arm)
        outer = pivot + inputs.ball_arm * math.sin(high)
    else:
        outer = inputs.outer_radius
        high = math.asin((outer - pivot) / inputs.ball_arm)
        refuse("hartnell", inputs, {"dead_centre": high >= end}, end=pivot + inputs.ball_arm * math.sin(end))
        lift = arm * (math.cos(angle - high) - lowest)
    middle = angle - math.acos(lowest + 0.5 * lift / arm)
    return Travel(arm_angles=(low, high), middle_angle=middle, radii=(inputs.inner_radius, outer), lift=lift)


def _require_rising_speeds(inputs: HartnellInputs, travel: Travel) -> None:
    """Raise MechanismError for speeds that do not rise with the sleeve."""
    ratio = inputs.highest_speed / inputs.lowest_speed
    least = math.sqrt(travel.radii[0] / travel.radii[1])
    is_isochronous = math.isclose(ratio, 1, rel_tol=1e-9)  # the same text in rpm may differ by rounding
    falls = ratio <= 1 and not is_isochronous
    cases = {"isochronous": is_isochronous, "no_spring": falls and ratio <= least, "unstable": falls and ratio > least}
    refuse("hartnell", inputs, cases, ratio=ratio, least=least)


def _require_spring(forces: list[float], inputs: HartnellInputs) -> None:
    """Raise MechanismError unless a spring that presses the sleeve down, harder in the highest position, gives the exact forces (N)."""
    lowest, highest = forces
    cases = {"lifting_spring": lowest <= 0, "falling_force": lowest > 0 and highest <= lowest}
    ratio = inputs.highest_speed / inputs.lowest_speed
    refuse("hartnell", inputs, cases, lowest=lowest, highest=highest, pull=-lowest, ratio=ratio)


def _make_spring(governor: closed.HartnellGovernor, travel: Travel, forces: list[float], lift: float) -> SleeveSpring:
    """Return the spring with two forces (N) over a lift (m), and the speeds that it gives the exact governor."""
    rate = (forces[1] - forces[0]) / lift
    # the textbooks' lift may differ from the arms' lift, on which the spring is then fitted
    fitted = (forces[0], forces[0] + rate * travel.lift)
    low, high = (_find_speed(governor, angle, force) for angle, force in zip(travel.arm_angles, fitted, strict=True))
    return SleeveSpring(forces=(forces[0], forces[1]), rate=rate, compression=forces[0] / rate, speeds=(low, high))


def _find_speed(governor: closed.HartnellGovernor, arm_angle: float, force: float) -> float:
    """Return the speed of equilibrium (rad/s); raise MechanismError where the weight of the balls alone drives them outward."""
    try:
        return float(closed.equilibrium_speed(governor, arm_angle=arm_angle, spring_force=force))
    except MechanismError as error:
        raise MechanismError(*sentences("hartnell", governor, {"heavy_balls": True}, force=force, at=arm_angle)) from error


def _exact_effort(governor: closed.HartnellGovernor, arm_angle: float, force: float) -> float:
    """Return the mean force (N) on a sleeve held at an arm angle (rad) under a spring force (N), for a change of speed of 1 %."""
    speed = float(closed.equilibrium_speed(governor, arm_angle=arm_angle, spring_force=force))
    raised = float(closed.spring_force(governor, arm_angle=arm_angle, spindle_speed=(1 + SPEED_CHANGE) * speed))
    return 0.5 * (raised - force)

"""Design of a pendulum governor by Zehnder's procedure I to VIII: masses, arms, suspension, positions and limits of speed.

It uses the closed forms only and does not round intermediate results. The arms of length l hang at the offset e from the axis, at the
angle a from the vertical, and the balls move at the distance x = e + l sin a from the axis. With the mass ratio m of sleeve and ball, a
ball is in equilibrium at the speed w where the slope of its path is tan a = w^2 x / (g (1 + m)): everywhere on the parabola x^2 = c y with
c = 2 g (1 + m) / w^2. The arms begin on the parabola of the lowest speed; the closer they come to its radius of curvature, the more they
swing for a given range of speed.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from governor_mechanism.closed_form import parabolic, pendulum, pendulum_sizing
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.model.results.result import Column, format_columns
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.studies.design.skeleton import (
    GOVERNED,
    SPEED_CHANGE,
    Check,
    CheckedDesign,
    fill_rows,
    find_checks,
    mass_ratio_limits,
    refuse,
    relative_range,
    require_valid,
    sentences,
    sleeve_damping,
    speed_steps,
)
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM
from governor_mechanism.units.fields import entry, optional, quantity
from governor_mechanism.units.text_table import fill_places, in_unit

START_RADIUS_CONSTANTS = (1000.0, 1.0)
"""Zehnder's start radius in cm, 1000 sqrt(1 + m) / n - 1 with the lowest speed n in rpm."""

MAX_ARM_ANGLE = math.radians(75)
"""Largest arm angle, rad: above it the speed rises without bound, and the arms run into the spindle head."""

TRIAL_STEPS = np.radians([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
"""Steps of the arm angle in the table of trials, rad; the one is taken that gives the fewest rows but at least MIN_TRIALS."""

MIN_TRIALS = 5
"""Smallest number of trials up to the highest position."""

ARM_TOLERANCE = 1e-9
"""Tolerance of the arm relative to the radius of curvature; both come from the same numbers, up to rounding."""

START_FRACTION, TARGET_FRACTION = 0.5, 0.75
"""Fractions of the lift at which the sleeve of the scene starts, and to which the rise of the speed brings it against the resistance."""

HOLD_TIME = 0.5
"""Time before the speed rises, s."""

RISE_PERIODS, SETTLING_PERIODS = 2.0, 2.5
"""Duration of the rise and time to settle after it, in periods of small oscillations half way up."""

DURATION_LIMITS = (0.5, 60.0)
"""Shortest and longest rise and settling, s: a governor near its astatic position has periods without bound."""

POINTS_PER_PERIOD = 200
"""Reported times in a period."""


_SPEEDS = (1 * RPM, 10_000 * RPM)  # a speed outside has a wrong unit


class GovernorKind(StrEnum):
    """Zehnder's kinds of pendulum governors, which are cases of one calculation."""

    WATT = "watt"
    IMPROVED_WATT = "improved-watt"
    PORTER = "porter"


@dataclass(frozen=True, kw_only=True)
class PendulumInputs:
    """Inputs of a design in SI; None stands for what follows from the kind or from the other inputs.

    Without arm and offset, Watt's governor hangs on the axis, and the arms of the others are as long as the radius of curvature.
    """

    kind: str = entry(
        "choice",
        default="porter",
        words=tuple(map(str, GovernorKind)),
        meaning="watt: no load on the sleeve, arms shorter than the radius of curvature; improved-watt: the same with arms as long as this "
        "radius, which cross; porter: with a load on the sleeve",
    )
    lowest_speed: float | None = optional("angular_speed", meaning="speed of rest n1 in the lowest position", limits=_SPEEDS)
    highest_speed: float | None = optional("angular_speed", meaning="speed of rest n2 in the highest position", limits=_SPEEDS)
    mass_ratio: float | None = optional("ratio", meaning="mass m of the sleeve over the mass of a ball at the joint", sign="not negative")
    insensitivity: float = quantity(
        "ratio", default=0.04, meaning="range of speed in which the resistance holds the sleeve", limits=GOVERNED
    )
    speed_fluctuation: float = quantity(
        "ratio", default=0.025, meaning="coefficient of speed fluctuation that the flywheel leaves", sign="not negative", limits=GOVERNED
    )
    resistance: float | None = optional("force", meaning="resistance W at the sleeve; 6 kgf, or 1 kgf for Watt's governors")
    arm: float | None = optional("length", meaning="length l of the arms up to the balls; it gives the offset, or the offset gives it")
    offset: float | None = optional("length", meaning="distance of the suspension from the axis; negative for crossed arms", sign="any")
    joint_ratio: float = quantity(
        "ratio",
        default=1.0,
        meaning="distance of the joint of arm and link from the suspension over the arm; 1 for links at the balls",
        limits=(0.0, 1.0),
    )
    start_radius: float | None = optional("length", meaning="distance x1 of the balls from the axis in the lowest position")
    gravity: float = quantity("acceleration", default=9.81, meaning="gravitational acceleration")


DEFAULT_INPUTS = PendulumInputs()
"""A Porter governor for 120 to 126 rpm against 6 kgf."""


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """What the procedure starts from, with nothing left open but the geometry: speeds rad/s, resistance N."""

    kind: GovernorKind
    lowest_speed: float
    highest_speed: float
    mass_ratio: float
    resistance: float


@dataclass(frozen=True, kw_only=True)
class ParabolaStart:
    """The lowest position on the parabola x^2 = c y of the lowest speed; lengths m, angle rad."""

    double_parameter: float  # c
    empirical_abscissa: float  # distance from the axis by the empirical rule
    # abscissa, ordinate: distance x1 from the axis that is taken, and height y1 above the vertex
    abscissa: float
    ordinate: float
    arm_angle: float  # angle a1 of the arm from the vertical, the slope of the parabola
    radius_of_curvature: float  # radius of curvature there

    @property
    def parameter(self) -> float:
        """Half of c, m."""
        return self.double_parameter / 2


@dataclass(frozen=True, kw_only=True)
class TrialPosition:
    """A position of step VI: change of the arm angle from the lowest position and arm angle (rad), ball radius (m), speed (rad/s)."""

    angle_change: float
    arm_angle: float
    ball_radius: float
    speed: float


TRIAL_COLUMNS = (
    Column("angle_change", "a2 - a1, deg", ".6g/deg"),
    Column("arm_angle", "a2, deg", ".6f/deg"),
    Column("ball_radius", "x2, mm", ".4f/mm"),
    Column("speed", "w2, rad/s", ".7f"),
    Column("speed", "n2, rpm", ".5f/rpm"),
)


@dataclass(frozen=True)
class DesignStep:
    """A step of the procedure: its number in the paper, the quantity, its formula, its value and the unit of the value."""

    number: str
    quantity: str
    formula: str
    value: float
    unit: str


STEP_COLUMNS = (
    Column("number", "step"),
    Column("quantity", "quantity"),
    Column("formula", "formula"),
    Column("value", "value", ".7g"),
    Column("unit", ""),
)


@dataclass(frozen=True, kw_only=True, repr=False)
class PendulumDesign(CheckedDesign):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs, with the values of their kind.
    requirement
        Kind, speeds, mass ratio and resistance.
    governor
        Dimensions and masses.
    start
        The lowest position and its parabola.
    arm_angles
        Arm angles at the lowest and the highest speed, rad.
    ball_radii
        Distances of the balls from the axis there, m.
    trials
        Positions and speeds on the way, the table of step VI.
    sleeve_lift
        Travel of the sleeve, m.
    sleeve_force
        Force P + Q that holds down the sleeve at standstill, N.
    speed_limits
        Lowest and highest speed that the governor allows with its resistance, steps VII and VIII, rad/s.
    checks
        Zehnder's rules.
    """

    inputs: PendulumInputs
    requirement: Requirement
    governor: PendulumGovernor
    start: ParabolaStart
    arm_angles: tuple[float, float]
    ball_radii: tuple[float, float]
    trials: tuple[TrialPosition, ...]
    sleeve_lift: float
    sleeve_force: float
    speed_limits: tuple[float, float]
    checks: tuple[Check, ...]

    machine = "pendulum"
    derived = ("sensitiveness", "effort", "work_capacity", "middle_angle", "steps", "warnings")

    @property
    def sensitiveness(self) -> float:
        """Range of speed over mean speed, without resistance (German Ungleichförmigkeitsgrad)."""
        return relative_range((self.requirement.lowest_speed, self.requirement.highest_speed))

    @property
    def is_osculating(self) -> bool:
        """Whether the arm is the radius of curvature of the parabola at the lowest position."""
        return math.isclose(self.governor.arm, self.start.radius_of_curvature, rel_tol=1e-9)  # both come from the same numbers

    @property
    def effort(self) -> float:
        """Mean force at the sleeve while it yields to a change of speed of 1 %, N."""
        return self.sleeve_force * ((1 + SPEED_CHANGE) ** 2 - 1) / 2

    @property
    def work_capacity(self) -> float:
        """Work that raises balls and sleeve from the lowest to the highest position, J."""
        return self.sleeve_force * self.sleeve_lift

    @property
    def middle_angle(self) -> float:
        """Arm angle at which the sleeve is half way up, rad."""
        return self.angle_at(START_FRACTION)

    def angle_at(self, fraction: float) -> float:
        """Return the arm angle (rad) at a fraction of the lift of the sleeve."""
        low, high = (math.cos(angle) for angle in self.arm_angles)
        return math.acos(low + fraction * (high - low))

    def equilibrium_speed(self, arm_angle: float) -> float:
        """Return the speed of rest (rad/s) at an arm angle (rad)."""
        return float(pendulum.equilibrium_speed(self.governor, arm_angle=arm_angle))

    @property
    def weights(self) -> tuple[float, float | None, float]:
        """Weights of a ball at the joint, of one on extended arms (None without), and of the sleeve, N."""
        gravity = self.inputs.gravity
        ratio = self.inputs.joint_ratio
        ball = gravity * self.governor.ball_mass
        return ball / ratio, ball if ratio < 1 else None, gravity * self.governor.sleeve_mass

    @property
    def rules(self) -> tuple[str, str, str, str]:
        """Formulas of start radius, arm, and limits of speed, which depend on what is given."""
        inputs = self.inputs
        arm = "given" if inputs.arm is not None else "(x1 - e) / sin a1" if self.governor.arm != self.start.radius_of_curvature else "rho"
        limits = ("n1 (1 - (delta - epsilon) / 2)", "n2 (1 + (delta - epsilon) / 2)")
        if inputs.insensitivity < inputs.speed_fluctuation:
            limits = ("n1: the machine overcomes W", "n2: the machine overcomes W")
        return "1000 sqrt(1 + m) / n1 - 1" if inputs.start_radius is None else "given", arm, *limits

    @property
    def steps(self) -> tuple[DesignStep, ...]:
        """The steps I to VIII with their numbers."""
        rows = fill_rows(self.machine, "steps", self)
        return tuple(DesignStep(number, quantity, formula, in_unit(value, unit), unit) for number, quantity, formula, value, unit in rows)

    @property
    def step_table(self) -> str:
        """The steps as text."""
        return format_columns(STEP_COLUMNS, self.steps)

    @property
    def arms_text(self) -> str:
        """What the arms are called."""
        return "crossed arms" if self.governor.offset < 0 else "arms"

    @property
    def suspension_text(self) -> str:
        """Where the arms hang."""
        return fill_places("at {offset:.5g mm} from the axis", self.governor) if self.governor.offset else "on the axis"

    @property
    def trial_table(self) -> str:
        """The table of step VI as text."""
        return format_columns(TRIAL_COLUMNS, self.trials)

    def target_speed(self) -> float:
        """Return the speed (rad/s) at which the rising sleeve comes to rest at TARGET_FRACTION of its lift: Zehnder's (1)."""
        return self.equilibrium_speed(self.angle_at(TARGET_FRACTION)) * math.sqrt(1 + self.inputs.insensitivity)

    def scene_values(self) -> Mapping[str, object]:
        """Return what the scene adds."""
        # Half way up and in equilibrium, the sleeve is held by its resistance while the speed rises
        # within the band of insensitivity, then rises with it to three quarters of its lift.
        middle = self.middle_angle
        governor = self.governor
        # Stable half way up even with too long an arm: its speed falls faster below the minimum than it rises above.
        frequency = math.sqrt(float(pendulum.squared_oscillation_frequency(governor, arm_angle=middle)))
        inertia = float(pendulum.stiffness(governor, arm_angle=middle)) / frequency**2
        rise, settling = (float(np.clip(periods * math.tau / frequency, *DURATION_LIMITS)) for periods in (RISE_PERIODS, SETTLING_PERIODS))
        times = (0.0, HOLD_TIME, HOLD_TIME + rise, HOLD_TIME + rise + settling)
        first = self.equilibrium_speed(middle)
        last = self.target_speed()
        names = {"watt": "Watt governor", "improved-watt": "Improved Watt governor", "porter": "Porter governor"}
        return {
            "name": names[self.inputs.kind],
            "arm_joint": None if self.inputs.joint_ratio == 1 else governor.joint_length,
            "sleeve_mass": governor.sleeve_mass or None,
            "damping": sleeve_damping(inertia, frequency, 2 * governor.joint_length * math.sin(middle)),
            "speed": speed_steps(times, (first, first, last, last)),
            "duration": times[-1],
            "output_interval": min(0.02, times[-1] / POINTS_PER_PERIOD),
        }


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_pendulum(inputs: PendulumInputs = DEFAULT_INPUTS) -> PendulumDesign:
    """Design a pendulum governor by Zehnder's procedure; by default a Porter governor with arms as long as the radius of curvature."""
    resolved, requirement = _resolve_inputs(inputs)
    start = _place_start(resolved, requirement)
    arm, offset = _choose_arm(resolved, requirement, start)
    governor = _build_governor(resolved, requirement, arm, offset)
    high_angle = _find_high_angle(governor, requirement, start)
    angles = start.arm_angle, high_angle
    margin = max(0.0, resolved.insensitivity - resolved.speed_fluctuation) / 2
    return PendulumDesign(
        inputs=resolved,
        requirement=requirement,
        governor=governor,
        start=start,
        arm_angles=angles,
        ball_radii=(start.abscissa, float(pendulum.ball_radius(governor, arm_angle=high_angle))),
        trials=tuple(_trials(governor, angles)),
        sleeve_lift=2 * governor.joint_length * (math.cos(angles[0]) - math.cos(angles[1])),
        sleeve_force=resolved.gravity * (governor.ball_mass / resolved.joint_ratio + governor.sleeve_mass),
        speed_limits=(requirement.lowest_speed * (1 - margin), requirement.highest_speed * (1 + margin)),
        checks=_checks(resolved, requirement, start, governor),
    )


def _resolve_inputs(inputs: PendulumInputs) -> tuple[PendulumInputs, Requirement]:
    """Return the inputs with the values of their kind, and the requirement from which the procedure starts."""
    kind = GovernorKind(inputs.kind)
    porter = {"lowest_speed": 120 * RPM, "highest_speed": 126 * RPM, "mass_ratio": 4.0, "resistance": 6 * KILOGRAM_FORCE_1853}
    watt = {"lowest_speed": 60 * RPM, "highest_speed": 63 * RPM, "mass_ratio": 0.0, "resistance": KILOGRAM_FORCE_1853}
    defaults = porter if kind is GovernorKind.PORTER else watt
    given = {name: getattr(inputs, name) for name in defaults if getattr(inputs, name) is not None}
    values: dict[str, Any] = defaults | given
    resolved = replace(inputs, **values)
    require_valid("pendulum", resolved, _contradictions)
    return resolved, Requirement(kind=kind, **values)


def _contradictions(inputs: PendulumInputs) -> list[str]:
    """Return a sentence for each input at odds with another; a load on the sleeve belongs to a Porter governor."""
    is_porter = inputs.kind == GovernorKind.PORTER
    cases = {
        "speeds": inputs.lowest_speed >= inputs.highest_speed,  # type: ignore[operator]  # resolved
        "porter_without_load": is_porter and inputs.mass_ratio == 0,
        "watt_with_load": not is_porter and inputs.mass_ratio != 0,
        "arm_and_offset": inputs.arm is not None and inputs.offset is not None,
    }
    return sentences("pendulum", inputs, cases)


def _place_start(inputs: PendulumInputs, requirement: Requirement) -> ParabolaStart:
    """Return the lowest position on the parabola of the lowest speed: steps III, IV and V."""
    speed = requirement.lowest_speed
    ratio = requirement.mass_ratio
    parameter = float(parabolic.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=inputs.gravity))
    factor, subtracted = START_RADIUS_CONSTANTS
    empirical = 0.01 * (factor * math.sqrt(1 + ratio) / (speed / RPM) - subtracted)
    abscissa = empirical if inputs.start_radius is None else inputs.start_radius
    refuse("pendulum", requirement, {"start_radius": abscissa <= 0}, empirical=abscissa)
    angle = math.atan(2 * abscissa / parameter)
    too_steep = {"start_angle": not angle < MAX_ARM_ANGLE}
    refuse("pendulum", requirement, too_steep, angle=angle, most=MAX_ARM_ANGLE, abscissa=abscissa)
    return ParabolaStart(
        double_parameter=parameter,
        empirical_abscissa=empirical,
        abscissa=abscissa,
        ordinate=float(parabolic.parabola_height(abscissa=abscissa, double_parameter=parameter)),
        arm_angle=angle,
        radius_of_curvature=float(parabolic.radius_of_curvature(abscissa=abscissa, double_parameter=parameter)),
    )


def _choose_arm(inputs: PendulumInputs, requirement: Requirement, start: ParabolaStart) -> tuple[float, float]:
    """Return the arm and the offset of its suspension (m) that keep the start and its slope."""
    sine = math.sin(start.arm_angle)
    offset = inputs.offset
    if offset is None and inputs.arm is None and requirement.kind is GovernorKind.WATT:
        offset = 0.0
    if offset is None:
        arm = start.radius_of_curvature if inputs.arm is None else inputs.arm
        return arm, start.abscissa - arm * sine
    refuse("pendulum", start, {"offset": offset >= start.abscissa}, offset=offset)
    return (start.abscissa - offset) / sine, offset


def _build_governor(inputs: PendulumInputs, requirement: Requirement, arm: float, offset: float) -> PendulumGovernor:
    """Return the governor with its masses: steps I, Ia and II."""
    force = {"resistance": requirement.resistance, "mass_ratio": requirement.mass_ratio, "insensitivity": inputs.insensitivity}
    mass_at_joint = float(pendulum_sizing.ball_mass_for_insensitivity(**force, gravity=inputs.gravity))
    return PendulumGovernor(
        arm=arm,
        offset=offset,
        arm_joint=inputs.joint_ratio * arm,
        ball_mass=inputs.joint_ratio * mass_at_joint,
        sleeve_mass=requirement.mass_ratio * mass_at_joint,
        gravity=inputs.gravity,
    )


def _find_high_angle(governor: PendulumGovernor, requirement: Requirement, start: ParabolaStart) -> float:
    """Return the arm angle (rad) at the highest speed: step VI, solved instead of tried."""

    def excess(angle: float) -> float:
        return float(pendulum.equilibrium_speed(governor, arm_angle=angle)) - requirement.highest_speed

    low = start.arm_angle
    if governor.offset < 0:  # crossed arms longer than the radius of curvature are slowest above the start
        low = max(low, math.asin(math.cbrt(-governor.offset / governor.arm)))
    is_too_fast = not low < MAX_ARM_ANGLE or excess(MAX_ARM_ANGLE) < 0
    refuse("pendulum", governor, {"highest_speed": is_too_fast}, speed=requirement.highest_speed, most=MAX_ARM_ANGLE)
    return find_root(excess, low, MAX_ARM_ANGLE)


def _trials(governor: PendulumGovernor, angles: tuple[float, float]) -> Iterator[TrialPosition]:
    """Yield the positions at round steps above the lowest, and the highest: the table that step VI asks for."""
    swing = angles[1] - angles[0]
    step = max((step for step in TRIAL_STEPS.tolist() if swing / step >= MIN_TRIALS), default=swing / MIN_TRIALS)
    for change in (*(step * k for k in range(math.ceil(swing / step - ARM_TOLERANCE))), swing):
        angle = angles[0] + change
        radius, speed = (float(of(governor, arm_angle=angle)) for of in (pendulum.ball_radius, pendulum.equilibrium_speed))
        yield TrialPosition(angle_change=change, arm_angle=angle, ball_radius=radius, speed=speed)


def _checks(inputs: PendulumInputs, requirement: Requirement, start: ParabolaStart, governor: PendulumGovernor) -> tuple[Check, ...]:
    """Return Zehnder's rules, and those of the kind of governor."""
    cure = "change mass_ratio" if requirement.kind is GovernorKind.PORTER else "change lowest_speed, or take kind=porter"
    values = {
        "requirement": requirement,
        "mass_ratios": [max(0.0, ratio) for ratio in mass_ratio_limits(requirement.lowest_speed)],
        "mass_ratio_cure": cure,
        "slope": 2 * start.abscissa / start.double_parameter,
        "arm_ratio": governor.arm / start.radius_of_curvature,
        "offset_ratio": governor.offset / governor.arm,
        "one_or_less": 1 - ARM_TOLERANCE,
        "one_or_more": 1 + ARM_TOLERANCE,
    }
    return find_checks("pendulum", inputs, "checks", requirement.kind, **values)

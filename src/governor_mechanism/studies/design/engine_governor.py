"""Inputs of the design of a governed engine, and its governor and dashpot.

The geometry of the governor follows from the droop, its gear and masses from the speed and the resistance at its sleeve.

The steady motion of engine and governor is stable if and only if Vyshnegradskii's x y > 1. A weak dashpot lets the governor hunt; a strong
one makes it so slow that engine and governor swing together. Between them one damping makes the slowest of all motions decay fastest. It is
chosen for the worst of full, half and no load, by the polynomial of third degree with the mean torque of the engine.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14: procedure I to VIII, with the offset in place of the radius of curvature.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form import pendulum, pendulum_sizing
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.governed_engine import CharacteristicCoefficients, pendulum_coefficients, vyshnegradskii_parameters
from governor_mechanism.closed_form.pendulum import LinkagePosition, PendulumGovernor
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.studies.design.skeleton import GOVERNED, refuse, relative_range, require_valid, sentences
from governor_mechanism.units.constants import HORSEPOWER_1901, RPM
from governor_mechanism.units.fields import optional, quantity

DEFAULT_MASS_RATIO = 4.0
"""Mass of the sleeve over that of one ball if neither it nor the gear ratio is given; Zehnder's rule allows 1 to 9 at 120 rpm."""

DEFAULT_OFFSET_RATIO = 0.05
"""Offset of the arms' suspension over their length if neither it nor the travel of the sleeve is given: room for the spindle."""

# Simulated with dry friction at the sleeve, the default engine overshoots by a fifth of the change of speed
# and settles with a quarter; with a half it takes four times as long, and with three quarters it does not
# settle.
INSENSITIVITY_PER_DROOP = 0.25
"""Insensitivity over the droop unless it is given."""

MAX_ARM_ANGLE = math.radians(75)
"""Largest arm angle without load, rad: above it the speed rises without bound."""

MAX_OFFSET_RATIO = 1.0
"""Largest offset over the length of the arms: beyond it the suspension is wider than the balls."""

LOAD_FRACTIONS = (1.0, 0.5, 0.0)
"""Loads at which the motions are judged, relative to the rated torque."""

SEARCH_DECADES, N_SEARCH_POINTS = 4.0, 161
"""Decades below and above the aperiodic damping of the governor alone in which the best one is sought, and points there: 20 a decade."""

SEARCH_TOLERANCE = 1e-10
"""Tolerance of the decimal logarithm of the damping; the decay rate there has a kink, so that its error is of the same order."""

_SPEED = (5 * RPM, 3000 * RPM)  # slower, flywheels are too heavy; faster, pistons cannot follow
_ARM_ANGLE = (math.radians(5), math.radians(60))  # below, the sleeve hardly moves; above, its speed rises without a use
_DROOP_SIGN = "be above 0: the speed without load is above that at full load, or nothing holds it"
_FLUCTUATION = "coefficient of speed fluctuation that the flywheel allows at full load"
_RESERVE_MEANING = "torque with the throttle open over that of full load, less 1"


@dataclass(frozen=True, kw_only=True)
class GovernedEngineInputs:
    """Inputs of a design in SI; the pressures, cut-off and clearances are those of Redtenbacher's air engine.

    Of offset and sleeve_travel, mass_ratio and gear_ratio, insensitivity and ball_mass each gives the other. Without any, the offset is
    1/20 of the arm, the mass ratio 4, and the insensitivity a quarter of the droop.
    """

    power: float = quantity(
        "power", default=20 * HORSEPOWER_1901, meaning="power at full load and the speed that belongs to it", limits=(1.0, 1e9)
    )
    speed: float = quantity("angular_speed", default=4 * math.pi, meaning="mean of the speeds at full load and without load", limits=_SPEED)
    droop: float = quantity("ratio", default=0.04, meaning="range of these speeds over their mean", hint=_DROOP_SIGN, limits=GOVERNED)
    speed_fluctuation: float = quantity("ratio", default=1 / 40, meaning=_FLUCTUATION, limits=GOVERNED)
    torque_reserve: float = quantity("ratio", default=0.1, meaning=_RESERVE_MEANING, sign="not negative", limits=(0.0, 1.0))
    stroke_ratio: float = quantity("ratio", default=2.0, meaning="stroke over the diameter of the expansion piston")
    pump_area_ratio: float = quantity(
        "ratio", default=1.0, meaning="area of the pump piston over that of the expansion piston, of equal stroke"
    )
    cut_off: float = quantity("ratio", default=0.375, meaning="cut-off relative to the stroke", sign="not negative")
    clearance: float = quantity("ratio", default=0.05, meaning="clearance relative to the volume of the stroke", sign="not negative")
    pump_clearance: float = quantity("ratio", default=0.05, meaning="clearance of the pump relative to the volume of its stroke")
    supply_pressure: float = quantity("pressure", default=4e5, meaning="absolute pressure of supply")
    back_pressure: float = quantity("pressure", default=1.5e5, meaning="absolute pressure behind the piston", sign="not negative")
    atmospheric_pressure: float = quantity("pressure", default=1e5, meaning="absolute pressure of the atmosphere")
    rim_speed: float = quantity("speed", default=15.0, meaning="speed of the middle of the flywheel's rim")
    arm: float = quantity("length", default=0.3, meaning="length of the arms and links of the governor")
    arm_angle: float = quantity("angle", default=math.radians(30), meaning="arm angle at full load", limits=_ARM_ANGLE)
    sleeve_travel: float | None = optional("length", meaning="travel of the sleeve from full load to no load")
    offset: float | None = optional("length", meaning="distance of the suspension from the axis; negative for crossed arms", sign="any")
    mass_ratio: float | None = optional("ratio", meaning="mass of the sleeve over that of one ball")
    gear_ratio: float | None = optional("ratio", meaning="turns of the spindle in a turn of the shaft")
    resistance: float = quantity("force", default=10.0, meaning="force that friction and throttle put up against the sleeve")
    insensitivity: float | None = optional("ratio", meaning="degree of insensitivity with that resistance", limits=GOVERNED)
    ball_mass: float | None = optional("mass", meaning="mass of one ball")
    dashpot: float | None = optional("damping", meaning="damping at the sleeve; by default all motions decay fastest")
    gravity: float = quantity("acceleration", default=9.81, meaning="gravitational acceleration")

    @property
    def full_load_speed(self) -> float:
        """Speed of the shaft at full load, rad/s."""
        return self.speed * (1 - self.droop / 2)

    @property
    def no_load_speed(self) -> float:
        """Speed of the shaft without load, rad/s."""
        return self.speed * (1 + self.droop / 2)

    @property
    def rated_torque(self) -> float:
        """Torque of the load at full load, N m."""
        return self.power / self.full_load_speed

    def engine(self, area: float, stroke: float) -> AirEngine:
        """Return the engine with an expansion piston of an area (m2) and a stroke (m), under the rated torque."""
        names = ("cut_off", "clearance", "pump_clearance", "atmospheric_pressure", "supply_pressure", "back_pressure")
        pump = {"pump_area": self.pump_area_ratio * area, "pump_stroke": stroke}
        load = {"load_pressure": math.pi * self.rated_torque / (area * stroke)}
        return AirEngine(area=area, stroke=stroke, **pump, **load, **{name: getattr(self, name) for name in names})


DEFAULT_INPUTS = GovernedEngineInputs()
"""20 PS at 120 rpm with a droop of 4 %."""


def validate_inputs(inputs: GovernedEngineInputs) -> None:
    """Raise MechanismError, with a sentence per mistake; pressures, cut-off and clearances are also validated by `AirEngine`."""
    require_valid("governed_engine", inputs, _offset_problems, alternatives=_alternative_problems)


def _alternative_problems(inputs: GovernedEngineInputs) -> list[str]:
    """Return a sentence for each pair of inputs of which one gives the other."""
    pairs = (("offset", "sleeve_travel"), ("mass_ratio", "gear_ratio"), ("ball_mass", "insensitivity"))
    return sentences(
        "governed_engine", inputs, {first: None not in (getattr(inputs, first), getattr(inputs, second)) for first, second in pairs}
    )


def _offset_problems(inputs: GovernedEngineInputs) -> list[str]:
    """Return a sentence about crossed arms whose balls would be on the axis."""
    least = -inputs.arm * math.sin(inputs.arm_angle)
    cases = {"balls_on_axis": inputs.offset is not None and inputs.offset <= least}
    return sentences("governed_engine", inputs, cases, least=least)


@dataclass(frozen=True, kw_only=True)
class GovernorDesign(Recorded):
    """A Porter governor with its gear; SI."""

    governor: PendulumGovernor  # dimensions and masses
    gear_ratio: float  # turns of the spindle in a turn of the shaft
    mass_ratio: float  # mass of the sleeve over that of one ball
    # full_load_angle, no_load_angle: arm angles, rad
    full_load_angle: float
    no_load_angle: float
    # full_load_lift, no_load_lift: lifts of the sleeve from its place at vertical arms, m
    full_load_lift: float
    no_load_lift: float
    # full_load_speed, no_load_speed: equilibrium speeds of the shaft at these lifts, rad/s
    full_load_speed: float
    no_load_speed: float
    sleeve_force: float  # force that holds down the sleeve at standstill, N
    insensitivity: float  # degree of insensitivity with the resistance at the sleeve
    effort: float  # mean force at the sleeve while it yields to the whole change of speed from full load to no load, N
    work_capacity: float  # that force times the travel of the sleeve, J
    # lowest and highest speed of the shaft when the resistance holds the sleeve, without the fluctuation in a
    # turn, rad/s
    speed_limits: tuple[float, float]

    derived = ("sleeve_travel",)

    @property
    def sleeve_travel(self) -> float:
        """Travel of the sleeve from full load to no load, m."""
        return self.no_load_lift - self.full_load_lift

    def lift(self, fraction: float) -> float:
        """Return the lift of the sleeve (m) at a fraction of the rated torque: the throttle closes linearly with it."""
        return self.no_load_lift - fraction * self.sleeve_travel

    def arm_angle(self, fraction: float) -> float:
        """Return the arm angle (rad) at a fraction of the rated torque."""
        return float(pendulum_sizing.angle_of_lift(arm=self.governor.arm, lift=self.lift(fraction)))

    def shaft_speed(self, fraction: float) -> float:
        """Return the equilibrium speed of the shaft (rad/s) at a fraction of the rated torque."""
        return float(pendulum.equilibrium_speed(self.governor, arm_angle=self.arm_angle(fraction))) / self.gear_ratio


def design_governor(inputs: GovernedEngineInputs) -> GovernorDesign:
    """Return the governor whose equilibrium speeds at full load and without load are the wanted ones."""
    offset, no_load_angle = _geometry(inputs)
    gear_ratio, mass_ratio = _gear_and_mass_ratio(inputs, offset)
    wanted = INSENSITIVITY_PER_DROOP * inputs.droop if inputs.insensitivity is None else inputs.insensitivity
    ball_mass = inputs.ball_mass
    if ball_mass is None:
        force = {"resistance": inputs.resistance, "mass_ratio": mass_ratio, "insensitivity": wanted}
        ball_mass = float(pendulum_sizing.ball_mass_for_insensitivity(**force, gravity=inputs.gravity))
    masses = {"ball_mass": ball_mass, "sleeve_mass": mass_ratio * ball_mass, "gravity": inputs.gravity}
    governor = PendulumGovernor(arm=inputs.arm, offset=offset, **masses)
    lifts = [_lift(inputs, angle) for angle in (inputs.arm_angle, no_load_angle)]
    low, high = (float(pendulum.equilibrium_speed(governor, arm_angle=angle)) / gear_ratio for angle in (inputs.arm_angle, no_load_angle))
    sleeve_force = float(pendulum_sizing.sleeve_force(**masses))
    insensitivity = inputs.resistance / sleeve_force
    effort = 0.5 * sleeve_force * ((high / low) ** 2 - 1)
    # A resistance that the fluctuation overcomes in every turn does not hold the sleeve.
    margin = max(0.0, insensitivity - inputs.speed_fluctuation) / 2
    return GovernorDesign(
        governor=governor,
        gear_ratio=gear_ratio,
        mass_ratio=mass_ratio,
        full_load_angle=inputs.arm_angle,
        no_load_angle=no_load_angle,
        full_load_lift=lifts[0],
        no_load_lift=lifts[1],
        full_load_speed=low,
        no_load_speed=high,
        sleeve_force=sleeve_force,
        insensitivity=insensitivity,
        effort=effort,
        work_capacity=effort * (lifts[1] - lifts[0]),
        speed_limits=(low * (1 - margin), high * (1 + margin)),
    )


def _geometry(inputs: GovernedEngineInputs) -> tuple[float, float]:
    """Return the offset (m) and the arm angle without load (rad) that give the droop."""
    ratio = inputs.no_load_speed / inputs.full_load_speed
    if inputs.sleeve_travel is not None:
        return _geometry_for_travel(inputs, inputs.sleeve_travel, ratio)
    offset = DEFAULT_OFFSET_RATIO * inputs.arm if inputs.offset is None else inputs.offset
    at_full_load = float(pendulum_sizing.smallest_stable_offset(arm=inputs.arm, arm_angle=inputs.arm_angle))
    refuse("governed_engine", inputs, {"unstable_loaded": offset <= at_full_load}, offset=offset, smallest=at_full_load)
    outer = _angle_for_ratio(inputs, offset, ratio)
    smallest = _smallest_offset(inputs, _lift(inputs, outer) - _lift(inputs))
    refuse("governed_engine", inputs, {"unstable_open": offset <= smallest}, offset=offset, smallest=smallest)
    return offset, outer


def _lift(inputs: GovernedEngineInputs, arm_angle: float | None = None) -> float:
    """Return the lift of the sleeve (m) at an arm angle (rad), by default at full load."""
    return float(pendulum_sizing.lift_of_angle(arm=inputs.arm, arm_angle=inputs.arm_angle if arm_angle is None else arm_angle))


def _smallest_offset(inputs: GovernedEngineInputs, travel: float) -> float:
    """Return the offset (m) above which all equilibria are stable, down to the sleeve's place with an open throttle."""
    full_load_lift = _lift(inputs)
    fall = inputs.torque_reserve * travel
    refuse("governed_engine", inputs, {"fall": full_load_lift <= fall}, fall=fall, lift=full_load_lift)
    lowest_angle = float(pendulum_sizing.angle_of_lift(arm=inputs.arm, lift=full_load_lift - fall))
    return float(pendulum_sizing.smallest_stable_offset(arm=inputs.arm, arm_angle=lowest_angle))


def _geometry_for_travel(inputs: GovernedEngineInputs, travel: float, ratio: float) -> tuple[float, float]:
    """Return the offset (m) with which a given travel of the sleeve has a ratio of the speeds, and the arm angle without load (rad)."""
    largest_travel = _lift(inputs, MAX_ARM_ANGLE) - _lift(inputs)
    limits = {"largest": largest_travel, "angle": MAX_ARM_ANGLE}
    refuse("governed_engine", inputs, {"travel": travel > largest_travel}, **limits, travel=travel)
    outer = float(pendulum_sizing.angle_of_lift(arm=inputs.arm, lift=_lift(inputs) + travel))
    angles = {"arm": inputs.arm, "inner_angle": inputs.arm_angle, "outer_angle": outer}
    offsets = (_smallest_offset(inputs, travel), MAX_OFFSET_RATIO * inputs.arm)
    smallest, largest = (relative_range((1.0, float(pendulum_sizing.speed_ratio(**angles, offset=offset)))) for offset in offsets)
    cases = {"small_droop": inputs.droop <= smallest, "large_droop": inputs.droop > largest}
    refuse("governed_engine", inputs, cases, smallest=smallest, largest=largest)
    return float(pendulum_sizing.offset_for_speed_ratio(**angles, ratio=ratio)), outer


def _angle_for_ratio(inputs: GovernedEngineInputs, offset: float, ratio: float) -> float:
    """Return the arm angle without load (rad) with which a given offset gives a ratio of the speeds."""

    def excess(angle: float) -> float:
        found = pendulum_sizing.speed_ratio(arm=inputs.arm, offset=offset, inner_angle=inputs.arm_angle, outer_angle=angle)
        return float(found) - ratio

    most = excess(MAX_ARM_ANGLE)
    limits = {"largest": relative_range((1.0, most + ratio)), "angle": MAX_ARM_ANGLE}
    refuse("governed_engine", inputs, {"droop": most < 0}, offset=offset, **limits)
    return find_root(excess, inputs.arm_angle, MAX_ARM_ANGLE)


def _gear_and_mass_ratio(inputs: GovernedEngineInputs, offset: float) -> tuple[float, float]:
    """Return the gear ratio and the mass ratio with which the full-load speed is the wanted one."""
    unloaded = PendulumGovernor(arm=inputs.arm, offset=offset, ball_mass=1.0, gravity=inputs.gravity)
    # Without a sleeve; its mass multiplies the square of the speed by 1 + m.
    slowest = float(pendulum.equilibrium_speed(unloaded, arm_angle=inputs.arm_angle)) / inputs.full_load_speed
    if inputs.gear_ratio is None:
        mass_ratio = DEFAULT_MASS_RATIO if inputs.mass_ratio is None else inputs.mass_ratio
        return slowest * math.sqrt(1 + mass_ratio), mass_ratio
    refuse("governed_engine", inputs, {"speed_ratio": inputs.gear_ratio < slowest}, slowest=slowest)
    return inputs.gear_ratio, (inputs.gear_ratio / slowest) ** 2 - 1


@dataclass(frozen=True, kw_only=True)
class LoopMotion:
    """Small motions of engine and governor about an equilibrium."""

    load_fraction: float  # load over the rated torque
    # coefficients a (1/s), b (1/s2), c (1/s3) of the characteristic polynomial s^3 + a s^2 + b s + c
    coefficients: CharacteristicCoefficients
    # x, y: vyshnegradskii's parameters; stable if x y > 1
    x: float
    y: float
    roots: tuple[complex, complex, complex]  # roots of the polynomial, 1/s, the least damped first

    @property
    def decay_rate(self) -> float:
        """Rate at which the slowest motion decays, 1/s; negative if it grows."""
        return -max(root.real for root in self.roots)

    def __str__(self) -> str:
        """Return the motion as a line of text."""
        roots = ", ".join(f"{root:.4g}" if root.imag else f"{root.real:.4g}" for root in self.roots)
        plane = f"x = {self.x:.4g}, y = {self.y:.4g}, x y = {self.x * self.y:.4g}"
        return f"  at {self.load_fraction:.0%} load: {plane}; roots {roots} 1/s"


@dataclass(frozen=True, kw_only=True)
class DashpotDesign(Recorded):
    """A dashpot at the sleeve."""

    damping: float  # its damping, N s/m
    is_given: bool  # whether it was an input
    smallest_stable_damping: float  # damping with x y = 1 at the worst load, N s/m
    motions: tuple[LoopMotion, ...]  # the motions at full, half and no load

    derived = ("decay_rate", "stability_margin")

    @property
    def decay_rate(self) -> float:
        """Rate at which the slowest motion at any of the loads decays, 1/s."""
        return min(motion.decay_rate for motion in self.motions)

    @property
    def exponent(self) -> float:
        """Exponent of the slowest motion, 1/s."""
        return -self.decay_rate

    @property
    def stability_margin(self) -> float:
        """Smallest x y of the loads; 1 is Vyshnegradskii's limit."""
        return min(motion.x * motion.y for motion in self.motions)

    @property
    def origin(self) -> str:
        """Where it comes from."""
        return "given" if self.is_given else "with which all motions decay fastest"


def design_dashpot(
    governor: GovernorDesign,
    flywheel_inertia: float,  # moment of inertia of flywheel and shaft, kg m2
    torque_slope: float,  # dM/dz of the engine's mean torque by the lift of the sleeve, N m/m; negative
    given: float | None,  # damping of a given dashpot, N s/m; None to choose it
) -> DashpotDesign:
    """Return the dashpot with which all motions decay fastest, or a given one."""
    shaft = {"flywheel_inertia": flywheel_inertia, "torque_slope": torque_slope, "gear_ratio": governor.gear_ratio}
    damping = _best_damping(governor, shaft) if given is None else given
    return DashpotDesign(
        damping=damping,
        is_given=given is not None,
        smallest_stable_damping=max(_limiting_damping(governor, shaft, fraction) for fraction in LOAD_FRACTIONS),
        motions=tuple(_motion(governor, shaft, fraction, damping) for fraction in LOAD_FRACTIONS),
    )


def _motion(governor: GovernorDesign, shaft: Mapping[str, Any], fraction: float, damping: float) -> LoopMotion:
    """Return the motions at a load with a dashpot."""
    coefficients = pendulum_coefficients(governor.governor, arm_angle=governor.arm_angle(fraction), sleeve_damping=damping, **shaft)
    x, y = (float(value) for value in vyshnegradskii_parameters(coefficients))
    return LoopMotion(load_fraction=fraction, coefficients=coefficients, x=x, y=y, roots=coefficients.roots())


def _limiting_damping(governor: GovernorDesign, shaft: Mapping[str, Any], fraction: float) -> float:
    """Return the damping with a b = c, N s/m: a is proportional to it, and b and c do not depend on it without self-regulation."""
    unit = _motion(governor, shaft, fraction, 1.0).coefficients
    return float(unit.c) / (float(unit.a) * float(unit.b))


def _best_damping(governor: GovernorDesign, shaft: Mapping[str, Any]) -> float:
    """Return the damping with the largest decay rate of the slowest motion at the worst load, N s/m."""
    angle = governor.arm_angle(LOAD_FRACTIONS[1])
    position = LinkagePosition(governor.governor, angle)
    inertia = float(position.in_plane_inertia_and_derivative()[0])
    stiffness = float(pendulum.stiffness(governor.governor, arm_angle=angle))
    aperiodic = 2 * np.sqrt(inertia * stiffness) / float(position.sleeve_derivative) ** 2

    def growth_rate(exponent: float) -> float:
        damping = float(aperiodic * 10.0**exponent)
        return -min(_motion(governor, shaft, fraction, damping).decay_rate for fraction in LOAD_FRACTIONS)

    grid = np.linspace(-SEARCH_DECADES, SEARCH_DECADES, N_SEARCH_POINTS)
    best = int(np.argmin([growth_rate(float(exponent)) for exponent in grid]))
    bounds = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(growth_rate, bounds=bounds, method="bounded", options={"xatol": SEARCH_TOLERANCE})
    return float(aperiodic * 10.0 ** float(found.x))

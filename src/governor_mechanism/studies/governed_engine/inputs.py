"""The inputs of the design of a governed engine, and what makes them invalid."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.closed_form.flywheel.engine import AirEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design_inputs import design_input, input_kinds
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

DEFAULT_MASS_RATIO = 4.0
"""Mass of the sleeve over that of one ball if neither it nor the gear ratio is given; Zehnder's rule allows 1 to 9 at 120 rpm."""

DEFAULT_OFFSET_RATIO = 0.05
"""Offset of the arms' suspension over their length if neither it nor the travel of the sleeve is given: room for the spindle."""

SPEED_LIMITS = (5 * math.pi / 30, 3000 * math.pi / 30)
"""Lowest and highest speed of an engine that can be designed, rad/s: slower, flywheels are too heavy; faster, pistons cannot follow."""

POWER_LIMITS = (1.0, 1e9)
"""Smallest and largest power of an engine that can be designed, W; a wider range means that a unit is wrong."""

INSENSITIVITY_PER_DROOP = 0.25
"""Insensitivity over the droop unless it is given.

Simulated with dry friction at the sleeve, the default engine overshoots by a fifth of the change of speed and settles with a quarter; with
a half it takes four times as long, and with three quarters it does not settle.
"""

MAX_RATIO = 0.5
"""Largest droop, speed fluctuation and insensitivity: what changes its speed by more is not governed."""

ARM_ANGLE_LIMITS = (math.radians(5), math.radians(60))
"""Smallest and largest arm angle at full load, rad: below, the sleeve hardly moves; above, its speed rises without a use."""

_MAY_BE_ZERO = ("torque_reserve", "cut_off", "clearance", "back_pressure")
_OF_ANY_SIGN = ("offset",)
_ALTERNATIVES = (("offset", "sleeve_travel"), ("mass_ratio", "gear_ratio"), ("ball_mass", "insensitivity"))


@dataclass(frozen=True, kw_only=True)
class GovernedEngineInputs:
    """Inputs of a design in SI; the pressures, cut-off and clearances are those of Redtenbacher's air engine.

    Attributes
    ----------
    power
        Power of the engine at full load and the speed that belongs to it, W.
    speed
        Mean of the speeds at full load and without load, rad/s.
    droop
        Speed without load less that at full load, over their mean.
    speed_fluctuation
        Coefficient of speed fluctuation that the flywheel allows at full load, (highest - lowest) / mean speed in a turn.
    torque_reserve
        Torque with the throttle open over that of full load, less 1: what is left to bring the speed up again.
    stroke_ratio
        Stroke over the diameter of the expansion piston.
    pump_area_ratio
        Area of the pump piston over that of the expansion piston; both have the same stroke.
    cut_off, clearance, pump_clearance
        Cut-off relative to the stroke, and clearances relative to the volumes of the strokes.
    supply_pressure, back_pressure, atmospheric_pressure
        Absolute pressures, Pa.
    rim_speed
        Speed of the middle of the flywheel's rim, m/s.
    arm
        Length of the arms and links of the governor, m.
    arm_angle
        Arm angle at full load, rad.
    sleeve_travel
        Travel of the sleeve from full load to no load, m. It gives the offset, or the offset gives it.
    offset
        Distance of the arms' suspension from the spindle axis, m; negative for crossed arms; 1/20 of the arm if nothing is given.
    mass_ratio
        Mass of the sleeve over that of one ball; 4 if nothing is given. It gives the gear ratio, or the gear ratio gives it.
    gear_ratio
        Turns of the spindle in a turn of the shaft.
    resistance
        Force that friction and throttle put up against the sleeve, N.
    insensitivity
        Degree of insensitivity with that resistance; a quarter of the droop if nothing is given. It gives the mass of the balls, or that
        mass gives it.
    ball_mass
        Mass of one ball, kg.
    dashpot
        Damping of the dashpot at the sleeve, N s/m; that with which all motions decay fastest if it is left out.
    gravity
        Gravitational acceleration, m/s2.
    """

    power: float = design_input("power", 20 * 75 * 9.80665)
    speed: float = design_input("angular_speed", 4 * math.pi)
    droop: float = design_input("ratio", 0.04)
    speed_fluctuation: float = design_input("ratio", 1 / 40)
    torque_reserve: float = design_input("ratio", 0.1)
    stroke_ratio: float = design_input("ratio", 2.0)
    pump_area_ratio: float = design_input("ratio", 1.0)
    cut_off: float = design_input("ratio", 0.375)
    clearance: float = design_input("ratio", 0.05)
    pump_clearance: float = design_input("ratio", 0.05)
    supply_pressure: float = design_input("pressure", 4e5)
    back_pressure: float = design_input("pressure", 1.5e5)
    atmospheric_pressure: float = design_input("pressure", 1e5)
    rim_speed: float = design_input("speed", 15.0)
    arm: float = design_input("length", 0.3)
    arm_angle: float = design_input("angle", math.radians(30))
    sleeve_travel: float | None = design_input("length", None)
    offset: float | None = design_input("length", None)
    mass_ratio: float | None = design_input("ratio", None)
    gear_ratio: float | None = design_input("ratio", None)
    resistance: float = design_input("force", 10.0)
    insensitivity: float | None = design_input("ratio", None)
    ball_mass: float | None = design_input("mass", None)
    dashpot: float | None = design_input("damping", None)
    gravity: float = design_input("acceleration", 9.81)

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
        return AirEngine(
            area=area,
            stroke=stroke,
            cut_off=self.cut_off,
            clearance=self.clearance,
            pump_area=self.pump_area_ratio * area,
            pump_stroke=stroke,
            pump_clearance=self.pump_clearance,
            atmospheric_pressure=self.atmospheric_pressure,
            supply_pressure=self.supply_pressure,
            back_pressure=self.back_pressure,
            load_pressure=math.pi * self.rated_torque / (area * stroke),
        )


DEFAULT_INPUTS = GovernedEngineInputs()
"""20 PS at 120 rpm with a droop of 4 %."""


def validate_inputs(inputs: GovernedEngineInputs) -> None:
    """Raise MechanismError, with a sentence per mistake, for inputs that are not valid.

    Parameters
    ----------
    inputs
        The inputs; pressures, cut-off and clearances are also validated by `AirEngine`.
    """
    problems = [*_sign_problems(inputs), *_alternative_problems(inputs)] or list(_range_problems(inputs))
    if problems:
        raise MechanismError(*problems)


def _sign_problems(inputs: GovernedEngineInputs) -> Iterator[str]:
    """Yield a sentence for each input that is not positive, or negative where 0 is allowed."""
    for name, kind in input_kinds(inputs).items():
        value = getattr(inputs, name)
        if value is None or name in _OF_ANY_SIGN or value > 0 or (name in _MAY_BE_ZERO and value == 0):
            continue
        found = format_quantity(value, QUANTITY_KINDS[kind].si_unit).strip()
        if name == "droop":
            yield f"droop must be above 0: the speed without load is above that at full load, or nothing holds it; got {found}"
        else:
            yield f"{name} must {'not be negative' if name in _MAY_BE_ZERO else 'be positive'}; got {found}"


def _alternative_problems(inputs: GovernedEngineInputs) -> Iterator[str]:
    """Yield a sentence for each pair of inputs of which one gives the other."""
    for pair in _ALTERNATIVES:
        if all(getattr(inputs, name) is not None for name in pair):
            yield f"{pair[0]} and {pair[1]} are given, but each follows from the other; give only one of them"


def _range_problems(inputs: GovernedEngineInputs) -> Iterator[str]:
    """Yield a sentence for each input out of its range."""
    for name in ("droop", "speed_fluctuation", "insensitivity"):
        value = getattr(inputs, name)
        if value is not None and value > MAX_RATIO:
            yield f"{name} must be at most {MAX_RATIO:.0%}, where nothing is governed; got {value:.4%}"
    if inputs.torque_reserve > 1:
        yield f"torque_reserve must be at most 100 % of the torque at full load; got {inputs.torque_reserve:.4%}"
    slowest, fastest = SPEED_LIMITS
    if not slowest <= inputs.speed <= fastest:
        limits = " to ".join(format_quantity(speed, "rad/s") for speed in SPEED_LIMITS)
        yield f"speed must be {limits}, for which piston engines are built; got {format_quantity(inputs.speed, 'rad/s')}"
    smallest, largest = POWER_LIMITS
    if not smallest <= inputs.power <= largest:
        yield f"power must be {smallest:g} W to {largest / 1e9:g} GW; got {inputs.power:.6g} W"
    low, high = ARM_ANGLE_LIMITS
    if not low <= inputs.arm_angle <= high:
        limits = " to ".join(format_quantity(angle, "rad") for angle in ARM_ANGLE_LIMITS)
        yield f"arm_angle must be {limits}; got {format_quantity(inputs.arm_angle, 'rad')}"
    if inputs.offset is not None and inputs.offset <= -inputs.arm * math.sin(inputs.arm_angle):
        least = format_quantity(-inputs.arm * math.sin(inputs.arm_angle), "m")
        yield f"offset must be above {least}, where the balls are on the axis at full load; got {format_quantity(inputs.offset, 'm')}"

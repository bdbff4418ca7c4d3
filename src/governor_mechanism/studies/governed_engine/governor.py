"""The governor of a design: its geometry from the droop, its gear and masses from the speed and the resistance at its sleeve.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14: procedure I to VIII, with the offset in place of the radius of curvature.
"""

import math
from dataclasses import dataclass
from typing import Any

from governor_mechanism.closed_form.pendulum import dynamics, sizing
from governor_mechanism.closed_form.pendulum.kinematics import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.studies.governed_engine.inputs import (
    DEFAULT_MASS_RATIO,
    DEFAULT_OFFSET_RATIO,
    INSENSITIVITY_PER_DROOP,
    GovernedEngineInputs,
)
from governor_mechanism.units.quantities import format_quantity

MAX_ARM_ANGLE = math.radians(75)
"""Largest arm angle without load, rad: above it the speed rises without bound."""

MAX_OFFSET_RATIO = 1.0
"""Largest offset over the length of the arms: beyond it the suspension is wider than the balls."""


@dataclass(frozen=True, kw_only=True)
class GovernorDesign:
    """A Porter governor with its gear; SI.

    Attributes
    ----------
    governor
        Dimensions and masses.
    gear_ratio
        Turns of the spindle in a turn of the shaft.
    mass_ratio
        Mass of the sleeve over that of one ball.
    full_load_angle, no_load_angle
        Arm angles, rad.
    full_load_lift, no_load_lift
        Lifts of the sleeve from its place at vertical arms, m.
    full_load_speed, no_load_speed
        Equilibrium speeds of the shaft at these lifts, rad/s.
    sleeve_force
        Force that holds down the sleeve at standstill, N.
    insensitivity
        Degree of insensitivity with the resistance at the sleeve.
    effort
        Mean force at the sleeve while it yields to the whole change of speed from full load to no load, N.
    work_capacity
        That force times the travel of the sleeve, J.
    speed_limits
        Lowest and highest speed of the shaft when the resistance holds the sleeve, without the fluctuation in a turn, rad/s.
    """

    governor: PendulumGovernor
    gear_ratio: float
    mass_ratio: float
    full_load_angle: float
    no_load_angle: float
    full_load_lift: float
    no_load_lift: float
    full_load_speed: float
    no_load_speed: float
    sleeve_force: float
    insensitivity: float
    effort: float
    work_capacity: float
    speed_limits: tuple[float, float]

    @property
    def sleeve_travel(self) -> float:
        """Travel of the sleeve from full load to no load, m."""
        return self.no_load_lift - self.full_load_lift

    def lift(self, fraction: float) -> float:
        """Return the lift of the sleeve (m) at a fraction of the rated torque: the throttle closes linearly with it."""
        return self.no_load_lift - fraction * self.sleeve_travel

    def arm_angle(self, fraction: float) -> float:
        """Return the arm angle (rad) at a fraction of the rated torque."""
        return float(sizing.angle_of_lift(arm=self.governor.arm, lift=self.lift(fraction)))

    def shaft_speed(self, fraction: float) -> float:
        """Return the equilibrium speed of the shaft (rad/s) at a fraction of the rated torque."""
        return float(dynamics.equilibrium_speed(self.governor, arm_angle=self.arm_angle(fraction))) / self.gear_ratio

    def as_json(self) -> dict[str, Any]:
        """Return the governor as plain values."""
        return plain_record(self, sleeve_travel=self.sleeve_travel)


def design_governor(inputs: GovernedEngineInputs) -> GovernorDesign:
    """Return the governor whose equilibrium speeds at full load and without load are the wanted ones.

    Parameters
    ----------
    inputs
        Valid inputs.

    Returns
    -------
    GovernorDesign
        The governor.

    Raises
    ------
    MechanismError
        If the geometry cannot give the droop, or the gear ratio not the speed.
    """
    offset, no_load_angle = _geometry(inputs)
    gear_ratio, mass_ratio = _gear_and_mass_ratio(inputs, offset)
    wanted = INSENSITIVITY_PER_DROOP * inputs.droop if inputs.insensitivity is None else inputs.insensitivity
    ball_mass = inputs.ball_mass
    if ball_mass is None:
        force = {"resistance": inputs.resistance, "mass_ratio": mass_ratio, "insensitivity": wanted}
        ball_mass = float(sizing.ball_mass_for_insensitivity(**force, gravity=inputs.gravity))
    governor = PendulumGovernor(
        arm=inputs.arm, offset=offset, ball_mass=ball_mass, sleeve_mass=mass_ratio * ball_mass, gravity=inputs.gravity
    )
    lifts = [float(sizing.lift_of_angle(arm=inputs.arm, arm_angle=angle)) for angle in (inputs.arm_angle, no_load_angle)]
    low, high = (float(dynamics.equilibrium_speed(governor, arm_angle=angle)) / gear_ratio for angle in (inputs.arm_angle, no_load_angle))
    sleeve_force = float(sizing.sleeve_force(ball_mass=ball_mass, sleeve_mass=governor.sleeve_mass, gravity=inputs.gravity))
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


def droop_of_speed_ratio(ratio: float) -> float:
    """Return the droop, difference over mean, that belongs to a ratio of the speeds without load and at full load."""
    return 2 * (ratio - 1) / (ratio + 1)


def _geometry(inputs: GovernedEngineInputs) -> tuple[float, float]:
    """Return the offset (m) and the arm angle without load (rad) that give the droop."""
    ratio = inputs.no_load_speed / inputs.full_load_speed
    if inputs.sleeve_travel is not None:
        return _geometry_for_travel(inputs, inputs.sleeve_travel, ratio)
    offset = DEFAULT_OFFSET_RATIO * inputs.arm if inputs.offset is None else inputs.offset
    outer = _angle_for_ratio(inputs, offset, ratio)
    smallest = _smallest_offset(inputs, float(sizing.lift_of_angle(arm=inputs.arm, arm_angle=outer)) - _full_load_lift(inputs))
    if offset <= smallest:
        raise MechanismError(
            f"offset must be above {format_quantity(smallest, 'm')}, or the equilibrium is unstable where the throttle is open; got "
            f"{format_quantity(offset, 'm')}; increase it or arm_angle"
        )
    return offset, outer


def _full_load_lift(inputs: GovernedEngineInputs) -> float:
    """Return the lift of the sleeve at full load, m."""
    return float(sizing.lift_of_angle(arm=inputs.arm, arm_angle=inputs.arm_angle))


def _smallest_offset(inputs: GovernedEngineInputs, travel: float) -> float:
    """Return the offset (m) above which all equilibria are stable, down to the sleeve's place with an open throttle."""
    full_load_lift = _full_load_lift(inputs)
    lowest_lift = full_load_lift - inputs.torque_reserve * travel
    if lowest_lift <= 0:
        raise MechanismError(
            f"the sleeve cannot fall by {format_quantity(full_load_lift - lowest_lift, 'm')}, the torque_reserve, below its place at full "
            f"load: at {format_quantity(full_load_lift, 'm')} below it the arms are vertical; reduce torque_reserve or the travel of the "
            "sleeve, or increase arm_angle"
        )
    lowest_angle = float(sizing.angle_of_lift(arm=inputs.arm, lift=lowest_lift))
    return float(sizing.smallest_stable_offset(arm=inputs.arm, arm_angle=lowest_angle))


def _geometry_for_travel(inputs: GovernedEngineInputs, travel: float, ratio: float) -> tuple[float, float]:
    """Return the offset (m) with which a given travel of the sleeve has a ratio of the speeds, and the arm angle without load (rad)."""
    arm, inner = inputs.arm, inputs.arm_angle
    largest_travel = float(sizing.lift_of_angle(arm=arm, arm_angle=MAX_ARM_ANGLE)) - _full_load_lift(inputs)
    if travel > largest_travel:
        raise MechanismError(
            f"sleeve_travel must be at most {format_quantity(largest_travel, 'm')}, with which the arms are at "
            f"{math.degrees(MAX_ARM_ANGLE):.6g} deg without load; got {format_quantity(travel, 'm')}; reduce it or arm_angle, or lengthen "
            "the arm"
        )
    outer = float(sizing.angle_of_lift(arm=arm, lift=_full_load_lift(inputs) + travel))
    angles = {"arm": arm, "inner_angle": inner, "outer_angle": outer}
    limits = _smallest_offset(inputs, travel), MAX_OFFSET_RATIO * arm
    smallest, largest = (droop_of_speed_ratio(float(sizing.speed_ratio(**angles, offset=offset))) for offset in limits)
    if not smallest < inputs.droop <= largest:
        cure = "reduce sleeve_travel or increase arm_angle" if inputs.droop <= smallest else "increase sleeve_travel or reduce arm_angle"
        raise MechanismError(
            f"a droop of {inputs.droop:.4%} cannot be had with a sleeve_travel of {format_quantity(travel, 'm')}, arms of "
            f"{format_quantity(arm, 'm')} and arm_angle {format_quantity(inner, 'rad')}: it is above {smallest:.4%}, where crossed arms "
            f"become unstable, and at most {largest:.4%}, with an offset as long as the arms; {cure}"
        )
    return float(sizing.offset_for_speed_ratio(**angles, ratio=ratio)), outer


def _angle_for_ratio(inputs: GovernedEngineInputs, offset: float, ratio: float) -> float:
    """Return the arm angle without load (rad) with which a given offset gives a ratio of the speeds."""
    smallest = float(sizing.smallest_stable_offset(arm=inputs.arm, arm_angle=inputs.arm_angle))
    if offset <= smallest:
        raise MechanismError(
            f"offset must be above {format_quantity(smallest, 'm')}, or the equilibrium at full load is unstable; got "
            f"{format_quantity(offset, 'm')}; increase it or arm_angle"
        )

    def excess(angle: float) -> float:
        found = sizing.speed_ratio(arm=inputs.arm, offset=offset, inner_angle=inputs.arm_angle, outer_angle=angle)
        return float(found) - ratio

    if excess(MAX_ARM_ANGLE) < 0:
        largest = droop_of_speed_ratio(excess(MAX_ARM_ANGLE) + ratio)
        raise MechanismError(
            f"a droop of {inputs.droop:.4%} cannot be had with an offset of {format_quantity(offset, 'm')} and arm_angle "
            f"{format_quantity(inputs.arm_angle, 'rad')}: it is at most {largest:.4%}, with the arms at "
            f"{math.degrees(MAX_ARM_ANGLE):.6g} deg without load; increase offset or reduce arm_angle"
        )
    return find_root(excess, inputs.arm_angle, MAX_ARM_ANGLE)


def _gear_and_mass_ratio(inputs: GovernedEngineInputs, offset: float) -> tuple[float, float]:
    """Return the gear ratio and the mass ratio with which the full-load speed is the wanted one."""
    unloaded = PendulumGovernor(arm=inputs.arm, offset=offset, ball_mass=1.0, gravity=inputs.gravity)
    # Without a sleeve; its mass multiplies the square of the speed by 1 + m.
    slowest = float(dynamics.equilibrium_speed(unloaded, arm_angle=inputs.arm_angle)) / inputs.full_load_speed
    if inputs.gear_ratio is None:
        mass_ratio = DEFAULT_MASS_RATIO if inputs.mass_ratio is None else inputs.mass_ratio
        return slowest * math.sqrt(1 + mass_ratio), mass_ratio
    if inputs.gear_ratio < slowest:
        raise MechanismError(
            f"gear_ratio must be at least {slowest:.6g}, with which the governor holds the speed without any mass of the sleeve; got "
            f"{inputs.gear_ratio:.6g}; increase it, or lengthen the arm"
        )
    return inputs.gear_ratio, (inputs.gear_ratio / slowest) ** 2 - 1

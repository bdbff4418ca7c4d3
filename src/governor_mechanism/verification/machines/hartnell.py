"""Hartnell's governor against its closed form: ball radius, equilibrium speed, stability, motion, energy."""

import math
from collections.abc import Iterable
from functools import partial

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatOrArray
from governor_mechanism.verification.machines.comparisons import Checks
from governor_mechanism.verification.machines.sleeve_governor import LIFT_READING, GovernorFormulas, check_sleeve_governor


def check_hartnell_governor(scene: Scene) -> Checks:
    """Yield every comparison that applies to the scene."""
    governor = build_hartnell_closed_form(scene)
    springs = [one for one in scene.effects if isinstance(one, OutputSpring) and one.reading == LIFT_READING]
    force = partial(_spring_force, governor, springs, _zero_lift_height(scene))
    rate = sum(spring.rate for spring in springs)

    def equilibrium_speed(*, arm_angle: FloatOrArray) -> FloatOrArray:
        return closed.equilibrium_speed(governor, arm_angle=arm_angle, spring_force=force(arm_angle))

    def squared_frequency(*, arm_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
        load = {"spring_force": force(arm_angle), "spring_rate": rate}
        return closed.squared_natural_frequency(governor, arm_angle=arm_angle, spindle_speed=spindle_speed, **load)

    def acceleration(*, arm_angle: FloatOrArray, **motion: FloatOrArray) -> FloatOrArray:
        return closed.arm_acceleration(governor, arm_angle=arm_angle, spring_force=force(arm_angle), **motion)

    formulas = GovernorFormulas(
        ball_radius=partial(closed.ball_radius, governor),
        equilibrium_speed=equilibrium_speed,
        squared_frequency=squared_frequency,
        acceleration=acceleration,
        spindle_acceleration=partial(closed.spindle_acceleration, governor),
    )
    yield from check_sleeve_governor(scene, formulas, OutputSpring)


def build_hartnell_closed_form(scene: Scene) -> closed.HartnellGovernor:
    """Return the closed form's governor of a scene."""
    dimensions = scene.part.dimensions
    names = ("ball_arm", "sleeve_arm", "pivot_radius", "ball_mass", "sleeve_mass")
    return closed.HartnellGovernor(
        **{name: dimensions[name] for name in names}, angle=dimensions["bell_crank_angle"], gravity=scene.gravity
    )


def _zero_lift_height(scene: Scene) -> float:
    """Return the height of the rollers above the pivots at zero lift, m."""
    dimensions = scene.part.dimensions
    sine = (dimensions["inner_radius"] - dimensions["pivot_radius"]) / dimensions["ball_arm"]
    # cos(angle - beta) from the sine of beta
    height = math.cos(dimensions["bell_crank_angle"]) * math.sqrt(1 - sine**2) + math.sin(dimensions["bell_crank_angle"]) * sine
    return dimensions["sleeve_arm"] * height


def _spring_force(
    governor: closed.HartnellGovernor, springs: Iterable[OutputSpring], zero_lift_height: float, arm_angle: FloatOrArray
) -> FloatOrArray:
    """Return the force (N) of the springs on the sleeve, downward, at an arm angle (rad)."""
    lift = closed.sleeve_height(governor, arm_angle=arm_angle) - zero_lift_height
    return sum((spring.preload + spring.rate * (lift - spring.zero) for spring in springs), 0.0 * lift)

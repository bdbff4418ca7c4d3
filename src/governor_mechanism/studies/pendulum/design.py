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
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from governor_mechanism.closed_form import parabolic
from governor_mechanism.closed_form.pendulum import dynamics, sizing
from governor_mechanism.closed_form.pendulum.kinematics import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.studies.governed_engine.results import Check
from governor_mechanism.studies.pendulum.inputs import DEFAULT_INPUTS, RPM, GovernorKind, PendulumInputs, Requirement, resolve_inputs
from governor_mechanism.studies.pendulum.results import ParabolaStart, PendulumDesign, TrialPosition
from governor_mechanism.studies.pendulum.scene_export import export_scene_document
from governor_mechanism.units.quantities import format_quantity

MASS_RATIO_CONSTANTS = (80.0, 15.0)
"""Zehnder's limits of the mass ratio m: w^2 / 80 - 1 to w^2 / 15 - 1, with the lowest speed w in rad/s."""

START_RADIUS_CONSTANTS = (1000.0, 1.0)
"""Zehnder's start radius in cm, 1000 sqrt(1 + m) / n - 1 with the lowest speed n in rpm."""

MAX_ARM_ANGLE = math.radians(75)
"""Largest arm angle, rad: above it the speed rises without bound, and the arms run into the spindle head."""

TRIAL_STEPS = np.radians([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
"""Steps of the arm angle in the table of trials, rad; that is taken which gives the fewest rows but at least MIN_TRIALS."""

MIN_TRIALS = 5
"""Smallest number of trials up to the highest position."""

ARM_TOLERANCE = 1e-9
"""Tolerance of the arm relative to the radius of curvature; both come from the same numbers, up to rounding."""


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_pendulum(inputs: PendulumInputs = DEFAULT_INPUTS) -> PendulumDesign:
    """Design a pendulum governor by Zehnder's procedure.

    Parameters
    ----------
    inputs
        The inputs; by default a Porter governor with arms as long as the radius of curvature.

    Returns
    -------
    PendulumDesign
        The design.

    Raises
    ------
    MechanismError
        If the inputs are not valid, or no such governor reaches the highest speed.
    """
    resolved, requirement = resolve_inputs(inputs)
    start = _place_start(resolved, requirement)
    arm, offset = _choose_arm(resolved, requirement, start)
    governor = _build_governor(resolved, requirement, arm, offset)
    high_angle = _find_high_angle(governor, requirement, start)
    angles = start.arm_angle, high_angle
    lift = 2 * governor.joint_length * (math.cos(angles[0]) - math.cos(angles[1]))
    margin = max(0.0, resolved.insensitivity - resolved.speed_fluctuation) / 2
    weight = resolved.gravity * (governor.ball_mass / resolved.joint_ratio + governor.sleeve_mass)
    design = PendulumDesign(
        inputs=resolved,
        requirement=requirement,
        governor=governor,
        start=start,
        arm_angles=angles,
        ball_radii=(start.abscissa, float(dynamics.ball_radius(governor, arm_angle=high_angle))),
        trials=tuple(_trials(governor, angles)),
        sleeve_lift=lift,
        sleeve_force=weight,
        speed_limits=(requirement.lowest_speed * (1 - margin), requirement.highest_speed * (1 + margin)),
        checks=tuple(_checks(resolved, requirement, start, governor)),
    )
    return replace(design, scene_document=export_scene_document(design))


def _place_start(inputs: PendulumInputs, requirement: Requirement) -> ParabolaStart:
    """Return the lowest position on the parabola of the lowest speed: steps III, IV and V."""
    speed, ratio = requirement.lowest_speed, requirement.mass_ratio
    parameter = float(parabolic.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=inputs.gravity))
    factor, subtracted = START_RADIUS_CONSTANTS
    empirical = 0.01 * (factor * math.sqrt(1 + ratio) / (speed / RPM) - subtracted)
    abscissa = empirical if inputs.start_radius is None else inputs.start_radius
    if abscissa <= 0:
        raise MechanismError(
            f"the empirical start radius, 1000 sqrt(1 + m) / n - 1 in cm, is {100 * abscissa:.4g} cm at {speed / RPM:.6g} rpm and "
            f"m = {ratio:g}; it must be positive: increase mass_ratio, or give start_radius"
        )
    angle = math.atan(2 * abscissa / parameter)
    if not angle < MAX_ARM_ANGLE:
        raise MechanismError(
            f"the arms hang at {math.degrees(angle):.4g} deg from the vertical in the lowest position; at most "
            f"{math.degrees(MAX_ARM_ANGLE):g} deg are possible: reduce start_radius ({format_quantity(abscissa, 'm')}) or lowest_speed"
        )
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
    if offset >= start.abscissa:
        raise MechanismError(
            f"offset ({format_quantity(offset, 'm')}) must be below the start radius ({format_quantity(start.abscissa, 'm')}), or the arms "
            "would hang inward; reduce offset, or give a larger start_radius"
        )
    return (start.abscissa - offset) / sine, offset


def _build_governor(inputs: PendulumInputs, requirement: Requirement, arm: float, offset: float) -> PendulumGovernor:
    """Return the governor with its masses: steps I, Ia and II."""
    force = {"resistance": requirement.resistance, "mass_ratio": requirement.mass_ratio, "insensitivity": inputs.insensitivity}
    mass_at_joint = float(sizing.ball_mass_for_insensitivity(**force, gravity=inputs.gravity))
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
        return float(dynamics.equilibrium_speed(governor, arm_angle=angle)) - requirement.highest_speed

    low = start.arm_angle
    if governor.offset < 0:  # crossed arms longer than the radius of curvature are slowest above the start
        low = max(low, math.asin(math.cbrt(-governor.offset / governor.arm)))
    if not low < MAX_ARM_ANGLE or excess(MAX_ARM_ANGLE) < 0:
        limit = math.degrees(MAX_ARM_ANGLE)
        raise MechanismError(
            f"with arms of {format_quantity(governor.arm, 'm')} the highest speed of {requirement.highest_speed / RPM:.6g} rpm is not "
            f"reached up to {limit:g} deg; reduce highest_speed, shorten arm, or increase offset"
        )
    return find_root(excess, low, MAX_ARM_ANGLE)


def _trials(governor: PendulumGovernor, angles: tuple[float, float]) -> Iterator[TrialPosition]:
    """Yield the positions at round steps above the lowest, and the highest: the table that step VI asks for."""
    swing = angles[1] - angles[0]
    step = max((step for step in TRIAL_STEPS.tolist() if swing / step >= MIN_TRIALS), default=swing / MIN_TRIALS)
    for change in (*(step * k for k in range(math.ceil(swing / step - ARM_TOLERANCE))), swing):
        angle = angles[0] + change
        radius, speed = (float(of(governor, arm_angle=angle)) for of in (dynamics.ball_radius, dynamics.equilibrium_speed))
        yield TrialPosition(angle_change=change, arm_angle=angle, ball_radius=radius, speed=speed)


def _checks(inputs: PendulumInputs, requirement: Requirement, start: ParabolaStart, governor: PendulumGovernor) -> Iterator[Check]:
    """Yield Zehnder's rules."""
    lowest, highest = (max(0.0, requirement.lowest_speed**2 / constant - 1) for constant in MASS_RATIO_CONSTANTS)
    cure = "change mass_ratio" if requirement.kind is GovernorKind.PORTER else "change lowest_speed, or take kind=porter"
    yield Check(
        rule="choice of m: w1^2 / 80 - 1 to w1^2 / 15 - 1, empirical",
        found=requirement.mass_ratio,
        lowest=lowest,
        highest=highest,
        cure=cure,
    )
    yield Check(
        rule="choice of delta: at least the speed fluctuation of the machine, or the sleeve moves in every turn",
        found=inputs.insensitivity,
        lowest=inputs.speed_fluctuation,
        cure="increase insensitivity, take a heavier flywheel, or fit a dashpot",
    )
    yield Check(
        rule="start radius x1 over that of x = 2 y (45 deg), which is the best; the empirical rule stays below",
        found=2 * start.abscissa / start.double_parameter,
        highest=1.0,
        cure="reduce start_radius",
    )
    yield from _arm_checks(requirement, start, governor)


def _arm_checks(requirement: Requirement, start: ParabolaStart, governor: PendulumGovernor) -> Iterator[Check]:
    """Yield the rules of step V on the arm, and of the kind of governor."""
    ratio = governor.arm / start.radius_of_curvature
    yield Check(
        rule="(V) arm l over the radius of curvature; a longer arm is unstable in the lowest position",
        found=ratio,
        highest=1 + ARM_TOLERANCE,
        cure="shorten arm, or increase offset",
    )
    if requirement.kind is GovernorKind.IMPROVED_WATT:
        yield Check(
            rule="kind improved-watt: arm l over the radius of curvature, with crossed arms",
            found=ratio,
            lowest=1 - ARM_TOLERANCE,
            cure="leave out arm and offset, or take kind=watt",
        )
    if requirement.kind is GovernorKind.WATT:
        yield Check(
            rule="kind watt: offset over arm; the arms of the ordinary governor do not cross",
            found=governor.offset / governor.arm,
            lowest=0.0,
            cure="increase offset, or take kind=improved-watt",
        )

"""The pendulum governor against Zehnder's closed forms: equilibrium, small oscillations, motion, torque, Jacobi integral."""

import math
from functools import partial

import numpy as np

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.effects.holding import Clearance
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.verification.machines import comparisons

RELAXATION_OFFSETS = (-0.12, 0.03, 0.15)
"""Start angles of the relaxation, from the equilibrium of the closed form (rad)."""

ARM_TRAVEL_MARGIN = 0.02
"""Minimum distance (rad) of a checked equilibrium from the end of the travel, which is a singular configuration."""


def check_pendulum_governor(scene: Scene) -> comparisons.Checks:
    """Yield every comparison that applies to the scene; equilibria are checked at the spindle's first speed."""
    # Equilibria are checked without output effects, motion with those that the closed form includes.
    comparisons.require_gravity_and_centrifugal(scene)
    governor = build_pendulum_closed_form(scene)
    has_clearance = any(isinstance(effect, Clearance) for effect in scene.effects)
    output_effects = [effect for effect in scene.effects if isinstance(effect, OutputEffect)]
    if has_clearance:
        yield "with clearance the sleeve is not fixed to the links: equilibria and motion are not checked"
    elif isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: equilibria at a given speed are not checked"
    else:
        if output_effects:
            yield f"equilibria and small oscillations are checked without {comparisons.name_effects(output_effects)}"
        yield from _check_equilibria(comparisons.without_output_effects(scene), governor)
    run = comparisons.run_scene(scene)
    yield from comparisons.note_early_end(run)
    if len(run.times) < 2:
        return
    if not has_clearance:
        yield from _check_motion(scene, governor, run)
    yield comparisons.compare_jacobi_integral(run)


def build_pendulum_closed_form(scene: Scene) -> PendulumGovernor:
    """Return the closed form's governor with the scene's rod masses and ball radius."""
    rods = next((effect for effect in scene.effects if isinstance(effect, RodMasses)), None)
    dimensions = dict(scene.part.dimensions)
    if rods is not None:
        ball_inertia = 2 / 5 * dimensions["ball_mass"] * rods.ball_radius**2  # a solid sphere
        dimensions |= {"arm_mass": rods.arm_mass, "link_mass": rods.link_mass, "ball_inertia": ball_inertia}
    return PendulumGovernor(**dimensions, gravity=scene.gravity)


def _check_equilibria(scene: Scene, governor: PendulumGovernor) -> comparisons.Checks:
    """Yield the comparisons of all equilibria at the spindle's first speed."""
    program = SpindleSpeedFunction(scene.spindle)
    speed = program.start_speed
    low, high = comparisons.travel_limits(scene, "arm_angle")
    if not program.is_constant:
        yield f"the spindle speed varies: equilibria are checked at its first value, {comparisons.format_rpm(speed)}; torque is not checked"
    constant_speed_scene = scene.with_changes(spindle=Spindle(speeds=(speed,)))
    angles = closed.equilibrium_angles(governor, spindle_speed=abs(speed)).tolist() if speed else []
    angles = [angle for angle in angles if low < angle < high]
    if not angles:
        yield f"at {comparisons.format_rpm(speed)} there is no equilibrium within the travel: nothing is checked there"
    for angle in angles:
        if low + ARM_TRAVEL_MARGIN < angle < high - ARM_TRAVEL_MARGIN:
            yield from _check_equilibrium(constant_speed_scene, governor, speed, angle)
        else:
            yield f"the equilibrium at {math.degrees(angle):.4g} deg is at the end of the travel: it is not checked"


def _check_equilibrium(scene: Scene, governor: PendulumGovernor, speed: float, angle: float) -> comparisons.Checks:
    """Yield the comparisons of one equilibrium: speed, relaxation, oscillation period."""
    label = f"{math.degrees(angle):.4g} deg"
    simulated_speed = equilibrium_speed_at(scene, np.array([angle]))[0]
    expected_speed = closed.equilibrium_speed(governor, arm_angle=angle)
    yield comparisons.compare_algebraic(f"equilibrium speed at {label}", simulated_speed, expected_speed, "rad/s", scale=speed)
    low, high = comparisons.travel_limits(scene, "arm_angle")
    squared_frequency = float(closed.squared_oscillation_frequency(governor, arm_angle=angle, spindle_speed=speed))
    starts = [min(max(angle + offset, (angle + low) / 2), (angle + high) / 2) for offset in RELAXATION_OFFSETS]
    yield from comparisons.check_stability(scene, "arm_angle", angle, squared_frequency, starts, label)


def _check_motion(scene: Scene, governor: PendulumGovernor, run: Trajectory) -> comparisons.Checks:
    """Yield the comparisons of a run with the integrated equations of motion; a note if an effect is not included."""
    if note := comparisons.note_unsupported_effects(scene):
        yield note
        return
    arm_acceleration = partial(closed.arm_acceleration, governor, damping=comparisons.sleeve_damping(scene))
    spindle_acceleration = partial(closed.spindle_acceleration, governor)
    angles, rates, speeds = comparisons.integrate_governor(run, len(run.times), "arm_angle", arm_acceleration, spindle_acceleration)
    yield comparisons.compare_reading(run, "arm_angle", angles)
    if isinstance(scene.spindle, FreeSpindle):
        yield comparisons.compare_reading(run, "spindle_speed", speeds)
    elif SpindleSpeedFunction(scene.spindle).is_constant:
        torque = closed.drive_torque(governor, arm_angle=angles, arm_rate=rates, spindle_speed=float(run.readings["spindle_speed"][0]))
        yield comparisons.compare_reading(run, "spindle_torque", torque)

"""The pendulum governor against Zehnder's closed forms: equilibrium, small oscillations, motion, torque, Jacobi integral."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.pendulum import dynamics as closed
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.scene import FreeSpindle, Scene, Spindle
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.oscillation import check_oscillation_period, check_relaxation, format_rpm, run_scene
from governor_mechanism.verification.report import ComparisonRow

RELAXATION_OFFSETS = (-0.12, 0.03, 0.15)
"""Start angles of the relaxation, from the equilibrium of the closed form (rad)."""

ARM_TRAVEL_MARGIN = 0.02
"""Minimum distance (rad) of a checked equilibrium from the end of the travel, which is a singular configuration."""


def check_pendulum_governor(scene: Scene) -> Iterator[ComparisonRow | str]:
    """Yield every comparison that applies to the scene; equilibria are checked at the spindle's first speed.

    Equilibria are checked without output effects, motion with those that the closed form includes.
    """
    if not (scene.gravity and scene.has_centrifugal):
        raise MechanismError("the closed forms of a pendulum governor need the effects gravity and centrifugal")
    governor = _build_closed_form_governor(scene)
    has_clearance = any(isinstance(effect, Clearance) for effect in scene.effects)
    output_effects = [effect for effect in scene.effects if isinstance(effect, OutputEffect)]
    if has_clearance:
        yield "with clearance the sleeve is not fixed to the links: equilibria and motion are not checked"
    elif isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: equilibria at a given speed are not checked"
    else:
        if output_effects:
            yield f"equilibria and small oscillations are checked without {_join_effect_names(output_effects)}"
        yield from _check_equilibria(replace(scene, effects=tuple(one for one in scene.effects if one not in output_effects)), governor)
    run = run_scene(scene)
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1]:.4g} of {scene.run.duration:.4g} s: {run.message}"
    if len(run.times) < 2:
        return
    unsupported_effects = [effect for effect in output_effects if not _is_in_closed_form(effect)]
    if unsupported_effects and not has_clearance:
        yield f"motion is not checked: the closed form does not include {_join_effect_names(unsupported_effects)}"
    elif not has_clearance:
        yield from _check_motion(scene, governor, run)
    yield ComparisonRow(
        quantity="Jacobi integral, largest change",
        simulated=run.energy.drift,
        expected=0.0,
        allowed=scene.run.accuracy,
        unit="1",
        reason="relative to mass x length scale^2 / time scale^2, like the accuracy",
    )


def _is_in_closed_form(effect: Effect) -> bool:
    """Return whether the closed form of the motion includes the effect: a linear dashpot on the sleeve."""
    return isinstance(effect, Dashpot) and effect.reading == "sleeve_lift" and not effect.quadratic


OUTPUT_EFFECT_NAMES: dict[type[Effect], str] = {OutputSpring: "spring", DryFriction: "dry friction", Dashpot: "dashpot", Stops: "stops"}
"""Names of effects in messages."""


def _join_effect_names(effects: Sequence[Effect]) -> str:
    """Return the names of the effects as a phrase."""
    names = list(dict.fromkeys(OUTPUT_EFFECT_NAMES[type(effect)] for effect in effects))
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _build_closed_form_governor(scene: Scene) -> closed.PendulumGovernor:
    """Return the closed form's governor with the scene's rod masses and ball radius."""
    rods = next((effect for effect in scene.effects if isinstance(effect, RodMasses)), None)
    dimensions = dict(scene.part.dimensions)
    if rods is not None:
        ball_inertia = 2 / 5 * dimensions["ball_mass"] * rods.ball_radius**2  # a solid sphere
        dimensions |= {"arm_mass": rods.arm_mass, "link_mass": rods.link_mass, "ball_inertia": ball_inertia}
    return closed.PendulumGovernor(**dimensions, gravity=scene.gravity)


def _check_equilibria(scene: Scene, governor: closed.PendulumGovernor) -> Iterator[ComparisonRow | str]:
    """Yield the comparisons of all equilibria at the spindle's first speed."""
    program = SpindleSpeedFunction(scene.spindle)
    speed, (low, high) = program.start_speed, _arm_angle_limits(scene)
    if not program.is_constant:
        yield f"the spindle speed varies: equilibria are checked at its first value, {format_rpm(speed)}; torque is not checked"
    constant_speed_scene = replace(scene, spindle=Spindle(speeds=(speed,)))
    angles = [angle for angle in _equilibrium_angles(governor, speed) if low < angle < high]
    if not angles:
        yield f"at {format_rpm(speed)} there is no equilibrium within the travel: nothing is checked there"
    for angle in angles:
        if low + ARM_TRAVEL_MARGIN < angle < high - ARM_TRAVEL_MARGIN:
            yield from _check_equilibrium(constant_speed_scene, governor, speed, angle)
        else:
            yield f"the equilibrium at {math.degrees(angle):.4g} deg is at the end of the travel: it is not checked"


def _equilibrium_angles(governor: closed.PendulumGovernor, speed: float) -> list[float]:
    """Return the arm angles of the equilibria (rad)."""
    return [float(angle) for angle in closed.equilibrium_angles(governor, spindle_speed=abs(speed))] if speed else []


def _check_equilibrium(scene: Scene, governor: closed.PendulumGovernor, speed: float, angle: float) -> Iterator[ComparisonRow | str]:
    """Yield the comparisons of one equilibrium: speed, relaxation, oscillation period."""
    angle_label = f"{math.degrees(angle):.4g} deg"
    yield ComparisonRow(
        quantity=f"equilibrium speed at {angle_label}",
        simulated=float(equilibrium_speed_at(scene, np.array([angle]))[0]),
        expected=float(closed.equilibrium_speed(governor, arm_angle=angle)),
        allowed=1e-10 * abs(speed),
        unit="rad/s",
        reason="both are algebraic; rounding and position assembly leave about 1e-13",
    )
    squared_frequency = float(closed.squared_oscillation_frequency(governor, arm_angle=angle, spindle_speed=speed))
    if squared_frequency <= 0:
        yield f"the equilibrium at {angle_label} is unstable: relaxation and oscillation are not checked"
        return
    low, high = _arm_angle_limits(scene)
    for offset in RELAXATION_OFFSETS:
        start = min(max(angle + offset, (angle + low) / 2), (angle + high) / 2)
        yield check_relaxation(scene, f"relaxation from {math.degrees(start):.4g} deg", start=start, expected=angle)
    period = 2 * math.pi / math.sqrt(squared_frequency)
    yield check_oscillation_period(scene, "arm_angle", angle=angle, period=period, label=angle_label)


def _check_motion(scene: Scene, governor: closed.PendulumGovernor, run: Trajectory) -> Iterator[ComparisonRow]:
    """Yield the comparisons of a run with the integrated equations of motion."""
    angles, rates, speeds = _integrate_closed_form(scene, governor, run)
    accuracy = scene.run.accuracy
    worst_index = int(np.argmax(np.abs(run.readings["arm_angle"] - angles)))
    yield ComparisonRow(
        quantity=f"arm angle in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
        simulated=float(run.readings["arm_angle"][worst_index]),
        expected=float(angles[worst_index]),
        allowed=accuracy,
        unit="rad",
        reason="the requested accuracy",
    )
    if isinstance(scene.spindle, FreeSpindle):
        worst_index = int(np.argmax(np.abs(run.readings["spindle_speed"] - speeds)))
        yield ComparisonRow(
            quantity=f"spindle speed in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
            simulated=float(run.readings["spindle_speed"][worst_index]),
            expected=float(speeds[worst_index]),
            allowed=accuracy * run.scales["spindle_speed"],
            unit="rad/s",
            reason="the requested accuracy times the scale of the speed",
        )
    elif SpindleSpeedFunction(scene.spindle).is_constant:
        speed = float(run.readings["spindle_speed"][0])
        torque = np.asarray(closed.drive_torque(governor, arm_angle=angles, arm_rate=rates, spindle_speed=speed))
        worst_index = int(np.argmax(np.abs(run.readings["spindle_torque"] - torque)))
        yield ComparisonRow(
            quantity=f"spindle torque in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
            simulated=float(run.readings["spindle_torque"][worst_index]),
            expected=float(torque[worst_index]),
            allowed=accuracy * run.scales["spindle_torque"],
            unit="N m",
            reason="the requested accuracy times the scale of the torque",
        )


def _integrate_closed_form(scene: Scene, governor: closed.PendulumGovernor, run: Trajectory) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return arm angle (rad), its rate (rad/s) and spindle speed (rad/s), each (n,), integrated from the run's initial state."""
    spindle = scene.spindle
    program = SpindleSpeedFunction(spindle)
    torque = CubicTimeFunction(spindle.torque) if isinstance(spindle, FreeSpindle) else None
    damping = sum(effect.linear for effect in scene.effects if isinstance(effect, Dashpot))

    def state_derivative(time: float, state: FloatArray) -> list[float]:
        arm_angle, arm_rate, spindle_speed = state
        spindle_acceleration = 0.0
        if isinstance(spindle, FreeSpindle) and torque:
            drive_torque = float(torque(np.array([time]), left_limit=time > start)[0])
            coordinates = {"arm_angle": arm_angle, "arm_rate": arm_rate, "spindle_speed": spindle_speed}
            spindle_acceleration = float(
                closed.spindle_acceleration(governor, **coordinates, constant_inertia=spindle.inertia, torque=drive_torque)
            )
        else:
            spindle_speed = float(program(np.array([time]), left_limit=time > start)[0])
        arm_acceleration = closed.arm_acceleration(
            governor, arm_angle=arm_angle, arm_rate=arm_rate, spindle_speed=spindle_speed, damping=damping
        )
        return [arm_rate, float(arm_acceleration), spindle_acceleration]

    breaks = torque.breakpoints if torque else program.breakpoints
    interior_breaks = breaks[(breaks > run.times[0]) & (breaks < run.times[-1])]
    knots = np.concatenate([run.times[:1], interior_breaks, run.times[-1:]])
    state = np.array([run.readings["arm_angle"][0], run.rates["arm_angle"][0], run.readings["spindle_speed"][0]])
    segments = [state[:, np.newaxis]]
    for start, end in pairwise(knots):
        segment_times = run.times[(run.times > start) & (run.times <= end)]
        evaluation_times = segment_times if segment_times.size and segment_times[-1] == end else np.append(segment_times, end)
        solution = solve_ivp(state_derivative, (start, end), state, method="DOP853", t_eval=evaluation_times, rtol=1e-13, atol=1e-14)
        segments.append(solution.y[:, : len(segment_times)])
        state = solution.y[:, -1]
    angles, rates, speeds = np.concatenate(segments, axis=1)
    return angles, rates, speeds


def _arm_angle_limits(scene: Scene) -> tuple[float, float]:
    """Return the limits of the arm angle (rad)."""
    limit = next(limit for limit in scene.part.mechanism.limits if limit.reading == "arm_angle")
    return limit.low, limit.high

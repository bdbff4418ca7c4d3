"""The pendulum governor against Zehnder's closed forms: rest, small swing, motion, torque, Jacobi integral."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.pendulum import dynamics as closed
from governor_mechanism.effects.clearance import Play
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram, TimeCurve
from governor_mechanism.model.effect import Effect, OnReading
from governor_mechanism.model.scene import FreeSpindle, Scene, Spindle
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.speed_curve import equilibrium_speed
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.oscillation import rpm, run_of, settled_row, swing_row
from governor_mechanism.verification.report import Row

STARTS = (-0.12, 0.03, 0.15)
"""rad from the closed form's equilibrium: from where the simulation is let go to settle."""

EDGE = 0.02
"""rad: an equilibrium nearer than that to the end of the travel, a dead centre, is not settled into."""


def findings(scene: Scene) -> Iterator[Row | str]:
    """Every comparison that applies to the scene; those at rest use the spindle's first speed.

    What is at rest is checked without the effects that act along readings, and motion with those of the closed form.
    """
    if not (scene.gravity and scene.centrifugal):
        raise MechanismError("the closed forms of a pendulum governor need both effects, gravity and centrifugal")
    governor = _closed_governor(scene)
    play = any(isinstance(effect, Play) for effect in scene.effects)
    acting = [effect for effect in scene.effects if isinstance(effect, OnReading)]
    if play:
        yield "with play the sleeve is free of the links: rest and motion are not checked"
    elif isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: rest at a given speed is not checked"
    else:
        if acting:
            yield f"rest and small swings are checked without {_spoken(acting)}"
        yield from _at_rests(replace(scene, effects=tuple(one for one in scene.effects if one not in acting)), governor)
    run = run_of(scene)
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1]:.4g} of {scene.run.duration:.4g} s: {run.message}"
    if len(run.times) < 2:
        return
    foreign = [effect for effect in acting if not _known(effect)]
    if foreign and not play:
        yield f"motion is not checked: the closed form has no {_spoken(foreign)}"
    elif not play:
        yield from _in_motion(scene, governor, run)
    yield Row(
        quantity="Jacobi integral, largest change",
        simulated=run.energy.drift,
        expected=0.0,
        allowed=scene.run.accuracy,
        unit="1",
        reason="relative to mass x size^2 / time scale^2, like the accuracy",
    )


def _known(effect: Effect) -> bool:
    """Whether the closed form of the motion has it: a linear oil brake on the sleeve."""
    return isinstance(effect, OilBrake) and effect.reading == "sleeve_lift" and not effect.quadratic


SPOKEN: dict[type[Effect], str] = {
    SpringOn: "spring",
    DryFriction: "dry friction",
    OilBrake: "oil brake",
    Stops: "stops",
}


def _spoken(effects: Sequence[Effect]) -> str:
    names = list(dict.fromkeys(SPOKEN[type(effect)] for effect in effects))
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _closed_governor(scene: Scene) -> closed.PendulumGovernor:
    """The closed form's governor, its rods and its balls' size those of the scene."""
    rods = next((effect for effect in scene.effects if isinstance(effect, Rods)), None)
    sizes = dict(scene.part.dimensions)
    if rods is not None:
        ball = 2 / 5 * sizes["ball_mass"] * rods.ball_radius**2  # a solid sphere
        sizes |= {"arm_mass": rods.arm_mass, "link_mass": rods.link_mass, "ball_inertia": ball}
    return closed.PendulumGovernor(**sizes, gravity=scene.gravity)


def _at_rests(scene: Scene, governor: closed.PendulumGovernor) -> Iterator[Row | str]:
    """All that rests at the spindle's first speed."""
    program = SpeedProgram(scene.spindle)
    speed, (low, high) = program.start_speed, _travel(scene)
    if not program.constant:
        yield f"the spindle's speed changes: rest is checked at its first, {rpm(speed)}; torque is not checked"
    steady = replace(scene, spindle=Spindle(speeds=(speed,)))
    angles = [angle for angle in _equilibria(governor, speed) if low < angle < high]
    if not angles:
        yield f"at {rpm(speed)} this governor rests nowhere within its travel: rest is not checked"
    for angle in angles:
        if low + EDGE < angle < high - EDGE:
            yield from _at_rest(steady, governor, speed, angle)
        else:
            yield f"the equilibrium at {math.degrees(angle):.4g} deg lies at the end of the travel: it is not checked"


def _equilibria(governor: closed.PendulumGovernor, speed: float) -> list[float]:
    return [float(angle) for angle in closed.equilibrium_angles(governor, spindle_speed=abs(speed))] if speed else []


def _at_rest(scene: Scene, governor: closed.PendulumGovernor, speed: float, angle: float) -> Iterator[Row | str]:
    degrees = f"{math.degrees(angle):.4g} deg"
    yield Row(
        quantity=f"speed of rest at {degrees}",
        simulated=float(equilibrium_speed(scene, np.array([angle]))[0]),
        expected=float(closed.equilibrium_speed(governor, arm_angle=angle)),
        allowed=1e-10 * abs(speed),
        unit="rad/s",
        reason="both are algebra; rounding and the closing of the joints leave about 1e-13",
    )
    squared = float(closed.small_oscillation_squared(governor, arm_angle=angle, spindle_speed=speed))
    if squared <= 0:
        yield f"the equilibrium at {degrees} is unstable: nothing settles into it or swings about it"
        return
    low, high = _travel(scene)
    for offset in STARTS:
        start = min(max(angle + offset, (angle + low) / 2), (angle + high) / 2)
        yield settled_row(scene, f"settled from {math.degrees(start):.4g} deg", start=start, expected=angle)
    period = 2 * math.pi / math.sqrt(squared)
    yield swing_row(scene, "arm_angle", angle=angle, period=period, at=degrees)


def _in_motion(scene: Scene, governor: closed.PendulumGovernor, run: Trajectory) -> Iterator[Row]:
    angles, rates, speeds = _motion(scene, governor, run)
    promised = scene.run.accuracy
    worst = int(np.argmax(np.abs(run.readings["arm_angle"] - angles)))
    yield Row(
        quantity=f"arm angle in motion (farthest, t = {run.times[worst]:.4g} s)",
        simulated=float(run.readings["arm_angle"][worst]),
        expected=float(angles[worst]),
        allowed=promised,
        unit="rad",
        reason="the accuracy asked of the run",
    )
    if isinstance(scene.spindle, FreeSpindle):
        worst = int(np.argmax(np.abs(run.readings["spindle_speed"] - speeds)))
        yield Row(
            quantity=f"spindle speed in motion (farthest, t = {run.times[worst]:.4g} s)",
            simulated=float(run.readings["spindle_speed"][worst]),
            expected=float(speeds[worst]),
            allowed=promised * run.scales["spindle_speed"],
            unit="rad/s",
            reason="the accuracy asked of the run, times the scale of speeds",
        )
    elif SpeedProgram(scene.spindle).constant:
        speed = float(run.readings["spindle_speed"][0])
        torque = np.asarray(closed.drive_torque(governor, arm_angle=angles, arm_rate=rates, spindle_speed=speed))
        worst = int(np.argmax(np.abs(run.readings["spindle_torque"] - torque)))
        yield Row(
            quantity=f"spindle torque in motion (farthest, t = {run.times[worst]:.4g} s)",
            simulated=float(run.readings["spindle_torque"][worst]),
            expected=float(torque[worst]),
            allowed=promised * run.scales["spindle_torque"],
            unit="N m",
            reason="the accuracy asked of the run, times the scale of torques",
        )


def _motion(
    scene: Scene, governor: closed.PendulumGovernor, run: Trajectory
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Arm angle, its rate, spindle speed (n,) by the closed forms' equations of motion, from the run's own start."""
    spindle = scene.spindle
    program = SpeedProgram(spindle)
    torque = TimeCurve(spindle.torque) if isinstance(spindle, FreeSpindle) else None
    brake = sum(effect.linear for effect in scene.effects if isinstance(effect, OilBrake))

    def slope(time: float, state: FloatArray) -> list[float]:
        angle, rate, speed = state
        gain = 0.0
        if isinstance(spindle, FreeSpindle) and torque:
            pull = float(torque(np.array([time]), before=time > start)[0])
            moving = {"arm_angle": angle, "arm_rate": rate, "spindle_speed": speed}
            gain = float(closed.spindle_acceleration(governor, **moving, rest_inertia=spindle.inertia, torque=pull))
        else:
            speed = float(program(np.array([time]), before=time > start)[0])
        bend = closed.arm_acceleration(governor, arm_angle=angle, arm_rate=rate, spindle_speed=speed, oil_brake=brake)
        return [rate, float(bend), gain]

    breaks = torque.breaks if torque else program.breaks
    inner = breaks[(breaks > run.times[0]) & (breaks < run.times[-1])]
    knots = np.concatenate([run.times[:1], inner, run.times[-1:]])
    state = np.array([run.readings["arm_angle"][0], run.rates["arm_angle"][0], run.readings["spindle_speed"][0]])
    kept = [state[:, np.newaxis]]
    for start, end in pairwise(knots):
        times = run.times[(run.times > start) & (run.times <= end)]
        wanted = times if times.size and times[-1] == end else np.append(times, end)
        part = solve_ivp(slope, (start, end), state, method="DOP853", t_eval=wanted, rtol=1e-13, atol=1e-14)
        kept.append(part.y[:, : len(times)])
        state = part.y[:, -1]
    angles, rates, speeds = np.concatenate(kept, axis=1)
    return angles, rates, speeds


def _travel(scene: Scene) -> tuple[float, float]:
    limit = next(limit for limit in scene.part.mechanism.limits if limit.reading == "arm_angle")
    return limit.low, limit.high

"""Hartung's governor in motion against Lagrange's equation along its lever angle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.stops import Stops
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram, TimeCurve
from governor_mechanism.model.effect import OnReading
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.report import Row

LEVER = "lever_angle"


def spring_force(scene: Scene, lever: float) -> float:
    """Force (N) of each spring at a lever angle (rad), by the scene's dimensions alone."""
    sizes = scene.part.dimensions
    x = sizes["fulcrum_radius"] - sizes["weight_arm"] * math.sin(lever)
    return sizes["spring_preload"] + sizes["spring_rate"] * (x - sizes["preload_radius"])


def in_motion(scene: Scene, governor: closed.HartungGovernor, run: Trajectory) -> Iterator[Row | str]:
    """A run against the equation of motion, until something strikes; a note where that has not all of its effects."""
    foreign = sorted({type(one).__name__ for one in scene.effects if isinstance(one, OnReading) and not _known(one)})
    if foreign:
        yield f"motion is not checked: the closed form has no {' and '.join(foreign)}"
        return
    struck = [event.time for event in run.events if event.kind == "strikes its stop"]
    until = int(np.searchsorted(run.times, struck[0])) if struck else len(run.times)
    if struck:
        yield f"motion is checked until {struck[0]:.4g} s, when the lever strikes its stop"
    if until < 2:
        return
    angles, speeds = _motion(scene, governor, run, until)
    worst = int(np.argmax(np.abs(run.readings[LEVER][:until] - angles)))
    yield Row(
        quantity=f"lever angle in motion (farthest, t = {run.times[worst]:.4g} s)",
        simulated=float(run.readings[LEVER][worst]),
        expected=float(angles[worst]),
        allowed=scene.run.accuracy,
        unit="rad",
        reason="the accuracy asked of the run",
    )
    if isinstance(scene.spindle, FreeSpindle):
        worst = int(np.argmax(np.abs(run.readings["spindle_speed"][:until] - speeds)))
        yield Row(
            quantity=f"spindle speed in motion (farthest, t = {run.times[worst]:.4g} s)",
            simulated=float(run.readings["spindle_speed"][worst]),
            expected=float(speeds[worst]),
            allowed=scene.run.accuracy * run.scales["spindle_speed"],
            unit="rad/s",
            reason="the accuracy asked of the run, times the scale of speeds",
        )


def _known(effect: OnReading) -> bool:
    """Whether the closed form of the motion has it, up to a blow: a linear oil brake on the sleeve, and stops."""
    brake = isinstance(effect, OilBrake) and effect.reading == "sleeve_lift" and not effect.quadratic
    return brake or isinstance(effect, Stops)


def _motion(
    scene: Scene, governor: closed.HartungGovernor, run: Trajectory, until: int
) -> tuple[FloatArray, FloatArray]:
    """Lever angle and spindle speed (until,) by the closed forms' equations of motion, from the run's own start."""
    spindle = scene.spindle
    program = SpeedProgram(spindle)
    torque = TimeCurve(spindle.torque) if isinstance(spindle, FreeSpindle) else None
    brake = sum(effect.linear for effect in scene.effects if isinstance(effect, OilBrake))

    def slope(time: float, state: Sequence[float]) -> list[float]:
        lever, rate, speed = (float(value) for value in state)
        gain, moment = 0.0, np.array([time])
        if isinstance(spindle, FreeSpindle) and torque:
            pull, own = float(torque(moment, before=time > start)[0]), spindle.inertia
            now = {"lever_angle": lever, "lever_rate": rate, "spindle_speed": speed}
            gain = float(closed.spindle_acceleration(governor, **now, rest_inertia=own, torque=pull))
        else:
            speed = float(program(moment, before=time > start)[0])
        bend = closed.angular_acceleration(
            governor,
            lever_angle=lever,
            lever_rate=rate,
            spring_force=spring_force(scene, lever),
            spindle_speed=speed,
            brake=brake,
        )
        return [rate, float(bend), gain]

    times = run.times[:until]
    breaks = torque.breaks if torque else program.breaks
    inner = breaks[(breaks > times[0]) & (breaks < times[-1])]
    state = np.array([run.readings[LEVER][0], run.rates[LEVER][0], run.readings["spindle_speed"][0]])
    kept = [state[:, np.newaxis]]
    for start, end in pairwise(np.concatenate([times[:1], inner, times[-1:]]).tolist()):
        asked = times[(times > start) & (times <= end)]
        wanted = asked if asked.size and asked[-1] == end else np.append(asked, end)
        part = solve_ivp(slope, (start, end), state, method="DOP853", t_eval=wanted, rtol=1e-12, atol=1e-13)
        kept.append(part.y[:, : len(asked)])
        state = part.y[:, -1]
    angles, _, speeds = np.concatenate(kept, axis=1)
    return angles, speeds

"""The motion of Hartung's governor against Lagrange's equation along its lever angle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.stops import Stops
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.report import ComparisonRow

LEVER_ANGLE_READING = "lever_angle"


def hartung_spring_force(scene: Scene, lever_angle: float) -> float:
    """Return the force (N) of each spring at a lever angle (rad), from the scene's dimensions."""
    dimensions = scene.part.dimensions
    weight_radius = dimensions["fulcrum_radius"] - dimensions["weight_arm"] * math.sin(lever_angle)
    return dimensions["spring_preload"] + dimensions["spring_rate"] * (weight_radius - dimensions["preload_radius"])


def check_hartung_motion(scene: Scene, governor: closed.HartungGovernor, run: Trajectory) -> Iterator[ComparisonRow | str]:
    """Yield the comparison of a run with the equation of motion until the first impact; a note if an effect is not included."""
    unsupported_effects = sorted(
        {type(effect).__name__ for effect in scene.effects if isinstance(effect, OutputEffect) and not _is_in_closed_form(effect)}
    )
    if unsupported_effects:
        yield f"motion is not checked: the closed form does not include {' and '.join(unsupported_effects)}"
        return
    impact_times = [event.time for event in run.events if event.kind == "strikes its stop"]
    n_compared = int(np.searchsorted(run.times, impact_times[0])) if impact_times else len(run.times)
    if impact_times:
        yield f"motion is checked until {impact_times[0]:.4g} s, when the lever strikes its stop"
    if n_compared < 2:
        return
    angles, speeds = _integrate_closed_form(scene, governor, run, n_compared)
    worst_index = int(np.argmax(np.abs(run.readings[LEVER_ANGLE_READING][:n_compared] - angles)))
    yield ComparisonRow(
        quantity=f"lever angle in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
        simulated=float(run.readings[LEVER_ANGLE_READING][worst_index]),
        expected=float(angles[worst_index]),
        allowed=scene.run.accuracy,
        unit="rad",
        reason="the requested accuracy",
    )
    if isinstance(scene.spindle, FreeSpindle):
        worst_index = int(np.argmax(np.abs(run.readings["spindle_speed"][:n_compared] - speeds)))
        yield ComparisonRow(
            quantity=f"spindle speed in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
            simulated=float(run.readings["spindle_speed"][worst_index]),
            expected=float(speeds[worst_index]),
            allowed=scene.run.accuracy * run.scales["spindle_speed"],
            unit="rad/s",
            reason="the requested accuracy times the scale of the speed",
        )


def _is_in_closed_form(effect: OutputEffect) -> bool:
    """Return whether the closed form includes the effect up to the first impact: a linear dashpot on the sleeve, and stops."""
    is_linear_sleeve_dashpot = isinstance(effect, Dashpot) and effect.reading == "sleeve_lift" and not effect.quadratic
    return is_linear_sleeve_dashpot or isinstance(effect, Stops)


def _integrate_closed_form(
    scene: Scene, governor: closed.HartungGovernor, run: Trajectory, n_compared: int
) -> tuple[FloatArray, FloatArray]:
    """Return lever angle (rad) and spindle speed (rad/s), each (n_compared,), integrated from the run's initial state."""
    spindle = scene.spindle
    program = SpindleSpeedFunction(spindle)
    torque = CubicTimeFunction(spindle.torque) if isinstance(spindle, FreeSpindle) else None
    damping = sum(effect.linear for effect in scene.effects if isinstance(effect, Dashpot))

    def state_derivative(time: float, state: Sequence[float]) -> list[float]:
        lever_angle, lever_rate, spindle_speed = (float(value) for value in state)
        spindle_acceleration, time_array = 0.0, np.array([time])
        if isinstance(spindle, FreeSpindle) and torque:
            drive_torque, constant_inertia = float(torque(time_array, left_limit=time > start)[0]), spindle.inertia
            coordinates = {"lever_angle": lever_angle, "lever_rate": lever_rate, "spindle_speed": spindle_speed}
            spindle_acceleration = float(
                closed.spindle_acceleration(governor, **coordinates, constant_inertia=constant_inertia, torque=drive_torque)
            )
        else:
            spindle_speed = float(program(time_array, left_limit=time > start)[0])
        lever_acceleration = closed.lever_acceleration(
            governor,
            lever_angle=lever_angle,
            lever_rate=lever_rate,
            spring_force=hartung_spring_force(scene, lever_angle),
            spindle_speed=spindle_speed,
            damping=damping,
        )
        return [lever_rate, float(lever_acceleration), spindle_acceleration]

    times = run.times[:n_compared]
    breaks = torque.breakpoints if torque else program.breakpoints
    interior_breaks = breaks[(breaks > times[0]) & (breaks < times[-1])]
    state = np.array([run.readings[LEVER_ANGLE_READING][0], run.rates[LEVER_ANGLE_READING][0], run.readings["spindle_speed"][0]])
    segments = [state[:, np.newaxis]]
    for start, end in pairwise(np.concatenate([times[:1], interior_breaks, times[-1:]]).tolist()):
        segment_times = times[(times > start) & (times <= end)]
        evaluation_times = segment_times if segment_times.size and segment_times[-1] == end else np.append(segment_times, end)
        solution = solve_ivp(state_derivative, (start, end), state, method="DOP853", t_eval=evaluation_times, rtol=1e-12, atol=1e-13)
        segments.append(solution.y[:, : len(segment_times)])
        state = solution.y[:, -1]
    angles, _, speeds = np.concatenate(segments, axis=1)
    return angles, speeds

"""Time-dependent inputs of a fixed-step run: spindle speed (prescribed or free), force-element functions and drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.impulse.pymunk.step_inputs import StepInputs
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.force_laws import free_spindle_speed
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.force_elements import Force, ForceElement, Torque
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import FloatArray

InertiaCallback = Callable[[float], float]
"""Return the moment of inertia about the spindle (kg m2) of the mechanism a number of seconds ahead."""


class TimeInputs:
    """Step inputs of a run, interval by interval; accumulates the work (J) and the angle (rad) of the spindle.

    `uses_left_limits`: at a discontinuity use the left limit and the full step weight; the caller restarts the scheme there.
    """

    def __init__(self, scene: Scene) -> None:
        mechanism, spindle = scene.part.mechanism, scene.spindle
        self._speed_program = SpindleSpeedFunction(spindle)
        self._free_spindle = spindle if isinstance(spindle, FreeSpindle) else None
        self._torque_function = CubicTimeFunction(self._free_spindle.torque) if self._free_spindle else None
        self._spindle_inertia = self._free_spindle.inertia if self._free_spindle else 0.0
        self._load_functions = [
            CubicTimeFunction(program) for element in mechanism.force_elements for program in _element_programs(element)
        ]
        drives = [joint for joint in mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
        self._drive_functions = [CubicTimeFunction(joint.motion) for joint in drives]
        self._friction_functions = [CubicTimeFunction(contact.friction or InputFunction()) for contact in contacts_of(scene)]
        self._has_varying_speed = not self._speed_program.is_constant
        self._start_speed_squared = self._speed_program.start_speed**2
        self.uses_left_limits = False

    @property
    def breakpoints(self) -> FloatArray:
        """Return the times (s) of jumps and kinks, at which steps must end."""
        functions = [self._speed_program, *self._load_functions, *self._drive_functions, *self._friction_functions]
        functions += [self._torque_function] if self._torque_function else []
        return np.unique(np.concatenate([function.breakpoints for function in functions]))

    def reset(self, inertia: InertiaCallback) -> None:
        """Begin a run; `inertia` predicts the moment of inertia that rotates with the spindle."""
        self._predict_inertia = inertia
        self.has_jump, self.work, self.spindle_angle = False, 0.0, 0.0
        self._mechanism_inertia = inertia(0.0) if self._has_varying_speed or self._free_spindle else 0.0
        self._spindle_speed = self._speed_program.start_speed
        self._angular_momentum = (self._spindle_inertia + self._mechanism_inertia) * self._spindle_speed

    def start_inputs(self, h: float) -> StepInputs:
        """Return the inputs at the start, before a first step of `h` seconds."""
        return replace(self.constant_inputs(h), h=0.5 * h)

    def constant_inputs(self, h: float) -> StepInputs:
        """Return the inputs of a step of `h` seconds with all inputs, including the spindle speed, kept at their start values."""
        return self._inputs_at(0.0, h, self._start_speed_squared)

    def restart_inputs(self, time: float, h: float) -> StepInputs:
        """Return the inputs of a restart at `time` (s), before a first step of `h` seconds.

        The kick has half the size, not half the length: if the step length changes, pymunk scales the accumulated joint impulses
        wrongly and applies wrong bounds.
        """
        speed_squared = self._spindle_speed**2 if self._free_spindle else float(self._speed_program(np.array([time]))[0]) ** 2
        return replace(self._inputs_at(time, h, speed_squared), kick_scale=0.5)

    def _inputs_at(self, time: float, h: float, spindle_speed_squared: float) -> StepInputs:
        """Return the inputs at a time (s) for a step of `h` seconds, with the drives at its end."""
        times = np.array([time])
        return StepInputs(
            h=h,
            next_h=h,
            spindle_speed_squared=spindle_speed_squared,
            load_values=tuple(float(function(times)[0]) for function in self._load_functions),
            drive_values=tuple(float(function(times + h)[0]) for function in self._drive_functions),
            friction_limits=tuple(float(function(times)[0]) for function in self._friction_functions),
        )

    def accumulators(self) -> tuple[float, float, float, float, float]:
        """Return all accumulated quantities, for `restore`."""
        return self.work, self.spindle_angle, self._mechanism_inertia, self._spindle_speed, self._angular_momentum

    def restore(self, accumulators: tuple[float, float, float, float, float]) -> None:
        """Restore the accumulated quantities."""
        self.work, self.spindle_angle, self._mechanism_inertia, self._spindle_speed, self._angular_momentum = accumulators

    def prepare_interval(self, start: float, end: float, n_steps: int, next_h: float) -> None:
        """Prepare `n_steps` steps from start to end (s), followed by one of `next_h`."""
        h = (end - start) / n_steps
        times = start + (end - start) * np.arange(n_steps + 1) / n_steps
        times[-1] = end
        self._h, self._next_h, self._n_steps = h, next_h, n_steps
        functions = [self._speed_program, *self._load_functions, *self._friction_functions] + (
            [self._torque_function] if self._torque_function else []
        )
        self.has_jump = any(_has_jump_at(function, end) for function in functions)
        if self._has_varying_speed:
            right_limits, left_limits = (self._speed_program(times) ** 2, self._speed_program(times, left_limit=True) ** 2)
            self._speed_squared_changes = list(
                zip((left_limits[1:] - right_limits[:-1]).tolist(), (right_limits[1:] - left_limits[1:]).tolist(), strict=True)
            )
        following_h = 0.0 if self.uses_left_limits else next_h
        self._speeds_squared = (
            _sample_at_kicks(self._speed_program, times, following_h, 2)
            if self._has_varying_speed
            else [self._start_speed_squared] * n_steps
        )
        if self._torque_function:
            self._torque_impulses = [self._torque_function.integral(a, b) for a, b in pairwise(times.tolist())]
        self._load_values = [_sample_at_kicks(function, times, following_h, 1) for function in self._load_functions]
        self._friction_limits = [_sample_at_kicks(function, times, following_h, 1) for function in self._friction_functions]
        targets = np.append(times[2:], end + next_h)
        self._drive_values = [function(targets).tolist() for function in self._drive_functions]

    def step_inputs(self, index: int) -> StepInputs:
        """Return the inputs at the end of step `index` of the interval."""
        is_last = index == self._n_steps - 1
        h, next_h = self._h, self._next_h if is_last else self._h
        speed_squared = self._speeds_squared[index]
        if self._has_varying_speed:
            self._add_work(index)
        if self._free_spindle:
            speed_squared = self._advance_spindle(index)
        return StepInputs(
            h=h,
            next_h=next_h,
            spindle_speed_squared=speed_squared,
            kick_scale=0.5 * (h + next_h) / h,
            load_values=tuple(values[index] for values in self._load_values),
            drive_values=tuple(values[index] for values in self._drive_values),
            friction_limits=tuple(values[index] for values in self._friction_limits),
        )

    def _add_work(self, index: int) -> None:
        """Add the work J omega d(omega) of the speed change over a step, by the trapezoidal rule plus a jump at its end."""
        inertia = self._predict_inertia(self._h)
        change, jump = self._speed_squared_changes[index]
        self.work += 0.25 * (self._mechanism_inertia + inertia) * change + 0.5 * inertia * jump
        self._mechanism_inertia = inertia

    def _advance_spindle(self, index: int) -> float:
        """Return the square of the free spindle's speed at the end of a step and add its angle by the trapezoidal rule."""
        self._angular_momentum += self._torque_impulses[index]
        speed = float(free_spindle_speed(self._angular_momentum, self._spindle_inertia + self._predict_inertia(self._h)))
        self.spindle_angle += 0.5 * self._h * (self._spindle_speed + speed)
        self._spindle_speed = speed
        return speed**2


def _element_programs(element: ForceElement) -> tuple[InputFunction, ...]:
    """Return the time functions of a force element."""
    if isinstance(element, Force):
        return (element.x, element.y)
    return (element.moment,) if isinstance(element, Torque) else ()


def _sample_at_kicks(function: CubicTimeFunction, times: FloatArray, next_h: float, power: int) -> list[float]:
    """Return a time function, raised to `power`, at the end of each step.

    At a jump on the last end, both sides are weighted by the two parts of the kick; with `next_h` = 0 only the left limit counts.
    """
    right_values, left_value = function(times) ** power, function(times[-1:], left_limit=True) ** power
    h = times[-1] - times[-2]
    values: list[float] = right_values[1:].tolist()
    values[-1] = float((h * left_value[0] + next_h * right_values[-1]) / (h + next_h))
    return values


def _has_jump_at(function: CubicTimeFunction, time: float) -> bool:
    """Return whether a time function jumps at a time (s)."""
    times = np.array([time])
    return bool(function(times)[0] != function(times, left_limit=True)[0])

"""Time-dependent inputs of a fixed-step run: spindle speed (prescribed or free), loads, friction limits and drives."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.engines.impulse.applied_forces import StepInputs, lower_scene
from governor_mechanism.integrators.time_grid import sort_distinct
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class SpindleState:
    """Work of changes of a given speed (J), angle, speed, angular momentum of a free spindle, moment of inertia about it (kg m2)."""

    work: float = 0.0
    angle: float = 0.0
    inertia: float = 0.0
    speed: float = 0.0
    angular_momentum: float = 0.0


class TimeInputs:
    """Step inputs of a run, interval by interval; `spindle` accumulates the work and the angle of the spindle.

    `has_jump` states whether an input jumps at the end of the interval. With contacts, a jump counts with its left limit and the full step
    weight: the scheme restarts there.
    """

    def __init__(self, scene: Scene) -> None:
        functions = lower_scene(scene)[1]
        self._speed_program = SpindleSpeedFunction(scene.spindle)
        self._free_spindle = scene.spindle if isinstance(scene.spindle, FreeSpindle) else None
        self._torque_function = CubicTimeFunction(self._free_spindle.torque) if self._free_spindle else None
        n_speeds = sum(plane.given_speed is not None for plane in scene.system.planes)  # the first inputs
        n_drives = sum(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in scene.mechanism.joints)
        self._drive_indices = range(n_speeds, n_speeds + n_drives)
        self._varying_functions = [pair for pair in enumerate(functions[n_speeds:], n_speeds) if not pair[1].is_constant]
        self.n_varying = len(self._varying_functions) + (not self._speed_program.is_constant) + (self._free_spindle is not None)
        start = np.zeros(1)
        self._start_values = np.array([float(function(start)[0]) for function in functions])
        self.breakpoints: FloatArray = sort_distinct(np.concatenate([start[:0], *(function.breakpoints for function in functions)]))
        """Times (s) of jumps and kinks, at which steps must end."""
        jumps = [function(self.breakpoints) != function(self.breakpoints, left_limit=True) for function in functions]
        self._jump_times = set(self.breakpoints[np.any(jumps, axis=0)].tolist())
        self._uses_left_limits, self.has_jump = has_contacts(scene), False

    def reset(self, inertia: Callable[[float], float]) -> None:
        """Begin a run; `inertia` predicts the moment of inertia about the spindle (kg m2) a number of seconds ahead."""
        self._predict_inertia, self.has_jump = inertia, False
        speed = self._speed_program.start_speed
        own_inertia = self._free_spindle.inertia if self._free_spindle else 0.0
        mechanism_inertia = inertia(0.0) if self._free_spindle or not self._speed_program.is_constant else 0.0
        self.spindle = SpindleState(inertia=mechanism_inertia, speed=speed, angular_momentum=(own_inertia + mechanism_inertia) * speed)

    def start_inputs(self, h: float) -> StepInputs:
        """Return the inputs at the start, before a first step of `h` seconds."""
        return replace(self.constant_inputs(h), h=0.5 * h)

    def constant_inputs(self, h: float) -> StepInputs:
        """Return the inputs of a step of `h` seconds with all inputs, including the spindle speed, kept at their start values."""
        return self._inputs_at(0.0, h, self._speed_program.start_speed**2)

    def restart_inputs(self, time: float, h: float) -> StepInputs:
        """Return the inputs of a restart at `time` (s), before a first step of `h` seconds."""
        # The kick has half the size, not half the length: if the step length changes, pymunk scales
        # the accumulated joint impulses wrongly and applies wrong bounds.
        # The speed program of a free spindle is constant; a prescribed spindle keeps its start speed in `spindle`.
        speed = self.spindle.speed if self._speed_program.is_constant else float(self._speed_program(np.array([time]))[0])
        return replace(self._inputs_at(time, h, speed**2), kick_scale=0.5)

    def _inputs_at(self, time: float, h: float, spindle_speed_squared: float) -> StepInputs:
        """Return the inputs at a time (s) for a step of `h` seconds, with the drives at its end."""
        values = self._start_values.copy()
        for index, function in self._varying_functions:
            values[index] = function(np.array([time + h if index in self._drive_indices else time]))[0]
        return StepInputs(h, h, spindle_speed_squared, values)

    def prepare_interval(self, start: float, end: float, n_steps: int, next_h: float) -> None:
        """Prepare `n_steps` steps from start to end (s), followed by one of `next_h`."""
        self._h = (end - start) / n_steps
        self._next_h = next_h
        self._n_steps = n_steps
        self.has_jump = end in self._jump_times
        self._values: Sequence[FloatArray] | FloatArray = [self._start_values] * n_steps
        self._speeds_squared = [self._speed_program.start_speed**2] * n_steps
        if self.n_varying:
            self._sample_inputs(start, end, n_steps, next_h)

    def _sample_inputs(self, start: float, end: float, n_steps: int, next_h: float) -> None:
        """Sample the inputs that vary at the steps of an interval."""
        times = start + (end - start) * np.arange(n_steps + 1) / n_steps
        times[-1] = end
        following_h = 0.0 if self._uses_left_limits else next_h
        values = np.tile(self._start_values, (n_steps, 1))
        for index, function in self._varying_functions:
            if index in self._drive_indices:
                values[:, index] = function(np.append(times[2:], end + next_h))
            else:
                values[:, index] = _sample_at_kicks(function, times, following_h)
        self._values = values
        if not self._speed_program.is_constant:
            right_limits = self._speed_program(times) ** 2
            left_limits = self._speed_program(times, left_limit=True) ** 2
            self._speeds_squared = _sample_at_kicks(self._speed_program, times, following_h, 2).tolist()
            changes = left_limits[1:] - right_limits[:-1]
            jumps = right_limits[1:] - left_limits[1:]
            self._speed_squared_changes = np.stack([changes, jumps], axis=1).tolist()
        if self._torque_function:
            self._torque_impulses = np.diff(self._torque_function.integrals(float(times[0]), times)).tolist()

    def step_inputs(self, index: int) -> StepInputs:
        """Return the inputs at the end of step `index` of the interval."""
        h, next_h = self._h, self._next_h if index == self._n_steps - 1 else self._h
        speed_squared = self._speeds_squared[index]
        if not self._speed_program.is_constant:
            self._add_work(index)
        if self._free_spindle:
            speed_squared = self._advance_spindle(self._free_spindle.inertia, index)
        return StepInputs(h, next_h, speed_squared, self._values[index], kick_scale=0.5 * (h + next_h) / h)

    def _add_work(self, index: int) -> None:
        """Add the work J omega d(omega) of the speed change over a step, by the trapezoidal rule plus a jump at its end."""
        inertia = self._predict_inertia(self._h)
        change, jump = self._speed_squared_changes[index]
        work = self.spindle.work + 0.25 * (self.spindle.inertia + inertia) * change + 0.5 * inertia * jump
        self.spindle = replace(self.spindle, work=work, inertia=inertia)

    def _advance_spindle(self, own_inertia: float, index: int) -> float:
        """Return the square of the free spindle's speed at the end of a step and add its angle by the trapezoidal rule."""
        momentum = self.spindle.angular_momentum + self._torque_impulses[index]
        speed = float(momentum / (own_inertia + self._predict_inertia(self._h)))
        angle = self.spindle.angle + 0.5 * self._h * (self.spindle.speed + speed)
        self.spindle = replace(self.spindle, angle=angle, speed=speed, angular_momentum=momentum)
        return speed**2


def _sample_at_kicks(function: CubicTimeFunction, times: FloatArray, next_h: float, power: int = 1) -> FloatArray:
    """Return a time function, raised to `power`, at the end of each step; shape (steps,)."""
    # At a jump on the last end, both sides are weighted by the two parts of the kick; with `next_h` = 0
    # only the left limit counts.
    right_values = function(times) ** power
    left_value = function(times[-1:], left_limit=True) ** power
    h = times[-1] - times[-2]
    right_values[-1] = (h * left_value[0] + next_h * right_values[-1]) / (h + next_h)
    return right_values[1:]

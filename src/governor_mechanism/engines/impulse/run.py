"""Fixed-step integration of a pymunk model over a time grid, and relaxation to equilibrium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.impulse.event_stepper import EventDrivenStepper
from governor_mechanism.engines.impulse.pymunk import PymunkModel
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.integrators.time_grid import TimeGrid
from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

LIMIT_CHECK_INTERVAL = 256
"""Number of monitor times between two checks of the limits of the mechanism."""

MAX_BODY_DISTANCE_RATIO = 1e3
"""Distance of a body from the origin, relative to the length scale, at which a run counts as diverged (unsolved joints)."""


@dataclass(frozen=True)
class FixedStepSolution:
    """Poses and velocities (times, bodies, 3) at the monitor times; shorter than the grid if the run was abandoned.

    `work` (times,) J is the work of changes of a prescribed spindle speed, `spindle_angle` (times,) rad that of a free spindle, and
    `dissipated_energy` (times,) J the loss in dashpots, friction and stops. `contact_modes` has one entry per monitor time.
    """

    poses: FloatArray
    velocities: FloatArray
    work: FloatArray
    spindle_angle: FloatArray
    dissipated_energy: FloatArray
    events: tuple[Event, ...] = ()
    contact_modes: tuple[ContactMode, ...] = ()
    n_split_steps: int = 0


def integrate_fixed_step(
    model: PymunkModel,
    grid: TimeGrid,
    level: int,
    time_inputs: TimeInputs,
    start: tuple[FloatArray, FloatArray],
    *,
    length_scale: float,
    is_within_limits: Callable[[FloatArray], bool],
) -> FixedStepSolution:
    """Integrate over the grid, with the steps of each interval halved `level` times, from poses and velocities (bodies, 3).

    The run is abandoned if a body diverges, and soon after `is_within_limits` rejects poses (times, bodies, 3).
    """
    poses, velocities = start
    step_counts = grid.min_steps << level
    if step_counts.size == 0:
        return FixedStepSolution(poses[np.newaxis], velocities[np.newaxis], np.zeros(1), np.zeros(1), np.zeros(1))
    lengths = np.diff(grid.monitor_times) / step_counts
    next_lengths = np.append(lengths[1:], lengths[-1:])
    model.start(poses, velocities, time_inputs.start_inputs(float(lengths[0])))
    time_inputs.reset(model.predict_spindle_inertia)
    if model.is_plain:
        states = [(model.poses(), model.velocities(), 0.0, 0.0, 0.0)]
    else:  # the poses are those of the start; the velocities are already half a step ahead
        states = [(model.poses(), _to_proxy_velocities(model, velocities), 0.0, 0.0, 0.0)]
    for index, (h, next_h) in enumerate(zip(lengths.tolist(), next_lengths.tolist(), strict=True)):
        # The last kick spans half of this step and half of the next, which can differ in length.
        time_inputs.prepare_interval(grid.monitor_times[index], grid.monitor_times[index + 1], int(step_counts[index]), next_h)
        try:
            earlier, previous = _step_interval(model, int(step_counts[index]), time_inputs)
        except (ValueError, OverflowError):  # a body diverged to a position that is not finite
            break
        current, poses_now = model.velocities(), model.poses()
        if model.is_plain:
            velocities_now = current
        elif time_inputs.has_jump:  # the load jumps, so the mean of both sides is not the velocity: extrapolate from the left
            velocities_now = previous + 0.5 * (previous - earlier)
        else:
            velocities_now = (next_h * previous + h * current) / (h + next_h)
        if not np.max(np.abs(poses_now[:, :2])) < MAX_BODY_DISTANCE_RATIO * length_scale:
            break
        states.append((poses_now, velocities_now, time_inputs.work, time_inputs.spindle_angle, model.dissipated_energy))
        if len(states) % LIMIT_CHECK_INTERVAL == 0 and not is_within_limits(_mass_centres(model, states[-LIMIT_CHECK_INTERVAL:])):
            break
    columns = [np.array(column) for column in zip(*states, strict=True)]
    mass_centre_poses, mass_centre_velocities = model.to_mass_centres(columns[0], columns[1])
    return FixedStepSolution(mass_centre_poses, mass_centre_velocities, columns[2], columns[3], columns[4])


def integrate_with_events(
    scene: Scene,
    model: PymunkModel,
    grid: TimeGrid,
    level: int,
    time_inputs: TimeInputs,
    start: tuple[FloatArray, FloatArray],
    *,
    time_scale: float,
    length_scale: float,
    is_within_limits: Callable[[FloatArray], bool],
) -> FixedStepSolution:
    """Integrate as `integrate_fixed_step` does, for a scene with contacts; `time_scale` is in seconds."""
    step_counts = grid.min_steps << level
    lengths = np.diff(grid.monitor_times) / step_counts if step_counts.size else np.ones(1)
    next_lengths = np.append(lengths[1:], lengths[-1:])
    stepper = EventDrivenStepper(scene, model, time_inputs, start, time_scale=time_scale, level=level, h=float(lengths[0]))
    states, contact_modes = [(*start, 0.0, 0.0, stepper.dissipated_energy)], [stepper.mode]
    for index, next_h in enumerate(next_lengths[: step_counts.size].tolist()):
        begin, end = float(grid.monitor_times[index]), float(grid.monitor_times[index + 1])
        try:
            is_complete = stepper.integrate(begin, end, int(step_counts[index]), next_h)
        except (ValueError, OverflowError, np.linalg.LinAlgError):
            break
        poses, velocities = stepper.mass_centre_state()
        if not (is_complete and np.max(np.abs(poses[:, :2])) < MAX_BODY_DISTANCE_RATIO * length_scale):
            break
        states.append((poses, velocities, time_inputs.work, time_inputs.spindle_angle, stepper.dissipated_energy))
        contact_modes.append(stepper.mode)
        if len(states) % LIMIT_CHECK_INTERVAL == 0 and not is_within_limits(
            np.array([state[0] for state in states[-LIMIT_CHECK_INTERVAL:]])
        ):
            break
    columns = [np.array(column) for column in zip(*states, strict=True)]
    return FixedStepSolution(
        columns[0], columns[1], columns[2], columns[3], columns[4], tuple(stepper.events), tuple(contact_modes), stepper.n_split_steps
    )


def _mass_centres(model: PymunkModel, states: list[tuple[FloatArray, FloatArray, float, float, float]]) -> FloatArray:
    """Return the poses (n, bodies, 3) of the mass centres of recorded states."""
    poses, velocities = (np.array([state[column] for state in states]) for column in (0, 1))
    return model.to_mass_centres(poses, velocities)[0]


def _to_proxy_velocities(model: PymunkModel, velocities: FloatArray) -> FloatArray:
    """Convert the start velocities to those of the body proxies; the pin of a pinned body does not move."""
    return np.where(model.pinned_bodies()[:, np.newaxis], velocities * np.array([0.0, 0.0, 1.0]), velocities)


def _step_interval(model: PymunkModel, n_steps: int, time_inputs: TimeInputs) -> tuple[FloatArray, FloatArray]:
    """Step through one interval; return the velocities before the last kick but one (empty without a jump) and before the last."""
    earlier = np.empty(0)
    for index in range(n_steps):
        if index == n_steps - 1:
            previous = model.velocities()
        elif time_inputs.has_jump and index == n_steps - 2:
            earlier = model.velocities()
        model.step(time_inputs.step_inputs(index))
    return earlier, previous


N_JOINT_RECOVERY_STEPS = 3
"""Number of steps after a stop in which the joints recover from it; the kinetic energy there is not that of the oscillation."""


@dataclass(frozen=True)
class RelaxationResult:
    """Final poses (bodies, 3), the number of steps, and whether the mechanism came to rest."""

    poses: FloatArray
    steps: int
    at_rest: bool


def relax(
    model: PymunkModel,
    h: float,
    time_inputs: TimeInputs,
    poses: FloatArray,
    *,
    max_rest_energy: float,
    is_within_limits: Callable[[FloatArray], bool],
    max_steps: int,
) -> RelaxationResult:
    """Release the mechanism and remove its kinetic energy at each maximum, until it stays in place (kinetic damping).

    From one stop to the next it swings from rest toward the equilibrium, which reduces the distance about a hundredfold. `max_rest_energy`
    (J) is the largest kinetic energy that counts as rest; `is_within_limits` checks poses (bodies, 3).
    """
    model.start(poses, np.zeros_like(poses), time_inputs.start_inputs(h))
    inputs = time_inputs.constant_inputs(h)
    max_energy, steps_since_stop = 0.0, 0
    for steps in range(max_steps):
        energy = model.kinetic_energy()
        if steps_since_stop > N_JOINT_RECOVERY_STEPS and energy < max_energy:  # just past the maximum, which is at the equilibrium
            if max_energy < max_rest_energy:
                return RelaxationResult(_mass_centre_poses(model), steps, True)
            model.zero_velocities()
            max_energy, steps_since_stop = 0.0, 0
            if not is_within_limits(_mass_centre_poses(model)):
                break
        if steps_since_stop >= N_JOINT_RECOVERY_STEPS:
            max_energy = max(max_energy, energy)
        steps_since_stop += 1
        model.step(inputs)
    return RelaxationResult(_mass_centre_poses(model), steps, False)


def _mass_centre_poses(model: PymunkModel) -> FloatArray:
    """Return the present poses (bodies, 3) of the mass centres."""
    return model.to_mass_centres(model.poses(), model.velocities())[0]

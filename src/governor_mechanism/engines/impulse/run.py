"""Fixed-step integration of a pymunk model over a time grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.impulse.event_stepper import EventDrivenStepper
from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.integrators.time_grid import TimeGrid
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, has_contacts
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


class FixedStepper:
    """Integrates a pymunk model without contacts over successive intervals from start poses and velocities (bodies, 3).

    `h` (s) is the first step.
    """

    events: tuple[Event, ...] = ()
    mode = ContactMode()
    n_split_steps = 0

    def __init__(self, model: PymunkModel, time_inputs: TimeInputs, start: tuple[FloatArray, FloatArray], h: float) -> None:
        self._model, self._time_inputs = model, time_inputs
        model.start(*start, time_inputs.start_inputs(h))
        time_inputs.reset(model.predict_spindle_inertia)
        # Except in a plain model the velocities are half a step ahead of the poses; the start velocities belong to the poses.
        self._poses, self._velocities = model.state()
        if not model.is_plain:
            self._velocities = model.to_proxy_velocities(start[1])

    def integrate(self, start: float, end: float, n_steps: int, next_h: float) -> bool:
        """Integrate from start to end (s) in `n_steps` steps, followed by one of `next_h`."""
        model, time_inputs, h = self._model, self._time_inputs, (end - start) / n_steps
        # The last kick spans half of this step and half of the next, which can differ in length.
        time_inputs.prepare_interval(start, end, n_steps, next_h)
        earlier = previous = self._velocities
        for index in range(n_steps):
            earlier, previous = previous, model.step(time_inputs.step_inputs(index))
        self._poses, self._velocities = model.state()
        if model.is_plain:
            return True
        if time_inputs.has_jump:  # the load jumps, so the mean of both sides is not the velocity: extrapolate from the left
            self._velocities = previous + 0.5 * (previous - earlier)
        else:
            self._velocities = (next_h * previous + h * self._velocities) / (h + next_h)
        return True

    def mass_centre_state(self) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (bodies, 3) of the mass centres at the present time."""
        return self._model.to_mass_centres(self._poses, self._velocities)

    @property
    def dissipated_energy(self) -> float:
        """Return the energy dissipated so far by dashpots (J)."""
        return self._model.forces.dissipated_energy


def integrate_over_grid(
    scene: Scene,
    model: PymunkModel,
    grid: TimeGrid,
    level: int,
    time_inputs: TimeInputs,
    start: tuple[FloatArray, FloatArray],
    settings: ImpulseSettings,
    *,
    time_scale: float,
    is_within_limits: Callable[[FloatArray], bool],
) -> FixedStepSolution:
    """Integrate over the grid, with the steps of each interval halved `level` times, from poses and velocities (bodies, 3).

    The run is abandoned if a body diverges, and soon after `is_within_limits` rejects poses (times, bodies, 3). `time_scale` is in s.
    """
    step_counts = grid.min_steps << level
    lengths = np.diff(grid.monitor_times) / step_counts if step_counts.size else np.ones(1)
    next_lengths = np.append(lengths[1:], lengths[-1:])
    h, is_splitting = float(lengths[0]), has_contacts(scene)
    stepper: FixedStepper | EventDrivenStepper
    if is_splitting:
        stepper = EventDrivenStepper(scene, model, time_inputs, start, settings, time_scale=time_scale, level=level, h=h)
    else:
        stepper = FixedStepper(model, time_inputs, start, h)
    initial = start if is_splitting or not step_counts.size else stepper.mass_centre_state()
    states, contact_modes = [(*initial, 0.0, 0.0, stepper.dissipated_energy)], [stepper.mode]
    max_distance = MAX_BODY_DISTANCE_RATIO * scene.part.mechanism.length_scale
    for index, next_h in enumerate(next_lengths[: step_counts.size].tolist()):
        begin, end = float(grid.monitor_times[index]), float(grid.monitor_times[index + 1])
        try:
            is_complete = stepper.integrate(begin, end, int(step_counts[index]), next_h)
        except (ValueError, OverflowError, np.linalg.LinAlgError):  # a body diverged to a position that is not finite
            break
        poses, velocities = stepper.mass_centre_state()
        if not (is_complete and np.max(np.abs(poses[:, :2])) < max_distance):
            break
        states.append((poses, velocities, time_inputs.spindle.work, time_inputs.spindle.angle, stepper.dissipated_energy))
        contact_modes.append(stepper.mode)
        if len(states) % LIMIT_CHECK_INTERVAL == 0 and not is_within_limits(np.array([row[0] for row in states[-LIMIT_CHECK_INTERVAL:]])):
            break
    columns = [np.array(column) for column in zip(*states, strict=True)]
    return FixedStepSolution(
        poses=columns[0],
        velocities=columns[1],
        work=columns[2],
        spindle_angle=columns[3],
        dissipated_energy=columns[4],
        events=tuple(stepper.events),
        contact_modes=tuple(contact_modes) if is_splitting else (),
        n_split_steps=stepper.n_split_steps,
    )

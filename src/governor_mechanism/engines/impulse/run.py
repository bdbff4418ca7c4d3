"""Fixed-step integration of a pymunk model over a time grid."""

from collections.abc import Mapping

import numpy as np

from governor_mechanism.engines.impulse.event_stepper import EventDrivenStepper
from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, has_contacts
from governor_mechanism.model.events import Event
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

LIMIT_CHECK_INTERVAL = 256
"""Number of monitor times between two checks of the limits of the mechanism."""

MAX_BODY_DISTANCE_RATIO = 1e3
"""Distance of a body from the origin, relative to the length scale, at which a run counts as diverged (unsolved joints)."""


class FixedStepper:
    """Integrates a pymunk model without contacts over successive intervals; `h` (s) is the first step."""

    events: tuple[Event, ...] = ()
    mode = ContactMode()
    n_split_steps = 0

    def __init__(self, problem: FixedStepProblem, model: PymunkModel, h: float) -> None:
        self._model, self._time_inputs = model, problem.time_inputs
        model.start(*problem.start, self._time_inputs.start_inputs(h))
        self._time_inputs.reset(model.predict_spindle_inertia)
        # Except in a plain model the velocities are half a step ahead of the poses; the start velocities belong to the poses.
        self._poses, self._velocities = model.state()
        if not model.is_plain:
            self._velocities = model.to_proxy_velocities(problem.start[1])

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


def integrate_over_grid(problem: FixedStepProblem, level: int, iterations: int) -> tuple[FixedStepSolution, Mapping[str, int]]:
    """Integrate over the grid, with the steps of each interval halved `level` times and at first `iterations` of the joint solver.

    The run is abandoned if a body diverges, and soon after it leaves the limits of the mechanism. The second result states how often one
    step evaluates each force law.
    """
    model = PymunkModel(problem.scene, iterations=iterations, plain=problem.settings.plain)
    times, step_counts, time_inputs = problem.grid.monitor_times, problem.grid.min_steps << level, problem.time_inputs
    lengths = np.diff(times) / step_counts if step_counts.size else np.ones(1)
    next_lengths = np.append(lengths[1:], lengths[-1:])[: step_counts.size].tolist()
    stepper: FixedStepper | EventDrivenStepper
    if has_contacts(problem.scene):
        stepper, start = EventDrivenStepper(problem, model, level, float(lengths[0])), problem.start
    else:
        stepper = FixedStepper(problem, model, float(lengths[0]))
        start = stepper.mass_centre_state() if step_counts.size else problem.start
    states, contact_modes = [(*start, 0.0, 0.0, stepper.dissipated_energy)], [stepper.mode]
    max_distance = MAX_BODY_DISTANCE_RATIO * problem.scene.part.mechanism.length_scale
    for index, next_h in enumerate(next_lengths):
        try:
            is_complete = stepper.integrate(float(times[index]), float(times[index + 1]), int(step_counts[index]), next_h)
        except (ValueError, OverflowError, np.linalg.LinAlgError):  # a body diverged to a position that is not finite
            break
        poses, velocities = stepper.mass_centre_state()
        if not (is_complete and np.max(np.abs(poses[:, :2])) < max_distance):
            break
        states.append((poses, velocities, time_inputs.spindle.work, time_inputs.spindle.angle, stepper.dissipated_energy))
        contact_modes.append(stepper.mode)
        if len(states) % LIMIT_CHECK_INTERVAL == 0:
            recent_poses = np.array([row[0] for row in states[-LIMIT_CHECK_INTERVAL:]])
            if problem.evaluator.find_first_out_of_range(recent_poses) is not None:
                break
    poses, velocities, work, spindle_angle, dissipated_energy = (np.array(column) for column in zip(*states, strict=True))
    history = StateHistory(
        times=times[: len(states)],
        poses=poses,
        velocities=velocities,
        work=work,
        dissipated_energy=dissipated_energy,
        lags=np.zeros((len(states), 0)),
    )
    solution = FixedStepSolution(
        states=history,
        raw_poses=poses,
        spindle_angle=spindle_angle,
        events=tuple(stepper.events),
        contact_modes=tuple(contact_modes) if has_contacts(problem.scene) else (),
        n_split_steps=stepper.n_split_steps,
    )
    return solution, model.forces.evaluation_counts

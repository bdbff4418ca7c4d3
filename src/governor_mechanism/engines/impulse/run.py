"""Fixed-step integration of a pymunk model over a time grid."""

from dataclasses import replace

import numpy as np

from governor_mechanism.engines.impulse.event_stepper import EventDrivenStepper
from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution, StepExit
from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.engines.impulse.work_budget import StepLimitError
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

MIN_PATH_STEPS = 4
"""Steps in an interval from which the limits are checked at each of them: the motion is fast against the monitor times."""

EXIT_BISECTIONS = 30
"""Bisections of an exit within a step: to 1e-9 of the step, far less than its error."""

LIMIT_CHECK_INTERVAL = 256
"""Number of monitor times between two checks of the limits of the mechanism."""


@np.errstate(all="ignore")  # diverging bodies give infinite values before the run is abandoned
def integrate_over_grid(problem: FixedStepProblem, level: int, iterations: int, n_times: int) -> FixedStepSolution:
    """Integrate over `n_times` of the grid, with the steps of each interval halved `level` times and `iterations` of the joint solver.

    The run is abandoned if its share of the budget is spent, soon after it leaves the limits of the mechanism, and where a body is too
    far away. Its states have compatible velocities and the shaft of a free spindle.
    """
    settings, evaluator, budget = problem.settings, problem.evaluator, problem.budget
    model = PymunkModel(problem.scene, iterations=iterations, plain=settings.plain, count_step=budget.count_step)
    times, step_counts, time_inputs = problem.grid.monitor_times, problem.grid.min_steps << level, problem.time_inputs
    lengths = np.diff(times) / step_counts if step_counts.size else np.ones(1)
    next_lengths = np.append(lengths[1:], lengths[-1:])[: step_counts.size].tolist()
    first_h = float(lengths[0])
    model.start(*problem.start, time_inputs.start_inputs(first_h))
    time_inputs.reset(model.predict_spindle_inertia)
    contacts = problem.scene_contacts if has_contacts(problem.scene) else None
    stepper = StaggeredStepper(problem, model, level, first_h) if contacts is None else EventDrivenStepper(problem, model, level, first_h)
    # A stop that is struck at the start has changed the velocities.
    start = stepper.mass_centre_state() if contacts or step_counts.size else problem.start
    states, contact_modes = [(*start, 0.0, 0.0, stepper.state.dissipated_energy)], [contacts.mode] if contacts else []
    first_exit: StepExit | None = None
    has_limits = bool(evaluator.mechanism.limits) and not settings.plain
    is_complete, reached_limit, max_distance = True, False, settings.max_distance_ratio * evaluator.mechanism.length_scale
    for index, next_h in enumerate(next_lengths[: n_times - 1]):
        stepper.path = [] if has_limits and step_counts[index] >= MIN_PATH_STEPS else None
        start_poses = states[-1][0]
        try:
            is_complete = stepper.integrate(float(times[index]), float(times[index + 1]), int(step_counts[index]), next_h)
        except StepLimitError:
            reached_limit = True
            break
        except (ValueError, OverflowError, np.linalg.LinAlgError):  # a body diverged to a position that is not finite
            break
        poses, velocities = stepper.mass_centre_state()
        if not (is_complete and np.isfinite(poses).all()):
            break
        states.append((poses, velocities, time_inputs.spindle.work, time_inputs.spindle.angle, stepper.state.dissipated_energy))
        contact_modes += [contacts.mode] if contacts else []
        if np.max(np.abs(poses[:, :2])) > max_distance:
            break  # it flies away, or its joints are torn
        if stepper.path:
            first_exit = _find_step_exit(problem, model, float(times[index]), start_poses, stepper.path, len(states) - 1)
            if first_exit is not None:
                break
        if len(states) % LIMIT_CHECK_INTERVAL == 0:
            recent_poses, recent_velocities = (np.array([row[k] for row in states[-LIMIT_CHECK_INTERVAL:]]) for k in (0, 1))
            if evaluator.find_first_out_of_range(recent_poses) or evaluator.find_first_stall(recent_poses, recent_velocities):
                break
    n_steps = int(step_counts[: len(states) - 1].sum()) + stepper.n_split_steps
    raw_poses, velocities, work, spindle_angle, dissipated_energy = (np.array(column) for column in zip(*states, strict=True))
    times, lags = times[: len(states)], np.zeros((len(states), 0))
    history = StateHistory(times=times, poses=raw_poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, lags=lags)
    return FixedStepSolution(
        states=_with_compatible_velocities(problem, history, spindle_angle),
        raw_poses=raw_poses,
        events=tuple(contacts.events) if contacts else (),
        contact_modes=tuple(contact_modes),
        has_chatter=not is_complete,
        first_exit=first_exit,
        reached_limit=reached_limit,
        n_steps=n_steps,
        evaluation_counts={law: count * n_steps for law, count in model.forces.evaluation_counts.items()},
    )


def _find_step_exit(
    problem: FixedStepProblem, model: PymunkModel, start: float, start_poses: FloatArray, path: list[tuple[float, FloatArray]], index: int
) -> StepExit | None:
    """Return the first exit from the limits along the steps of an interval that ends at monitor time `index`, or None."""
    times = np.array([start, *(time for time, _ in path)])
    poses = np.array([one for _, one in path])
    poses = np.concatenate([start_poses[np.newaxis], model.to_mass_centres(poses, np.zeros_like(poses))[0]])
    found = problem.evaluator.find_first_out_of_range(poses)
    if found is None or found[0] == 0:
        return None
    k, (low, high) = found[0], (0.0, 1.0)
    for _ in range(EXIT_BISECTIONS):
        middle = 0.5 * (low + high)
        between = (1 - middle) * poses[k - 1] + middle * poses[k]
        is_outside = problem.evaluator.find_first_out_of_range(between[np.newaxis]) is not None
        low, high = (low, middle) if is_outside else (middle, high)
    return StepExit(index, found[1], float(times[k - 1] + high * (times[k] - times[k - 1])))


def _with_compatible_velocities(problem: FixedStepProblem, history: StateHistory, spindle_angle: FloatArray) -> StateHistory:
    """Return the states of a run with velocities that the joints allow, and with the shaft of a free spindle at angles (times,) rad."""
    times, poses, velocities, evaluator = history.times, history.poses, history.velocities, problem.evaluator
    if not problem.settings.plain:
        # The mean of two half steps opens the joints slightly, and more where the step length changes.
        # With contacts the gap depends on the step, which differs where a step was split.
        poses, velocities = problem.projector.project(times, poses, velocities, closes_joints=has_contacts(problem.scene))
    poses, velocities = evaluator.with_shaft(times, poses, velocities, spindle_angle)
    return replace(history, poses=poses, velocities=velocities)

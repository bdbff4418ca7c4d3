"""Fixed-step integration of a pymunk model over a time grid; a step with an event is split there.

Sliding friction is a force. Sticking friction is a pymunk joint that bears no more than the friction limit, so the joint solver itself
decides when it slips, and in which direction. A stop reflects an impact and holds a resting contact by a joint that only pushes. The
staggered scheme restarts at each event from poses and velocities of one time.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.impulse.contact import ContactModeTracker
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.records import DetectedEvent, FixedStepProblem, FixedStepSolution, HeldModel, StepExit
from governor_mechanism.engines.impulse.settings import StepLimitError
from governor_mechanism.engines.impulse.staggered_stepper import Path, StaggeredStepper
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, has_contacts
from governor_mechanism.model.events import EventKind
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

MIN_REMAINDER_RATIO = 1e-4
"""Remainder before a monitor time, relative to a step, that is extrapolated instead of stepped: a step would divide by rounding."""

BOUNCE_DURATION_FACTOR = 1.2
"""Multiple of the predicted duration of a short bounce after which it is over."""

PASSAGE_STEP_RATIO = 1e-3
"""Part of a step over which the speed along an edge is measured."""

MIN_SUBSTEP_RATIO, TIME_ROUNDING_RATIO = 1e-9, 4e-15
"""Shortest substep relative to a step, and relative to the elapsed time (rounding)."""

# The contact starts to move with zero force; a release slightly too early would be held again at once.
RELEASE_SEARCH_START = 0.05
RELEASE_FRACTION_TOLERANCE = 1e-9
RELEASE_DELAY_FRACTION = 1e-4
"""Step fractions of a release: where the search begins, its tolerance, and the delay of the release after the root."""

JOIN_DELAY_FRACTION = 1e-8
"""Step fraction behind the join of two edges at which a run goes on: there the next edge is the nearer one, in spite of rounding."""

SLIP_SEARCH_START = 0.5
"""Step fraction from which the holding force is computed directly; earlier it is extrapolated, since shorter steps lose it to rounding."""

STEP_LENGTH_TOLERANCE = 1e-9
"""Relative difference up to which two step lengths count as equal."""

EVENT_FRACTION_TOLERANCE = 1e-13
"""Tolerance of an event location, as a fraction of the step."""


class EventDrivenStepper(StaggeredStepper):
    """Integrates over intervals, splitting steps at events; `level` is how often the first step `h` (s) is halved."""

    def __init__(self, problem: FixedStepProblem, model: PymunkModel, level: int, h: float) -> None:
        super().__init__(problem, model, level, h)
        self._contact_tracker = ContactModeTracker(problem, self)
        self._steps_per_bounce = problem.settings.min_steps_per_bounce << level
        self._bounce_step, self._bounce_end = 0.0, -math.inf
        self._restart_after_event(h)

    def integrate(self, start: float, end: float, n_steps: int, next_h: float) -> bool:
        """Integrate from start to end (s) in `n_steps` steps, followed by one of `next_h`; return False if chatter does not end."""
        full_step = (end - start) / n_steps
        time = start
        n_events = 0
        target = end
        steps = n_steps
        is_hold_step_changed = self.is_holding and abs(full_step - self.last_h) > STEP_LENGTH_TOLERANCE * full_step
        if is_hold_step_changed or start < self._bounce_end:
            self.close_joints()
            target, steps = self._plan_substeps(start, end, full_step)
        while time < end:
            h = (target - time) / steps
            detected = self._step_until_event(time, target, steps, next_h if target == end else h)
            if not detected and target == end:
                break
            if detected:
                n_events += 1
                self._locate_first_event(detected, h)
            else:
                self.close_joints()
            if n_events > self._problem.settings.max_events_per_step * n_steps:
                return False
            time = self.state.time
            if end - time < MIN_REMAINDER_RATIO * full_step:
                self.extrapolate_to(end, full_step)
                self._end_at_restart(next_h)
                return True
            target, steps = self._plan_substeps(time, end, full_step)
        if self.time_inputs.has_jump:
            self.close_joints()
            self._end_at_restart(next_h)
        return True

    def _end_at_restart(self, next_h: float) -> None:
        """Restart at the end of an interval, before a step of `next_h` seconds; where an input jumps, in another mode."""
        if self.time_inputs.has_jump:
            self._contact_tracker.change_mode()
        self._restart_after_event(next_h)

    def _plan_substeps(self, time: float, end: float, full_step: float) -> tuple[float, int]:
        """Restart toward `end` (s) with steps of at most `full_step`; return the target time (s) and the number of steps."""
        # A bounce takes a number of steps such that the steps of all runs shorten by the same
        # factor from level to level.
        steps = math.ceil((end - time) / full_step * (1 - MIN_REMAINDER_RATIO))
        bounce_duration = self._restart_after_event((end - time) / steps)
        if bounce_duration < self._steps_per_bounce * full_step:
            self._bounce_step = bounce_duration / self._steps_per_bounce
            self._bounce_end = time + BOUNCE_DURATION_FACTOR * bounce_duration
        if self._bounce_end <= time + self._bounce_step:
            return end, steps
        target = min(end, self._bounce_end)
        if end - target < MIN_REMAINDER_RATIO * full_step:
            target = end
        steps = math.ceil((target - time) / min(self._bounce_step, full_step))
        self._restart_after_event((target - time) / steps)
        return target, steps

    def _step_until_event(self, start: float, end: float, n_steps: int, next_h: float) -> list[DetectedEvent]:
        """Step until an event is detected and return the detected events."""
        time_inputs, h = self.time_inputs, (end - start) / n_steps
        self.last_h = h
        self._budget.count_interval()
        time_inputs.prepare_interval(start, end, n_steps, next_h)
        if time_inputs.has_jump:  # the run restarts there with the right limits
            time_inputs.prepare_interval(start, end, n_steps, h)
        for index in range(n_steps):
            state = self.step(time_inputs.step_inputs(index), end if index == n_steps - 1 else start + (index + 1) * h)
            detected = self._contact_tracker.detect_events(state)
            if detected:
                return detected
            self.state = state
            if self.path is not None:
                self.path.append((state.time, state.poses))
        return []

    def _locate_first_event(self, detected: list[DetectedEvent], h: float) -> None:
        """Move to the first of the detected events within the next `h` seconds and apply its transitions."""
        self.close_joints()
        fractions = {index: self._event_fraction(event, h) for index, event in enumerate(detected)}
        first = min(1.0, *fractions.values())
        self.state = self.take_trial_step(max(first, self._min_fraction(h)) * h)
        self.n_split_steps += 1
        first_events = [event for index, event in enumerate(detected) if fractions[index] - first <= 10 * EVENT_FRACTION_TOLERANCE]
        self._contact_tracker.change_mode(first_events)

    def _event_fraction(self, event: DetectedEvent, h: float) -> float:
        """Return the fraction of the next `h` seconds at which an event occurs; infinite if it does not occur."""
        from scipy.optimize import brentq  # slow to import

        constraint = self._contact_tracker.constraints[event.index] if event.kind == EventKind.SLIP else None
        is_release = event.kind in (EventKind.SLIP, EventKind.SEPARATION)
        min_fraction = self._min_fraction(h)

        # Those of forces are negative at the start: they have no value before a step.
        initial_value = -1.0 if is_release else event.event_function(self.state)

        known = dict[float, float]()  # the same trial step, taken again after others, may round to another sign

        def event_value(fraction: float) -> float:
            if fraction <= min_fraction:
                return initial_value
            if fraction not in known:
                known[fraction] = event.event_function(self.take_trial_step(fraction * h, steps=1 if constraint is None else 2))
            return known[fraction]

        held_value = None if constraint is None else constraint.held_value
        if constraint is not None:
            # A short step would remove the position error left by long steps with a force that does not exist: hold the present value.
            constraint.is_force_limited = False
            constraint.held_value = float(self.state.values[self._contact_tracker.contact_outputs[event.index]])
        try:
            end_value = event_value(event.latest)
            low = 0.0
            high = event.latest
            if end_value <= 0.0:
                return math.inf  # the joint solver had not converged in the full step
            if is_release:
                low = RELEASE_SEARCH_START if event.kind == EventKind.SEPARATION else SLIP_SEARCH_START
                low_value = event_value(low)
                if low_value >= 0.0:
                    extrapolated_root = low - low_value * (1.0 - low) / (end_value - low_value) if end_value > low_value else 0.0
                    return min(max(extrapolated_root, min_fraction) + RELEASE_DELAY_FRACTION, low)
                return min(1.0, float(brentq(event_value, low, 1.0, xtol=RELEASE_FRACTION_TOLERANCE, rtol=1e-15)) + RELEASE_DELAY_FRACTION)
            if initial_value > -RELEASE_SEARCH_START * end_value:
                # The step starts at the last event: find a time at which the event function is negative again.
                low = next((fraction for fraction in 0.5 ** np.arange(1, 30) if event_value(fraction) < 0.0), -1.0)
                if low < 0.0:
                    # A contact that has just slipped starts without speed; any other contact without speed was at rest before.
                    has_just_slipped = self._contact_tracker.last_release_time == self.state.time
                    return 1.0 if event.kind == EventKind.STICK and has_just_slipped else 0.0
            delay = JOIN_DELAY_FRACTION if event.kind is None else 0.0
            return min(1.0, float(brentq(event_value, low, high, xtol=EVENT_FRACTION_TOLERANCE, rtol=1e-15)) + delay)
        finally:
            if constraint is not None:
                constraint.is_force_limited, constraint.held_value = True, held_value

    def _min_fraction(self, h: float) -> float:
        """Return the smallest fraction of `h` seconds that is well above the rounding of the present time."""
        return max(MIN_SUBSTEP_RATIO, TIME_ROUNDING_RATIO * self.state.time / h)

    def _restart_after_event(self, h: float) -> float:
        """Restart before a step of `h` seconds; return the duration (s) of the shortest bounce or edge that begins, or infinity."""
        self.restart(h)
        rates_after_kick = self.forces.output_rates(self.model.state()[1])
        accelerations = (rates_after_kick - self.state.rates) / (0.5 * h)
        passage = self._contact_tracker.joins.passage_duration(PASSAGE_STEP_RATIO * h)
        # The rest of an edge that takes no longer than rounding is passed already.
        durations = [passage if passage > self._steps_per_bounce * self._min_fraction(h) * h else math.inf]
        for k, side in self._contact_tracker.rebound_sides.items():
            output = self._contact_tracker.contact_outputs[k]
            deceleration = side * float(accelerations[output])
            if deceleration > 0.0:
                durations.append(-2 * side * float(self.state.rates[output]) / deceleration)
        self._contact_tracker.rebound_sides = {}
        return min(durations)


MIN_PATH_STEPS = 4
"""Steps in an interval from which the limits are checked at each of them: the motion is fast against the monitor times."""

N_PATHS_TOGETHER = 16
"""Number of these intervals that are checked together, if there are no contacts: those after an exit would be in the log of events."""

EXIT_BISECTIONS = 30
"""Bisections of an exit within a step: to 1e-9 of the step, far less than its error."""

LIMIT_CHECK_INTERVAL = 256
"""Number of monitor times between two checks of the limits of the mechanism."""


class MonitoredState(NamedTuple):
    """State of a run at a monitor time."""

    poses: FloatArray  # of the pymunk bodies, m and rad; shape (bodies, 3)
    velocities: FloatArray  # shape (bodies, 3)
    work: float  # of the spindle, J
    spindle_angle: float  # rad
    dissipated_energy: float  # J


@np.errstate(all="ignore")  # diverging bodies give infinite values before the run is abandoned
def integrate_over_grid(problem: FixedStepProblem, level: int, iterations: int, n_times: int) -> FixedStepSolution:
    """Integrate over `n_times` of the grid, with the steps of each interval halved `level` times and `iterations` of the joint solver."""
    run = GridRun(problem, level, iterations)
    run.integrate(n_times)
    return run.solution()


class GridRun:
    """A run over the monitor times, with its states there."""

    # It is abandoned if its share of the budget is spent, soon after it leaves the limits of the mechanism,
    # and where a body is too far away.
    def __init__(self, problem: FixedStepProblem, level: int, iterations: int) -> None:
        self._problem, self._times = problem, problem.grid.monitor_times
        self._model = PymunkModel(problem.scene, iterations=iterations, plain=problem.settings.plain, count_step=problem.budget.count_step)
        self._step_counts = problem.grid.min_steps << level
        self._lengths = np.diff(self._times) / self._step_counts if self._step_counts.size else np.ones(1)
        self._contacts = problem.scene_contacts if has_contacts(problem.scene) else None
        first_h = float(self._lengths[0])
        self._model.start(*problem.start, problem.time_inputs.start_inputs(first_h))
        problem.time_inputs.reset(self._model.predict_spindle_inertia)
        make_stepper = EventDrivenStepper if self._contacts else StaggeredStepper
        self._stepper = make_stepper(problem, self._model, level, first_h)
        self._states = list[MonitoredState]()
        self._contact_modes = list[ContactMode]()
        self._held_models = list[HeldModel | None]()
        self._keep_state()
        self._paths = list[tuple[int, Path]]()
        self._is_complete, self._reached_limit = True, False
        self._first_exit: StepExit | None = None

    def _keep_state(self) -> None:
        """Keep the present state."""
        state, spindle = self._stepper.state, self._problem.time_inputs.spindle
        self._states.append(MonitoredState(state.poses, state.velocities, spindle.work, spindle.angle, state.dissipated_energy))
        self._contact_modes += [self._contacts.mode] if self._contacts else []
        self._held_models.append(self._problem.held_model)

    def integrate(self, n_times: int) -> None:
        """Integrate over `n_times` of the grid, or until the run is abandoned."""
        mechanism, settings = self._problem.evaluator.mechanism, self._problem.settings
        has_limits = bool(mechanism.limits) and not settings.plain
        max_distance = settings.max_distance_ratio * mechanism.length_scale
        next_lengths = np.append(self._lengths[1:], self._lengths[-1:])[: self._step_counts.size].tolist()
        for index, next_h in enumerate(next_lengths[: n_times - 1]):
            self._stepper.path = [] if has_limits and self._step_counts[index] >= MIN_PATH_STEPS else None
            if not self._integrate_interval(index, next_h):
                break
            self._keep_state()
            if np.max(np.abs(self._stepper.state.poses[:, :2])) > max_distance:
                break  # it flies away, or its joints are torn
            if self._stepper.path:
                self._paths.append((index, self._stepper.path))
            if len(self._paths) >= (1 if self._contacts else N_PATHS_TOGETHER):
                self._check_paths()
            if self._first_exit or (len(self._states) % LIMIT_CHECK_INTERVAL == 0 and self._is_outside()):
                break
        self._check_paths()

    def _integrate_interval(self, index: int, next_h: float) -> bool:
        """Integrate over an interval, followed by a step of `next_h` seconds; return whether the run goes on."""
        start, end = float(self._times[index]), float(self._times[index + 1])
        try:
            self._is_complete = self._stepper.integrate(start, end, int(self._step_counts[index]), next_h)
        except StepLimitError:
            self._reached_limit = True
            return False
        except (ValueError, OverflowError, np.linalg.LinAlgError):  # a body diverged to a position that is not finite
            return False
        return self._is_complete and bool(np.isfinite(self._stepper.state.poses).all())

    def _check_paths(self) -> None:
        """Look for an exit along the steps of the last intervals; what follows it is forgotten."""
        if self._first_exit is None:
            self._first_exit = _find_step_exit(self._problem, self._model, self._times, self._states, self._paths)
            self._paths.clear()
        if self._first_exit is not None:
            del self._states[self._first_exit.time_index + 1 :], self._held_models[self._first_exit.time_index + 1 :]
            self._is_complete, self._reached_limit = True, False

    def _is_outside(self) -> bool:
        """Return whether the last states leave the limits of the mechanism."""
        recent = (np.array(column) for column in list(zip(*self._states[-LIMIT_CHECK_INTERVAL:], strict=True))[:2])
        poses, velocities = self._model.to_mass_centres(*recent)
        evaluator = self._problem.evaluator
        return bool(evaluator.find_first_out_of_range(poses) or evaluator.find_first_stall(poses, velocities))

    def solution(self) -> FixedStepSolution:
        """Return the states of the run, with velocities that the joints allow and the shaft of a free spindle, and how it ended."""
        model, n_times = self._model, len(self._states)
        poses, velocities, work, spindle_angle, dissipated_energy = (np.array(column) for column in zip(*self._states, strict=True))
        raw_poses, velocities = model.to_mass_centres(poses, velocities)
        if not (self._contacts or self._step_counts.size):
            raw_poses[0], velocities[0] = self._problem.start
        times, lags = self._times[:n_times], np.zeros((n_times, 0))
        history = StateHistory(
            times=times, poses=raw_poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, lags=lags
        )
        n_steps = int(self._step_counts[: n_times - 1].sum()) + self._stepper.n_split_steps
        return FixedStepSolution(
            states=_with_compatible_velocities(self._problem, history, self._held_models, spindle_angle),
            raw_poses=raw_poses,
            events=tuple(self._contacts.events) if self._contacts else (),
            contact_modes=tuple(self._contact_modes),
            has_chatter=not self._is_complete,
            first_exit=self._first_exit,
            reached_limit=self._reached_limit,
            n_steps=n_steps,
            evaluation_counts={law: count * n_steps for law, count in model.forces.evaluation_counts.items()},
        )


def _find_step_exit(
    problem: FixedStepProblem, model: PymunkModel, times: FloatArray, states: list[MonitoredState], paths: list[tuple[int, Path]]
) -> StepExit | None:
    """Return the first exit from the limits along the steps of intervals, by their numbers, or None."""
    poses = np.array([poses for _, path in paths for _, poses in path])
    if not len(poses) or problem.evaluator.find_first_out_of_range(model.to_mass_centres(poses, poses)[0]) is None:
        return None
    exits = (_find_exit_on_path(problem, model, [(float(times[index]), states[index].poses), *path], index + 1) for index, path in paths)
    return next((one for one in exits if one is not None), None)


def _find_exit_on_path(problem: FixedStepProblem, model: PymunkModel, path: Path, index: int) -> StepExit | None:
    """Return the first exit from the limits along the steps of an interval that ends at monitor time `index`, or None."""
    times, poses = np.array([time for time, _ in path]), np.array([poses for _, poses in path])
    poses = model.to_mass_centres(poses, poses)[0]
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


def _with_compatible_velocities(
    problem: FixedStepProblem, history: StateHistory, models: Sequence[HeldModel | None], spindle_angle: FloatArray
) -> StateHistory:
    """Return the states of a run with velocities that joints and held outputs allow, and a free shaft at angles (times,) rad."""
    times = history.times
    poses = history.poses.copy()
    velocities = history.velocities.copy()
    evaluator = problem.evaluator
    if not problem.settings.plain:
        # The mean of two half steps opens the joints slightly, and more where the step length changes.
        # With contacts the gap depends on the step, which differs where a step was split.
        closes_joints = has_contacts(problem.scene)
        start = 0
        for _, group in groupby(models, key=lambda model: id(model and model[0])):
            part = slice(start, start + len(list(group)))
            motion = times[part], poses[part], velocities[part]
            poses[part], velocities[part] = problem.projector.project(*motion, closes_joints=closes_joints, model=models[start])
            start = part.stop
    poses, velocities = evaluator.with_shaft(times, poses, velocities, spindle_angle)
    return replace(history, poses=poses, velocities=velocities)

"""Single steps of a pymunk model, and restarts of the staggered scheme from synchronous poses and velocities."""

from dataclasses import replace

import numpy as np

from governor_mechanism.engines.impulse.applied_forces import StepInputs
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.records import FixedStepProblem, StepState
from governor_mechanism.numerics.interpolation import interpolate_samples
from governor_mechanism.types import FloatArray

Path = list[tuple[float, FloatArray]]
"""Times (s) and poses (bodies, 3) of the pymunk bodies along the steps of an interval."""

N_WARM_STARTS = 3
"""Number of repetitions of a start, so that the joint solver begins from its converged impulses."""

N_WARM_UP_STEPS = 4
"""Number of steps after a restart in which the joint solver still finds its impulses."""


class StaggeredStepper:
    """A started pymunk model at one time of a run.

    `state` is the present state, `last_h` (s) the length of the last step, `is_holding` whether a contact is held. The solver iterations
    are multiplied by a factor for restarts and while a contact is held: contact decisions use the holding force, which converges more
    slowly than the velocities. `n_split_steps` counts the steps that were split at events.
    """

    def __init__(self, problem: FixedStepProblem, model: PymunkModel, level: int, h: float) -> None:
        self.model, self.forces, self.time_inputs, self.last_h = model, model.forces, problem.time_inputs, h
        self.is_holding = False
        self._warm_up_steps_left = 0
        self.n_split_steps = 0
        self.path: Path | None = None
        """The steps of the present interval, where they are asked for."""
        self._problem, self._budget = problem, problem.budget
        self._restart_iteration_factor = problem.settings.restart_iteration_factor
        # A bias of the holding force shows in the difference of levels with other iterations.
        self._hold_iteration_factor = problem.settings.hold_iteration_factor << (level % 2)
        velocities = model.to_proxy_velocities(problem.start[1])
        values, rates = self.forces.output_values, self.forces.output_rates(velocities)
        self.state = StepState(0.0, model.state()[0], velocities, values, rates, problem.time_inputs.spindle, 0.0, rates, np.zeros(0))

    def integrate(self, start: float, end: float, n_steps: int, next_h: float) -> bool:
        """Integrate from start to end (s) in `n_steps` steps, followed by one of `next_h`; return whether that succeeds."""
        model = self.model
        time_inputs = self.time_inputs
        h = (end - start) / n_steps
        # The last kick spans half of this step and half of the next, which can differ in length.
        time_inputs.prepare_interval(start, end, n_steps, next_h)
        self._budget.count_interval()
        earlier = previous = self.state.velocities
        for index in range(n_steps):
            self._budget.check()
            earlier, previous = previous, model.step(time_inputs.step_inputs(index))
            if self.path is not None:
                self.path.append((start + (index + 1) * h, model.state()[0]))
        poses, velocities = model.state()
        # In a plain model the velocities belong to the poses; else they are half a step ahead of them.
        if time_inputs.has_jump and not model.is_plain:  # the mean of both sides is not the velocity: extrapolate from the left
            velocities = previous + 0.5 * (previous - earlier)
        elif not model.is_plain:
            velocities = (next_h * previous + h * velocities) / (h + next_h)
        self.state = replace(self.state, poses=poses, velocities=velocities, dissipated_energy=self.forces.dissipated_energy)
        return True

    @property
    def _iteration_factor(self) -> int:
        """Factor on the solver iterations at a restart, and while a contact is held."""
        return self._hold_iteration_factor if self.is_holding else self._restart_iteration_factor

    def close_joints(self) -> None:
        """Close the joints; the gap that a step leaves depends on its length."""
        self.state = self.with_closed_joints(self.state)

    def mass_centre_state(self) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (bodies, 3) of the mass centres at the present time."""
        return self.model.to_mass_centres(self.state.poses, self.state.velocities)

    def step(self, inputs: StepInputs, time: float) -> StepState:
        """Take one step; return the state at `time` (s), without moving to it."""
        model, forces = self.model, self.forces
        self._budget.check()
        model.set_iteration_factor(self._iteration_factor if self.is_holding or self._warm_up_steps_left else 1)
        self._warm_up_steps_left = max(self._warm_up_steps_left - 1, 0)
        velocities_before = model.step(inputs)
        poses, velocities_after = model.state()
        velocities = (inputs.next_h * velocities_before + inputs.h * velocities_after) / (inputs.h + inputs.next_h)
        motion = poses, velocities, forces.output_values, forces.output_rates(velocities)
        rates_after_kick = forces.output_rates(velocities_after)
        return StepState(time, *motion, self.time_inputs.spindle, forces.dissipated_energy, rates_after_kick, inputs.values)

    def take_trial_step(self, h: float, steps: int = 1) -> StepState:
        """Return the state `h` seconds ahead, without moving to it; joint forces are valid from the second step on."""
        # The first step starts with closed joints, but a step leaves a gap proportional to the
        # square of its length, so the first joint forces also contain the force that opens this
        # gap.
        self.restart(h / steps)
        time = self.state.time
        self.time_inputs.prepare_interval(time, time + h, steps, h / steps)
        for index in range(steps):
            state = self.step(self.time_inputs.step_inputs(index), time + (index + 1) * h / steps)
        return self.with_closed_joints(state)

    def restart(self, h: float) -> None:
        """Restart the scheme from the present state, before a step of `h` seconds."""
        self._budget.count_interval()
        state = self.state
        self.model.set_iteration_factor(self._iteration_factor)
        self._warm_up_steps_left = N_WARM_UP_STEPS
        inputs, self.last_h = self.time_inputs.restart_inputs(state.time, h), h
        for _ in range(N_WARM_STARTS):
            self.model.start(state.poses, state.velocities, inputs)
        self.time_inputs.spindle, self.forces.dissipated_energy = state.spindle, state.dissipated_energy

    def set_velocities(self, velocities: FloatArray, dissipated_energy: float = 0.0) -> None:
        """Set the velocities (bodies, 3) of the mass centres after impulses, which dissipate an energy (J)."""
        velocities = self.model.to_proxy_velocities(velocities)
        rates = self.forces.output_rates(velocities)
        total_energy = self.state.dissipated_energy + dissipated_energy
        self.state = replace(self.state, velocities=velocities, rates=rates, dissipated_energy=total_energy)

    def extrapolate_to(self, end: float, full_step: float) -> None:
        """Extrapolate to a time `end` (s) so close that a step would be dominated by rounding."""
        state, remaining = self.state, end - self.state.time
        if remaining <= 0.0:
            return
        self.restart(full_step)
        acceleration = (self.model.state()[1] - state.velocities) / (0.5 * full_step)
        self.time_inputs.prepare_interval(state.time, end, 1, full_step)
        self.time_inputs.step_inputs(0)
        inputs = self.time_inputs.restart_inputs(state.time, full_step).values
        self.state = replace(
            state,
            time=end,
            poses=state.poses + remaining * (state.velocities + 0.5 * remaining * acceleration),
            velocities=state.velocities + remaining * acceleration,
            values=state.values + remaining * state.rates,
            rates=state.rates + remaining * self.forces.output_rates(acceleration),
            spindle=self.time_inputs.spindle,
            dissipated_energy=state.dissipated_energy + remaining * self.forces.dissipated_power(state.rates, inputs),
        )

    def interpolate(self, start: StepState, end: StepState, since: float) -> StepState:
        """Return the state some time (s) after the first one of a step, with poses on the cubics between both and velocities on lines."""
        times, inside = np.array([start.time, end.time]), np.array([start.time + since])
        samples = np.array([start.poses, end.poses]), np.array([start.velocities, end.velocities])
        (poses,) = interpolate_samples(times, *samples, inside)
        velocities = start.velocities + since / (end.time - start.time) * (end.velocities - start.velocities)
        values = self.forces.evaluate_outputs(poses)
        rates = self.forces.output_rates(velocities)
        return replace(start, time=start.time + since, poses=poses, velocities=velocities, values=values, rates=rates)

    def with_closed_joints(self, state: StepState) -> StepState:
        """Return a state with closed joints and compatible velocities."""
        centre_poses, centre_velocities = self.model.to_mass_centres(state.poses, state.velocities)
        (poses,), (velocities,) = self._problem.projector.project(
            np.array([state.time]), centre_poses[np.newaxis], centre_velocities[np.newaxis], model=self._problem.held_model
        )
        proxy_velocities = self.model.to_proxy_velocities(velocities)
        proxy_poses = np.where(self.model.pinned_mask, state.poses, poses)
        values = self.forces.evaluate_outputs(proxy_poses)
        rates = self.forces.output_rates(proxy_velocities)
        return replace(state, poses=proxy_poses, velocities=proxy_velocities, values=values, rates=rates)

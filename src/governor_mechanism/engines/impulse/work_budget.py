"""Budget of work of a request: it bounds all its runs together, whatever their steps, iterations and events; it knows no clock."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.forces.contacts import output_forces_of
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray, IntArray

ITERATION_WORK = 1e-3
"""Work of one iteration of the solver at one joint, in units of a step of a few free bodies (20 µs when it was measured)."""

CONTACT_WORK, OUTPUT_FORCE_WORK, VARYING_INPUT_WORK = 3.0, 0.5, 1.0
"""Work that contacts, forces along readings and each varying input add to a step, in the same units."""

INTERVAL_WORK = 8.0
"""Work of beginning an interval of steps, as between two monitor times; each varying input adds as much."""


class StepLimitError(Exception):
    """A run has spent its share of the budget."""


class WorkBudget:
    """Work of all runs of a request, counted in steps with the first number of solver iterations; other work counts as its time in steps.

    `limit` is the largest work of all runs together, and `spent` the work so far.
    """

    def __init__(self, settings: ImpulseSettings, scene: Scene, n_varying_inputs: int) -> None:
        self._n_joints = len(scene.mechanism.joints)
        self._work_without_iterations = 1.0 + CONTACT_WORK * has_contacts(scene) + OUTPUT_FORCE_WORK * len(output_forces_of(scene))
        self._work_without_iterations += VARYING_INPUT_WORK * n_varying_inputs
        self._unit = self._step_work(settings.iterations)
        self._interval_steps = INTERVAL_WORK * (1 + n_varying_inputs) / self._unit
        self.limit = settings.max_steps or int(settings.max_step_work / self._unit)
        self.spent, self._run_end = 0.0, float(self.limit)

    def _step_work(self, iterations: int) -> float:
        return self._work_without_iterations + ITERATION_WORK * self._n_joints * iterations

    def steps_per_step(self, iterations: int) -> float:
        """Return as how many steps one with a number of iterations counts."""
        return self._step_work(iterations) / self._unit

    def expected_work(self, n_levels: int, n_steps: FloatArray | IntArray) -> FloatArray:
        """Return the work of a first result over each interval; its coarsest run takes `n_steps` (intervals,) steps there."""
        work: FloatArray = np.asarray((2.0**n_levels - 1.0) * n_steps + n_levels * self._interval_steps, dtype=np.float64)
        return work

    @property
    def remaining(self) -> float:
        """Return the work that is left for further runs."""
        return self.limit - self.spent

    def begin_run(self, later_shares: Sequence[float]) -> None:
        """Begin a run that may spend one share of what remains; later runs of the same result need the other shares."""
        self._run_end = self.spent + self.remaining / (1.0 + sum(later_shares))

    def count_step(self, iterations: int) -> None:
        """Count a step."""
        self.spent += self.steps_per_step(iterations)

    def count_interval(self) -> None:
        """Count the beginning of an interval of steps."""
        self.spent += self._interval_steps

    def check(self) -> None:
        """Raise StepLimitError if the run has spent its share."""
        if self.spent > self._run_end:
            raise StepLimitError

"""What all fixed-step runs of one scene share, and what each of them returns."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.integrators.time_grid import TimeGrid
from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.state_history import StateHistory
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class FixedStepProblem:
    """A scene with its inputs, the grid of its runs, and poses and velocities (bodies, 3) at the start."""

    scene: Scene
    settings: ImpulseSettings
    evaluator: ReadingEvaluator
    grid: TimeGrid
    time_inputs: TimeInputs
    start: tuple[FloatArray, FloatArray]


@dataclass(frozen=True, kw_only=True)
class FixedStepSolution:
    """States at the monitor times of one run, fewer than the grid has if the run was abandoned.

    `raw_poses` (times, bodies, 3) have the joint gaps that the steps leave, `spindle_angle` (times,) rad is that of a free spindle, and
    `contact_modes` has one entry per monitor time of a scene with contacts. `n_split_steps` counts the steps that were split at events.
    """

    states: StateHistory
    raw_poses: FloatArray
    spindle_angle: FloatArray
    events: tuple[Event, ...]
    contact_modes: tuple[ContactMode, ...]
    n_split_steps: int

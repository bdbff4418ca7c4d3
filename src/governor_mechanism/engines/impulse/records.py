"""Records of fixed-step runs: what all runs of a scene share, what each returns, and the states and events of its steps."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from governor_mechanism.engines.impulse.settings import ImpulseSettings, WorkBudget
from governor_mechanism.engines.impulse.time_inputs import SpindleState, TimeInputs
from governor_mechanism.integrators.time_grid import TimeGrid
from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.dynamics.arrays import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.constrained_solution import CLOSURE_TOLERANCE_RATIO, StateProjector
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, has_contacts
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

HeldModel = tuple[System, SystemWorkspace]
"""Model of a contact mode, in which held outputs are constraints, and its workspace."""


@dataclass(frozen=True)
class FixedStepProblem:
    """A scene with its inputs, the grid of its runs, poses and velocities (bodies, 3) at the start, and the budget of all runs."""

    scene: Scene
    settings: ImpulseSettings
    evaluator: ReadingEvaluator
    grid: TimeGrid
    time_inputs: TimeInputs
    start: tuple[FloatArray, FloatArray]
    budget: WorkBudget

    @cached_property
    def projector(self) -> StateProjector:
        """Return the projection of states onto the joints."""
        return StateProjector(self.scene)

    @cached_property
    def scene_contacts(self) -> SceneContacts:
        """Return the contacts of the scene, which every run begins again with `continue_from`."""
        tolerance = CLOSURE_TOLERANCE_RATIO * self.scene.part.mechanism.length_scale
        return SceneContacts(self.scene, self.evaluator.time_scale, tolerance)

    @property
    def held_model(self) -> HeldModel | None:
        """Return the model of the present contact mode, in which held outputs are constraints; None without contacts."""
        return self.scene_contacts.model if has_contacts(self.scene) else None


@dataclass(frozen=True)
class StepExit:
    """Exit from the limits between two monitor times: index of the later one, sentence, and time (s)."""

    time_index: int
    message: str
    time: float


@dataclass(frozen=True, kw_only=True)
class FixedStepSolution:
    """States at the monitor times of one run, fewer than the grid has if the run was abandoned.

    `raw_poses` (times, bodies, 3) have the joint gaps that the steps leave, and `contact_modes` has one entry per monitor time of a scene
    with contacts. `has_chatter` states whether the run was abandoned because of too many events in a step, `reached_limit` whether it ended
    because its share of the budget was spent, `first_exit` where its steps leave the limits between two monitor times, and
    `evaluation_counts` how often each force law was evaluated.
    """

    states: StateHistory
    raw_poses: FloatArray
    events: tuple[Event, ...]
    contact_modes: tuple[ContactMode, ...]
    has_chatter: bool
    reached_limit: bool
    first_exit: StepExit | None
    n_steps: int
    evaluation_counts: Mapping[str, int]


@dataclass(frozen=True)
class StepState:
    """State of a run at one time (s).

    Poses and velocities (bodies, 3) of the body proxies, values and rates (outputs,), state of the spindle and dissipated energy (J);
    the rates right after the kick of the step that led there, and the inputs (inputs,) of that step.
    """

    time: float
    poses: FloatArray
    velocities: FloatArray
    values: FloatArray
    rates: FloatArray
    spindle: SpindleState
    dissipated_energy: float
    rates_after_kick: FloatArray
    inputs: FloatArray


@dataclass(frozen=True)
class OutputCrossing:
    """Event function of the contact or one-sided spring `index`: `sign` times an output, less a threshold; the rate where it sticks."""

    kind: EventKind
    index: int
    output: int
    sign: float
    threshold: float

    def __call__(self, state: StepState) -> float:
        """Return the event function, positive after the event."""
        return self.sign * float((state.rates if self.kind is EventKind.STICK else state.values)[self.output]) - self.threshold

    def find_highest(self, start: StepState, end: StepState) -> float:
        """Return the time since the start at which the lines of a rising and then falling value meet, if above zero; else 0."""
        h = end.time - start.time
        value = self(start)
        end_value = self(end)
        rise = self.sign * float(start.rates[self.output])
        fall = -self.sign * float(end.rates[self.output])
        if not (value < 0.0 and end_value < 0.0 and rise > 0.0 and fall > 0.0):
            return 0.0
        time = (end_value + fall * h - value) / (rise + fall)
        return time if 0.0 < time < h and value + rise * time > 0.0 else 0.0


@dataclass(frozen=True)
class DetectedEvent:
    """An event within a step, of the contact or one-sided spring `index`; its event function is zero at the event.

    Its kind is None where a contact comes to another edge, which is no event of the run.

    `direction` is the sign of the motion after the event, and `latest` a fraction of the step at which it has passed.
    """

    kind: EventKind | None
    index: int
    event_function: Callable[[StepState], float]
    direction: int
    latest: float = 1.0

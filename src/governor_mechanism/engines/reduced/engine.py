"""Reduced engine: one coordinate along tables of the assembled mechanism, integrated by DOP853 in compiled code."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from governor_mechanism.effects.holding import Clearance
from governor_mechanism.effects.registry import EFFECT_TYPES, FORCE_LAWS
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import CertifiedRunner, ErrorControlledEngine, StepPlan
from governor_mechanism.engines.exit_location import Exit, find_first_exit
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.reduced.integration import ReducedSettings
from governor_mechanism.engines.reduced.passage import describe_passage_end
from governor_mechanism.engines.reduced.run import ReducedRun, ReducedSolution
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.time_grid import divide_intervals, make_time_grid
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, outline_gaps_of
from governor_mechanism.mechanics.dynamics.inputs import reading_functions_of
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.mechanics.kinematics.constraint_equations import constraint_equations_of
from governor_mechanism.mechanics.reduction.reduced_model import ShaftTrain, find_shaft_train, parts_with_coordinate, shaft_readings
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import CylinderGas, Torque, TorsionDamper
from governor_mechanism.model.joints import GROUND, JOINT_TYPES, Gear, Joint
from governor_mechanism.model.output_variables import ControlledValue
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult, StateHistory
from governor_mechanism.observables.sampled_motion import DenseOutput
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class ReducedEngine(ErrorControlledEngine):
    """Fastest engine, of order 8, for one degree of freedom; its error is twice the difference from a run of half steps."""

    name: ClassVar[str] = "reduced"  # name of the engine
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES - {Clearance}  # effects that it can simulate
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES  # joints that it can simulate

    settings: ReducedSettings = field(default_factory=ReducedSettings)  # numerical settings

    def _refuses(self, scene: Scene) -> str:
        """Return why the engine cannot run a scene: it integrates one coordinate of one part and one shaft."""
        parts, remedy = parts_with_coordinate(scene), "choose engine 'multibody'"
        if len(parts) != 1:
            return (
                "engine 'reduced' integrates one coordinate and one shaft, a part in a fixed plane whose bodies are pinned to the ground "
                f"at their mass centres; of {[part.name for part in scene.parts]}, {len(parts)} are more than a shaft; {remedy}"
            )
        prefix, part = parts[0]
        if constraint_equations_of(part.mechanism).is_driven.any():
            return f"engine 'reduced' integrates one free coordinate, but drives move this mechanism; {remedy}"
        if (mobility := mobility_of(part.mechanism)) != 1:
            reason = ", and contacts take none of them away, as parts that touch may leave" if outline_gaps_of(scene) else ""
            return f"engine 'reduced' integrates one degree of freedom; this mechanism has mobility {mobility}{reason}; {remedy}"
        for gap in outline_gaps_of(scene):
            if gap.others:
                cure = "give it at_once, as large as repeat, which makes a gap of each"
                return f"engine 'reduced' cannot model one gap of several rollers, as of contact {gap.contact!r}; {cure}, or {remedy}"
        own_readings = {prefix + reading.name for reading in (*part.mechanism.readings, *part.mechanism.internal_outputs)}
        for problem in _shaft_problems(scene, find_shaft_train(scene), own_readings):
            return f"engine 'reduced' cannot model {problem}; {remedy}"
        return ""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        return ReducedRunner(self, scene, request).run()


class ReducedRunner(CertifiedRunner):
    """Runs of one scene at different tolerances, each width of table pieces with its own motion table."""

    method = "explicit (DOP853) along one coordinate"

    def __init__(self, engine: ReducedEngine, scene: Scene, request: RunRequest) -> None:
        initial_motion, self.settings = initial_state(scene), engine.settings
        super().__init__(engine, request, ReadingEvaluator(scene, initial_motion[0]))
        self._initial_motion = initial_motion
        self._reduced_runs: dict[float, ReducedRun] = {}
        mechanism, part = scene.mechanism, parts_with_coordinate(scene)[0][1]
        self._has_control = any(isinstance(one, ControlledValue) for one in mechanism.derived_readings)
        has_other_limits = len(mechanism.limits) > len(part.mechanism.limits)
        self._may_exit = self._has_control or has_other_limits or bool(mechanism.stall_limits)

    def get_reduced_run(self, width_ratio: float) -> ReducedRun:
        """Return the run along the table with this factor on the width of its first pieces."""
        if width_ratio not in self._reduced_runs:
            first = next(iter(self._reduced_runs.values()), None)
            reduced_run = first.along_other_table(width_ratio) if first else self._make_run(width_ratio)
            if not reduced_run.motion_table.is_started:
                message = reduced_run.motion_table.end_message(1)[1]
                raise MechanismError(f"engine 'reduced' cannot start: {message}; choose engine 'multibody'")
            self._reduced_runs[width_ratio] = reduced_run
        return self._reduced_runs[width_ratio]

    def _make_run(self, width_ratio: float) -> ReducedRun:
        return ReducedRun(self.evaluator, self._initial_motion, self.max_steps, self.settings, width_ratio)

    def run_once(self, tolerance: float, plan: StepPlan) -> RunResult:
        """Return one run; every other one is along a table with narrower pieces."""
        self.n_runs += 1
        reduced_run = self.get_reduced_run(self.settings.comparison_width_ratio if plan.level % 2 else 1.0)
        times, is_reported = self._choose_times(reduced_run)
        solution = reduced_run.integrate(times, tolerance, plan)
        self.setup_time = sum(one.motion_table.setup_time for one in self._reduced_runs.values())
        history = reduced_run.state_history(solution)
        is_kept = is_reported[: len(history.times)]
        outcome, detail = describe_passage_end(
            reduced_run.motion_table, solution.status, solution.end_time, solution.side, self.max_steps, stops_short=solution.stops_short
        )
        motion_exit = self._find_exit(reduced_run, solution, history, tolerance)
        if motion_exit is not None:
            outcome, detail = motion_exit.outcome, motion_exit.detail
            is_kept = is_kept & (history.times < motion_exit.time)
        reported_states = history
        if not is_kept.all():
            reported = np.flatnonzero(is_kept)
            reported_states, solution = history.at(reported), solution.at(reported)
        modes = reduced_run.contact_modes(solution, reported_states.poses)
        return RunResult(
            reported_states=reported_states,
            monitor_states=partial(self._make_monitor_states, reduced_run, tolerance, plan.without_record(), reported_states.times[-1:]),
            observables=self.evaluator.evaluate(reported_states, modes),
            outcome=outcome,
            detail=detail,
            step=solution.last_step,
            contact_modes=modes,
            reported_indices=slice(None),
            contact_events=solution.events,
        )

    def _choose_times(self, reduced_run: ReducedRun) -> tuple[FloatArray, BoolArray]:
        """Return the times (n,) s at which a run gives its state, and which of them are reported: a control is looked at in between."""
        times = self.request.times
        if not self._has_control or not len(times):
            return times, np.ones(len(times), dtype=np.bool_)
        max_interval = self.settings.monitor_interval_ratio * self.evaluator.time_scale
        if times[-1] / max_interval > self.max_steps:
            return times, np.ones(len(times), dtype=np.bool_)
        grid = make_time_grid(times, reduced_run.breakpoints, np.inf, max_interval)
        return grid.monitor_times, np.isin(np.arange(len(grid.monitor_times)), grid.reported_indices)

    def _find_exit(self, reduced_run: ReducedRun, solution: ReducedSolution, history: StateHistory, tolerance: float) -> Exit | None:
        """Return where a control leaves its range or a shaft stalls, or None; limits of the part with the coordinate end the table."""
        if not self._may_exit:
            return None
        event_times = np.array([event.time for event in solution.events])
        state_at = partial(reduced_run.state_between, solution, tolerance)
        samples = history if solution.exit_step is None else reduced_run.sample_exit(solution, solution.exit_step)
        return find_first_exit(self.evaluator, samples, state_at, event_times, self.request.accuracy)

    def _make_monitor_states(
        self, reduced_run: ReducedRun, tolerance: float, plan: StepPlan, end: FloatArray, max_times: int
    ) -> tuple[StateHistory, tuple[ContactMode, ...], DenseOutput | None]:
        """Return states, at most `max_times`, so close that no event is missed, their modes, and the dense output between them."""
        settings = self.settings
        max_interval = self.settings.monitor_interval_ratio * self.evaluator.time_scale
        times = make_time_grid(np.minimum(end, max_times * max_interval), reduced_run.breakpoints, np.inf, max_interval).monitor_times
        while True:
            solution = reduced_run.integrate(times, tolerance, plan)
            displacements = np.abs(np.diff(solution.states[:, 0])) / reduced_run.motion_table.arrays.assembly.coordinate_scale
            n_intervals = np.ceil(displacements / settings.monitor_interval_ratio).clip(1)
            if np.max(displacements, initial=0.0) < settings.max_monitor_travel:
                break
            n_kept = int(np.searchsorted(np.cumsum(n_intervals), max_times, side="right"))
            if n_kept == 0 or n_intervals.sum() <= len(n_intervals):
                break
            times = divide_intervals(times[: n_kept + 1], n_intervals[:n_kept].astype(np.int64))
        states = reduced_run.state_history(solution)
        modes = reduced_run.contact_modes(solution, states.poses)
        return states, modes, partial(reduced_run.integrate_from_row, solution, tolerance)

    def count_steps(self) -> int:
        """Return the steps of all runs so far, rejected ones included."""
        counts = (one.counts for one in self._reduced_runs.values())
        return sum(int(one[StepCounter.ACCEPTED] + one[StepCounter.REJECTED]) for one in counts)

    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, the rejected steps, and the evaluations by force law."""
        reduced_runs = list(self._reduced_runs.values())
        steps, rejected, evaluations, moving_evaluations = map(sum, zip(*(one.counts.tolist() for one in reduced_runs), strict=True))
        n_pieces = sum(reduced_run.motion_table.n_pieces for reduced_run in reduced_runs)
        law_counts = Counter({"equations of motion": evaluations, "table pieces": n_pieces})
        model = reduced_runs[0].motion_table.model
        for law_index in [*model.output_forces["law"].tolist(), *model.shaft_forces["law"].tolist()]:
            law = FORCE_LAWS[law_index]
            law_counts[law.law_name] += moving_evaluations if law.dissipates else evaluations
        if n_frictions := int(np.sum(model.contacts["friction_input"] != NO_INDEX)):
            law_counts[FRICTION_LAW_NAME] = n_frictions * moving_evaluations
        return steps, rejected, dict(law_counts)


def _shaft_problems(scene: Scene, train: ShaftTrain, own_readings: set[str]) -> Iterator[str]:
    """Yield what the model of one coordinate and one shaft cannot describe."""
    rotors = {GROUND, *train.rotors}
    for name in train.rotors:
        if name not in train.motion:
            yield f"body {name!r}, which turns independently of {next(iter(train.motion))!r}"
    for joint in scene.mechanism.joints:
        if isinstance(joint, Gear) and len({joint.first.body, joint.second.body} & set(train.rotors)) == 1:
            yield f"gear {joint.name!r} between a shaft and a body that does more than rotate"
    for name in scene.system.breaking_gears:
        yield f"gear {name!r}, which breaks"
    for effect in scene.output_effects:
        if effect.reading not in own_readings:
            yield f"the effect {type(effect).__name__} on {effect.reading!r}, an angle of the shaft"
    for element in scene.mechanism.force_elements:
        if element.switch is not None:
            yield f"the cut-off of {element.name!r}, which moves"
        bodies = set(element.bodies)
        if bodies & set(train.rotors) and not (isinstance(element, Torque | TorsionDamper | CylinderGas) and bodies <= rotors):
            yield f"force element {element.name!r} on the shaft, which is neither a torque, nor a torsion damper, nor gas"
    readings = own_readings | shaft_readings(scene, train)
    for function in reading_functions_of(scene):
        if function.lag:
            yield f"a load that follows {function.reading!r} with a lag"
        if function.source not in readings:
            yield f"a load that depends on {function.reading!r}, which is no reading of {train.rotors} nor of the part with the coordinate"

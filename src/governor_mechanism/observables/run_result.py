"""Result of a run as an engine returns it, from which its trajectory is made, and what is computed from it on first access."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.integrators.time_grid import sort_distinct
from governor_mechanism.mechanics.dynamics.arrays import ground_pin_of_point_mass
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.mechanics.dynamics.force_laws import gravitational_energy
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.dynamics.output_forces import element_potential_energy
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_equations import make_constraint_table
from governor_mechanism.mechanics.kinematics.output_variables import (
    READING_UNITS,
    OutputDerivatives,
    evaluate_output,
    evaluate_output_value,
    rows_of_readings,
)
from governor_mechanism.model.events import Event, EventKind, NamedCrossing
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.results.records import Energy, Outcome, Reaction, Recurrence, SpeedFluctuation
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.observables.branch_choice import find_singular_configurations
from governor_mechanism.observables.crossings import find_crossings
from governor_mechanism.observables.error_scales import MotionScales
from governor_mechanism.observables.sampled_motion import (
    BodyState,
    BoundedDenseOutput,
    DenseOutput,
    SampledMotion,
    find_speed_fluctuation,
    find_times_near,
)
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray


def evaluate_mechanical_energy(
    scene: Scene,
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (n, bodies, 3)
    velocities: FloatArray,  # their time derivatives; same shape
) -> tuple[FloatArray, FloatArray]:
    """Return the kinetic energy, and the potential energy of gravity and springs; J, shape (n,) each."""
    weights, inertias = _energy_coefficients(scene)
    kinetic = (velocities**2).reshape(len(velocities), inertias.size) @ inertias.ravel()
    potential = poses[:, :, 1] @ weights + element_potential_energy(scene.mechanism, poses)
    for effect in output_forces_of(scene):
        value = evaluate_output_value(scene.mechanism, effect.reading, poses)
        potential += np.where(value < effect.slack_below, 0.0, effect.potential(effect.coefficients, value)[0])
    return kinetic, potential


@once_per_object
def _energy_coefficients(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Weight (bodies,) N of each body, and half the inertia (bodies, 3) of its motion in the plane; zero for shafts of spindles."""
    mechanism = scene.mechanism
    shafts = {mechanism.body_index(plane.shaft) for plane in scene.system.planes if plane.shaft and plane.has_reaction}
    counted = np.array([index not in shafts for index in range(len(mechanism.bodies))])
    masses = np.array([body.mass for body in mechanism.bodies])
    inertias = np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).reshape(-1, 3)
    weights = gravitational_energy(masses, np.array(scene.system.gravity), 1.0)
    return counted * weights, 0.5 * counted[:, np.newaxis] * inertias


LARGEST_INTERVAL_RATIO = 1.1
"""Longest interval between crossings, relative to the shortest, up to which they recur: beyond it a mean says little."""

LEAST_ADVANCE = 0.5
"""Least way of a reading from the first to the last crossing, relative to its range, with which it goes on and does not come back."""


def are_regular(crossing: NamedCrossing, times: FloatArray) -> bool:
    """Return whether a crossing recurs at times (n,) s that lie about equally far apart."""
    period = crossing.n_per_period
    if len(times) < period + 2:
        return False
    periods = times[period:] - times[:-period]
    return bool(np.max(periods) <= LARGEST_INTERVAL_RATIO * np.min(periods))


def describe_recurrence(
    scene: Scene,
    motion: SampledMotion,
    crossing: NamedCrossing,
    times: FloatArray,  # times of its crossings, s; shape (n,)
    errors: Mapping[str, float],  # certified errors of the readings, SI; empty without a certificate
) -> Recurrence:
    """Return the means from one crossing to the next over whole periods."""
    # Readings and energies are taken in the middle between two crossings: at a crossing itself a clock
    # may be driving its pendulum.
    period = crossing.n_per_period
    used = _whole_periods(times, period)
    middles = _whole_periods(0.5 * (times[:-1] + times[1:]), period)
    poses, velocities = _states_at(motion, middles[[0, -1]])
    between = motion.poses[(motion.times >= middles[0]) & (motion.times <= middles[-1])]
    advances, work = _find_advances(scene, poses, between), _work_of_loads(scene, poses)
    start_energy, end_energy = np.sum(evaluate_mechanical_energy(scene, poses, velocities), axis=0).tolist()
    n_intervals = len(middles) - 1
    return Recurrence(
        count=len(times),
        interval=float(used[-1] - used[0]) / (len(used) - 1),
        interval_error=_interval_error(scene, motion, crossing.reading, used, errors),
        advances={name: way / n_intervals for name, way in advances.items()},
        units={name: READING_UNITS[scene.mechanism.reading(name).quantity] for name in advances},
        supplied=None if work is None else work / n_intervals,
        lost=None if work is None else (work - (end_energy - start_energy)) / n_intervals,
    )


def _whole_periods(times: FloatArray, period: int) -> FloatArray:
    """Return the times without those at the start that make no whole period."""
    return times[(len(times) - 1) % period :]


def _states_at(motion: SampledMotion, times: FloatArray) -> BodyState:
    """Return poses and velocities (n, bodies, 3) at times (n,) s."""
    intervals = np.clip(np.searchsorted(motion.times, times, side="right") - 1, 0, len(motion.times) - 2)
    poses, velocities = motion.interpolate(intervals, times)
    for k in np.flatnonzero(~motion.is_smooth(intervals, intervals + 1)).tolist():
        if (state := motion.dense_output(int(intervals[k]), float(times[k]))) is not None:
            poses[k], velocities[k] = state
    return poses, velocities


def _interval_error(scene: Scene, motion: SampledMotion, reading: str, times: FloatArray, errors: Mapping[str, float]) -> float | None:
    """Return a bound of the error (s) of the mean interval, from those of the first and the last crossing; None of a speed, or unknown."""
    if reading not in errors or reading not in [one.name for one in scene.mechanism.readings]:
        return None
    poses, velocities = _states_at(motion, times[[0, -1]])
    rates = np.abs(evaluate_output(scene.mechanism, reading, poses).rate(velocities))
    return float(np.sum(errors[reading] / rates)) / (len(times) - 1) if np.all(rates > 0.0) else None


def _find_advances(scene: Scene, poses: FloatArray, between: FloatArray) -> dict[str, float]:
    """Return by name how far readings that do not come back go from the first to the last of two poses (2, bodies, 3)."""
    # Others (n, bodies, 3) lie between them. The angle of a line is none of them: it does not count
    # full turns.
    advances = dict[str, float]()
    for reading in scene.mechanism.readings:
        start, end = evaluate_output(scene.mechanism, reading.name, poses).value.tolist()
        inner = evaluate_output(scene.mechanism, reading.name, between).value
        if not isinstance(reading, LineAngle) and abs(end - start) > LEAST_ADVANCE * np.ptp([start, *inner, end]):
            advances[reading.name] = end - start
    return advances


def _work_of_loads(scene: Scene, poses: FloatArray) -> float | None:
    """Return the work (J) of forces and torques between two poses (2, bodies, 3); None where the poses do not give it."""
    # That is so with drivers, spindles, gas in cylinders, and loads that change.
    mechanism, work = scene.mechanism, 0.0
    if scene.system.planes or any(part.mechanism.count_drivers() for part in scene.parts):
        return None
    for element in mechanism.force_elements:
        if not isinstance(element, Force | Torque) or not all(load.is_constant for load in element.inputs):
            if element.inputs:
                return None
            continue
        for load, displacement in zip(element.loads, element.displacements, strict=True):
            start, end = OutputDerivatives(rows_of_readings(mechanism, [displacement], {}), poses).value.tolist()
            work += load.values[0] * (end - start)
    return work


NEAR_DEPENDENT_PIVOT_RATIO = 1e-9
"""Pivot ratio (a squared angle) below which the constraint rows are examined for indeterminate forces."""

MIN_PARTICIPATION_RATIO = 1e-6
"""A row takes part in a linear dependence if its component in the left null vector exceeds this."""


@dataclass(frozen=True, kw_only=True)
class StateHistory:
    """States of a motion at n times."""

    times: FloatArray  # times, s; shape (n,)
    poses: FloatArray  # position (m) of the mass centre and angle (rad) of every body; shape (n, bodies, 3)
    velocities: FloatArray  # their rates, m/s and rad/s; shape (n, bodies, 3)
    # work put in by changes of a given spindle speed, less the work of drivers, force elements and spindle
    # torque, J; shape (n,). It includes `dissipated_energy`.
    work: FloatArray
    dissipated_energy: FloatArray  # energy dissipated by dashpots, dry friction and stops, J; shape (n,)
    lags: FloatArray  # states of first-order lags; shape (n, lags)

    def at(self, indices: slice | IntArray) -> StateHistory:
        """Return the states at some of the times."""
        return StateHistory(**{name: states[indices] for name, states in vars(self).items()})


MonitoredMotion = tuple[StateHistory, tuple[ContactMode, ...], DenseOutput | None]
"""States and contact modes at the monitor times, and a dense output between them where there is one."""

# Its argument is the largest number of these times; where more are needed, they end before the motion.
StateProvider = Callable[[int], MonitoredMotion]
"""Function that computes a monitored motion."""

MAX_EVENT_SAMPLES = 100_000
"""Largest number of samples of a motion in which events are searched that an engine computes for it: each takes some 30 microseconds."""

MAX_SAMPLES = 20_000_000
"""Largest number of samples of a motion for everything else: it bounds the memory."""

SEARCH_ERRORS = (ArithmeticError, ValueError, np.linalg.LinAlgError)
"""Errors of a search that say nothing about the run."""


@dataclass(frozen=True)
class FoundEvents:
    """Events in the order of time, and sentences on those that may be missing."""

    events: tuple[Event, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Observables:
    """Observables at n times."""

    readings: dict[str, FloatArray]  # readings by name, SI; shape (n,) each
    rates: dict[str, FloatArray]  # rates of the readings by name, SI per second; shape (n,) each
    units: dict[str, str]  # units of the readings by name
    motion_scales: MotionScales  # what the scales of errors in this motion follow from
    evaluate_joint_gap: Callable[[], FloatArray]  # function that evaluates `joint_gap`
    evaluate_energy: Callable[[float], Energy]  # function that evaluates `energy`, with the scale (J) of its errors

    @cached_property
    def motion_rate(self) -> float:
        """Rate of the motion, 1/s, that scales per second are multiplied by."""
        return self.motion_scales.motion_rate(self.rates)

    @cached_property
    def scales(self) -> dict[str, float]:
        """Scales of the errors of readings and rates in this motion, as in `Trajectory.scales`."""
        return self.motion_scales.error_scales(self.readings, self.rates, self.motion_rate)

    @cached_property
    def joint_gap(self) -> FloatArray:
        """Largest constraint violation, m; shape (n,)."""
        return self.evaluate_joint_gap()

    @cached_property
    def energy(self) -> Energy:
        """Energy balance."""
        return self.evaluate_energy(self.motion_scales.energy_scale(self.motion_rate))


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """Result of an engine's run, from which the trajectory is made."""

    reported_states: StateHistory  # states at the reported times
    monitor_states: StateHistory | StateProvider  # states at all monitor times, or a function that computes them
    observables: Observables  # observables at the reported times
    # how the run ended; None while a run that reached its end is not yet compared with the requested
    # accuracy
    outcome: Outcome | None
    detail: str  # details of the outcome, as text
    step: float = 0.0  # longest step, s, or the last one
    error_estimate: float | None = None  # largest error relative to the scales; None without a certificate
    reading_errors: dict[str, float] = field(default_factory=dict)  # error of each reading, rate, and the joints, SI
    dense_output: DenseOutput | None = None  # motion between the monitor times, where the engine can give it
    contact_modes: tuple[ContactMode, ...] = ()  # contact mode at each monitor time; empty without contacts
    reported_indices: slice | IntArray | None = None  # monitor times that are reported
    contact_events: tuple[Event, ...] = ()  # contact events that the engine located
    # number of reported times excluded from the error estimate because they are too close to an event
    n_excluded: int = 0

    @property
    def n_reached(self) -> int:
        """Number of reported times that the run reached."""
        return len(self.reported_states.times)

    @property
    def reported_modes(self) -> tuple[ContactMode, ...]:
        """Contact mode at each reported time; empty without contacts."""
        return modes_at(self.contact_modes, slice(None) if self.reported_indices is None else self.reported_indices)


def modes_at(modes: tuple[ContactMode, ...], indices: slice | IntArray) -> tuple[ContactMode, ...]:
    """Return the contact modes at some of the times of a motion; none of a motion without contacts."""
    return tuple(np.array(modes, dtype=object)[indices]) if modes else ()


@dataclass(frozen=True)
class DeferredMotionAnalysis:
    """Result of a run from which joint reactions and events are computed on request."""

    scene: Scene
    result: RunResult
    mobility: int

    def reactions(self) -> dict[str, Reaction]:
        """Return the reaction of every joint, by name, at the reported times."""
        return compute_reactions(self.scene, self.result.reported_states, self.result.reported_modes)

    def events(self) -> tuple[Event, ...]:
        """Return all events in the order of time."""
        return self._found_events.events

    def event_notes(self) -> tuple[str, ...]:
        """Return sentences on events that may be missing or less accurate."""
        return self._found_events.notes

    @cached_property
    def _found_events(self) -> FoundEvents:
        """All events. A search that fails costs neither the run nor the other events."""
        events, has_contacts = list(self.result.contact_events), bool(self.result.contact_modes)
        notes = list[str]()
        if self.result.n_reached and (self.scene.crossings or not has_contacts):
            dense_output, motion = self._searched_motion
            notes += self._note_end_of_search(motion)
            searches: dict[str, Callable[[], Sequence[Event]]] = {
                f"crossing {one.name!r}": partial(self._find_crossing, one, motion) for one in self.scene.crossings
            }
            if not has_contacts:
                searches["turning points and change points"] = partial(
                    find_singular_configurations, self.scene.mechanism, motion, self.mobility
                )
            for subject, search in searches.items():
                try:
                    events += search()
                except SEARCH_ERRORS as error:
                    notes.append(f"the search for {subject} failed, and none of them is listed: {error}")
            notes += dense_output.notes()
        return FoundEvents(tuple(sorted(events, key=lambda event: event.time)), tuple(notes))

    @cached_property
    def _searched_motion(self) -> tuple[BoundedDenseOutput, SampledMotion]:
        """The motion in which events are searched for, and its dense output."""
        return self._sample(*self._monitored_motion)

    def _note_end_of_search(self, motion: SampledMotion) -> list[str]:
        """Return a sentence if the samples end before the motion."""
        searched, end = float(motion.times[-1]), float(self.result.reported_states.times[-1])
        if searched >= end:
            return []
        return [
            f"events after t = {searched:.6g} s are not searched for: {MAX_EVENT_SAMPLES} samples of the motion reach no further; "
            "shorten the run"
        ]

    def speed_fluctuations(self) -> dict[str, SpeedFluctuation]:
        """Return the extreme speeds in the last turn of the shafts that must not turn back, by the reading of their angle."""
        limits = self.scene.mechanism.stall_limits
        if not limits or not self.result.n_reached or self.result.reported_states.lags.size:
            return {}
        motion = self.sample_motion()
        found = {limit.reading: find_speed_fluctuation(self.scene, limit.reading, motion) for limit in limits}
        return {reading: extremes for reading, extremes in found.items() if extremes is not None}

    def recurrences(self) -> dict[str, Recurrence]:
        """Return how named crossings recur, by their names."""
        found = dict[str, Recurrence]()
        for crossing in self.scene.crossings:
            events = [one for one in self.events() if one.kind is EventKind.CROSSING and one.subject == crossing.name]
            if are_regular(crossing, times := np.array([event.time for event in events])):
                motion, errors = self._searched_motion[1], self.result.reading_errors
                found[crossing.name] = describe_recurrence(self.scene, motion, crossing, times, errors)
        return found

    def lags_at(self, k: int) -> tuple[float, ...]:
        """Return the states of the lags at reported time k."""
        return tuple(self.result.reported_states.lags[k].tolist())

    def states_near_events(self, times: FloatArray) -> dict[int, BodyState]:
        """Return the states at those of times (n,) s that lie between the same two reported times as a contact event, by their indices."""
        reported, found = self.result.reported_states.times, dict[int, BodyState]()
        event_times = np.array([event.time for event in self.result.contact_events])
        for k in find_times_near(event_times, reported, times).tolist():
            monitored, _, dense_output = self._monitored_motion
            last = int(np.searchsorted(monitored.times, times[k], side="right")) - 1
            state = dense_output(last, float(times[k])) if dense_output and last + 1 < len(monitored.times) else None
            if state is not None:
                found[k] = state
        return found

    @cached_property
    def _monitored_motion(self) -> MonitoredMotion:
        """States, contact modes and dense output in which events are searched for, and between which frames beside events lie."""
        return self._monitor(MAX_EVENT_SAMPLES)

    def sample_motion(self) -> SampledMotion:
        """Return the motion at the monitor times."""
        return self._sample(*self._monitor(MAX_SAMPLES))[1]

    def _monitor(self, max_samples: int) -> MonitoredMotion:
        """Return states, contact modes and dense output at the monitor times, at most a number of them if they are computed for it."""
        states = self.result.monitor_states
        return (states, self.result.contact_modes, self.result.dense_output) if isinstance(states, StateHistory) else states(max_samples)

    def _sample(
        self, states: StateHistory, modes: tuple[ContactMode, ...], dense_output: DenseOutput | None
    ) -> tuple[BoundedDenseOutput, SampledMotion]:
        """Return a monitored motion with its accelerations, and its dense output, of which a search takes a bounded number of states."""
        bounded_output = BoundedDenseOutput(dense_output)
        dynamics = compute_inverse_dynamics(self.scene, states.times, states.poses, states.velocities, states.lags, modes)
        contact_times = sort_distinct(np.array([event.time for event in self.result.contact_events]))
        motion = states.times, states.poses, states.velocities, dynamics.accelerations
        break_times = list(self.scene.system.breaking_gears.values())
        breakpoints = sort_distinct(np.concatenate([break_times, *(one.breakpoints for one in make_system(self.scene)[1])]))
        return bounded_output, SampledMotion(*motion, dynamics.pivot_ratios, bounded_output, contact_times, breakpoints)

    def _find_crossing(self, crossing: NamedCrossing, motion: SampledMotion) -> list[Event]:
        """Return the events of a named crossing; without an error estimate, the error is taken to be that which the scene asks for."""
        scene, result = self.scene, self.result
        scales = {one.name: scene.mechanism.output_scale(one.name) for one in scene.mechanism.internal_outputs} | result.observables.scales
        allowed = {crossing.reading: scene.run.accuracy * scales[crossing.reading]}
        start_values = {name: float(values[0]) for name, values in result.observables.readings.items()}
        start = float(result.reported_states.times[0]), start_values
        return find_crossings(scene.system, motion, [crossing], allowed | result.reading_errors, start)


def compute_reactions(scene: Scene, states: StateHistory, modes: Sequence[ContactMode]) -> dict[str, Reaction]:
    """Return the reaction of every joint, by name, at the states of a motion and in their contact modes."""
    mechanism = scene.mechanism
    motion_dynamics = compute_inverse_dynamics(scene, states.times, states.poses, states.velocities, states.lags, modes)
    owner = make_constraint_table(mechanism).joint_indices
    undetermined = _find_undetermined(mechanism, states.poses, motion_dynamics.pivot_ratios)
    result = {}
    for index, joint in enumerate(mechanism.joints):
        own_rows = owner == index
        forces = motion_dynamics.joint_forces[:, own_rows].sum(axis=1)
        forces[:, :2] += _point_mass_pin_force(mechanism, joint, motion_dynamics)
        result[joint.name] = Reaction(force=forces[:, :2], moment=forces[:, 2], determined=~undetermined[:, index] & bool(own_rows.any()))
    return result


def _point_mass_pin_force(mechanism: Mechanism, joint: Joint, motion_dynamics: InverseDynamics) -> FloatArray:
    """Return the pin force (n, 2), N, on the second body that accelerates a body treated as a point mass about a ground pin."""
    # The equations of motion about the pin do not contain it.
    total = np.zeros((len(motion_dynamics.accelerations), 2))
    for point, sign in ((joint.second, 1.0), (joint.first, -1.0)):
        index = mechanism.body_index(point.body)
        if index != GROUND_INDEX and ground_pin_of_point_mass(mechanism, mechanism.bodies[index]) is joint:
            total += sign * mechanism.bodies[index].mass * motion_dynamics.accelerations[:, index, :2]
    return total


def _find_undetermined(mechanism: Mechanism, poses: FloatArray, pivot_ratios: FloatArray) -> NDArray[np.bool_]:
    """Return for each pose and joint (n, joints) whether its forces are statically indeterminate."""
    undetermined = np.zeros((len(poses), len(mechanism.joints)), dtype=np.bool_)
    position_solver = PositionSolver(mechanism)
    for i in np.flatnonzero(pivot_ratios < NEAR_DEPENDENT_PIVOT_RATIO):
        left_singular_vectors, singular_values, _ = np.linalg.svd(position_solver.scaled_joint_jacobian(poses[i]), full_matrices=True)
        rank = int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0])) if singular_values.size else 0
        participating = np.any(np.abs(left_singular_vectors[:, rank:]) > MIN_PARTICIPATION_RATIO, axis=1)
        undetermined[i, np.unique(position_solver.equations.joint_indices[participating])] = True
    return undetermined

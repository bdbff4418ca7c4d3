"""Readings, rates, energies (without what outputs dissipate), work, joint gaps and the trajectory from states, for every engine."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, forced_output_names
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, outline_gaps_of, output_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.mechanics.dynamics.force_laws import spindle_inertia, spindle_inertia_rate
from governor_mechanism.mechanics.dynamics.output_forces import CONSERVATIVE_TYPES
from governor_mechanism.mechanics.kinematics.assembly import assembly_notes, mobility_of, position_solver_of
from governor_mechanism.mechanics.kinematics.constraint_equations import constraint_equations_of
from governor_mechanism.mechanics.kinematics.output_variables import (
    READING_UNITS,
    evaluate_output,
    evaluate_output_value,
    evaluate_readings,
    unwrap_output,
)
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE, TurningPlane
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import ContactForce, CylinderPressure, DerivedReading, JointForce, JointMoment, StallLimit
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.records import Cost, Energy, Outcome, Reaction
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.interpolation import cubic_hermite, cubic_hermite_derivative, quintic_hermite
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.observables.derived_readings import evaluate_derived_readings
from governor_mechanism.observables.error_scales import JOINT_GAP, MotionScales, name_of_rate
from governor_mechanism.observables.motion_readings import evaluate_run_readings
from governor_mechanism.observables.run_result import (
    DeferredMotionAnalysis,
    Observables,
    RunResult,
    StateHistory,
    compute_reactions,
    evaluate_mechanical_energy,
)
from governor_mechanism.types import FloatArray


def evaluate_joint_forces(scene: Scene, history: StateHistory, modes: Sequence[ContactMode]) -> dict[str, FloatArray]:
    """Return reported forces and moments (n,), SI, of joints by name; MechanismError if rigid bodies leave one open at all times."""
    outputs = [one for one in scene.mechanism.derived_readings if isinstance(one, JointForce | JointMoment)]
    if not outputs:
        return {}
    reactions = compute_reactions(scene, history, modes)
    joints = dict.fromkeys(output.joint for output in outputs)
    undetermined = [name for name in joints if len(history.times) and not reactions[name].determined.any()]
    if undetermined:
        raise MechanismError(*map(_undetermined_message, undetermined))
    return {output.name: _value(reactions[output.joint], output) for output in outputs}


def _undetermined_message(joint: str) -> str:
    return (
        f"run.readings names 'reaction.{joint}', a joint whose force rigid-body mechanics does not determine: joints hold the bodies "
        "more often than their motion needs; leave the joint out, or remove a joint that is redundant"
    )


def _value(reaction: Reaction, output: DerivedReading) -> FloatArray:
    """Return the component (n,) of a reaction that a reading is."""
    components = {"x": reaction.force[:, 0], "y": reaction.force[:, 1], "magnitude": reaction.magnitude}
    return components[output.component] if isinstance(output, JointForce) else reaction.moment


def evaluate_contact_forces(scene: Scene, history: StateHistory, modes: Sequence[ContactMode]) -> dict[str, FloatArray]:
    """Return the forces of contacts that the run reports, by name, N; shape (n,) each."""
    outputs = [one for one in scene.mechanism.derived_readings if isinstance(one, ContactForce)]
    if not outputs:
        return {}
    states = history.times, history.poses, history.velocities, history.lags
    forces = compute_inverse_dynamics(scene, *states, modes).contact_forces
    names = [one.output_name for one in contacts_of(scene)]
    values = dict[str, FloatArray]()
    for output in outputs:
        gaps = [gap for gap in outline_gaps_of(scene) if gap.contact == output.contact and (gap.friction > 0.0 or not output.is_friction)]
        columns = [names.index(gap.slip.name if output.is_friction else gap.name) for gap in gaps]
        values[output.name] = forces[:, columns].sum(axis=1)
    return values


class PlaneRotation:
    """Rotation of a plane with its spindle."""

    def __init__(
        self,
        mechanism: Mechanism,  # mechanism with the bodies of the plane
        plane: TurningPlane,
    ) -> None:
        self.plane, self._mechanism = plane, mechanism
        # index of the body that the plane turns with; -1 if its speed is given
        self.shaft_index = mechanism.body_index(plane.shaft) if plane.shaft else -1
        # given speed as a function of time; None where it is not given
        self.speed_function = SpindleSpeedFunction(plane.given_speed, plane.ratio) if plane.given_speed else None

    def speed(self, times: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the speed (n,) rad/s at times (n,) s, with velocities (n, bodies, 3)."""
        return self.of_shaft(velocities) if self.speed_function is None else self.speed_function(times)

    def of_shaft(self, motion: FloatArray) -> FloatArray:
        """Return the angle or speed (n,) of the plane from poses or velocities (n, bodies, 3)."""
        column: FloatArray = self.plane.ratio * motion[:, self.shaft_index, 2]
        return column

    def inertia(self, poses: FloatArray) -> FloatArray:
        """Return the moment of inertia (n,) kg m2 of the bodies about the spindle at poses (n, bodies, 3)."""
        total: FloatArray = poses[:, self._bodies, 0] ** 2 @ self._masses + self._constant_inertia
        if self._oriented_bodies:
            xx, yy, xy, zz = self._second_moments
            total += spindle_inertia(0.0, xx, yy, xy, zz, 0.0, poses[:, self._oriented_bodies, 2]).sum(axis=1)
        return total

    def driving_torque(self, times: FloatArray, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the torque (n,) N m that drives the plane at its given speed: the rate of the angular momentum, d(J omega)/dt."""
        inertia_rate = 2 * (poses[:, self._bodies, 0] * velocities[:, self._bodies, 0]) @ self._masses
        if self._oriented_bodies:
            xx, yy, xy, _ = self._second_moments
            angles = poses[:, self._oriented_bodies, 2]
            rates = velocities[:, self._oriented_bodies, 2]
            inertia_rate += spindle_inertia_rate(0.0, xx, yy, xy, 0.0, angles, 0.0, rates).sum(axis=1)
        torque: FloatArray = inertia_rate * self.speed(times, velocities)
        if self.speed_function is not None and not self.speed_function.is_constant:
            torque += self.inertia(poses) * self.speed_function.derivative(times)
        return torque

    @cached_property
    def _bodies(self) -> slice | list[int]:
        """Bodies of the plane; a slice, which selects without a copy, where one follows the other."""
        bodies = list(self.plane.bodies)
        is_row = bodies == list(range(bodies[0], bodies[0] + len(bodies))) if bodies else False
        return slice(bodies[0], bodies[-1] + 1) if is_row else bodies

    @cached_property
    def _masses(self) -> FloatArray:
        return np.array([self._mechanism.bodies[k].mass for k in self.plane.bodies])

    @cached_property
    def _oriented_bodies(self) -> list[int]:
        """Bodies whose moment of inertia about the spindle depends on their angle."""
        bodies = self._mechanism.bodies
        moments = {k: bodies[k].second_moments for k in self.plane.bodies}
        return [k for k, one in moments.items() if one.xx != one.yy or one.xy != 0.0]

    @cached_property
    def _second_moments(self) -> FloatArray:
        """Second moments xx, yy, xy and zz of the bodies whose angle counts, kg m2; shape (4, bodies)."""
        moments = [self._mechanism.bodies[k].second_moments for k in self._oriented_bodies]
        return np.array([[one.xx, one.yy, one.xy, one.zz] for one in moments]).reshape(-1, 4).T

    @cached_property
    def _constant_inertia(self) -> float:
        """Moment of inertia of the other bodies about axes through their mass centres, kg m2."""
        others = set(self.plane.bodies) - set(self._oriented_bodies)
        moments = [self._mechanism.bodies[k].second_moments for k in sorted(others)]
        return sum(one.xx + one.zz for one in moments)


@once_per_object
def plane_rotations(scene: Scene) -> tuple[PlaneRotation, ...]:
    """Return the rotations of the planes of a scene that turn with a spindle, in the order of the planes."""
    return tuple(PlaneRotation(scene.mechanism, plane) for plane in scene.system.planes)


N_GAUSS_POINTS = 4
"""Gauss points in each interval: order 8."""


def integrate_work(
    scene: Scene,
    history: StateHistory,  # states at times that include every breakpoint of an input function; shape (n,)
    # contact mode at each time, or empty if the scene has no contacts
    contact_modes: Sequence[ContactMode] = (),
) -> FloatArray:
    """Return the work (n,) J of drivers and force elements since the first time."""
    # Between the times of the history the path is a quintic Hermite interpolant. With contacts it is a
    # cubic one, because accelerations jump; that is inaccurate in the intervals of impacts.

    def evaluate_motion(times: FloatArray, poses: FloatArray, velocities: FloatArray) -> InverseDynamics:
        return compute_inverse_dynamics(scene, times, poses, velocities, history.lags[: len(times)], contact_modes[: len(times)])

    times = history.times
    poses = history.poses
    velocities = history.velocities
    durations = np.diff(times)
    h = durations[:, np.newaxis, np.newaxis]
    increments = np.zeros_like(durations)
    ends = (poses[:-1], poses[1:], velocities[:-1], velocities[1:])
    if not contact_modes:
        start_accelerations = evaluate_motion(times, poses, velocities).accelerations[:-1]
        # A jump at a monitor time belongs to the interval that starts there.
        end_accelerations = evaluate_motion(np.nextafter(times, -np.inf), poses, velocities).accelerations[1:]
    for node, weight in zip(*np.polynomial.legendre.leggauss(N_GAUSS_POINTS), strict=True):
        fraction = 0.5 * (1.0 + node)
        if contact_modes:
            segment_poses = cubic_hermite(*ends, h, fraction)
            segment_velocities = cubic_hermite_derivative(*ends, h, fraction)
        else:
            segment_poses, segment_velocities = quintic_hermite(
                poses[:-1], velocities[:-1], start_accelerations, poses[1:], velocities[1:], end_accelerations, h, fraction
            )
        segment_times = times[:-1] + fraction * durations
        power = evaluate_motion(segment_times, segment_poses, segment_velocities).power + _compute_dissipated_power(
            scene, segment_times, segment_poses, segment_velocities, contact_modes
        )
        increments += 0.5 * weight * durations * power
    return np.concatenate([[0.0], np.cumsum(increments)])


def _compute_dissipated_power(
    scene: Scene, times: FloatArray, poses: FloatArray, velocities: FloatArray, contact_modes: Sequence[ContactMode]
) -> FloatArray:
    """Return the power (n,) W dissipated by dashpots and sliding friction."""
    dissipated_power = np.zeros(len(times))

    for effect in (effect for effect in output_forces_of(scene) if effect.dissipates):
        output = evaluate_output(scene.mechanism, effect.reading, poses)
        rate = output.rate(velocities)
        dissipated_power -= effect.evaluate(output.value, rate) * rate
    for k, contact in enumerate(contacts_of(scene) if contact_modes else ()):
        if contact.friction is not None:
            sliding_signs = np.array([mode.sliding_signs[k] for mode in contact_modes[: len(times)]])
            rate = evaluate_output(scene.mechanism, contact.output_name, poses).rate(velocities)
            dissipated_power += CubicTimeFunction(contact.friction)(times) * sliding_signs * rate
    return dissipated_power


ERROR_ESTIMATE_FLOOR = 1e-13
"""Smallest error estimate, relative to the scales: two runs may agree to the last digit and share the same rounding error."""


@once_per_object
def _known_start_mobility(_: Scene) -> list[int]:
    """Return the degrees of freedom at the start of a scene, if they were counted."""
    return []


class ReadingEvaluator:
    """Evaluator of the states of one scene, with the scales of its errors."""

    def __init__(
        self,
        scene: Scene,
        initial_poses: FloatArray,  # poses of the mass centres at the start; shape (bodies, 3)
    ) -> None:
        self.scene = scene
        self._initial_poses = initial_poses
        self.mechanism: Mechanism = scene.mechanism  # mechanism of all its parts
        self.rotations = plane_rotations(scene)  # rotation of each plane that turns with a spindle
        self._constraint_equations = constraint_equations_of(self.mechanism)
        self.time_scale, self._motion_scales = time_scale(scene), MotionScales(scene)  # time scale of the scene, s
        # largest energy scale of any motion of the scene, J
        self.energy_scale = self._motion_scales.mass * self.mechanism.length_scale**2 / self.time_scale**2

    def _evaluate_spindles(self, history: StateHistory) -> Iterator[tuple[str, str, FloatArray]]:
        """Yield name, unit and values (n,) of each output of a spindle."""
        for rotation in self.rotations:
            plane = rotation.plane
            yield f"{plane.prefix}{SPINDLE_SPEED}", "rad/s", rotation.speed(history.times, history.velocities)
            if plane.given_speed and plane.is_loaded:
                torque = rotation.driving_torque(history.times, history.poses, history.velocities)
                yield f"{plane.prefix}{SPINDLE_TORQUE}", "N m", torque
            elif not plane.given_speed and not plane.has_reaction:
                yield f"{plane.prefix}{SPINDLE_ANGLE}", "rad", rotation.of_shaft(history.poses)

    def evaluate(self, history: StateHistory, modes: Sequence[ContactMode] = ()) -> Observables:
        """Return all observables at the states of a history, in their contact modes if there are contacts."""
        mechanism = self.mechanism
        values, rates_of_values = evaluate_readings(mechanism, history.poses, history.velocities)
        names = [reading.name for reading in mechanism.readings]
        readings = {one.name: unwrap_output(one, value) for one, value in zip(mechanism.readings, values, strict=True)}
        units = {reading.name: READING_UNITS[reading.quantity] for reading in mechanism.readings}
        if mechanism.derived_readings:
            readings |= evaluate_derived_readings(self.scene, history) | evaluate_joint_forces(self.scene, history, modes)
            readings |= evaluate_contact_forces(self.scene, history, modes)
            readings |= evaluate_run_readings(self.scene, history, modes)
            units |= {output.name: output.unit for output in mechanism.derived_readings}
        for name, unit, spindle_values in self._evaluate_spindles(history):
            readings[name], units[name] = spindle_values, unit
        return Observables(
            readings=readings,
            rates=dict(zip(names, rates_of_values, strict=True)),
            units=units,
            motion_scales=self._motion_scales,
            evaluate_joint_gap=partial(self.evaluate_joint_gap, history.poses, history.times),
            evaluate_energy=partial(self._evaluate_energy, history),
        )

    def make_trajectory(self, result: RunResult, *, cost: Cost, settings: dict[str, Any]) -> Trajectory:
        """Return the trajectory of a run; its joint reactions and events are computed on first access."""
        states = result.reported_states
        observables = result.observables
        mobility = self._count_mobility(states) if result.n_reached > 0 else mobility_of(self.mechanism)
        return Trajectory(
            scene=self.scene,
            times=states.times,
            poses=states.poses,
            velocities=states.velocities,
            readings=observables.readings,
            rates=observables.rates,
            units=observables.units,
            scales=observables.scales,
            joint_gap=observables.joint_gap,
            energy=observables.energy,
            outcome=result.outcome or Outcome.NOT_CERTIFIED,
            detail=result.detail,
            cost=cost,
            error_estimate=result.error_estimate,
            reading_errors=result.reading_errors,
            settings=settings,
            mobility=mobility,
            notes=(*assembly_notes(self.scene), *self._missing_crossing_notes(result)),
            n_excluded=result.n_excluded,
            deferred_results=DeferredMotionAnalysis(self.scene, result, mobility),
        )

    def _count_mobility(self, states: StateHistory) -> int:
        """Return the degrees of freedom at the first state; at the start of a scene they are counted once."""
        known = _known_start_mobility(self.scene) if states.times[0] == 0.0 else []
        if not known:
            known.append(position_solver_of(self.mechanism).count_degrees_of_freedom(states.poses[0]))
        return known[0]

    def _missing_crossing_notes(self, result: RunResult) -> tuple[str, ...]:
        """Return a sentence if named crossings may be missing: without dense output nothing is known between two contact events."""
        has_dense_output = result.dense_output is not None or not isinstance(result.monitor_states, StateHistory)
        if has_dense_output or not (self.scene.crossings and result.contact_events):
            return ()
        return ("crossings named in [events] between two contact events in quick succession may be missing; choose engine 'multibody'",)

    def with_shaft(
        self, times: FloatArray, poses: FloatArray, velocities: FloatArray, spindle_angle: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (n, bodies, 3) of a part and behind them a free spindle's shaft, whose momentum gives its speed."""
        spindle = self.scene.spindle
        if not isinstance(spindle, FreeSpindle):
            return poses, velocities
        initial_inertia = spindle.inertia + self.rotations[0].inertia(self._initial_poses[np.newaxis])[0]
        torque = CubicTimeFunction(spindle.torque)
        momentum = initial_inertia * (spindle.start_speed or 0.0) + torque.integrals(0.0, times)
        speed = momentum / (spindle.inertia + self.rotations[0].inertia(poses))
        shaft_motion = np.zeros((2, len(poses), 1, 3))
        start_angle = self.scene.state.motion_of([body.name for body in self.mechanism.bodies])[0][-1][2] if self.scene.state else 0.0
        shaft_motion[:, :, 0, 2] = start_angle + spindle_angle, speed
        return np.concatenate([poses, shaft_motion[0]], axis=1), np.concatenate([velocities, shaft_motion[1]], axis=1)

    def integrate_missing_work(self, history: StateHistory, contact_modes: tuple[ContactMode, ...]) -> FloatArray | None:
        """Return the work (n,) J of drivers, loads and spindle torque, from their power, if the engine leaves out any, else None."""
        has_drives = bool(self._constraint_equations.is_driven.any())
        elements = self.mechanism.force_elements
        has_nonconservative_loads = any(not isinstance(one, CONSERVATIVE_TYPES) or not one.has_potential for one in elements)
        if not (has_drives or has_nonconservative_loads) or len(history.times) < 2:
            return None
        return -integrate_work(self.scene, history, contact_modes)

    def evaluate_joint_gap(self, poses: FloatArray, times: FloatArray) -> FloatArray:
        """Return the largest constraint violation (n,) m at poses (n, bodies, 3) and times (n,) s; a broken gear has none."""
        gaps = np.abs(self._constraint_equations.residuals_along(poses, times))
        for name, end in self.scene.system.breaking_gears.items():
            is_gear = self._constraint_equations.joint_indices == self.mechanism.joint_index(name)
            gaps[np.ix_(is_gear, times > end)] = 0.0
        largest: FloatArray = gaps.max(axis=0, initial=0.0)
        return largest

    def compare_observables(self, better: Observables, worse: Observables) -> dict[str, float]:
        """Return the largest difference of each reading and rate (see `name_of_rate`) and the largest joint gap, in SI."""
        # At a dead centre pressures jump: where only one of the motions has passed it, they are not
        # compared.
        differences = {name: values - worse.readings[name] for name, values in better.readings.items()}
        differences |= {name_of_rate(name): values - worse.rates[name] for name, values in better.rates.items()}
        differences[JOINT_GAP] = better.joint_gap
        for output in self.mechanism.derived_readings:
            if isinstance(output, CylinderPressure):
                strokes, others = (np.floor(one.readings[output.reading] / np.pi) for one in (better, worse))
                differences[output.name] = differences[output.name] * (strokes == others)
        return {name: float(np.abs(values).max(initial=0.0)) for name, values in differences.items()}

    def least_errors(self, observables: Observables) -> dict[str, float]:
        """Return the least error of each reading, rate and event time, SI: the rounding error that all runs share."""
        return {name: ERROR_ESTIMATE_FLOOR * scale for name, scale in observables.scales.items()}

    def to_relative_error(self, errors: dict[str, float], observables: Observables) -> float:
        """Return the largest error relative to its scale in this motion, and at least the rounding error that all runs share."""
        return max(ERROR_ESTIMATE_FLOOR, *(error / observables.scales[name] for name, error in errors.items()))

    def find_first_out_of_range(self, poses: FloatArray) -> tuple[int, str] | None:
        """Return the index of the first pose outside the mechanism's limits and the sentence that describes it, or None."""
        exits = []
        for limit in self.mechanism.limits:
            value = evaluate_output_value(self.mechanism, limit.reading, poses)
            for is_outside, message in ((~(value > limit.low), limit.low_message), (~(value < limit.high), limit.high_message)):
                if is_outside.any():
                    exits.append((int(np.argmax(is_outside)), f"{limit.reading}: {message}"))
        return min(exits) if exits else None

    def find_first_stall(self, poses: FloatArray, velocities: FloatArray) -> tuple[int, str] | None:
        """Return the index of the first state in which a shaft that must not turn back does, and what happens there, or None."""
        stalls = []
        for limit in self.mechanism.stall_limits:
            if (turns_back := evaluate_output(self.mechanism, limit.reading, poses).rate(velocities) < 0.0).any():
                index = int(np.argmax(turns_back))
                stalls.append((index, self.describe_stall(limit, poses[index])))
        return min(stalls) if stalls else None

    def describe_stall(self, limit: StallLimit, poses: FloatArray) -> str:
        """Return what happens where a shaft turns back at poses (bodies, 3), with its angle."""
        angle = float(evaluate_output_value(self.mechanism, limit.reading, poses))
        return f"{limit.message}, at {limit.reading} = {math.degrees(angle):.4f} deg"

    def count_model_size(self) -> dict[str, int]:
        """Return the number of bodies, constraint equations, force elements, contacts and so on; only those that are not zero."""
        contacts = contacts_of(self.scene)
        counts = {
            "bodies": len(self.mechanism.bodies),
            "joint equations": len(self._constraint_equations.joint_indices),
            "force elements": len(self.mechanism.force_elements),
            "readings with forces": len(forced_output_names(self.scene)),
            "springs and dashpots along readings": len(output_forces_of(self.scene)),
            "frictions": sum(contact.friction is not None for contact in contacts),
            "stops": sum(int(np.isfinite(contact.low)) + int(np.isfinite(contact.high)) for contact in contacts),
        }
        return {name: count for name, count in counts.items() if count}

    def _evaluate_energy(self, history: StateHistory, scale: float) -> Energy:
        """Return the energy balance, with the scale (J) of its errors."""
        rotation, work = np.zeros((2, len(history.times)))
        kinetic, potential = evaluate_mechanical_energy(self.scene, history.poses, history.velocities)
        for one in self.rotations:
            if one.plane.is_loaded:
                own_inertia = self.mechanism.bodies[one.shaft_index].planar_inertia if one.plane.has_reaction else 0.0
                energy = 0.5 * (own_inertia + one.inertia(history.poses)) * one.speed(history.times, history.velocities) ** 2
                rotation += energy
                work += energy if one.plane.has_reaction else -energy
        jacobi = kinetic + potential + work + history.work
        dissipated = history.dissipated_energy
        return Energy(kinetic=kinetic, potential=potential, rotation=rotation, jacobi=jacobi, dissipated_energy=dissipated, scale=scale)

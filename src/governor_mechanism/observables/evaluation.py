"""Evaluate observables from states, for every engine: readings, rates, energies, joint gaps, and the trajectory of a run."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, output_forces_of
from governor_mechanism.mechanics.dynamics.force_elements import spring_potential_energy as spring_potential
from governor_mechanism.mechanics.dynamics.force_laws import gravitational_energy, spindle_inertia, spindle_inertia_rate
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver, assembly_notes
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_output, evaluate_output_value, unwrap_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.force_elements import Spring, TorsionSpring
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Energy, Outcome, Trajectory
from governor_mechanism.observables.error_scales import JOINT_GAP, MotionScales, name_of_rate
from governor_mechanism.observables.run_result import DeferredMotionAnalysis, Observables, RunResult, StateHistory
from governor_mechanism.observables.static_forces import evaluate_derived_forces
from governor_mechanism.observables.work import integrate_work
from governor_mechanism.types import FloatArray

ERROR_ESTIMATE_FLOOR = 1e-13
"""Smallest error estimate, relative to the scales: two runs may agree to the last digit and share the same rounding error."""


class ReadingEvaluator:
    """Evaluator of the states of one scene, with the scales of its errors.

    Parameters
    ----------
    scene
        The scene.
    initial_poses
        Poses of the mass centres at the start; shape (bodies, 3).

    Attributes
    ----------
    scene
        Scene.
    mechanism
        Mechanism of all its parts.
    planes
        Planes that turn with a spindle.
    speed_functions
        Given spindle speed of each plane as a function of time; None where it is not given.
    time_scale
        Time scale of the scene, s.
    energy_scale
        Largest energy scale of any motion of the scene, J.
    """

    def __init__(self, scene: Scene, initial_poses: FloatArray) -> None:
        self.scene = scene
        self._initial_poses = initial_poses
        self.mechanism: Mechanism = scene.mechanism
        self.planes = scene.system.planes
        speeds = [(plane.given_speed, plane.ratio) for plane in self.planes]
        self.speed_functions = [SpindleSpeedFunction(given, ratio) if given else None for given, ratio in speeds]
        self._shaft_indices = [self.mechanism.body_index(plane.shaft) if plane.shaft else -1 for plane in self.planes]
        self._constraint_equations = ConstraintEquations(self.mechanism)
        self.time_scale, self._motion_scales = time_scale(scene), MotionScales(scene)
        self.energy_scale = self._motion_scales.mass * self.mechanism.length_scale**2 / self.time_scale**2

    def _spindle_outputs(self) -> Iterator[tuple[str, str, Callable[[StateHistory], FloatArray]]]:
        """Yield name and unit of each output of a spindle, and the function that evaluates it."""
        for index, plane in enumerate(self.planes):
            yield f"{plane.prefix}{SPINDLE_SPEED}", "rad/s", partial(self.evaluate_speed, index)
            if plane.given_speed and plane.is_loaded:
                yield f"{plane.prefix}{SPINDLE_TORQUE}", "N m", partial(self._evaluate_spindle_torque, index)
            elif not plane.given_speed and not plane.has_reaction:
                yield f"{plane.prefix}{SPINDLE_ANGLE}", "rad", partial(self._evaluate_spindle_angle, index)

    def evaluate(self, history: StateHistory) -> Observables:
        """Return all observables at the states of a history."""
        readings, rates, units = dict[str, FloatArray](), dict[str, FloatArray](), dict[str, str]()
        for reading in self.mechanism.readings:
            name, output = reading.name, evaluate_output(self.mechanism, reading.name, history.poses)
            readings[name], rates[name] = unwrap_output(reading, output.value), output.rate(history.velocities)
            units[name] = READING_UNITS[reading.quantity]
        readings |= evaluate_derived_forces(self.scene, history.poses)
        units |= {output.name: "N" for output in self.mechanism.derived_forces}
        for name, unit, evaluate_output_of in self._spindle_outputs():
            readings[name], units[name] = evaluate_output_of(history), unit
        joint_gap = self.evaluate_joint_gap(history.poses, history.times)
        energy = self._evaluate_energy(history, self._motion_scales.energy_scale(rates))
        return Observables(readings=readings, rates=rates, units=units, joint_gap=joint_gap, energy=energy)

    def make_trajectory(self, result: RunResult, *, cost: Cost, settings: dict[str, Any]) -> Trajectory:
        """Return the trajectory of a run; its joint reactions and events are computed on first access."""
        states, position_solver = result.reported_states, PositionSolver(self.mechanism)
        mobility = position_solver.count_degrees_of_freedom(states.poses[0]) if result.n_reached else position_solver.mobility
        return Trajectory(
            scene=self.scene,
            times=states.times,
            poses=states.poses,
            velocities=states.velocities,
            **vars(result.observables),
            scales=self._motion_scales.error_scales(result.observables.readings, result.observables.rates),
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

    def _missing_crossing_notes(self, result: RunResult) -> tuple[str, ...]:
        """Return a sentence if named crossings may be missing: without dense output nothing is known between two contact events."""
        has_dense_output = result.dense_output is not None or not isinstance(result.monitor_states, StateHistory)
        if has_dense_output or not (self.scene.crossings and result.contact_events):
            return ()
        return ("crossings named in [events] between two contact events in quick succession may be missing; choose engine 'multibody'",)

    def evaluate_speed(self, index: int, history: StateHistory) -> FloatArray:
        """Return the speed (n,) rad/s of a plane at the states of a history."""
        speed_function = self.speed_functions[index]
        return self._shaft_column(index, history.velocities) if speed_function is None else speed_function(history.times)

    def _evaluate_spindle_angle(self, index: int, history: StateHistory) -> FloatArray:
        """Return the angle (n,) rad of a plane that turns with a shaft."""
        return self._shaft_column(index, history.poses)

    def _shaft_column(self, index: int, motion: FloatArray) -> FloatArray:
        """Return the angles or angular velocities (n,) of a plane from those of its shaft."""
        column: FloatArray = self.planes[index].ratio * motion[:, self._shaft_indices[index], 2]
        return column

    def with_shaft(
        self, times: FloatArray, poses: FloatArray, velocities: FloatArray, spindle_angle: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (n, bodies, 3) of a part with those of the shaft of its spindle, if that is free, behind them.

        The speed of the shaft at the times (n,) s follows from the angular momentum.
        """
        spindle = self.scene.spindle
        if not isinstance(spindle, FreeSpindle):
            return poses, velocities
        initial_inertia = spindle.inertia + self.evaluate_spindle_inertia(0, self._initial_poses[np.newaxis])[0]
        torque = CubicTimeFunction(spindle.torque)
        impulses = np.array([torque.integral(0.0, float(time)) for time in times])
        momentum = initial_inertia * (spindle.start_speed or 0.0) + impulses
        speed = momentum / (spindle.inertia + self.evaluate_spindle_inertia(0, poses))
        shaft_motion = np.zeros((2, len(poses), 1, 3))
        shaft_motion[:, :, 0, 2] = spindle_angle, speed
        return np.concatenate([poses, shaft_motion[0]], axis=1), np.concatenate([velocities, shaft_motion[1]], axis=1)

    def integrate_missing_work(self, history: StateHistory, contact_modes: tuple[ContactMode, ...]) -> FloatArray | None:
        """Return the work (n,) J to add for an engine that does not integrate the work of drivers, loads and spindle torque.

        It is integrated from their power between the times of the history; None if nothing does such work.
        """
        has_drives = bool(self._constraint_equations.is_driven.any())
        has_nonconservative_loads = any(not isinstance(load, Spring | TorsionSpring) for load in self.mechanism.force_elements)
        if not (has_drives or has_nonconservative_loads) or len(history.times) < 2:
            return None
        return -integrate_work(self.scene, history, contact_modes)

    def evaluate_joint_gap(self, poses: FloatArray, times: FloatArray) -> FloatArray:
        """Return the largest constraint violation (n,) m at poses (n, bodies, 3) and times (n,) s; a broken gear has none."""
        gaps = np.abs(self._constraint_equations.residuals(poses, times))
        for name, end in self.scene.system.breaking_gears.items():
            is_gear = self._constraint_equations.joint_indices == self.mechanism.joint_index(name)
            gaps[np.ix_(times > end, is_gear)] = 0.0
        largest: FloatArray = np.max(gaps, axis=-1, initial=0.0)
        return largest

    def compare_observables(self, better: Observables, worse: Observables) -> dict[str, float]:
        """Return the largest difference of each reading and rate (see `name_of_rate`) and the largest joint gap, in SI."""
        pairs = {name: (values, worse.readings[name]) for name, values in better.readings.items()}
        pairs |= {name_of_rate(name): (values, worse.rates[name]) for name, values in better.rates.items()}
        pairs[JOINT_GAP] = better.joint_gap, np.zeros_like(better.joint_gap)
        return {name: float(np.max(np.abs(first - second), initial=0.0)) for name, (first, second) in pairs.items()}

    def to_relative_error(self, errors: dict[str, float], observables: Observables) -> float:
        """Return the largest error relative to its scale in this motion, and at least the rounding error that all runs share."""
        scales = self._motion_scales.error_scales(observables.readings, observables.rates)
        return max(ERROR_ESTIMATE_FLOOR, *(error / scales[name] for name, error in errors.items()))

    def find_first_out_of_range(self, poses: FloatArray) -> tuple[int, str] | None:
        """Return the index of the first pose outside the mechanism's limits and the sentence that describes it, or None."""
        exits = []
        for limit in self.mechanism.limits:
            value = evaluate_output_value(self.mechanism, limit.reading, poses)
            for is_outside, message in ((~(value > limit.low), limit.low_message), (~(value < limit.high), limit.high_message)):
                if is_outside.any():
                    exits.append((int(np.argmax(is_outside)), f"{limit.reading}: {message}"))
        return min(exits) if exits else None

    def _evaluate_spindle_torque(self, index: int, history: StateHistory) -> FloatArray:
        """Return the driving torque at a given speed: the rate of the parts' angular momentum, d(J omega)/dt."""
        speed_function = self.speed_functions[index]
        speed, inertia_rate = self.evaluate_speed(index, history), np.zeros(len(history.times))
        acceleration = np.zeros_like(speed) if speed_function is None else speed_function.derivative(history.times)
        for k in self.planes[index].bodies:
            body, (x, _, angle), (x_rate, _, angular_velocity) = self.mechanism.bodies[k], history.poses[:, k].T, history.velocities[:, k].T
            inertia_rate += spindle_inertia_rate(body.mass, *body.second_moments.in_plane, x, angle, x_rate, angular_velocity)
        torque: FloatArray = inertia_rate * speed + self.evaluate_spindle_inertia(index, history.poses) * acceleration
        return torque

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

    def evaluate_spindle_inertia(self, index: int, poses: FloatArray) -> FloatArray:
        """Return the moment of inertia J (n,) kg m2 of the bodies of a plane about its spindle."""
        total = np.zeros(len(poses))
        for k in self.planes[index].bodies:
            body = self.mechanism.bodies[k]
            total += spindle_inertia(body.mass, *body.second_moments.in_plane, body.second_moments.zz, poses[:, k, 0], poses[:, k, 2])
        return total

    def _evaluate_energy(self, history: StateHistory, scale: float) -> Energy:
        """Return the energy balance, with the scale (J) of its errors."""
        kinetic, potential, rotation, work = (np.zeros(len(history.times)) for _ in range(4))
        shafts = {index for index, plane in zip(self._shaft_indices, self.planes, strict=True) if plane.has_reaction}
        for index, body in enumerate(self.mechanism.bodies):
            velocity = history.velocities[:, index]
            if index in shafts:
                continue
            kinetic += 0.5 * body.mass * np.sum(velocity[:, :2] ** 2, axis=1)
            kinetic += 0.5 * body.planar_inertia * velocity[:, 2] ** 2
            potential += gravitational_energy(body.mass, self.scene.system.gravity[index], history.poses[:, index, 1])
        potential += spring_potential(self.mechanism, history.poses)
        for effect in output_forces_of(self.scene):
            value = evaluate_output_value(self.mechanism, effect.reading, history.poses)
            potential += np.where(value < effect.slack_below, 0.0, effect.potential(effect.coefficients, value)[0])
        for index, plane in enumerate(self.planes):
            if plane.is_loaded:
                own_inertia = self.mechanism.bodies[self._shaft_indices[index]].planar_inertia if plane.has_reaction else 0.0
                inertia = own_inertia + self.evaluate_spindle_inertia(index, history.poses)
                energy = 0.5 * inertia * self.evaluate_speed(index, history) ** 2
                rotation += energy
                work += energy if plane.has_reaction else -energy
        jacobi, dissipated = kinetic + potential + work + history.work, history.dissipated_energy
        return Energy(kinetic=kinetic, potential=potential, rotation=rotation, jacobi=jacobi, dissipated_energy=dissipated, scale=scale)

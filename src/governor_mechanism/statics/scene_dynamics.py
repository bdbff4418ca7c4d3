"""A scene as equations z'' = a(z, z') in independent coordinates, with the last inputs; all that knows how it is lowered is here."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.arrays import (
    N_ENERGY_STATES,
    System,
    SystemWorkspace,
    from_mass_centres,
    make_system_workspace,
    to_mass_centres,
)
from governor_mechanism.mechanics.dynamics.body_forces import inertia_of_plane
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.constrained_solution import project_state
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, active_forces_of, initial_mode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.inputs import initial_lags, reading_tables_of
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.constraint_equations import RowEvaluation, make_constraint_table
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import N_CUBIC_COLUMNS, VALUE_COLUMN, stack_local_cubics
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import ReadingFunction
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import NO_INDEX, FloatArray, IntArray

KINK_TOLERANCE = 1e-9
"""Distance from a point of a table, relative to its largest point, within which the steady state is at the kink."""

CLOSURE_TOLERANCE = 1e-16
"""Residual relative to the length scale to which joints are closed: below rounding, so that all Newton iterations are made."""

MAX_GAP_RATIO = 1e-11
"""Gap of a joint relative to the length scale above which the mechanism cannot be assembled at a position."""

MIN_PARTITION_RATIO = 1e-2
"""Smallest ratio of singular values of the dependent coordinates' Jacobian; below it, other independent coordinates are chosen."""


class IndependentModel(NamedTuple):
    """Equations in independent coordinates."""

    projected: System  # a system that a projection does not move along them
    workspace: SystemWorkspace  # its workspace
    inputs: FloatArray  # local cubics of the inputs; shape (inputs, columns)
    reference: FloatArray  # poses near which dependent coordinates are solved; shape (3 bodies,)
    independent: IntArray  # indices of the independent coordinates
    closure_tolerance: float  # largest residual of a joint that is closed, m
    largest_gap: float  # largest residual of a joint that could be closed, m


@jit_in_place
def _place_at(
    model: IndependentModel,
    z: FloatArray,  # independent coordinates; shape (n,)
    rates: FloatArray,  # their rates; shape (n,)
    state: FloatArray,  # state vector, to be filled
) -> bool:
    """Fill a state with poses and velocities at independent coordinates, and with lags; return whether it can be assembled there."""
    reference, independent = model.reference, model.independent
    n, n_free = reference.size, independent.size
    poses, velocities = state[:n].reshape(-1, 3), state[n : 2 * n].reshape(-1, 3)
    copy_array(state[:n], reference)
    state[n : 2 * n] = 0.0
    for k in range(n_free):
        state[independent[k]], state[n + independent[k]] = z[k], rates[k]
    copy_array(state[state.size - (rates.size - n_free) :], rates[n_free:])
    gap = project_state(model.projected, model.workspace, model.inputs, 0.0, poses, velocities, model.closure_tolerance)
    return bool(gap < model.largest_gap)


@jit_in_place
def _evaluate_accelerations(
    system: System,
    model: IndependentModel,
    z: FloatArray,  # independent coordinates; shape (k, n)
    rates: FloatArray,  # their rates; shape (k, n)
    state: FloatArray,  # state vector for use in between
    derivative: FloatArray,  # the same
    accelerations: FloatArray,  # result; shape (k, n)
) -> None:
    """Fill the accelerations of the independent coordinates, and the rates of the lags; NaN where the mechanism cannot be assembled."""
    reference, independent = model.reference, model.independent
    n_lags = z.shape[1] - independent.size
    for k in range(len(z)):
        if not _place_at(model, z[k], rates[k], state):
            accelerations[k] = np.nan
            continue
        evaluate_state_derivative(system, model.workspace, model.inputs, 0.0, state, derivative)
        for i in range(independent.size):
            accelerations[k, i] = derivative[reference.size + independent[i]]
        copy_array(accelerations[k, independent.size :], derivative[state.size - n_lags :])


class SceneDynamics:
    """Accelerations, readings and inputs in coordinates that are chosen at poses; MechanismError if none is free, or a drive goes on."""

    # A lag counts as a rate of a coordinate of its own, on which nothing depends. `names` are those of
    # poses of bodies and shafts, then lags; `scales` (n,) a radian or a length scale, of a lag its
    # start value times the time scale (s); `start` and `start_rates` (n,) those of the given poses
    # (bodies, 3) and velocities. Inputs are taken at `time` (s), by default that of their last change.

    def __init__(self, scene: Scene, poses: FloatArray, velocities: FloatArray, time: float | None = None) -> None:
        self.scene, self._mechanism, self.time_scale, self._time = scene, scene.mechanism, time_scale(scene), time
        self._set_mode(initial_mode(scene))
        self._require_steady_inputs()
        origin_poses, origin_velocities = from_mass_centres(self._system, poses, velocities)
        self._reference, bodies, axes = origin_poses, self._mechanism.bodies, ("x", "y", "angle")
        self._independent = self._choose_coordinates(origin_poses)
        self._hold_independent()
        lags = initial_lags(scene, poses, velocities)
        names = [f"{bodies[k // 3].name}.{axes[k % 3]}" for k in self._independent]
        self.names = (*names, *(f"lag {k + 1}" for k in range(len(lags))))
        pose_scales = np.tile([self._mechanism.length_scale, self._mechanism.length_scale, 1.0], len(origin_poses))
        lag_scales = self.time_scale * np.where(lags != 0.0, np.abs(lags), 1.0)
        self.scales: FloatArray = np.concatenate([pose_scales[self._independent], lag_scales])
        self.start: FloatArray = np.concatenate([origin_poses.ravel()[self._independent], np.zeros(len(lags))])
        self.start_rates: FloatArray = np.concatenate([origin_velocities.ravel()[self._independent], lags])
        if not self.names:
            raise MechanismError("the mechanism has no free degree of freedom: its drives determine the motion, and nothing can oscillate")

    def _set_mode(self, mode: ContactMode) -> None:
        self._mode = mode
        self._system, functions = make_system(self.scene, mode)
        last = max([0.0, *(float(function.breakpoints[-1]) for function in functions if function.breakpoints.size)])
        self._inputs: FloatArray = stack_local_cubics(functions, np.array([last if self._time is None else self._time]))[0]
        self._workspace = make_system_workspace(self._system)

    def _hold_independent(self) -> None:
        """Make the system in which a projection does not change the independent coordinates."""
        inverse_mass = self._system.inverse_mass.copy()
        inverse_mass.ravel()[self._independent] = 0.0
        self._projected = self._system._replace(inverse_mass=inverse_mass)

    def _require_steady_inputs(self) -> None:
        if np.any(self._system.planes["amplitude"]):
            raise MechanismError(
                "the steady state is periodic, because the spindle speed fluctuates in each turn; linearise at the mean speed, "
                "with spindle.speed_fluctuation = 0"
            )
        drives = self._system.constraint_rows.table["drive"]
        motions = self._inputs[drives[drives != NO_INDEX]]
        if np.any(motions[:, 2]) or np.any(motions[:, N_CUBIC_COLUMNS:]):  # a rate or harmonics
            raise MechanismError(
                "the steady state is periodic, because a drive turns or moves the mechanism all the time; "
                "let the drive end at rest, or replace it by a mean torque"
            )

    def _constraint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the dimensionless constraint Jacobian (rows, 3 bodies)."""
        jacobian = RowEvaluation(self._system.constraint_rows, poses).jacobian.reshape(-1, poses.size)
        # Angles count half: a shaft is described by its angle, which turns steadily, rather than by the path of its mass centre.
        scaled: FloatArray = jacobian * np.tile([1.0, 1.0, 0.5 / self._mechanism.length_scale], len(poses))
        return scaled

    def _choose_coordinates(self, poses: FloatArray) -> IntArray:
        """Return the indices of the coordinates that the pivoted QR factorisation of the constraint Jacobian chooses last."""
        from scipy.linalg import qr  # slow to import

        free, jacobian = self._free_coordinates(), self._constraint_jacobian(poses)
        if not len(jacobian):
            return free
        _, triangle, order = qr(jacobian[:, free], mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        return np.sort(free[order[int(np.sum(pivots > RANK_TOLERANCE * pivots[0])) :]])

    def is_well_conditioned(self, z: FloatArray) -> bool:
        """Return whether the independent coordinates describe the motion about z well."""
        free = self._free_coordinates()
        jacobian = self._constraint_jacobian(self.motion(z, np.zeros_like(z))[0])
        dependent = np.setdiff1d(free, self._independent)
        if not len(dependent):
            return True
        all_values, values = (np.linalg.svd(jacobian[:, columns], compute_uv=False) for columns in (free, dependent))
        return bool(values[len(dependent) - 1] > MIN_PARTITION_RATIO * all_values[len(dependent) - 1])

    def _free_coordinates(self) -> IntArray:
        """Return the indices of the coordinates with finite mass."""
        return np.flatnonzero(self._system.inverse_mass.ravel() > 0.0)

    def set_contact_mode(self, z: FloatArray, rates: FloatArray) -> bool:
        """Make one-sided springs taut or slack and choose segments of tables as readings demand; return whether any has changed."""
        previous_mode, poses = self._mode, self.poses(z)
        taut = tuple(self._reading(one.reading, poses) > one.slack_below for one in one_sided_forces_of(self.scene))
        tables = reading_tables_of(self.scene)
        segments = tuple(int(np.searchsorted(table.positions, self._input_of_function(table, z, rates))) for table in tables)
        mode = replace(previous_mode, taut=taut, segments=segments)
        if mode == previous_mode:
            return False
        self._set_mode(mode)
        self._hold_independent()
        return True

    def _input_of_function(self, function: ReadingFunction, z: FloatArray, rates: FloatArray) -> float:
        """Return the value of the reading, or the speed, that a load depends on."""
        poses, velocities = self.mass_centre_motion(z, rates)
        output = evaluate_output(self._mechanism, function.source, poses)
        return float(output.rate(velocities) if function.is_rate else output.value)

    def drop_quadratic_damping(self, z: FloatArray, rates: FloatArray) -> bool:
        """Leave out quadratic dashpots at rest, where they have no effect on small motions; return whether there are any."""
        forces = self._system.output_forces.copy()
        reading_rates = dict(zip(self.reading_names, self.reading_jacobian(z) @ rates, strict=True))
        is_dropped = False
        for i, effect in enumerate(active_forces_of(self.scene, self._mode)):
            if reading_rates.get(effect.reading, 0.0) == 0.0 and effect.linear_coefficients != effect.coefficients:
                forces["coefficients"][i, : len(effect.linear_coefficients)] = effect.linear_coefficients
                is_dropped = True
        self._system = self._system._replace(output_forces=forces)
        return is_dropped

    def motion(self, z: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (bodies, 3) of the body origins; NaN if the mechanism cannot be assembled there."""
        state, n_coordinates = self._make_state(), self._reference.size
        if not _place_at(self._make_model(self._inputs), z, rates, state):
            state[:n_coordinates] = np.nan
        poses, velocities = state[: 2 * n_coordinates].reshape(2, *self._reference.shape)
        return poses, velocities

    def _make_state(self) -> FloatArray:
        """Return an empty state vector."""
        return np.zeros(2 * self._reference.size + N_ENERGY_STATES + len(self.names) - len(self._independent))

    def _make_model(self, inputs: FloatArray) -> IndependentModel:
        """Return the arrays of the equations with local cubics of the inputs."""
        tolerance, largest_gap = (ratio * self._mechanism.length_scale for ratio in (CLOSURE_TOLERANCE, MAX_GAP_RATIO))
        return IndependentModel(
            self._projected, self._workspace, inputs, self._reference.ravel(), self._independent, tolerance, largest_gap
        )

    def move_reference(self, z: FloatArray) -> None:
        """Solve dependent coordinates from the poses at these coordinates from now on."""
        self._reference = self.motion(z, np.zeros_like(z))[0]

    def mass_centre_motion(self, z: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (bodies, 3) of the mass centres."""
        return to_mass_centres(self._system, *self.motion(z, rates))

    def poses(self, z: FloatArray) -> FloatArray:
        """Return the poses of the mass centres; shape (bodies, 3)."""
        return self.mass_centre_motion(z, np.zeros_like(z))[0]

    def accelerations(self, z: FloatArray, rates: FloatArray, input_changes: Mapping[int, float] | None = None) -> FloatArray:
        """Return the accelerations (k, n) at coordinates and rates, NaN where nothing can be assembled, with changes of inputs by index."""
        inputs = self._inputs.copy()
        for index, change in (input_changes or {}).items():
            inputs[index, VALUE_COLUMN] += change
        state, accelerations = self._make_state(), np.empty(z.shape)
        _evaluate_accelerations(self._system, self._make_model(inputs), z, rates, state, np.empty_like(state), accelerations)
        return accelerations

    def require_no_uneven_turning(self) -> None:
        """Raise MechanismError if an angle starts so fast that it makes full turns, although forces depend on it."""
        # An angle passes over a potential if half its squared rate exceeds the work per inertia
        # between two extrema, at most twice the largest acceleration.
        for k in np.flatnonzero([name.endswith(".angle") for name in self.names]):
            turned = self.start + np.multiply.outer(np.linspace(0.0, 2 * np.pi, 16, endpoint=False), np.eye(len(self.start))[k])
            accelerations = self.accelerations(turned, np.zeros_like(turned))[:, k]
            is_uneven = np.ptp(accelerations) > 1e-9 * np.max(np.abs(accelerations))
            if is_uneven and self.start_rates[k] ** 2 > 4 * np.max(np.abs(accelerations)):  # False where NaN
                raise MechanismError(
                    f"the steady state is periodic: {self.names[k]} turns, and forces or inertias depend on it, so accelerations cannot "
                    "vanish; use the mean torque and a flywheel instead of the mechanism"
                )

    @property
    def reading_names(self) -> tuple[str, ...]:
        """Names of all readings but the angles of spindles."""
        angles = {f"{plane.prefix}{SPINDLE_ANGLE}" for plane in self.scene.system.planes}
        return tuple(reading.name for reading in self._mechanism.readings if reading.name not in angles)

    def reading_scale(self, name: str) -> float:
        """Return the scale of a reading, SI."""
        return self._mechanism.output_scale(name)

    def _reading(self, name: str, poses: FloatArray) -> float:
        return float(evaluate_output_value(self._mechanism, name, poses))

    def readings(self, z: FloatArray) -> FloatArray:
        """Return the values of all readings; shape (readings,)."""
        poses = self.poses(z)
        return np.array([self._reading(name, poses) for name in self.reading_names])

    def reading_jacobian(self, z: FloatArray) -> FloatArray:
        """Return the derivatives of all readings with respect to the independent coordinates; shape (readings, n)."""
        poses, columns = self.poses(z), self._velocity_columns(z)
        gradients = [evaluate_output(self._mechanism, name, poses).gradient for name in self.reading_names]
        return np.tensordot(np.array(gradients).reshape(-1, *poses.shape), columns, axes=((1, 2), (1, 2)))

    def _velocity_columns(self, z: FloatArray) -> FloatArray:
        """Return the velocities of the mass centres for a unit rate of each coordinate; shape (n, bodies, 3)."""
        return np.array([self.mass_centre_motion(z, unit)[1] for unit in np.eye(len(z))])

    def force_columns(self, z: FloatArray) -> FloatArray:
        """Return the accelerations by a unit force along each reading, at zero rates; shape (n, readings)."""
        masses = np.array([[body.mass, body.mass, body.planar_inertia] for body in self._mechanism.bodies])
        n_free = len(self._independent)
        for index, plane in enumerate(self._system.planes):
            if plane["has_reaction"]:
                masses[plane["shaft"], 2] += inertia_of_plane(self._system.bodies, index, *self.motion(z, np.zeros_like(z)))[0]
        columns = self._velocity_columns(z)[:n_free]
        result = np.zeros((len(z), len(self.reading_names)))
        mass_matrix = np.einsum("ikc,kc,jkc->ij", columns, masses, columns)
        result[:n_free] = np.linalg.solve(mass_matrix, self.reading_jacobian(z)[:, :n_free].T)
        return result

    @property
    def input_indices(self) -> dict[str, int]:
        """Inputs of the equations by name: given spindle speeds, then torques and components of forces, before their factors."""
        planes = self.scene.system.planes
        speeds = list(dict.fromkeys(plane.given_speed for plane in planes if plane.given_speed))
        given = [plane for plane in planes if plane.is_loaded and plane.given_speed and plane.ratio == 1.0]
        indices = {f"{plane.prefix}{SPINDLE_SPEED}": speeds.index(plane.given_speed) for plane in given if plane.given_speed}
        next_input = len(speeds) + len(make_constraint_table(self._mechanism).motions)
        for element in self._mechanism.force_elements:
            names = [element.name] if isinstance(element, Torque) else []
            names += [f"{element.name}.{axis}" for axis in "xy"] if isinstance(element, Force) else []
            indices |= {name: next_input + k for k, name in enumerate(names)}
            next_input += len(names)
        return indices

    def spindle_speed_rows(self) -> dict[str, FloatArray]:
        """Return the speeds (rad/s) of spindles that turn with a body for a unit rate of each coordinate, by name; shape (n,)."""
        columns = self._velocity_columns(self.start)
        planes = [plane for plane in self.scene.system.planes if plane.shaft]
        bodies = [self._mechanism.body_index(plane.shaft) for plane in planes]
        return {f"{plane.prefix}{SPINDLE_SPEED}": plane.ratio * columns[:, k, 2] for plane, k in zip(planes, bodies, strict=True)}

    def notes(self, z: FloatArray, rates: FloatArray) -> tuple[str, ...]:
        """Return what the linearised equations leave out, one sentence each. Raise MechanismError at a stop or a kink of a force law."""
        poses = self.poses(z)
        notes = [f"gear {name!r} counts as intact" for name in self.scene.system.breaking_gears]
        for contact in contacts_of(self.scene):
            value = self._reading(contact.output_name, poses)
            tolerance = MAX_GAP_RATIO * self.reading_scale(contact.output_name)
            if not contact.low + tolerance < value < contact.high - tolerance:
                raise MechanismError(
                    f"the equilibrium, {contact.output_name} = {value:.6g}, is at or beyond a stop, "
                    "where the motion has no linear equations; move the stops, or take another equilibrium"
                )
            if contact.friction is not None:
                notes.append(f"dry friction on {contact.output_name} is left out: at rest it holds, and it has no linear law")
        for effect in one_sided_forces_of(self.scene):
            if abs(self._reading(effect.reading, poses) - effect.slack_below) <= MAX_GAP_RATIO * self.reading_scale(effect.reading):
                raise MechanismError(
                    f"the {effect.key} on {effect.reading!r} is just slack at the equilibrium, where its force has no linear law"
                )
        for table in reading_tables_of(self.scene):
            value = self._input_of_function(table, z, rates)
            if min(abs(value - position) for position in table.positions) <= KINK_TOLERANCE * max(map(abs, table.positions)):
                raise MechanismError(
                    f"the steady state, {table.reading} = {value:.6g}, is at a kink of a table, where it has no derivative; move its point"
                )
        return tuple(notes)

"""From poses and velocities to a Trajectory: readings, rates, energies, joint gaps. The same for every engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import Mode, energy_on, springs_of
from governor_mechanism.mechanics.dynamics.force_elements import potential as spring_potential
from governor_mechanism.mechanics.dynamics.force_laws import (
    free_spindle_speed,
    height_energy,
    spindle_inertia,
    spindle_inertia_rate,
)
from governor_mechanism.mechanics.kinematics.assembly import Assembler, assembly_notes
from governor_mechanism.mechanics.kinematics.constraint_equations import JointEquations
from governor_mechanism.mechanics.kinematics.output_variables import measure, reading_value
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram, TimeCurve
from governor_mechanism.model.events import Event
from governor_mechanism.model.force_elements import Spring, TorsionSpring
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.mechanism import LineAngle, Mechanism
from governor_mechanism.model.scene import TURNING, FreeSpindle, Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.model.trajectory import Cost, Energy, Outcome, Trajectory
from governor_mechanism.observables.deferred import Stationed, Told
from governor_mechanism.observables.singular_configurations import Between
from governor_mechanism.observables.static_forces import outputs_of
from governor_mechanism.observables.work import work_between
from governor_mechanism.types import FloatArray, IntArray

UNITS = {"angle": "rad", "length": "m"}

SHARED = 1e-13
"""In units of the scales: two runs of one motion may agree to their last digits, and both be off by so much."""


@dataclass(frozen=True, kw_only=True)
class Report:
    """Readings, their rates and units by name; joint gaps; the energy ledger."""

    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    units: dict[str, str]
    joint_gap: FloatArray
    energy: Energy


@dataclass(frozen=True, kw_only=True)
class Finding:
    """What an engine has to tell: states at the reported times and at all its stations, how it ended, its errors."""

    state: State
    stations: State | Stationed
    report: Report
    outcome: Outcome
    detail: str
    estimate: float | None
    errors: dict[str, float]
    between: Between | None = None
    modes: tuple[Mode, ...] = ()
    reported: slice | IntArray | None = None
    happened: tuple[Event, ...] = ()
    excluded: int = 0


class Reporter:
    """Reads states of one scene that starts at poses `start` (bodies, 3); holds the scales of its accuracies."""

    def __init__(self, scene: Scene, start: FloatArray) -> None:
        self.scene = scene
        self._start = start
        self.mechanism: Mechanism = scene.part.mechanism
        self.program = SpeedProgram(scene.spindle)
        self._equations = JointEquations(self.mechanism)
        self.turning = scene.part.plane == TURNING
        self.loaded = self.turning and scene.centrifugal
        self.free = isinstance(scene.spindle, FreeSpindle)
        mass = sum(body.mass for body in self.mechanism.bodies)
        self.time_scale = time_scale(scene)
        self.energy_scale = mass * self.mechanism.size**2 / self.time_scale**2

    def scales(self) -> dict[str, float]:
        """1 rad or the machine's size for positions; mass, size and time scale for what the spindle does."""
        by_quantity = {"angle": 1.0, "length": self.mechanism.size}
        scales = {reading.name: by_quantity[reading.quantity] for reading in self.mechanism.readings}
        scales |= {output.name: self.energy_scale / self.mechanism.size for output in self.mechanism.outputs}
        if self.turning:
            scales["spindle_speed"] = 1.0 / self.time_scale
        if self.free:
            scales["spindle_angle"] = 1.0
        elif self.loaded:
            scales["spindle_torque"] = self.energy_scale
        return scales

    def report(self, state: State) -> Report:
        """Everything that is read off n states."""
        readings, rates = self._positions(state)
        units = {reading.name: UNITS[reading.quantity] for reading in self.mechanism.readings}
        readings |= outputs_of(self.scene, state.poses)
        units |= {output.name: "N" for output in self.mechanism.outputs}
        if self.turning:
            readings["spindle_speed"], units["spindle_speed"] = state.spindle[:, 1], "rad/s"
        if self.free:
            readings["spindle_angle"], units["spindle_angle"] = state.spindle[:, 0], "rad"
        elif self.loaded:
            readings["spindle_torque"], units["spindle_torque"] = self._torque(state), "N m"
        return Report(
            readings=readings,
            rates=rates,
            units=units,
            joint_gap=self.gap(state.poses, state.times),
            energy=self._energy(state),
        )

    def trajectory(self, found: Finding, *, cost: Cost, settings: dict[str, Any]) -> Trajectory:
        """The result of a run; joint forces and events wait in it until they are asked for."""
        state, stations, report = found.state, found.stations, found.report
        assembler = Assembler(self.mechanism)
        mobility = assembler.freedoms(state.poses[0]) if len(state.times) else assembler.mobility
        return Trajectory(
            scene=self.scene,
            times=state.times,
            poses=state.poses,
            velocities=state.velocities,
            readings=report.readings,
            rates=report.rates,
            units=report.units,
            scales=self.scales(),
            joint_gap=report.joint_gap,
            energy=report.energy,
            outcome=found.outcome,
            detail=found.detail,
            cost=cost,
            error_estimate=found.estimate,
            reading_errors=found.errors,
            settings=settings,
            mobility=mobility,
            notes=assembly_notes(self.scene),
            excluded=found.excluded,
            afterwards=Told(
                self.scene, state, stations, mobility, found.between, found.modes, found.reported, found.happened
            ),
        )

    def spindle_speeds(self, times: FloatArray, poses: FloatArray) -> FloatArray:
        """Speed (n,) rad/s of the spindle at times (n,) s and poses (n, bodies, 3)."""
        spindle = self.scene.spindle
        if not isinstance(spindle, FreeSpindle) or not len(times):
            return self.program(times)
        own = spindle.inertia
        start = (own + self.inertia(self._start[np.newaxis])[0]) * spindle.start_speed
        torque = TimeCurve(spindle.torque)
        momentum = start + np.array([torque.integral(0.0, float(time)) for time in times])
        speeds: FloatArray = free_spindle_speed(momentum, own + self.inertia(poses))
        return speeds

    def uncounted_work(self, stations: State) -> FloatArray | None:
        """What an engine that counts no work of drives, loads and a free spindle's torque has to add to State.work.

        (n,) J, found from their power between the stations; None where nothing does any.
        """
        drives = any(isinstance(joint, DrivenTurn | DrivenSlide) for joint in self.mechanism.joints)
        loads = any(not isinstance(load, Spring | TorsionSpring) for load in self.mechanism.loads)
        if not (drives or loads or self.free) or len(stations.times) < 2:
            return None
        return -work_between(self.scene, stations, self.spindle_speeds)

    def gap(self, poses: FloatArray, times: FloatArray) -> FloatArray:
        """Widest joint opening (...) m at times (...) s."""
        return self._equations.gap(poses, times)

    def errors(self, better: Report, worse: Report) -> dict[str, float]:
        """Largest difference of each reading, each rate (named 'rate of ...') and the joints, in SI."""
        found = {name: _largest(values, worse.readings[name]) for name, values in better.readings.items()}
        found |= {f"rate of {name}": _largest(values, worse.rates[name]) for name, values in better.rates.items()}
        found["joint_gap"] = float(np.max(better.joint_gap, initial=0.0))
        return found

    def relative(self, errors: dict[str, float]) -> float:
        """The largest of these errors in units of its scale; not less than rounding, which all runs share."""
        scales = self.scales()
        scales |= {f"rate of {name}": scale / self.time_scale for name, scale in scales.items()}
        scales["joint_gap"] = self.mechanism.size
        return max(SHARED, *(error / scales[name] for name, error in errors.items()))

    def first_outside(self, poses: FloatArray) -> tuple[int, str] | None:
        """Index of the first pose outside the mechanism's limits, and the sentence that says what happened."""
        found = []
        for limit in self.mechanism.limits:
            value = reading_value(self.mechanism, limit.reading, poses)
            for outside, sentence in ((~(value > limit.low), limit.below), (~(value < limit.high), limit.above)):
                if outside.any():
                    found.append((int(np.argmax(outside)), f"{limit.reading}: {sentence}"))
        return min(found) if found else None

    def _positions(self, state: State) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        readings, rates = {}, {}
        for reading in self.mechanism.readings:
            found = measure(self.mechanism, reading.name, state.poses)
            wraps = isinstance(reading, LineAngle)  # the angle of a body is counted on
            readings[reading.name] = np.unwrap(found.value) if wraps else found.value
            rates[reading.name] = np.sum(found.gradient * state.velocities, axis=(-2, -1))
        return readings, rates

    def _torque(self, state: State) -> FloatArray:
        """The drive's torque at a given speed: the rate of the parts' angular momentum, d(J omega)/dt."""
        speed, slope = self.program(state.times), self.program.slope(state.times)
        rate = np.zeros_like(speed)
        for index, body in enumerate(self.mechanism.bodies):
            pose, velocity = state.poses[:, index], state.velocities[:, index]
            rate += spindle_inertia_rate(
                body.mass, *body.moments.in_plane, pose[:, 0], pose[:, 2], velocity[:, 0], velocity[:, 2]
            )
        torque: FloatArray = rate * speed + self.inertia(state.poses) * slope
        return torque

    def inertia(self, poses: FloatArray) -> FloatArray:
        """J (n,) kg m2 of all bodies about the spindle."""
        total: FloatArray = sum(
            (
                spindle_inertia(
                    body.mass, *body.moments.in_plane, body.moments.zz, poses[:, index, 0], poses[:, index, 2]
                )
                for index, body in enumerate(self.mechanism.bodies)
            ),
            np.zeros(len(poses)),
        )
        return total

    def _energy(self, state: State) -> Energy:
        kinetic, potential = np.zeros(len(state.times)), np.zeros(len(state.times))
        for index, body in enumerate(self.mechanism.bodies):
            velocity = state.velocities[:, index]
            kinetic += 0.5 * body.mass * np.sum(velocity[:, :2] ** 2, axis=1)
            kinetic += 0.5 * (body.moments.xx + body.moments.yy) * velocity[:, 2] ** 2
            potential += height_energy(body.mass, self.scene.gravity, state.poses[:, index, 1])
        potential += spring_potential(self.mechanism, state.poses)
        for spring in springs_of(self.scene):
            potential += energy_on(spring, reading_value(self.mechanism, spring.reading, state.poses))
        rotation = np.zeros_like(kinetic)
        if self.loaded:
            own = self.scene.spindle.inertia if isinstance(self.scene.spindle, FreeSpindle) else 0.0
            rotation = 0.5 * (own + self.inertia(state.poses)) * state.spindle[:, 1] ** 2
        return Energy(
            kinetic=kinetic,
            potential=potential,
            rotation=rotation,
            jacobi=kinetic + potential + (rotation if self.free else -rotation) + state.work,
            dissipated=state.lost,
            scale=self.energy_scale,
        )


def _largest(first: FloatArray, second: FloatArray) -> float:
    return float(np.max(np.abs(first - second), initial=0.0))

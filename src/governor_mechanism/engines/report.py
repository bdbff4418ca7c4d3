"""From poses and velocities to a Trajectory: readings, rates, energies, joint gaps. The same for every engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.equations.constraints import JointEquations
from governor_mechanism.equations.forces import height_energy, spindle_inertia, spindle_inertia_rate
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import reading_gradient, reading_value
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.scene import TURNING, Scene
from governor_mechanism.speed import SpeedProgram
from governor_mechanism.trajectory import Energy

UNITS = {"angle": "rad", "length": "m"}


@dataclass(frozen=True, kw_only=True)
class State:
    """What an engine found at n times: poses and velocities (n, bodies, 3), work (n,) J of the speed's changes."""

    times: Array
    poses: Array
    velocities: Array
    work: Array


@dataclass(frozen=True, kw_only=True)
class Report:
    """Readings, their rates and units by name; joint gaps; the energy ledger."""

    readings: dict[str, Array]
    rates: dict[str, Array]
    units: dict[str, str]
    joint_gap: Array
    energy: Energy


class Reporter:
    """Reads states of one scene; holds the scales that accuracies refer to."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanism: Mechanism = scene.part.mechanism
        self.program = SpeedProgram(scene.spindle)
        self._equations = JointEquations(self.mechanism)
        self.turning = scene.part.plane == TURNING
        self.loaded = self.turning and scene.centrifugal
        mass = sum(body.mass for body in self.mechanism.bodies)
        self.time_scale = time_scale(scene)
        self.energy_scale = mass * self.mechanism.size**2 / self.time_scale**2

    def scales(self) -> dict[str, float]:
        """1 rad or the machine's size for positions; mass, size and time scale for what the spindle does."""
        by_quantity = {"angle": 1.0, "length": self.mechanism.size}
        scales = {reading.name: by_quantity[reading.quantity] for reading in self.mechanism.readings}
        if self.turning:
            scales["spindle_speed"] = 1.0 / self.time_scale
        if self.loaded:
            scales["spindle_torque"] = self.energy_scale
        return scales

    def report(self, state: State) -> Report:
        """Everything that is read off n states."""
        readings, rates = self._positions(state)
        units = {reading.name: UNITS[reading.quantity] for reading in self.mechanism.readings}
        if self.turning:
            readings["spindle_speed"], units["spindle_speed"] = self.program(state.times), "rad/s"
        if self.loaded:
            readings["spindle_torque"], units["spindle_torque"] = self._torque(state), "N m"
        return Report(
            readings=readings, rates=rates, units=units, joint_gap=self.gap(state.poses), energy=self._energy(state)
        )

    def gap(self, poses: Array) -> Array:
        """Widest joint opening (...) m."""
        return self._equations.gap(poses)

    def errors(self, better: Report, worse: Report) -> dict[str, float]:
        """Largest difference of each reading, each rate (named 'rate of ...') and the joints, in SI."""
        found = {name: _largest(values, worse.readings[name]) for name, values in better.readings.items()}
        found |= {f"rate of {name}": _largest(values, worse.rates[name]) for name, values in better.rates.items()}
        found["joint_gap"] = float(np.max(better.joint_gap, initial=0.0))
        return found

    def relative(self, errors: dict[str, float]) -> float:
        """The largest of these errors in units of its scale."""
        scales = self.scales()
        scales |= {f"rate of {name}": scale / self.time_scale for name, scale in scales.items()}
        scales["joint_gap"] = self.mechanism.size
        return max(error / scales[name] for name, error in errors.items())

    def first_outside(self, poses: Array) -> tuple[int, str] | None:
        """Index of the first pose outside the mechanism's limits, and the sentence that says what happened."""
        found = []
        for limit in self.mechanism.limits:
            value = reading_value(self.mechanism, limit.reading, poses)
            for outside, sentence in ((~(value > limit.low), limit.below), (~(value < limit.high), limit.above)):
                if outside.any():
                    found.append((int(np.argmax(outside)), f"{limit.reading}: {sentence}"))
        return min(found) if found else None

    def _positions(self, state: State) -> tuple[dict[str, Array], dict[str, Array]]:
        readings, rates = {}, {}
        for reading in self.mechanism.readings:
            value = reading_value(self.mechanism, reading.name, state.poses)
            readings[reading.name] = np.unwrap(value) if reading.quantity == "angle" else value
            gradient = reading_gradient(self.mechanism, reading.name, state.poses)
            rates[reading.name] = np.sum(gradient * state.velocities, axis=(-2, -1))
        return readings, rates

    def _torque(self, state: State) -> Array:
        """The drive's torque at a given speed: the rate of the parts' angular momentum, d(J omega)/dt."""
        speed, slope = self.program(state.times), self.program.slope(state.times)
        rate = np.zeros_like(speed)
        for index, body in enumerate(self.mechanism.bodies):
            pose, velocity = state.poses[:, index], state.velocities[:, index]
            rate += spindle_inertia_rate(
                body.mass, *body.moments.in_plane, pose[:, 0], pose[:, 2], velocity[:, 0], velocity[:, 2]
            )
        torque: Array = rate * speed + self._inertia(state.poses) * slope
        return torque

    def _inertia(self, poses: Array) -> Array:
        total: Array = sum(
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
        turning = self.turning and self.scene.centrifugal
        rotation = (
            0.5 * self._inertia(state.poses) * self.program(state.times) ** 2 if turning else np.zeros_like(kinetic)
        )
        return Energy(
            kinetic=kinetic,
            potential=potential,
            rotation=rotation,
            jacobi=kinetic + potential - rotation + state.work,
            scale=self.energy_scale,
        )


def time_scale(scene: Scene) -> float:
    """The time (s) in which the scene's motion changes: one radian of the fastest spindle speed, or a free fall."""
    fastest = max(abs(speed) for speed in scene.spindle.speeds)
    size = scene.part.mechanism.size
    fall = float(np.sqrt(size / scene.gravity)) if scene.gravity else np.inf
    start = max((abs(rate) for rate in scene.start.rates.values()), default=0.0)
    candidates = [fall, 1 / fastest if fastest and scene.centrifugal else np.inf, 1 / start if start else np.inf]
    return min(candidates) if min(candidates) < np.inf else 1.0


def _largest(first: Array, second: Array) -> float:
    return float(np.max(np.abs(first - second), initial=0.0))

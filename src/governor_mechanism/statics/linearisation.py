"""Linearised equations of a scene about an equilibrium or the steady rotation near its start: eigenvalues, modes, inputs and outputs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Generic, Self, TypeVar

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_output_value
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import directional_derivative, jacobian
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import has_spindle_dependent_loads
from governor_mechanism.statics.first_order_system import ComplexArray, FirstOrderSystem, Mode, Onset, Stability, format_rate, mode_columns
from governor_mechanism.statics.scene_dynamics import SceneDynamics
from governor_mechanism.statics.steady_state import NO_STEADY_STATE, SteadyState, settle
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_reading_name, format_value, parse_quantity
from governor_mechanism.units.text_table import short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class StateSpace:
    """State-space form x' = A x + B u, y = C x + D u with the names of states, inputs u and outputs y. All in SI."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    __repr__ = short_repr

    def frequency_response(
        self,
        frequencies: Sequence[float] | FloatArray,  # angular frequencies, rad/s; shape (n,)
    ) -> ComplexArray:
        """Return the complex amplitudes of the outputs for unit amplitudes of the inputs; shape (n, outputs, inputs)."""
        try:
            columns = np.array([np.linalg.solve(1j * float(w) * np.eye(len(self.A)) - self.A, self.B) for w in frequencies])
        except np.linalg.LinAlgError as error:
            raise MechanismError(
                "a frequency is that of an undamped mode, where the response is infinite; take another frequency"
            ) from error
        response: ComplexArray = self.C @ columns.reshape(-1, *self.B.shape) + self.D
        return response


RATE_PREFIX = "rate of "
"""Start of the name of an output that is the rate of a reading."""

FORCE_PREFIX = "force on "
"""Start of the name of an input that is a force or torque along a reading."""

OUTPUT_TOLERANCE = 1e-12
"""Relative accuracy of the derivatives of the rates of readings that turn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearisation(FirstOrderSystem, Result):
    """Linearised equations of a scene about a steady state, in first-order form.

    Attributes
    ----------
    readings
        Readings in the steady state, SI; without those that turn steadily.
    rates
        Rates of the readings that turn steadily, and the speed of a free spindle, SI/s.
    state_names
        Names of the states: positions of bodies, their rates, and speeds of cyclic coordinates.
    notes
        What is left out, one sentence each.
    """

    readings: Mapping[str, float]
    rates: Mapping[str, float]
    state_names: tuple[str, ...]
    notes: tuple[str, ...]
    _dynamics: SceneDynamics = field(repr=False)
    _state: SteadyState = field(repr=False)

    __repr__ = short_repr

    derived = ("stability", "stable", "error_estimate", "matrix", "eigenvalues", "modes")

    @property
    def columns(self) -> tuple[Column, ...]:
        """What is stated of each mode."""
        return mode_columns(self._amplitude_scales())

    @property
    def rows(self) -> tuple[Mode, ...]:
        """The modes, which are the rows of tables."""
        return self.modes

    def __str__(self) -> str:
        """Return the steady state and its stability, a table of the modes, and the notes."""
        units = {reading.name: READING_UNITS[reading.quantity] for reading in self._dynamics.scene.mechanism.readings}
        state = [f"{format_reading_name(name)} {format_quantity(value, units[name])}" for name, value in self.readings.items()]
        state += [format_rate(name, value, units.get(name, "rad")) for name, value in self.rates.items()]
        return "\n".join([f"{', '.join(state)}: {self.stability}", format_columns(self.columns, self.rows), *self.notes])

    @property
    def stable(self) -> bool:
        """Whether all small motions decay."""
        return self.stability is Stability.STABLE

    @property
    def error_estimate(self) -> float:
        """Largest estimated error of an eigenvalue, 1/s."""
        return float(np.max(self.errors))

    @cached_property
    def onset(self) -> Onset:
        """How self-excited oscillations begin, at a limit of stability."""
        return Onset.UNKNOWN if any("quadratic" in note for note in self.notes) else super().onset

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Modes in descending order of the growth rate."""
        scales = self._amplitude_scales()
        modes = []
        for value, vector, error, growth_rate, is_conserved in zip(
            self.eigenvalues, self.eigenvectors.T, self.errors, self.growth_rates, self.is_conserved, strict=True
        ):
            if value.imag < 0.0:
                continue  # the conjugate of the one before
            amplitudes = {name: complex(self._output_rows[name] @ vector) for name in scales}
            largest = max(amplitudes, key=lambda name: abs(amplitudes[name]) / scales[name], default=None)
            factor = amplitudes[largest] / scales[largest] if largest and amplitudes[largest] else 1.0
            modes.append(
                Mode(
                    eigenvalue=complex(value),
                    error_estimate=float(error),
                    natural_frequency=float(abs(value)),
                    damping_ratio=float(-growth_rate / abs(value)) if growth_rate else 0.0,
                    amplitudes={name: amplitude / factor for name, amplitude in amplitudes.items()},
                    is_conserved=bool(is_conserved),
                )
            )
        return tuple(modes)

    def _amplitude_scales(self) -> dict[str, float]:
        """Return the scales of the outputs whose amplitudes describe a mode: readings, and the rates of those that turn."""
        dynamics = self._dynamics
        scales = {name: dynamics.reading_scale(name) for name in dynamics.reading_names}
        shown = {name: scale for name, scale in scales.items() if name not in self.rates}
        shown |= {f"{RATE_PREFIX}{name}": scale / dynamics.time_scale for name, scale in scales.items() if name in self.rates}
        return shown | dict.fromkeys(dynamics.spindle_speed_rows(), 1 / dynamics.time_scale)

    @cached_property
    def _output_rows(self) -> dict[str, FloatArray]:
        """Derivatives of all outputs with respect to the state, by name of output."""
        dynamics = self._dynamics
        state = self._state
        m = len(self._state.positions)
        reading_jacobian = dynamics.reading_jacobian(state.z)

        def reading_rates(displacements: FloatArray) -> FloatArray:
            moved = state.expand(np.array([np.append(self.scales[:m] * one, self.state[m:]) for one in displacements]))
            return np.array([dynamics.reading_jacobian(z) @ rates for z, rates in zip(*moved, strict=True)])

        by_position = jacobian(reading_rates, np.zeros(m), np.ones(m), tolerance=OUTPUT_TOLERANCE)[0] / self.scales[:m]
        value_rows = np.hstack([reading_jacobian[:, state.positions], np.zeros((len(reading_jacobian), len(self.state) - m))])
        rate_rows = np.hstack([by_position, reading_jacobian @ state.basis])
        rows = {name: row for name, row in zip(dynamics.reading_names, value_rows, strict=True) if name not in self.rates}
        rows |= {f"{RATE_PREFIX}{name}": row for name, row in zip(dynamics.reading_names, rate_rows, strict=True)}
        return rows | {name: np.append(np.zeros(m), row @ state.basis) for name, row in dynamics.spindle_speed_rows().items()}

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of all inputs."""
        return (*self._dynamics.input_indices, *(f"{FORCE_PREFIX}{name}" for name in self._dynamics.reading_names))

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of all outputs: readings, their rates, and the speed of a free spindle."""
        return tuple(self._output_rows)

    def state_space(self, inputs: Sequence[str], outputs: Sequence[str]) -> StateSpace:
        """Return the state-space form for chosen inputs and outputs.

        Parameters
        ----------
        inputs
            Names from `input_names`: "spindle_speed" if it is given, "spindle_torque" of a free spindle, torques by name,
            components of forces as "name.x", and "force on" a reading.
        outputs
            Names from `output_names`: readings, "rate of" a reading, "spindle_speed" if the spindle is free.

        Returns
        -------
        StateSpace
            The matrices.

        Raises
        ------
        MechanismError
            If a name is unknown.
        """
        for argument, names in (("inputs", inputs), ("outputs", outputs)):
            if not isinstance(names, list | tuple):
                raise MechanismError(f"{argument} must be a list of names; found {format_value(names)}")
        for name, known, noun in [(n, self.input_names, "input") for n in inputs] + [(n, self.output_names, "output") for n in outputs]:
            if name not in known:
                raise MechanismError(f"no {noun} {name!r}; {noun}s are {list(known)}.{did_you_mean(name, known)}")
        m, n_states = len(self._state.positions), len(self.state_names)
        inverse_basis = np.linalg.inv(self._state.basis)
        columns = [np.append(np.zeros(m), inverse_basis @ self._acceleration_by(name)) for name in inputs]
        return StateSpace(
            A=self.matrix,
            B=np.array(columns).reshape(-1, n_states).T,
            C=np.array([self._output_rows[name] for name in outputs]).reshape(-1, n_states),
            D=np.zeros((len(outputs), len(inputs))),
            states=self.state_names,
            inputs=tuple(inputs),
            outputs=tuple(outputs),
        )

    def _acceleration_by(self, name: str) -> FloatArray:
        """Return the accelerations (n,) of the coordinates by a unit of an input."""
        z = self._state.z
        rates = self._state.rates
        dynamics = self._dynamics
        if name.startswith(FORCE_PREFIX):
            column: FloatArray = dynamics.force_columns(z)[:, dynamics.reading_names.index(name.removeprefix(FORCE_PREFIX))]
            return column
        index = dynamics.input_indices[name]

        def accelerations(changes: FloatArray) -> FloatArray:
            return np.array([dynamics.accelerations(z[np.newaxis], rates[np.newaxis], {index: float(one)})[0] for one in changes[:, 0]])

        return directional_derivative(accelerations, np.zeros(1), np.ones(1))[0]


TURNING_TOLERANCE = 1e-9
"""Rate of a reading, in its scale over the time scale, above which it turns steadily."""


def linearise_scene(
    scene: Scene,
    poses: FloatArray,  # assembled poses near the steady state; shape (bodies, 3)
    # their time derivatives, of which those of steadily turning shafts matter; shape (bodies, 3)
    velocities: FloatArray,
    # speed of the spindle, rad/s, or text with a unit; that of the scene if None
    spindle_speed: float | str | None = None,
) -> Linearisation:
    """Linearise a scene about the steady state near given poses.

    Inputs that vary with time have their last value.

    Result: linearised equations, eigenvalues and modes. Raises MechanismError if there is no steady state
    near the start, it is periodic, or it has no linear equations.
    """
    if spindle_speed is not None:
        speed = parse_quantity(spindle_speed, "angular_speed", "the spindle's speed")
        spindle = scene.spindle
        given = replace(spindle, start_speed=speed) if isinstance(spindle, FreeSpindle) else Spindle(speeds=(speed,))
        scene = scene.with_changes(spindle=given)
    dynamics, state = settle(scene, poses, velocities)
    dynamics.move_reference(state.z)
    notes = dynamics.notes(state.z, state.rates)
    if dynamics.drop_quadratic_damping(state.z, state.rates):
        notes += ("quadratic damping has no effect on small motions about rest",)
    return _build_linearisation(dynamics, state, notes)


def linearise_from_start(
    scene: Scene,
    poses: FloatArray,  # initial poses; shape (bodies, 3)
    velocities: FloatArray,  # initial velocities; shape (bodies, 3)
    # speed of the spindle, rad/s, or text with a unit; the last of the scene if None
    spindle_speed: float | str | None = None,
) -> Linearisation:
    """Linearise a scene as `linearise_scene` does, about the equilibrium nearest to the start if it has one degree of freedom."""
    if len(scene.parts) > 1:
        return linearise_scene(scene, poses, velocities, spindle_speed)
    speed = last_spindle_speed(scene) if spindle_speed is None else spindle_speed
    try:
        equilibria = find_equilibria(scene, speed)
    except MechanismError as error:  # there is none, or more degrees of freedom, or an unknown travel
        try:
            return linearise_scene(scene, poses, velocities, spindle_speed)
        except MechanismError as other_error:
            is_general = any(one.startswith(NO_STEADY_STATE) for one in other_error.problems)
            earlier_problems = error.problems if is_general else ()
            raise MechanismError(*earlier_problems, *other_error.problems) from None
    start = float(evaluate_output_value(scene.part.mechanism, scene.part.mechanism.coordinate, poses))
    return linearise_scene(scene, poses_at(scene, min(equilibria, key=lambda one: abs(one.coordinate - start))), velocities, spindle_speed)


def poses_at(scene: Scene, equilibrium: Equilibrium) -> FloatArray:
    """Return the poses (bodies, 3) of all bodies of a scene at an equilibrium of its part, with the shaft of a free spindle."""
    return np.concatenate([equilibrium.poses, np.zeros((len(scene.mechanism.bodies) - len(scene.part.mechanism.bodies), 3))])


def last_spindle_speed(scene: Scene) -> float | None:
    """Return the last given speed of the spindle, rad/s; None for a free spindle, or if the loads do not depend on it."""
    return scene.spindle.speeds[-1] if isinstance(scene.spindle, Spindle) and has_spindle_dependent_loads(scene) else None


def _build_linearisation(dynamics: SceneDynamics, state: SteadyState, notes: tuple[str, ...]) -> Linearisation:
    values = dynamics.readings(state.z)
    reading_rates = dynamics.reading_jacobian(state.z) @ state.rates
    readings, rates = {}, {}
    for name, value, rate in zip(dynamics.reading_names, values, reading_rates, strict=True):
        if abs(rate) * dynamics.time_scale > TURNING_TOLERANCE * dynamics.reading_scale(name):
            rates[name] = float(rate)
        else:
            readings[name] = float(value)
    rates |= {name: float(row @ state.rates) for name, row in dynamics.spindle_speed_rows().items()}
    positions = [dynamics.names[k] for k in state.positions]
    cyclic = [" + ".join(dynamics.names[k] for k in np.flatnonzero(direction)) for direction in state.cyclic.T]
    linearisation = Linearisation(
        **vars(state.first_order_system),
        readings=readings,
        rates=rates,
        state_names=(*positions, *(f"{RATE_PREFIX}{name}" for name in [*positions, *cyclic])),
        notes=notes,
        _dynamics=dynamics,
        _state=state,
    )
    if not np.all(np.isfinite(linearisation.matrix)):
        raise MechanismError("the steady state is a singular configuration, about which the mechanism cannot move freely")
    return linearisation


RELATIVE_TOLERANCE = 1e-12
"""Tolerance of the value at the limit, relative to the ends of its range."""


_ONSET_MEANINGS = {
    Onset.SOFT: "soft (their amplitude grows from zero)",
    Onset.HARD: "hard (large disturbances lead to large oscillations on the stable side too)",
    Onset.UNKNOWN: "not determined",
}
"""What each onset of oscillations means."""

Linearised = TypeVar("Linearised", bound=FirstOrderSystem)


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityLimit(Result, Generic[Linearised]):
    """Limit of stability along one key of a scene.

    Attributes
    ----------
    key
        Key of the scene.
    unit
        Its SI unit.
    value
        Value at the limit, SI.
    frequency
        Frequency of the oscillation that begins there, rad/s; 0 if the motion diverges without oscillation.
    stable_below
        Whether the steady state is stable for smaller values.
    onset
        Whether the oscillations begin softly or hard.
    linearisation
        Linearised equations at the limit.
    """

    key: str
    unit: str
    value: float
    frequency: float
    stable_below: bool
    onset: Onset
    linearisation: Linearised

    __repr__ = short_repr

    columns = (Column("key"), Column("value"), Column("unit"), Column("frequency", unit="rad/s"), Column("stable_below"), Column("onset"))

    @property
    def rows(self) -> tuple[Self, ...]:
        """The limit, which is the row of tables."""
        return (self,)

    def __str__(self) -> str:
        """Return the limit in a sentence, and the linearised equations there."""
        return f"{self.sentence}\n{self.linearisation}"

    @property
    def sentence(self) -> str:
        """On which side of the limit the steady state is stable, and what begins there."""
        value = f"{self.value:.10g} {self.unit}".strip()
        start = f"{self.key}: stable {'below' if self.stable_below else 'above'} {value}"
        if not self.frequency:
            return f"{start}; at the limit the motion diverges without oscillation"
        return f"{start}; oscillations of {self.frequency:.6g} rad/s begin there, onset {_ONSET_MEANINGS[self.onset]}"


def find_stability_limit(
    linearise_at: Callable[[float], Linearised],
    low: float,  # one end of the range, SI
    high: float,  # the other end, SI
    *,
    key: str,
    unit: str,  # its SI unit
) -> StabilityLimit[Linearised]:
    """Return the limit of stability between two values of a parameter."""
    from scipy.optimize import brentq  # slow to import

    linearise_at = cache(linearise_at)

    def growth_rate(value: float) -> float:
        """Return the largest real part, also if it is within its error."""
        try:
            linearisation = linearise_at(value)
        except MechanismError as error:
            raise MechanismError(*(f"{key} = {value:.6g} {unit}".strip() + f": {problem}" for problem in error.problems)) from error
        return linearisation.critical_real_part

    ends = {value: linearise_at(value) for value in (low, high)}
    rates = [end.growth_rate for end in ends.values()]
    if not rates[0] * rates[1] < 0.0:
        states = " and ".join(
            f"{end.stability} at {value:.6g} {unit}".strip() + f" (largest real part {end.growth_rate:.6g} 1/s)"
            for value, end in ends.items()
        )
        raise MechanismError(
            f"no limit of stability lies between the ends of {key}: it is {states}; give ends that are stable and unstable"
        )
    value = float(brentq(growth_rate, low, high, xtol=RELATIVE_TOLERANCE * max(abs(low), abs(high)), rtol=RELATIVE_TOLERANCE))
    linearisation = linearise_at(value)
    return StabilityLimit(
        key=key,
        unit=unit,
        value=value,
        frequency=linearisation.critical_frequency,
        stable_below=(rates[0] < 0.0) == (low < high),
        onset=linearisation.onset,
        linearisation=linearisation,
    )

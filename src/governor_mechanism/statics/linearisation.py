"""Linearised equations of a scene about an equilibrium or a steady rotation: eigenvalues, modes, inputs and outputs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.results.result import Column, Result
from governor_mechanism.numerics.finite_differences import directional_derivative, jacobian
from governor_mechanism.statics.first_order_system import ComplexArray, FirstOrderSystem, Mode, Onset, Stability, format_modes, format_rate
from governor_mechanism.statics.scene_dynamics import SceneDynamics
from governor_mechanism.statics.steady_state import SteadyState
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_reading_name, format_value
from governor_mechanism.units.short_repr import short_repr


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
        """Return the complex amplitudes of the outputs for unit amplitudes of the inputs.

        Result: amplitudes, SI; shape (n, outputs, inputs). Raises MechanismError if a frequency is exactly
        that of an undamped mode.
        """
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
    columns = (
        Column("growth_rate", value="eigenvalue.real"),
        Column("frequency", value="eigenvalue.imag"),
        Column("error_estimate"),
        Column("natural_frequency"),
        Column("damping_ratio"),
        Column("is_conserved"),
    )

    @property
    def rows(self) -> tuple[Mode, ...]:
        """The modes, which are the rows of tables."""
        return self.modes

    def __str__(self) -> str:
        """Return the steady state and its stability, a table of the modes, and the notes."""
        units = {reading.name: READING_UNITS[reading.quantity] for reading in self._dynamics.scene.mechanism.readings}
        state = [f"{format_reading_name(name)} {format_quantity(value, units[name])}" for name, value in self.readings.items()]
        state += [format_rate(name, value, units.get(name, "rad")) for name, value in self.rates.items()]
        return "\n".join([f"{', '.join(state)}: {self.stability}", format_modes(self.modes), *self.notes])

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
        dynamics, state, m = self._dynamics, self._state, len(self._state.positions)
        reading_jacobian = dynamics.reading_jacobian(state.z)

        def reading_rates(displacement: FloatArray) -> FloatArray:
            z, rates = state.expand(np.concatenate([self.scales[:m] * displacement, self.state[m:]]))
            values: FloatArray = dynamics.reading_jacobian(z) @ rates
            return values

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
        z, rates, dynamics = self._state.z, self._state.rates, self._dynamics
        if name.startswith(FORCE_PREFIX):
            column: FloatArray = dynamics.force_columns(z)[:, dynamics.reading_names.index(name.removeprefix(FORCE_PREFIX))]
            return column
        index = dynamics.input_indices[name]

        def accelerations(change: FloatArray) -> FloatArray:
            return dynamics.accelerations(z, rates, {index: float(change[0])})

        return directional_derivative(accelerations, np.zeros(1), np.ones(1))[0]

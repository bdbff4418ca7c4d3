"""Eigenvalues, stability and onset of oscillations of any first-order system x' = f(x) at a steady state."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.results.result import Column
from governor_mechanism.numerics.roots import VectorFunction, directional_derivative, jacobian
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.quantities import format_reading_name
from governor_mechanism.units.text_table import short_repr


@dataclass(frozen=True, kw_only=True)
class Mode:
    """One mode of small motions: a real eigenvalue, or a pair of complex ones."""

    eigenvalue: complex  # eigenvalue, 1/s; that of a pair with positive imaginary part
    error_estimate: float  # estimated error of the eigenvalue, 1/s
    natural_frequency: float  # magnitude of the eigenvalue, rad/s
    damping_ratio: float  # damping ratio: 0 undamped, 1 a real negative eigenvalue, negative if the motion grows
    # complex amplitude by output, SI; the largest in units of its scale is 1. A reading that turns steadily
    # has that of its rate.
    amplitudes: Mapping[str, complex]
    # whether this is the zero eigenvalue of a conserved quantity, such as the momentum of a free spindle
    is_conserved: bool = False

    __repr__ = short_repr


def mode_columns(
    outputs: Iterable[str],  # names of the outputs, whose amplitudes the text shows
) -> tuple[Column, ...]:
    """Return the columns of modes."""
    return (
        Column("growth_rate", "growth 1/s", _format_growth, "1/s", value="eigenvalue.real", side="r"),
        Column("frequency", "frequency rad/s", ".8g", "rad/s", value="eigenvalue.imag"),
        Column("damping_ratio", "damping ratio", _format_damping, side="r"),
        Column("error_estimate", "error 1/s", ".1g", "1/s"),
        *(Column("", format_reading_name(name), partial(_format_amplitude, name), side="r") for name in outputs),
        Column("natural_frequency", unit="rad/s"),
        Column("is_conserved"),
    )


def _format_growth(mode: Mode) -> str:
    """Return the rate of growth; 0 of an undamped motion, whose rate is rounding."""
    return f"{mode.eigenvalue.real:.6g}" if mode.damping_ratio else "0"


def _format_damping(mode: Mode) -> str:
    return "conserved" if mode.is_conserved else f"{mode.damping_ratio:.6g}"


def _format_amplitude(output: str, mode: Mode) -> str:
    """Return magnitude and phase, a real amplitude with its sign."""
    amplitude = mode.amplitudes[output]
    if abs(amplitude.imag) <= 1e-9 * abs(amplitude):
        return f"{amplitude.real:.4g}"
    return f"{abs(amplitude):.4g} at {math.degrees(math.atan2(amplitude.imag, amplitude.real)):.4g} deg"


def format_rate(
    name: str,
    value: float,  # rate, SI
    unit: str,
) -> str:
    """Return the steady rate of a reading as text, as "spindle speed 10.3 rad/s"."""
    title = format_reading_name(name) if name.endswith("speed") else f"rate of {format_reading_name(name)}"
    return f"{title} {value:.6g} {unit}/s"


ComplexArray = NDArray[np.complexfloating]

ERROR_MARGIN = 10.0
"""Multiple of the estimated error of an eigenvalue within which its real part counts as zero."""

MIN_DAMPING_RATIO = 1e-11
"""Real part relative to the magnitude of the largest eigenvalue below which it is rounding."""


class Stability(StrEnum):
    """Stability of small motions about a steady state."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    UNDAMPED = "marginal: undamped"
    NEUTRAL = "marginal: neutral"


class Onset(StrEnum):
    """How self-excited oscillations begin where a steady state becomes unstable.

    Soft: their amplitude grows from zero. Hard: they appear at once with a large amplitude, also from a large disturbance
    of the stable side.
    """

    SOFT = "soft"
    HARD = "hard"
    UNKNOWN = "not determined"


@dataclass(frozen=True, eq=False)
class FirstOrderSystem:
    """A first-order system x' = f(x) at a steady state, where f vanishes."""

    derivative: VectorFunction = field(repr=False)  # the function f, of several states (k, n)
    state: FloatArray = field(repr=False)  # steady state; shape (n,)
    scales: FloatArray = field(repr=False)  # change of each component that changes the motion considerably; shape (n,)
    # number of quantities, such as momenta, that stay constant. Each brings an eigenvalue zero.
    n_conserved: int = field(default=0, repr=False)

    def _scaled_derivative(self, displacements: FloatArray) -> FloatArray:
        """Return f (k, n), for displacements (k, n) from the steady state, in units of the scales."""
        derivative: FloatArray = self.derivative(self.state + self.scales * displacements) / self.scales
        return derivative

    @cached_property
    def _scaled_jacobian(self) -> tuple[FloatArray, FloatArray]:
        """Jacobian in units of the scales, and the error of its columns."""
        return jacobian(self._scaled_derivative, np.zeros(len(self.state)), np.ones(len(self.state)))

    @property
    def matrix(self) -> FloatArray:
        """Jacobian of f at the steady state, SI; shape (n, n)."""
        matrix: FloatArray = self._scaled_jacobian[0] / self.scales * self.scales[:, np.newaxis]
        return matrix

    @cached_property
    def _eigensystem(self) -> tuple[ComplexArray, ComplexArray, ComplexArray, FloatArray]:
        """Eigenvalues (largest real part first, each with positive imaginary part before its conjugate), left and right vectors, errors."""
        from scipy.linalg import eig  # slow to import

        matrix, column_errors = self._scaled_jacobian
        values, left, right = eig(matrix, left=True)
        rounding = np.finfo(np.float64).eps * float(np.linalg.norm(matrix))
        left_size = np.linalg.norm(left, axis=0)
        right_size = np.abs(right).T @ column_errors
        products = np.abs(np.sum(left.conj() * right, axis=0))
        errors = (left_size * right_size + rounding * left_size * np.linalg.norm(right, axis=0)) / np.maximum(products, 1e-300)
        largest_error = np.sqrt(float(np.linalg.norm(column_errors)) + rounding) * np.sqrt(float(np.linalg.norm(matrix)) or 1.0)
        errors = np.minimum(errors, largest_error)
        order = np.lexsort((-values.imag, -np.abs(values.imag), -np.round(values.real / (np.max(np.abs(values)) or 1.0), 9)))
        return values[order], left[:, order], right[:, order], errors[order]

    @property
    def eigenvalues(self) -> ComplexArray:
        """Eigenvalues, 1/s, in descending order of the real part; shape (n,)."""
        return self._eigensystem[0]

    @property
    def eigenvectors(self) -> ComplexArray:
        """Right eigenvectors, in SI, one a column; shape (n, n)."""
        return self._eigensystem[2] * self.scales[:, np.newaxis]

    @property
    def errors(self) -> FloatArray:
        """Estimated errors of the eigenvalues, 1/s; shape (n,)."""
        return self._eigensystem[3]

    @cached_property
    def is_conserved(self) -> BoolArray:
        """Whether each eigenvalue is the zero of a conserved quantity, which does not concern stability; shape (n,)."""
        is_conserved = np.zeros(len(self.eigenvalues), dtype=np.bool_)
        is_conserved[np.argsort(np.abs(self.eigenvalues), kind="stable")[: self.n_conserved]] = True
        return is_conserved

    @property
    def growth_rates(self) -> FloatArray:
        """Real parts of the eigenvalues, zero if they are within their error; shape (n,)."""
        real = self.eigenvalues.real
        largest = float(np.max(np.abs(self.eigenvalues), initial=0.0))
        return np.where(np.abs(real) <= ERROR_MARGIN * self.errors + MIN_DAMPING_RATIO * largest, 0.0, real)

    @property
    def critical_index(self) -> int:
        """Index of the eigenvalue with the largest real part; conserved quantities excluded."""
        return int(np.argmax(np.where(self.is_conserved, -np.inf, self.eigenvalues.real)))

    @property
    def growth_rate(self) -> float:
        """Largest growth rate, 1/s; 0 if it is within its error."""
        return float(self.growth_rates[self.critical_index])

    @property
    def critical_real_part(self) -> float:
        """Largest real part of an eigenvalue, 1/s, with its error."""
        return float(self.eigenvalues[self.critical_index].real)

    @property
    def critical_frequency(self) -> float:
        """Frequency of the mode with the largest real part, rad/s; 0 if it does not oscillate."""
        return abs(float(self.eigenvalues[self.critical_index].imag))

    @property
    def stability(self) -> Stability:
        """Stability of small motions."""
        if np.all(self.is_conserved):
            return Stability.NEUTRAL
        rate = self.growth_rate
        if rate != 0.0:
            return Stability.UNSTABLE if rate > 0.0 else Stability.STABLE
        is_marginal = (self.growth_rates == 0.0) & ~self.is_conserved
        is_slow = np.abs(self.eigenvalues.imag) <= ERROR_MARGIN * self.errors
        return Stability.NEUTRAL if np.any(is_marginal & is_slow) else Stability.UNDAMPED

    def first_lyapunov_coefficient(self) -> float:
        """Return the first Lyapunov coefficient where a pair of eigenvalues crosses the imaginary axis.

        Its scale is that of the critical eigenvector, whose largest component is one scale; its sign does not depend on that.

        Returns
        -------
        float
            Coefficient, 1/s; negative if the onset is soft.

        References
        ----------
        Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed. (2004), equation (5.34).
        """
        _, left, right, _ = self._eigensystem
        index = self.critical_index
        frequency = self.critical_frequency
        q = right[:, index]
        matrix = self._scaled_jacobian[0]
        q = q / np.max(np.abs(q))
        p = left[:, index] / np.vdot(q, left[:, index])  # <p, q> = 1

        def derivative_along(direction: FloatArray, order: int) -> FloatArray:
            size = float(np.max(np.abs(direction)))
            unit_direction = direction / (size or 1.0)
            return size**order * directional_derivative(self._scaled_derivative, np.zeros(len(direction)), unit_direction, order)[0]

        def bilinear(u: ComplexArray, v: ComplexArray) -> ComplexArray:
            parts = [[derivative_along(a + b, 2) - derivative_along(a - b, 2) for b in (v.real, v.imag)] for a in (u.real, u.imag)]
            return 0.25 * (parts[0][0] - parts[1][1]) + 0.25j * (parts[0][1] + parts[1][0])

        a, b = q.real, q.imag
        sums = derivative_along(a + b, 3)
        differences = derivative_along(a - b, 3)
        third = [derivative_along(x, 3) for x in (a, b)]
        cubic = third[0] + (sums + differences - 2 * third[0]) / 6 + 1j * (third[1] + (sums - differences - 2 * third[1]) / 6)
        steady = bilinear(q, np.linalg.solve(matrix, bilinear(q, q.conj())))
        double = bilinear(q.conj(), np.linalg.solve(2j * frequency * np.eye(len(q)) - matrix, bilinear(q, q)))
        return float((np.vdot(p, cubic) - 2 * np.vdot(p, steady) + np.vdot(p, double)).real / (2 * frequency))

    @cached_property
    def onset(self) -> Onset:
        """Onset of oscillations if the critical eigenvalues are on the imaginary axis."""
        if self.n_conserved or self.critical_frequency == 0.0:
            return Onset.UNKNOWN
        coefficient = self.first_lyapunov_coefficient()
        return Onset.UNKNOWN if not np.isfinite(coefficient) or coefficient == 0.0 else Onset.SOFT if coefficient < 0.0 else Onset.HARD

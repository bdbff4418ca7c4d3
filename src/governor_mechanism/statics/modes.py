"""Modes of small motions, and their description as text."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from governor_mechanism.units.quantities import format_reading_name
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table


@dataclass(frozen=True, kw_only=True)
class Mode:
    """One mode of small motions: a real eigenvalue, or a pair of complex ones.

    Attributes
    ----------
    eigenvalue
        Eigenvalue, 1/s; that of a pair with positive imaginary part.
    error_estimate
        Estimated error of the eigenvalue, 1/s.
    natural_frequency
        Magnitude of the eigenvalue, rad/s.
    damping_ratio
        Damping ratio: 0 undamped, 1 a real negative eigenvalue, negative if the motion grows.
    amplitudes
        Complex amplitude by output, SI; the largest in units of its scale is 1. A reading that turns steadily has that of its rate.
    is_conserved
        Whether this is the zero eigenvalue of a conserved quantity, such as the momentum of a free spindle.
    """

    eigenvalue: complex
    error_estimate: float
    natural_frequency: float
    damping_ratio: float
    amplitudes: Mapping[str, complex]
    is_conserved: bool = False

    __repr__ = short_repr


def format_modes(
    modes: Sequence[Mode],  # at least one mode; all have amplitudes of the same outputs
) -> str:
    """Return modes as a table.

    Result: lines of text: growth, frequency, damping ratio, error, and the amplitude of each output.
    """
    outputs = list(modes[0].amplitudes)
    headers = ["growth 1/s", "frequency rad/s", "damping ratio", "error 1/s", *(format_reading_name(name) for name in outputs)]
    rows = [
        [
            f"{mode.eigenvalue.real:.6g}" if mode.damping_ratio else "0",
            f"{mode.eigenvalue.imag:.8g}",
            "conserved" if mode.is_conserved else f"{mode.damping_ratio:.6g}",
            f"{mode.error_estimate:.1g}",
            *(_format_amplitude(mode.amplitudes[name]) for name in outputs),
        ]
        for mode in modes
    ]
    return format_table(headers, rows, "r")


def format_rate(
    name: str,
    value: float,  # rate, SI
    unit: str,
) -> str:
    """Return the steady rate of a reading as text.

    Result: text such as "spindle speed 10.3 rad/s".
    """
    title = format_reading_name(name) if name.endswith("speed") else f"rate of {format_reading_name(name)}"
    return f"{title} {value:.6g} {unit}/s"


def _format_amplitude(amplitude: complex) -> str:
    """Return magnitude and phase, a real amplitude with its sign."""
    if abs(amplitude.imag) <= 1e-9 * abs(amplitude):
        return f"{amplitude.real:.4g}"
    return f"{abs(amplitude):.4g} at {math.degrees(math.atan2(amplitude.imag, amplitude.real)):.4g} deg"

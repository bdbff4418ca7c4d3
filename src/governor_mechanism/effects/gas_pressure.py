"""Force law of the gas on one face of a double-acting piston that a crank moves.

In a stroke the pressure follows an isotherm, pressure times volume constant, up to where a valve opens, and is constant from there on; or
it is constant up to the cut-off and follows the isotherm from there on. Each stroke is a half turn of the crank, and repeats the one
before in the other direction.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from governor_mechanism.model.effect import ForceLaw
from governor_mechanism.model.force_elements import CylinderGas

SWITCH_COEFFICIENT = 4
"""Index of the travel at which isotherm and constant pressure meet among the coefficients."""


def travel_in_stroke(coefficient: Any, travel: Any, crank_angle: Any) -> Any:
    """Return the travel of a piston since the last dead centre, relative to the stroke.

    Parameters
    ----------
    coefficient
        1 / stroke, 1/m.
    travel
        Travel of the piston, m.
    crank_angle
        Crank angle, rad.

    Returns
    -------
    Any
        Travel, 0 to 1.
    """
    is_return = np.floor(crank_angle / np.pi + 1e-12) % 2.0  # at a dead centre, but for rounding, the next stroke has begun
    return is_return + (1.0 - 2.0 * is_return) * coefficient * travel


def gas_phase(coefficients: Any, travel: Any, crank_angle: Any) -> Any:
    """Return the phase of the cycle of a gas: 0 in a forward stroke before the switch, 1 behind it; 2 and 3 in a return stroke.

    Parameters
    ----------
    coefficients
        Coefficients of the law.
    travel
        Travel of the piston, m.
    crank_angle
        Crank angle, rad.

    Returns
    -------
    Any
        Phase.
    """
    is_return = np.floor(crank_angle / np.pi + 1e-12) % 2.0
    relative_travel = is_return + (1.0 - 2.0 * is_return) * (1.0 / coefficients[7]) * travel  # as `travel_in_stroke`, to the bit
    return 2.0 * is_return + 1.0 * (relative_travel >= coefficients[SWITCH_COEFFICIENT])


class GasPressure(ForceLaw):
    """The gas on a piston, by its travel (m) and the crank angle (rad), both zero at the dead centre where the forward stroke begins.

    The coefficients are: area of the piston, m2, negative for a gas that resists the stroke; constant pressure, Pa; volume at the beginning
    of a stroke and its change over the stroke, 1 or -1, relative to the swept volume; travel, relative to the stroke, at which isotherm
    and constant pressure meet; 1 if the constant pressure comes first, else 0; pressure on the other face, Pa; stroke, m.
    """

    law_name = "gas in cylinders"
    dissipates = False

    @staticmethod
    def force(coefficients: Any, value: Any, rate: Any) -> Any:
        """Return the force along the travel, N. In place of the rate of the travel it takes the crank angle, on which the sense depends."""
        return GasPressure.force_in_phase(coefficients, value, gas_phase(coefficients, value, rate))

    @staticmethod
    def force_in_phase(coefficients: Any, value: Any, phase: Any) -> Any:
        """Return the force along the travel, N, of a phase of the cycle, smooth also outside of it, where a step may try more than that."""
        is_return = np.floor(0.5 * phase)
        sense, switch = 1.0 - 2.0 * is_return, coefficients[4]
        travel = is_return + sense * value / coefficients[7]
        is_before, begins_constant = 1.0 - (phase - 2.0 * is_return), coefficients[5]
        is_isothermal = is_before + begins_constant - 2.0 * is_before * begins_constant
        volume_at_switch = coefficients[2] + coefficients[3] * switch
        volume = volume_at_switch + is_isothermal * coefficients[3] * (travel - switch)
        return sense * coefficients[0] * (coefficients[1] * volume_at_switch / volume - coefficients[6])


def gas_pressure(coefficients: Any, travel: Any, crank_angle: Any) -> Any:
    """Return the absolute pressure of the gas, Pa; the arguments are those of `gas_work`."""
    _, *others, _, stroke = coefficients
    force = GasPressure.force((1.0, *others, 0.0, stroke), travel, crank_angle)
    return np.abs(force)


def gas_work(coefficients: Any, travel: Any, crank_angle: Any) -> Any:
    """Return the work of the gas since the crank angle zero, the integral of `GasPressure.force` along the travel.

    Parameters
    ----------
    coefficients
        Coefficients of the law.
    travel
        Travel of the piston, m.
    crank_angle
        Crank angle, rad.

    Returns
    -------
    Any
        Work, J.
    """
    _, _, _, _, _, _, _, stroke = coefficients
    n_strokes = np.floor(np.asarray(crank_angle) / np.pi + 1e-12)  # as for the force
    is_return = n_strokes % 2.0
    relative_travel = np.clip(is_return + (1.0 - 2.0 * is_return) * travel / stroke, 0.0, 1.0)
    return n_strokes * _work_in_stroke(coefficients, 1.0) + _work_in_stroke(coefficients, relative_travel)


def pressure_in_stroke(gas: CylinderGas, travel: Any) -> Any:
    """Return the absolute pressure of a gas in a forward stroke, Pa, at a travel relative to the stroke."""
    return gas_pressure(gas.coefficients, travel * gas.stroke, np.full_like(travel, 0.5 * np.pi))


def work_per_stroke(gases: Iterable[CylinderGas]) -> float:
    """Return the work of gases whose throttle and cut-off are at rest in a stroke.

    Parameters
    ----------
    gases
        Gas on the pistons of an engine.

    Returns
    -------
    float
        Work on the shaft, J.
    """
    openings = ((gas, 1.0 if gas.throttle is None else gas.throttle.values[0]) for gas in gases)
    return sum(opening * float(gas_work(gas.coefficients, gas.stroke, np.pi)) for gas, opening in openings)


def _work_in_stroke(coefficients: Any, travel: Any) -> Any:
    """Return the work (J) since the last dead centre at a travel relative to the stroke."""
    area, pressure, volume, change, switch, begins_constant, back_pressure, stroke = coefficients
    volume_at_switch = volume + change * switch
    if begins_constant:
        constant_travel = np.minimum(travel, switch)
        isothermal_start, isothermal_end = switch, np.maximum(travel, switch)
    else:
        constant_travel = np.maximum(travel - switch, 0.0)
        isothermal_start, isothermal_end = 0.0, np.minimum(travel, switch)
    ratio = change * (isothermal_end - isothermal_start) / (volume + change * isothermal_start)
    expansion = change * volume_at_switch * np.log1p(ratio)
    return area * stroke * (pressure * (constant_travel + expansion) - back_pressure * travel)

"""Readings of a run as figures and films show them: numbers, units and statements on accuracy as text."""

import math
import textwrap
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.machines.slider_crank import PORT_OPENINGS, VALVE_DISPLACEMENT
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.motion_readings import PathCoordinate
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import Valve
from governor_mechanism.observables.valve_motion import has_valve_events, valve_motion_of, valve_of
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import display_unit, format_value

_FIGURE_NAMES = {"rad": "°", "m/s2": "m/s²"}
"""Display units by SI unit whose names in figures are not those in texts."""

_GREEK_CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Phi", "Psi", "Omega")
GREEK_LETTERS = {unicodedata.name(chr(code)).split()[-1].lower().replace("lamda", "lambda"): chr(code) for code in range(0x3B1, 0x3CA)}
GREEK_LETTERS |= {name: GREEK_LETTERS[name.lower()].upper() for name in _GREEK_CAPITALS}
"""Greek letters by name; capitals only where they differ from Latin ones."""


def display_unit_of(si_unit: str) -> tuple[str, float]:
    """Return the display unit of an SI unit and the factor to it."""
    factor, name = display_unit(si_unit)
    return _FIGURE_NAMES.get(si_unit, name), factor


_MULTIPLES = (("M", 1e-6), ("k", 1e-3))
"""Prefixes of units and their factors, largest first."""
_PREFIXED_UNITS = ("N", "N m", "J", "W")
"""Units that get a prefix before their numbers have more than four digits."""


def choose_multiple(si_unit: str, values: FloatArray) -> tuple[str, float]:
    """Return the display unit for values in an SI unit and the factor to it: kN or MN where N would give more than four digits."""
    unit, factor = display_unit_of(si_unit)
    largest = float(np.max(np.abs(values), initial=0.0))
    for prefix, multiple in _MULTIPLES if unit in _PREFIXED_UNITS else ():
        if largest * multiple >= 10.0:
            return prefix + unit, multiple
    return unit, factor


def format_name(name: str) -> str:
    """Return the name of a reading, part or effect as words: "governor.arm_angle" as "governor arm angle", "beta" as "β"."""
    return " ".join(GREEK_LETTERS.get(word, word) for word in name.replace(".", " ").replace("_", " ").split(" "))


def format_label(name: str, unit: str) -> str:
    """Return the label of an axis: "governor.arm_angle" in "°" as "Governor arm angle [deg]"."""
    words = format_name(name)
    # A single letter, Greek or Latin, is a symbol, whose capital would be another one.
    start = words[:1] if words[1:2] in ("", " ") else words[:1].upper()
    return start + words[1:] + (f" [{unit.replace('°', 'deg')}]" if unit else "")


def choose_decimals(values: NDArray[np.float64]) -> int:
    """Return the number of decimals, at most 4, that divides the range of the values into some hundred steps."""
    largest = float(np.abs(values).max())
    span = float(np.ptp(values))
    if span < 1e-4 * largest:
        # Practically constant: noise must not add decimals.
        span = 0.1 * largest
    return min(max(math.ceil(2 - math.log10(max(span, 1e-9))), 0), 4)


def format_numbers(values: NDArray[np.float64], all_values: NDArray[np.float64] | None = None) -> list[str]:
    """Format values with equal decimals, which suit them or the values of which they are some; a rounded zero has no sign."""
    decimals = choose_decimals(values if all_values is None else all_values)
    return [f"{round(float(value), decimals) + 0.0:.{decimals}f}" for value in values]


def format_rounded_up(error: float) -> str:
    """Format an error with one digit, rounded up."""
    if not (error > 0 and math.isfinite(error)):
        return f"{error:.0e}"
    decade = 10.0 ** math.floor(math.log10(error))
    # The margin keeps a multiple such as 3e-07 from being rounded up because of its last bit.
    return f"{math.ceil(error / decade * (1 - 1e-9)) * decade:.0e}"


def format_film_speed(slow_down: float) -> str:
    """Return how much slower or faster a film is than the machine, or an empty string for true time."""
    if slow_down == 1.0:
        return ""
    return f"{slow_down:.4g} × slower than real" if slow_down > 1.0 else f"{1 / slow_down:.4g} × faster than real"


def format_closing_lines(run: Trajectory, width: int) -> tuple[list[str], bool]:
    """Return at most two lines of at most `width` characters on accuracy or early end, and whether that is a failure."""
    # The cause of an early end comes first and may fill both lines; the general sentence takes what is
    # left.
    if run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED:
        return _format_accuracy(run)
    lines = textwrap.wrap(run.detail or run.outcome.value, width, max_lines=2, placeholder=" …")
    if run.detail and len(lines) == 1:
        lines.append(textwrap.shorten(run.outcome.value, width, placeholder=" …"))
    return lines, True


def _format_accuracy(run: Trajectory) -> tuple[list[str], bool]:
    """Return the line on accuracy, and whether the requested one was missed."""
    requested = f"requested {run.settings.get('asked_accuracy', run.scene.run.accuracy):.0e}"
    if run.error_estimate is None:
        return [f"accuracy not certified ({requested})"], False
    is_missed = run.outcome is Outcome.ACCURACY_MISSED
    return [f"accurate {'only ' if is_missed else ''}to {format_rounded_up(run.error_estimate)}, {requested}"], is_missed


STEAM_PORTS = PORT_OPENINGS[0], PORT_OPENINGS[2]
"""Names of the openings of the steam ports of crank end and head end."""


class ValveReadings(NamedTuple):
    """Lengths (n,) m by name, and the name of the reading that they follow from, whose errors are theirs."""

    source: str
    values: dict[str, FloatArray]


def valve_reading_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of what a run of a scene shows of its valve beside its readings."""
    return (VALVE_DISPLACEMENT, *STEAM_PORTS) if has_valve_events(scene) else ()


def find_valve_readings(run: Trajectory) -> ValveReadings:
    """Return openings, negative where a port is closed, from the position of the valve, unless readings; nothing without a valve."""
    if not has_valve_events(run.scene) or VALVE_DISPLACEMENT in run.readings:
        return ValveReadings("", {})
    valve = valve_of(run.scene)
    centre = _centre_of(run, valve)
    if centre is None:
        return ValveReadings("", {})
    displacement = run.readings[valve.displacement] - centre
    openings = (side * valve.outward_sign * displacement - valve.steam_lap for side in (1.0, -1.0))
    values = {VALVE_DISPLACEMENT: displacement, **dict(zip(STEAM_PORTS, openings, strict=True))}
    return ValveReadings(valve.displacement, {name: one for name, one in values.items() if name not in run.readings})


def _centre_of(run: Trajectory, valve: Valve) -> float | None:
    """Return the reading of the valve in its centre, m; None if it depends on a turn that the crank cannot make."""
    if not isinstance(valve.centre, str):
        return valve.centre
    try:
        return valve_motion_of(run.scene).centre
    except MechanismError:
        return None


MAX_SHOWN_ANGLE = 4 * np.pi
"""Range of an angle (rad) beyond which a scene of several parts shows its rate."""


@dataclass(frozen=True, kw_only=True)
class ShownReading:
    """Values (n,) of a reading, SI, with their unit, the scale of relative errors and the error estimate; 0 if not known."""

    values: FloatArray
    unit: str
    scale: float
    error: float


_MAX_UNEVENNESS = math.radians(1.0)
"""Deviation (rad) of an angle from even rotation below which nobody sees it in the plot of a turn or more."""


def turns_evenly(times: FloatArray, values: FloatArray, unit: str) -> bool:
    """Return whether an angle makes a turn or more at a constant rate: its plot would be a straight line, as of any motor."""
    if unit != "rad" or np.ptp(values) < math.tau:
        return False
    even = np.interp(times, times[[0, -1]], values[[0, -1]])
    return bool(np.abs(values - even).max() < _MAX_UNEVENNESS)


def shown_readings(run: Trajectory) -> dict[str, ShownReading]:
    """Return the readings by name, openings of ports as a viewer expects them: zero while the port is closed."""
    # In a scene of several parts, rates stand for angles of many turns, which look like straight lines,
    # unless the rate is a reading anyway. Coordinates of points whose paths are requested are left out:
    # their paths are shown.
    shown, ports = {}, find_port_openings(run)
    of_paths = {one.name for one in run.scene.mechanism.derived_readings if isinstance(one, PathCoordinate)}
    for name, values in run.readings.items():
        if name in of_paths:
            continue
        unit = run.units.get(name, "")
        scale = run.scales.get(name, 0.0)
        error = run.reading_errors.get(name, 0.0)
        if len(run.scene.parts) > 1 and unit == "rad" and np.ptp(values) > MAX_SHOWN_ANGLE:
            if name.endswith(f".{SPINDLE_ANGLE}") or _is_rate_a_reading(run, name):  # the spindle speed is always one
                continue
            error, scale = run.reading_errors.get(f"rate of {name}", 0.0), 0.0
            values = run.rates[name]
            unit = "rad/s"
            name = _name_of_rate(name)
        elif name in ports:
            values = np.maximum(values, 0.0)
        shown[name] = ShownReading(values=values, unit=unit, scale=scale, error=error)
    for name, one in _valve_readings(run).items():
        shown[name] = replace(one, values=np.maximum(one.values, 0.0)) if name in STEAM_PORTS else one
    return shown


def _valve_readings(run: Trajectory) -> dict[str, ShownReading]:
    """Return what the position of the valve of any valve gear says, with the errors of its reading."""
    source, values = find_valve_readings(run)
    scale = run.scales.get(source, 0.0)
    error = run.reading_errors.get(source, 0.0) if values else 0.0
    return {name: ShownReading(values=one, unit="m", scale=scale, error=error) for name, one in values.items()}


def name_to_plot(run: Trajectory, name: str) -> str:
    """Return the name by which `chosen_readings` finds a shown reading: a rate that stands for an angle is "rate of ..."."""
    sources = (source for source in run.rates if _name_of_rate(source) == name)
    return name if name in run.readings or name in find_valve_readings(run).values else f"{RATE_START}{next(sources, name)}"


def _name_of_rate(name: str) -> str:
    """Return the name of the rate that stands for an angle."""
    return f"{name.removesuffix('_angle')}_rate"


def _is_rate_a_reading(run: Trajectory, name: str) -> bool:
    """Return whether another reading of the part is the rate of an angle, but for rounding."""
    part = name.rpartition(".")[0]
    rates = run.rates[name]
    others = [values for one, values in run.readings.items() if run.units.get(one) == "rad/s" and one.rpartition(".")[0] == part]
    return any(np.allclose(values, rates, rtol=1e-9, atol=0.0) for values in others)


def find_port_openings(run: Trajectory) -> set[str]:
    """Return the names of the readings that are openings of the ports of a slide valve; a negative value is an overlap."""
    machines = [(f"{part.name}." if len(run.scene.parts) > 1 else "", part.machine) for part in run.scene.parts]
    return {prefix + name for prefix, machine in machines if _has_ports(machine) for name in PORT_OPENINGS}


def _has_ports(machine: str) -> bool:
    """Return whether a slide valve opens the ports of a machine."""
    return machine in MACHINES and set(PORT_OPENINGS) <= set(MACHINES[machine].reading_meanings)


RATE_START = "rate of "
"""Start of the name of a rate."""


def chosen_readings(run: Trajectory, names: Sequence[str]) -> dict[str, ShownReading]:
    """Return readings of a run by name as they are, and rates by "rate of ...". Raise MechanismError for an unknown name."""
    known = {**run.readings, **{f"{RATE_START}{name}": values for name, values in run.rates.items()}}
    shown, of_valve = {}, _valve_readings(run)
    for name in names:
        if not isinstance(name, str):
            raise MechanismError(f'a reading is given by its name, as in plot("arm_angle", "sleeve_lift"); found {format_value(name)}')
        if name in of_valve:
            shown[name] = of_valve[name]
            continue
        if name not in known:
            hint = (
                f" {name!r} is a joint: plot_reactions({name!r}) draws its force." if name in run.reactions else did_you_mean(name, known)
            )
            raise MechanismError(f"the run has no reading {name!r}; it has {', '.join((*known, *of_valve))}.{hint}")
        source = name.removeprefix(RATE_START)
        unit, factor = run.units.get(name) or f"{run.units[source]}/s", 1.0
        if unit == "rad/s" and name not in run.readings and np.ptp(run.readings[source]) <= MAX_SHOWN_ANGLE:
            unit, factor = "deg/s", math.degrees(1.0)  # an arm swings; what makes whole turns is shown in turns per minute
        scale, error = run.scales.get(name, 0.0), run.reading_errors.get(name, 0.0)
        shown[name] = ShownReading(values=known[name] * factor, unit=unit, scale=scale * factor, error=error * factor)
    return shown


READING_NOISE_RATIO = 1e-6
"""Change relative to the scale of a reading below which it is drawn as constant."""


_TICK_STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Steps of ticks, times a power of ten."""
_LOWEST_TICK = 0.06
"""Height, relative to that of a plot, below which a label would touch the heading of the next plot."""


def choose_ticks(limits: tuple[float, float]) -> list[float]:
    """Return a few ticks of an upright axis with limits: at least two, at most three steps apart."""
    low, high = limits
    widest = (high - low) / 3
    decade = 10.0 ** math.floor(math.log10(widest))
    steps = [number * part * decade for part in (0.1, 1.0, 10.0) for number in _TICK_STEPS]
    wide = next(k for k, step in enumerate(steps) if step >= widest * (1 - 1e-9))
    numbers = ((step, range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)) for step in reversed(steps[: wide + 1]))
    ticks = next([k * step for k in within] for step, within in numbers if len(within) > 1)
    clear = [tick for tick in ticks if tick >= low + _LOWEST_TICK * (high - low)]
    return clear if len(clear) > 1 else ticks


def axis_limits_for(values: FloatArray, noise: float = 0.0) -> tuple[float, float]:
    """Return limits around values, wide enough that changes up to `noise`, or far below the value, do not look like motion."""
    low, high = float(values.min()), float(values.max())
    half = max(0.58 * (high - low), 0.02 * max(abs(low), abs(high)), 25 * noise, 1e-9)
    middle = (low + high) / 2
    return middle - half, middle + half

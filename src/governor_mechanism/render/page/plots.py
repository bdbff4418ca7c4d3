"""Plots of a page: the readings of each part, or the curves of a governed engine."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.render.figures.page import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.render.machines.engine_room.arrangement import CUT_OFF, EngineRoomParts
from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing
from governor_mechanism.render.machines.engine_room.torques import engine_torque, mean_speed
from governor_mechanism.render.number_format import choose_decimals, display_unit_of, format_name
from governor_mechanism.render.page.views import ShownRun
from governor_mechanism.types import FloatArray

MAX_FIRST_PLOTS = 4
"""Number of plots beside the drawing; the others wait under a heading."""
MAX_PLOTS = 24
"""Largest number of plots: a page holds no more without becoming a table."""
_MAX_TICKS = 3
_BLUE, _VERMILLION, _GREEN, _BROWN, _PALE_BLUE = range(5)
"""Indices of the colours of curves."""


@dataclass(frozen=True, kw_only=True)
class PlotCurve:
    """A curve: its name, values in the display unit at the samples from `first` on, and the index of its colour."""

    name: str
    values: FloatArray
    series: int
    first: int = 0


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A plot.

    Attributes
    ----------
    name, unit
        Name, and display unit of the values.
    curves
        Curves; the first one is the main one.
    limits
        Limits of the axis.
    is_first
        Whether it stands beside the drawing.
    """

    name: str
    unit: str
    curves: Sequence[PlotCurve]
    limits: Vec2
    is_first: bool

    @property
    def decimals(self) -> int:
        """Number of decimals of the values."""
        return choose_decimals(np.concatenate([curve.values for curve in self.curves]))

    @property
    def ticks(self) -> list[float]:
        """A few round values within the limits."""
        low, high = self.limits
        step = round_step(high - low, _MAX_TICKS)
        return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def choose_plots(shown: ShownRun) -> list[Plot]:
    """Return the plots of a run: first those of its film, then all other readings."""
    first = list(_room_plots(shown.governed, shown.room, shown)) if shown.governed and shown.room else list(_film_plots(shown))
    taken = {plot.name for plot in first}
    others = [plot for plot in _all_readings(shown) if plot.name not in taken]
    return [*first, *others][:MAX_PLOTS]


def _film_plots(shown: ShownRun) -> Iterator[Plot]:
    """Yield the readings that the film shows: of several parts the first of each, then the second, and so on."""
    columns = [[(data, name) for name in _main_readings(data)] for data in shown.parts]
    longest = max(map(len, columns))
    in_turn = [column[k] for k in range(longest) for column in columns if k < len(column)]
    for k, (data, name) in enumerate(in_turn[:MAX_FIRST_PLOTS]):
        yield _plot_reading(shown, data, name, is_first=True, series=k)


def _main_readings(data: FrameData) -> list[str]:
    """Return the readings that the drawing lists, or else the coordinate, the spindle speed and others."""
    names = data.drawing.panel_readings or (data.part.mechanism.coordinate, "spindle_speed", *data.readings)
    # An angle of many turns looks like a straight line.
    readings = {name for name, reading in data.readings.items() if name != SPINDLE_ANGLE and np.isfinite(reading.values).any()}
    return [name for name in dict.fromkeys(names) if name in readings]


def _all_readings(shown: ShownRun) -> Iterator[Plot]:
    """Yield all readings of all parts that have values."""
    names = [(data, name) for data in shown.parts for name in data.readings if np.isfinite(data.readings[name].values).any()]
    for k, (data, name) in enumerate(names):
        yield _plot_reading(shown, data, name, is_first=False, series=k % 4)


def _plot_reading(shown: ShownRun, data: FrameData, name: str, *, is_first: bool, series: int) -> Plot:
    """Return the plot of a reading."""
    reading = data.readings[name]
    unit, factor = display_unit_of(reading.unit)
    values = _bridge_gaps(reading.values * factor)
    limits = axis_limits_for(values, READING_NOISE_RATIO * reading.scale * factor)
    title = format_name(f"{data.part.name}.{name}" if len(shown.parts) > 1 else name)
    return Plot(name=title, unit=unit, curves=(PlotCurve(name=title, values=values, series=series),), limits=limits, is_first=is_first)


def _bridge_gaps(values: FloatArray) -> FloatArray:
    """Return values with straight lines where they are infinite, as a static force is at a turning point of its reading."""
    finite = np.flatnonzero(np.isfinite(values))
    return np.interp(np.arange(len(values)), finite, values[finite])


def _room_plots(governed: EngineRoomParts, room: EngineRoomDrawing, shown: ShownRun) -> Iterator[Plot]:
    """Yield the plots of a governed engine: speed, the governor's reading, what it controls, and torque with load."""
    run, reading = shown.run, governed.governor_reading
    mean = mean_speed(run, governed)
    unit, factor = display_unit_of("rad/s")
    means = () if mean is None else (_curve_at(shown, "mean", mean[0], mean[1] * factor, _BLUE),)
    speed = _curve_at(shown, "actual", run.times, run.rates[governed.crank_angle] * factor, _PALE_BLUE if means else _BLUE)
    yield _plot_curves("speed", unit, (*means, speed))
    unit, factor = display_unit_of(run.units.get(reading, ""))
    name = format_name(reading)
    yield _plot_curves(name, unit, (_curve_at(shown, name, run.times, run.readings[reading] * factor, _GREEN),))
    if governed.opening_reading is not None:
        name = "cut-off" if governed.controlled == CUT_OFF else "throttle"
        yield _plot_curves(name, "%", (_curve_at(shown, name, run.times, 100 * room.control_values, _BROWN),))
    loads = (_curve_at(shown, "load", run.times, room.load_values, _VERMILLION),) if room.has_load else ()
    yield _plot_curves("torque", "N m", (_curve_at(shown, "engine", *engine_torque(run, governed), _BLUE), *loads))


def _plot_curves(name: str, unit: str, curves: tuple[PlotCurve, ...]) -> Plot:
    limits = axis_limits_for(np.concatenate([curve.values for curve in curves]))
    return Plot(name=name, unit=unit, curves=curves, limits=limits, is_first=True)


def _curve_at(shown: ShownRun, name: str, times: FloatArray, values: FloatArray, series: int) -> PlotCurve:
    """Return the curve of values (n,) at times (n,) s, at the samples within these times."""
    inside = np.flatnonzero((shown.times >= times[0]) & (shown.times <= times[-1]))
    rows = inside if len(inside) else np.array([0])
    return PlotCurve(name=name, values=np.interp(shown.times[rows], times, values), series=series, first=int(rows[0]))

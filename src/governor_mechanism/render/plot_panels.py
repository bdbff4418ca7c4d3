"""What is plotted over time beside a drawing, the same in films, in animated drawings and on pages: curves in display units."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, Final

import numpy as np

from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.frame_data import FrameData, ShownParts
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.machines.engine_room.arrangement import CUT_OFF, EngineRoomParts, engine_torque, load_steps, mean_speed
from governor_mechanism.render.range_bands import PlotSize, RangeBand, count_turns, find_range_band
from governor_mechanism.render.shown_readings import (
    READING_NOISE_RATIO,
    axis_limits_for,
    choose_decimals,
    chosen_readings,
    display_unit_of,
    format_name,
    format_numbers,
    turns_evenly,
)
from governor_mechanism.render.style import CURVE_COLOURS, SERIES_COLOURS
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing  # slow to import, and only for engine rooms

_BLUE, _VERMILLION, _GREEN, _PURPLE, _PALE_BLUE, _BROWN = range(len(CURVE_COLOURS))
"""Indices of the colours of curves."""
SPINDLE_SPEED: Final = "spindle_speed"


@dataclass(frozen=True, kw_only=True, eq=False)
class PanelCurve:
    """A curve of a panel.

    One that has its mean as another curve has no dot at the shown time, and its band has no line.
    """

    name: str
    times: FloatArray  # s; shape (n,)
    values: FloatArray  # in the display unit; shape (n,)
    series: int  # index of its colour in CURVE_COLOURS
    has_own_mean: bool = False
    turns: FloatArray | None = None  # turns of a shaft at its times, since any moment; shape (n,)
    error: float = 0.0  # error estimate, in the display unit

    @property
    def colour(self) -> str:
        """The colour by day."""
        return CURVE_COLOURS[self.series]

    def find_band(self, size: PlotSize) -> RangeBand | None:
        """Return the band that stands for it in a plot of a size; None if its oscillations are seen."""
        return find_range_band(self.times, self.values, size, self.turns)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlotPanel:
    """A plot of curves over the shown time."""

    name: str
    unit: str  # display unit of the values
    curves: Sequence[PanelCurve]  # the first one is the main one, whose number is shown
    limits: Vec2  # of the axis of values
    part: str = ""  # name of the part, for a reading of one
    marks: Sequence[float] = ()  # times of upright lines, s
    may_have_bands: bool = False  # whether oscillations too narrow to be resolved are drawn as a band, if there is space to say so
    is_stated: bool = False  # whether its number says all: it is constant, or an angle that turns evenly

    @property
    def decimals(self) -> int:
        """Number of decimals of the shown number."""
        return choose_decimals(self.curves[0].values)

    def find_bands(self, width: float, height: float, line_width: float) -> list[RangeBand | None]:
        """Return the band of each curve in a plot of a size with lines of a width, pixels; None for a curve that is drawn as it is."""
        if not self.may_have_bands:
            return [None] * len(self.curves)
        whole = PlotSize(width=width, height=height, line_width=line_width, limits=self.limits)
        spans = [float(np.ptp(curve.times)) if len(curve.times) else 0.0 for curve in self.curves]
        sizes = [replace(whole, width=width * span / max(spans)) if span else whole for span in spans]
        return [curve.find_band(size) for curve, size in zip(self.curves, sizes, strict=True)]

    def numbers_at(self, times: FloatArray) -> list[str]:
        """Return the shown number at times (m,) s."""
        main = self.curves[0]
        return format_numbers(np.interp(times, main.times, main.values), main.values)


def choose_part_panels(
    parts: ShownParts,
    *,
    most: int,  # largest number of panels
    with_speed: bool,  # whether the speed of the spindle is among them if there is one
    columns: Sequence[Sequence[FrameData]] = (),  # by part, its data in all runs that share the axes; this run alone if empty
    chosen: Sequence[str] = (),  # names of the readings to plot, if they are not the main ones
    in_row: bool = False,  # whether other readings take the place of those that are only stated
) -> list[PlotPanel]:
    """Return the panels of parts: those of readings with a curve to see, then those that are only stated.

    They are those chosen, all of which are plotted, or the first of each part, then the second, and so on. If none has a curve to see,
    what changes is plotted nevertheless, or else all.
    """
    columns = columns or [(data,) for data in parts]
    if chosen:
        named = [(data, column, data.plain_name(name)) for name in chosen for data, column in zip(parts, columns, strict=True)]
        found = [_PartReading(data=data, column=column, name=name) for data, column, name in named if name is not None]
        return [one.to_panel(series) for series, one in enumerate(found[: len(SERIES_COLOURS)])]
    of_parts = [list(_main_readings(data, column, most, with_speed)) for data, column in zip(parts, columns, strict=True)]
    candidates = [one for row in zip_longest(*of_parts) for one in row if one is not None]
    plotted = [one for one in (candidates if in_row else candidates[:most]) if one.has_curve][:most]
    if not plotted:
        changing = [one for one in candidates[:most] if one.is_changing]
        return [one.to_panel(series) for series, one in enumerate(changing or candidates[:most])]
    stated = [] if in_row else [one for one in candidates[:most] if one not in plotted]
    return [one.to_panel(series, is_stated=one in stated) for series, one in enumerate([*plotted, *stated])]


def all_part_panels(parts: ShownParts) -> list[PlotPanel]:
    """Return the panels of all readings of parts that have values."""
    found = [_PartReading(data=data, column=(data,), name=name) for data in parts for name in data.readings if _has_values(data, name)]
    return [one.to_panel(k % len(SERIES_COLOURS), is_stated=not one.has_curve) for k, one in enumerate(found)]


@dataclass(frozen=True, kw_only=True, eq=False)
class _PartReading:
    """A reading of a part."""

    data: FrameData
    column: Sequence[FrameData]  # the part in all runs that share the axis
    name: str

    @property
    def _shown(self) -> list[FrameData]:
        """The part in the runs that have the reading."""
        return [data for data in self.column if self.name in data.readings]

    @property
    def is_changing(self) -> bool:
        """Whether it changes beyond its noise in any of the runs, in the shown time."""
        values = ((_sampled_values(data, self.name), data.readings[self.name].scale) for data in self._shown)
        return any(float(np.ptp(sampled)) > READING_NOISE_RATIO * scale for sampled, scale in values)

    @property
    def has_curve(self) -> bool:
        """Whether it changes, and not as an angle that turns evenly."""
        return self.is_changing and not all(self._turns_evenly(data) for data in self._shown)

    def _turns_evenly(self, data: FrameData) -> bool:
        return turns_evenly(data.sample_times, _sampled_values(data, self.name), data.readings[self.name].unit)

    @property
    def _words(self) -> str:
        """Its name in words; of an angle that has only a letter, also the body that turns."""
        words = format_name(self.name)
        body = next((one.body for one in self.data.part.mechanism.readings if one.name == self.name and isinstance(one, BodyAngle)), "")
        return f"{words}, {body}" if body and len(words) == 1 else words

    def to_panel(self, series: int, *, is_stated: bool = False) -> PlotPanel:
        """Return its panel; the speed of a spindle always has the same colour."""
        unit, factor = display_unit_of(self.data.readings[self.name].unit)
        words = self._words
        values = _sampled_values(self.data, self.name) * factor
        colour = _GREEN if self.name == SPINDLE_SPEED else series
        of_runs = np.concatenate([_sampled_values(data, self.name) for data in self._shown])
        noise = READING_NOISE_RATIO * max(data.readings[self.name].scale for data in self._shown) * factor
        times, run = self.data.sample_times, self.data.drawing.run
        turns = count_turns(run)
        curve = PanelCurve(
            name=words, times=times, values=values, series=colour, turns=None if turns is None else np.interp(times, run.times, turns)
        )
        return PlotPanel(
            name=words,
            part=format_name(self.data.part.name),
            unit=unit,
            curves=(curve,),
            limits=axis_limits_for(of_runs * factor, noise),
            is_stated=is_stated,
        )


def _main_readings(data: FrameData, column: Sequence[FrameData], most: int, with_speed: bool) -> Iterator[_PartReading]:
    """Yield the readings that the drawing lists, or else the leading coordinate, another reading and the spindle speed."""
    names = data.drawing.panel_readings
    if not names:
        machine_readings = [name for name in data.readings if not name.startswith("spindle")]
        names = (data.part.mechanism.coordinate, *machine_readings)
        if with_speed:
            names = (*list(dict.fromkeys(names))[: most - 1], SPINDLE_SPEED, *machine_readings)
    for name in dict.fromkeys(names):
        if name in data.readings and _has_values(data, name):
            yield _PartReading(data=data, column=column, name=name)


def _has_values(data: FrameData, name: str) -> bool:
    """Return whether a reading of a part has a value anywhere in the shown time."""
    return bool(np.isfinite(data.sampled_values(name)).any())


def _sampled_values(data: FrameData, name: str) -> FloatArray:
    """Return a reading at the sample times, on straight lines where it is infinite, as a static force is where its reading turns back."""
    values = data.sampled_values(name)
    finite = np.isfinite(values)
    return np.interp(data.sample_times, data.sample_times[finite], values[finite]) if finite.any() else values


def choose_room_panels(
    run: Trajectory,
    governed: EngineRoomParts,
    room: "EngineRoomDrawing",
    time_span: Vec2,  # the shown time, s
    chosen: Sequence[str] = (),  # names of the readings to plot, if they are not the main ones
) -> list[PlotPanel]:
    """Return the panels of a governed engine from the top: speed, the governor's reading, what it controls, and torque with load."""
    shown = _RoomRun(run=run, governed=governed, room=room, time_span=time_span)
    return list(shown.chosen_panels(chosen) if chosen else shown.main_panels())


@dataclass(frozen=True, kw_only=True, eq=False)
class _RoomRun:
    """The run of a governed engine in a shown time (s)."""

    run: Trajectory
    governed: EngineRoomParts
    room: "EngineRoomDrawing"
    time_span: Vec2

    @cached_property
    def _turns(self) -> FloatArray | None:
        """Turns (n,) of the shaft at the times of the run."""
        return count_turns(self.run)

    def chosen_panels(self, names: Sequence[str]) -> Iterator[PlotPanel]:
        """Yield the panels of readings by name."""
        readings = chosen_readings(self.run, names).items()
        for series, (name, reading) in enumerate(list(readings)[: len(SERIES_COLOURS)]):
            unit, factor = display_unit_of(reading.unit)
            curve = self._curve(format_name(name), self.run.times, reading.values * factor, series)
            yield self._panel(format_name(name), unit, curve, noise=READING_NOISE_RATIO * reading.scale * factor)

    def main_panels(self) -> Iterator[PlotPanel]:
        """Yield the panels from the top."""
        run = self.run
        governed = self.governed
        room = self.room
        yield self._panel("speed", display_unit_of("rad/s")[0], *self._speed_curves())
        unit, factor = display_unit_of(run.units.get(governed.governor_reading, ""))
        part, _, name = governed.governor_reading.rpartition(".")
        reading = self._curve(format_name(name), run.times, run.readings[governed.governor_reading] * factor, _GREEN)
        noise = READING_NOISE_RATIO * run.scales.get(governed.governor_reading, 0.0) * factor
        yield self._panel(format_name(name), unit, reading, noise=noise, part=format_name(part))
        if governed.opening_reading is not None:
            name = "cut-off" if governed.controlled == CUT_OFF else "throttle"
            yield self._panel(name, "%", self._curve(name, run.times, 100 * room.control_values, _BROWN))
        loads = (self._curve("load", run.times, room.load_values, _VERMILLION),) if room.has_load else ()
        yield self._panel("torque", "N m", self._curve("engine", *engine_torque(run, governed), _BLUE), *loads)

    def _speed_curves(self) -> tuple[PanelCurve, ...]:
        """Return the mean speed of each turn and the speed in it; only the speed if the run has too few turns."""
        _, factor = display_unit_of("rad/s")
        speed = self.run.rates[self.governed.crank_angle] * factor
        mean = mean_speed(self.run, self.governed)
        if mean is None:
            return (self._curve("actual", self.run.times, speed, _BLUE),)
        times, values = mean
        actual = self._curve("actual", self.run.times, speed, _PALE_BLUE, has_own_mean=True)
        return self._curve("mean", times, values * factor, _BLUE), actual

    def _panel(self, name: str, unit: str, *curves: PanelCurve, noise: float = 0.0, part: str = "") -> PlotPanel:
        """Return a panel of curves."""
        limits = axis_limits_for(np.concatenate([curve.values for curve in curves]), noise)
        break_time = self.governed.break_time
        marks = [*load_steps(self.run, self.governed), *([] if break_time is None else [break_time])]
        return PlotPanel(name=name, part=part, unit=unit, curves=curves, limits=limits, marks=marks, may_have_bands=True)

    def _curve(self, name: str, times: FloatArray, values: FloatArray, series: int, *, has_own_mean: bool = False) -> PanelCurve:
        """Return the curve of values (n,) at times (n,) s in the shown time, straight across it if it lies beside these times."""
        first, last = np.clip(self.time_span, times[0], times[-1])
        inside = (times > first) & (times < last)
        ends = (first, last) if first < last else self.time_span
        shown = np.concatenate([ends[:1], times[inside], ends[1:]])
        within = np.concatenate([np.interp(ends[:1], times, values), values[inside], np.interp(ends[1:], times, values)])
        turns = None if self._turns is None else np.interp(shown, self.run.times, self._turns)
        return PanelCurve(name=name, times=shown, values=within, series=series, has_own_mean=has_own_mean, turns=turns)

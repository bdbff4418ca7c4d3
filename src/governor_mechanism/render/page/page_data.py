"""The data of a page: outlines, tracks, modes, forces and curves, as values that JSON knows.

Positions are units of the picture (`views.PICTURE_SIZE` on its larger side), angles clockwise in `ANGLE_QUANTUM` rad; `pack_numbers`
tells how numbers over time are written. Sample k of n stands for the time start + k (stop - start) / (n - 1).
"""

import math
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.joints import Point
from governor_mechanism.render.frame_data import DrawnForce, FrameData, find_forces
from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.render.geometry.recording import SEEN_AS, RecordedShape, find_half_thickness, record_parts
from governor_mechanism.render.machines.engine_room.arrangement import CUT_OFF, EngineRoomParts, engine_torque, mean_speed
from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing
from governor_mechanism.render.page.part_names import name_part
from governor_mechanism.render.page.views import PICTURE_SIZE, PageView, Picture, ShownRun, Track, TrackTable, Trail
from governor_mechanism.render.shown_readings import READING_NOISE_RATIO, axis_limits_for, choose_decimals, display_unit_of, format_name
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
    """A plot."""

    # name, unit: name, and display unit of the values
    name: str
    unit: str
    curves: Sequence[PlotCurve]  # curves; the first one is the main one
    limits: Vec2  # limits of the axis
    is_first: bool  # whether it stands beside the drawing

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


Packed = int | str
"""Numbers of one channel in quanta: one integer if all are equal, else text."""

FORMATS: Final[dict[str, tuple[int, int]]] = {"a": (1, 7), "b": (2, 7), "c": (1, 3), "d": (2, 3)}
"""How often differences are taken, and bits in a group, by the first letter of a text."""

_MAX_QUANTA = 2**40
"""Largest magnitude (quanta) that is packed: a page computes with doubles, which hold integers up to 2^53."""


def pack_numbers(
    values: FloatArray,  # values; shape (n,)
    quantum: float,  # largest rounding error times two, in the unit of the values; positive
) -> Packed:
    """Return values as integers or text.

    Each value is rounded to the nearest multiple of the quantum. Of the integers, the first and then the differences of neighbours are
    written, or the same of these. Then 0, -1, 1, -2, 2, ... become 0, 1, 2, 3, 4, ...; each of these takes groups of 7 or 3 bits, the
    lowest first, with one more bit above, which tells that another group follows. A byte holds one group of 7 bits, or two of 3 bits, the
    first in its lower half; a half that is left over is 8. The bytes are written in base 64 after a letter of FORMATS, the one of the
    shortest text.

    Result: the integer that all values are rounded to, or text.
    """
    quanta = np.rint(np.clip(np.asarray(values, dtype=float) / quantum, -_MAX_QUANTA, _MAX_QUANTA)).astype(np.int64)
    if not quanta.size or (quanta == quanta[0]).all():
        return int(quanta[0]) if quanta.size else 0
    return min((_write_text(quanta, letter) for letter in FORMATS), key=len)


def _write_text(integers: NDArray[np.int64], letter: str) -> str:
    """Return integers in a format."""
    order, n_bits = FORMATS[letter]
    for _ in range(order):
        integers = np.diff(integers, prepend=0)
    codes = np.where(integers < 0, -2 * integers - 1, 2 * integers)
    groups = _split_into_groups(codes.tolist(), n_bits)
    if n_bits == 3:
        groups = [low | high << 4 for low, high in zip(groups[::2], [*groups[1::2], 8], strict=False)]
    return letter + b64encode(bytes(groups)).decode("ascii")


def _split_into_groups(codes: list[int], n_bits: int) -> list[int]:
    """Return integers of at least 0 as groups of bits, the lowest first, with a bit above that tells that another group follows."""
    groups = []
    follows = 1 << n_bits
    for code in codes:
        while code >= follows:
            groups.append(code % follows | follows)
            code >>= n_bits
        groups.append(code)
    return groups


ANGLE_QUANTUM = 1e-4
"""Quantum of angles, rad: at the end of a bar as long as the picture it moves the end by one unit."""
AMPLITUDE_QUANTUM = 0.5
"""Quantum of the amplitude of a mode, units of the picture: a few modes together round to about one unit."""
RELATIVE_QUANTUM = 1e-4
"""Quantum of forces and readings, relative to the largest force and to the length of the axis."""
DIGIT_QUANTUM = 0.2
"""Quantum of readings, relative to the last digit that is shown, where that is coarser."""
_FORCE_LENGTH = 0.17
"""Length of the longest force, relative to the larger side of the picture."""
_MAX_SCALE_BAR = 0.3
"""Longest scale bar, relative to the width of the picture."""
_DISPLACEMENT_DECIMALS = 5


def collect_data(shown: ShownRun, slow_down: float) -> dict[str, Any]:
    """Return the data of a run whose seconds take `slow_down` seconds at first."""
    return collect_pictures(shown, slow_down) | {"plots": [_collect_plot(plot) for plot in choose_plots(shown)]}


def collect_pictures(shown: ShownRun, slow_down: float) -> dict[str, Any]:
    """Return the data of a run without its plots."""
    return {
        "times": {"start": float(shown.times[0]), "stop": float(shown.times[-1]), "count": len(shown.times)},
        "slowDown": slow_down,
        "angleQuantum": ANGLE_QUANTUM,
        "amplitudeQuantum": AMPLITUDE_QUANTUM,
        "views": [_collect_view(view, len(shown.times)) for view in shown.views],
    }


def collect_tracks(view: PageView, n_samples: int) -> dict[str, Any]:
    """Return the tracks of a view, and of each shape the role and the number of its track; None for a shape without one."""
    _, table = _table_of_bodies(view, view.picture)
    shapes = [(shape.role, table.describe(shape).track) for shape in _record_shapes(view, n_samples)]
    return {"tracks": [_collect_track(track) for track in table.tracks], "shapes": shapes}


def _table_of_bodies(view: PageView, picture: Picture) -> tuple[list[str], TrackTable]:
    """Return the names of the bodies of a view and a table with their tracks."""
    names = [body.name for body in view.data.part.mechanism.bodies] if view.shows_bodies else []
    poses = [picture.place_poses(view.place_poses(view.data.poses[:, index])) for index in range(len(names))]
    return names, TrackTable(picture, [Track(name=name, poses=one) for name, one in zip(names, poses, strict=True)])


def _record_shapes(view: PageView, n_samples: int) -> list[RecordedShape]:
    """Return the shapes of a view at its samples, back to front."""
    moments = [view.moment_at(k) for k in range(n_samples)]
    return [*record_parts(view.fixed, moments[:1]), *record_parts(view.moving, moments)]


def _collect_view(view: PageView, n_samples: int) -> dict[str, Any]:
    """Return the data of a view."""
    picture = view.picture
    width, height = picture.size
    names, table = _table_of_bodies(view, picture)
    axis = float(picture.place(view.place_poses(np.zeros((1, 3)))[:, :2])[0, 0])
    collected = [_collect_shape(shape, table, view) for shape in _record_shapes(view, n_samples)]
    return {
        "name": view.name,
        "isPlane": view.has_plane,
        "width": round(width),
        "height": round(height),
        "stroke": round(view.stroke, 2),
        "axis": round(axis),
        "slowing": view.rotation_slowing,
        "scales": [_scale_bar(name, unit * picture.scale, width) for name, unit in view.scales.items()],
        "spindle": pack_numbers(view.data.spindle_angle, ANGLE_QUANTUM) if view.has_outside else None,
        "trails": [_collect_trail(trail, view, picture) for trail in view.trails] if view.has_plane else [],
        "shapes": collected,
        "forces": _collect_forces(view, names, table, picture) if view.has_plane and view.shows_bodies else None,
        "tracks": [_collect_track(track) for track in table.tracks],
    }


def _collect_shape(shape: RecordedShape, table: TrackTable, view: PageView) -> dict[str, Any]:
    """Return the data of a shape; keys that do not apply are left out."""
    motion = table.describe(shape)
    body = table.tracks[motion.track].name if motion.track is not None and view.names_bodies else ""
    name, sentence = name_part(shape.role, view.machine, body)
    scale = table.picture.scale
    half_thickness = find_half_thickness(shape, PICTURE_SIZE / scale) if view.has_outside else None
    data: dict[str, Any] = {"role": shape.role, "kind": shape.kind}
    optional = {
        "name": name,
        "sentence": sentence,
        "text": shape.text,
        "track": motion.track,
        "modes": [
            [pack_numbers(mode.amplitudes, AMPLITUDE_QUANTUM), np.round(mode.displacements, _DISPLACEMENT_DECIMALS).ravel().tolist()]
            for mode in motion.modes
        ],
        "seenAs": SEEN_AS.get(shape.role) if view.has_outside else None,
        "radius": pack_numbers(scale * shape.radii, 1.0) if len(shape.radii) else None,
        "hidden": list(_hidden_intervals(shape)),
        "turns": None if half_thickness is None else scale * half_thickness,
    }
    data |= {key: value for key, value in optional.items() if value is not None and value != [] and value != ""}
    if view.has_outside and shape.part.section_only:
        data["isInPlaneOnly"] = True
    if motion.is_changing:
        return data | {"frames": list(_collect_frames(shape, table.picture))}
    if shape.kind == "lines":
        data["lengths"] = list(shape.outline)
    return data | {"points": _whole_numbers(motion.points)}


def _hidden_intervals(shape: RecordedShape) -> Iterator[list[int]]:
    """Yield the first sample of each interval in which a shape is hidden, and the first one after it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], shape.visible, [True]]).astype(int)))
    yield from edges.reshape(-1, 2).tolist()


def _collect_frames(shape: RecordedShape, picture: Picture) -> Iterator[list[Any]]:
    """Yield the first sample and the polylines, as lengths, x and y, of each stretch of samples with the same points."""
    before: list[Any] = []
    frames = shape.placed_lines() if shape.changing else ((points,) for points in shape.placed_points())
    for k, lines in enumerate(frames):
        points = picture.place(np.concatenate(lines) if lines else np.zeros((0, 2)))
        content = [[len(line) for line in lines], pack_numbers(points[:, 0], 1.0), pack_numbers(points[:, 1], 1.0)]
        if content != before:
            yield [k, *content]
        before = content


def _collect_track(track: Track) -> dict[str, Any]:
    """Return the data of a track."""
    x, y, angle = track.poses.T
    name = {"name": track.name} if track.name else {}
    return name | {"x": pack_numbers(x, 1.0), "y": pack_numbers(y, 1.0), "angle": pack_numbers(angle, ANGLE_QUANTUM)}


def _collect_trail(trail: Trail, view: PageView, picture: Picture) -> dict[str, Any]:
    """Return what stays behind a point for a second of film."""
    poses = np.column_stack([trail.places, np.zeros(len(trail.places))])
    x, y, _ = picture.place_poses(view.place_poses(poses)).T
    return {"role": trail.role, "x": pack_numbers(x, 1.0), "y": pack_numbers(y, 1.0)}


def _collect_forces(view: PageView, bodies: list[str], table: TrackTable, picture: Picture) -> dict[str, Any] | None:
    """Return the forces, with their common scale; None if there are none."""
    forces = find_forces(view.data)
    largest = max((float(np.hypot(*force.components.T).max(initial=0.0)) for force in forces), default=0.0)
    if not largest > 0.0:
        return None
    quantum = RELATIVE_QUANTUM * largest
    length = min(picture.size[0] * 2, PICTURE_SIZE) * _FORCE_LENGTH
    return {
        "largest": largest,
        "quantum": quantum,
        "unitsPerNewton": length / largest,
        "arrows": [_collect_force(force, quantum, bodies, view, picture) for force in forces],
    }


def _collect_force(force: DrawnForce, quantum: float, bodies: list[str], view: PageView, picture: Picture) -> dict[str, Any]:
    """Return the data of a force: its point in the axes of the track of its body, and its components; y points down."""
    x, y = force.components.T
    point: Point = force.point
    scale = picture.scale * float(np.hypot(*np.diff(view.place_poses(np.array([[0.0, 0, 0], [1.0, 0, 0]]))[:, :2], axis=0)[0]))
    return {
        "kind": force.kind,
        "name": force.name,
        "track": bodies.index(point.body),
        "point": [round(point.x * scale), round(-point.y * scale)],
        "x": pack_numbers(x, quantum),
        "y": pack_numbers(-y, quantum),
    }


def _scale_bar(name: str, units_per_metre: float, width: float) -> dict[str, Any]:
    """Return a scale bar of a round length."""
    length = round_step(_MAX_SCALE_BAR * width / units_per_metre, 2)
    return {"label": f"{name} {length * 1e3:g} mm".strip(), "length": round(length * units_per_metre)}


def _collect_plot(plot: Plot) -> dict[str, Any]:
    """Return the data of a plot."""
    low, high = plot.limits
    quantum = max(RELATIVE_QUANTUM * (high - low), DIGIT_QUANTUM * 10.0**-plot.decimals)
    return {
        "name": plot.name,
        "unit": plot.unit,
        "decimals": plot.decimals,
        "limits": [low, high],
        "ticks": [float(f"{tick:.6g}") for tick in plot.ticks],
        "isFirst": plot.is_first,
        "curves": [_collect_curve(curve, low, quantum) for curve in plot.curves],
    }


def _collect_curve(curve: PlotCurve, low: float, quantum: float) -> dict[str, Any]:
    """Return the data of a curve; its values count from the lower end of the axis."""
    return {
        "name": curve.name,
        "series": curve.series,
        "first": curve.first,
        "count": len(curve.values),
        "quantum": quantum,
        "values": pack_numbers(curve.values - low, quantum),
    }


def _whole_numbers(points: FloatArray) -> list[int]:
    """Return points (n, 2) as x, y, x, y, ... in whole units."""
    flat: list[int] = np.rint(points).astype(int).ravel().tolist()
    return flat


def roles_of(data: dict[str, Any]) -> set[str]:
    """Return the roles of all shapes of a page."""
    shapes: Iterable[dict[str, Any]] = (shape for view in data["views"] for shape in view["shapes"])
    trails = {trail["role"] for view in data["views"] for trail in view["trails"]}
    return {shape[key] for shape in shapes for key in ("role", "seenAs") if key in shape} | trails

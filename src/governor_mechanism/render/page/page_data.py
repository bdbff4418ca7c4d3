"""The data of a page: outlines, tracks, modes, forces and curves, as values that JSON knows.

Positions are units of the picture (`views.PICTURE_SIZE` on its larger side), angles clockwise in `ANGLE_QUANTUM` rad; `pack_numbers`
tells how numbers over time are written. Sample k of n stands for the time start + k (stop - start) / (n - 1).
"""

from base64 import b64encode
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.joints import Point
from governor_mechanism.render.frame_data import END_TOLERANCE, DrawnForce, find_forces
from governor_mechanism.render.geometry.primitives import round_step
from governor_mechanism.render.geometry.recording import SEEN_AS, RecordedShape, find_half_thickness, record_parts
from governor_mechanism.render.page.part_names import name_part
from governor_mechanism.render.page.views import PICTURE_SIZE, PageView, Picture, ShownRun, Track, TrackTable, Trail
from governor_mechanism.render.plot_panels import PanelCurve, PlotPanel, all_part_panels, choose_part_panels, choose_room_panels
from governor_mechanism.render.range_bands import RangeBand, name_cycles
from governor_mechanism.render.shown_readings import choose_ticks
from governor_mechanism.types import FloatArray

MAX_FIRST_PLOTS = 4
"""Number of plots beside the drawing; the others wait under a heading."""
MAX_PLOTS = 24
"""Largest number of plots: a page holds no more without becoming a table."""
PLOT_SIZE = (250.0, 80.0, 1.6)
"""Width and height of a plot of a governed engine on a screen of 1366 pixels, and the width of its curves, pixels."""


def choose_panels(shown: ShownRun) -> tuple[list[PlotPanel], list[PlotPanel]]:
    """Return the panels of a run beside its drawing, those of its film, and the ones of all other readings.

    All may have bands: a page has space to say what these are.
    """
    if shown.governed and shown.room:
        first = choose_room_panels(shown.run, shown.governed, shown.room, shown.parts[0].time_span)
    else:
        first = choose_part_panels(shown.parts, most=MAX_FIRST_PLOTS, with_speed=True)
    taken = {(panel.part, panel.name) for panel in first}
    others = [panel for panel in all_part_panels(shown.parts) if (panel.part, panel.name) not in taken]
    chosen = [replace(panel, may_have_bands=True) for panel in (*first, *others)[:MAX_PLOTS]]
    return chosen[: len(first)], chosen[len(first) :]


def _collect_plots(shown: ShownRun) -> list[dict[str, Any]]:
    """Return the data of all plots of a run."""
    first, others = choose_panels(shown)
    has_parts = len(shown.parts) > 1
    return [_collect_plot(panel, shown.parts[0].times, has_parts) | {"isFirst": panel in first} for panel in (*first, *others)]


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
    return collect_pictures(shown, slow_down) | {"plots": _collect_plots(shown)}


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


def _collect_plot(panel: PlotPanel, times: FloatArray, has_parts: bool) -> dict[str, Any]:
    """Return the data of a plot with curves at sample times (n,) s; where there are several parts, it has the name of its own too."""
    low, high = panel.limits
    quantum = max(RELATIVE_QUANTUM * (high - low), DIGIT_QUANTUM * 10.0**-panel.decimals)
    bands = panel.find_bands(*PLOT_SIZE)
    drawn = [band for band in bands if band is not None]
    state: dict[str, Any] = {"isStated": True} if panel.is_stated else {}
    note = {"note": f"band: range within {name_cycles(drawn)}"} if drawn else {}
    return (
        state
        | note
        | {
            "name": f"{panel.part} {panel.name}".strip() if has_parts else panel.name,
            "unit": panel.unit,
            "decimals": panel.decimals,
            "limits": [low, high],
            "ticks": [float(f"{tick:.6g}") for tick in choose_ticks(panel.limits)],
            "marks": [float(f"{mark:.6g}") for mark in panel.marks if times[0] <= mark <= times[-1]],
            "curves": [_collect_curve(curve, band, times, low, quantum) for curve, band in zip(panel.curves, bands, strict=True)],
        }
    )


def _collect_curve(curve: PanelCurve, band: RangeBand | None, times: FloatArray, low: float, quantum: float) -> dict[str, Any]:
    """Return the data of a curve at those of sample times (n,) s at which it is; its values count from the lower end of the axis."""
    margin = END_TOLERANCE * float(np.abs(times).max())
    inside = np.flatnonzero((times >= curve.times[0] - margin) & (times <= curve.times[-1] + margin))
    rows = inside if len(inside) else np.array([0])
    values = np.interp(times[rows], curve.times, curve.values)
    return {
        "name": curve.name,
        "series": curve.series,
        "first": int(rows[0]),
        "count": len(rows),
        "quantum": quantum,
        "values": pack_numbers(values - low, quantum),
    } | ({} if band is None else {"band": _collect_band(band, curve, times, low, quantum)})


def _collect_band(band: RangeBand, curve: PanelCurve, times: FloatArray, low: float, quantum: float) -> dict[str, Any]:
    """Return the data of the band of a curve, and of its mean unless that is a curve: x in thousandths of the plot's width, values."""

    def x_of(moments: FloatArray) -> Packed:
        return pack_numbers((moments - times[0]) / (times[-1] - times[0]), 1e-3)

    ends = {"x": x_of(band.times), "low": pack_numbers(band.low - low, quantum), "high": pack_numbers(band.high - low, quantum)}
    return ends | ({} if curve.has_own_mean else {"meanX": x_of(band.mean_times), "means": pack_numbers(band.means - low, quantum)})


def _whole_numbers(points: FloatArray) -> list[int]:
    """Return points (n, 2) as x, y, x, y, ... in whole units."""
    flat: list[int] = np.rint(points).astype(int).ravel().tolist()
    return flat


def roles_of(data: dict[str, Any]) -> set[str]:
    """Return the roles of all shapes of a page."""
    shapes: Iterable[dict[str, Any]] = (shape for view in data["views"] for shape in view["shapes"])
    trails = {trail["role"] for view in data["views"] for trail in view["trails"]}
    return {shape[key] for shape in shapes for key in ("role", "seenAs") if key in shape} | trails

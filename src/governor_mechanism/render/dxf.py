"""A mechanism in one position as a drawing in DXF, true to scale in millimetres, for programs that design parts."""

import os
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.options import require_points
from governor_mechanism.render.frame_data import FrameData, find_parts, shows_bodies
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.motion_layers import PointPaths
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import PATH, QUANTITY, TEXT, check_arguments
from governor_mechanism.units.quantities import convert_texts

MILLIMETRES: Final = 1e3
"""Units of the drawing in a metre."""
DXF_MILLIMETRES: Final = 4
"""What $INSUNITS says of a drawing in millimetres."""
LAYERS: Final = {"ground": 8, "parts": 7, "pins": 1, "paths": 5}
"""Layers, and their colours by the index of AutoCAD."""
PIN_ROLES: Final = frozenset({"pivot", "eye", "tracer", "drive"})
"""Roles of shapes that are pins or points."""
UNDRAWN_ROLES: Final = frozenset({"plate web", "plate rim"})
"""Roles of fills, whose edge is a shape of its own."""


@check_arguments(path=PATH, time=QUANTITY, part=TEXT)
def write_dxf(
    run: Trajectory,
    path: str | os.PathLike[str],
    *,
    time: float | str | None = None,
    paths: Sequence[str] | None = None,
    part: str | None = None,
) -> Path:
    """Write the mechanism of a run at a time; `Trajectory.save_dxf` documents the parameters, the result and the errors."""
    target = Path(path)
    if target.suffix.lower() != ".dxf":
        raise MechanismError(f"a drawing's name must end in .dxf; got {target.name!r}")
    data = _data_at(run, _time_within(run, time), part)
    require_points(paths or (), run.scene)
    ezdxf = _require_ezdxf()
    document = ezdxf.new(units=DXF_MILLIMETRES)
    for layer, colour in LAYERS.items():
        document.layers.add(layer, color=colour)
    space, drawing = document.modelspace(), data.drawing
    _draw(space, "ground", drawing.static_shapes)
    moving = list(shapes_of(drawing.moving, data.moment_at(0)))
    _draw(space, "parts", [shape for shape in moving if shape.role not in PIN_ROLES])
    _draw(space, "pins", [shape for shape in moving if shape.role in PIN_ROLES])
    _draw(space, "paths", PointPaths(data, paths).shapes)
    with atomic_write(target) as temporary:
        document.saveas(temporary)
    return target


def _time_within(run: Trajectory, time: float | str | None) -> float:
    """Return the time of the drawing, s; raise MechanismError if the run does not reach it."""
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to draw; its message: {run.message}")
    first, last = float(run.times[0]), float(run.times[-1])
    moment = first if time is None else float(convert_texts(time, "time", "time"))
    if not first <= moment <= last:
        raise MechanismError(f"time of a drawing must lie within the run, {first:g}..{last:g} s; got {moment:g} s")
    return moment


def _data_at(run: Trajectory, time: float, name: str | None) -> FrameData:
    """Return the part of a run at a time, s; raise MechanismError unless it is one part whose drawing shows its bodies."""
    parts = find_parts(run, name)
    if len(parts) > 1:
        raise MechanismError(f"a drawing shows one part; the scene has {[one.name for one in parts]}; choose one by part")
    data = FrameData(run, parts[0], (float(run.times[0]), float(run.times[-1])), np.array([time]))
    if not shows_bodies(data):
        raise MechanismError(f"the drawing of machine {parts[0].machine!r} is a diagram, which is not to scale")
    return data


def _require_ezdxf() -> Any:
    """Return the package that writes DXF, or refuse if it is not installed."""
    try:
        return import_module("ezdxf")
    except ImportError as missing:
        raise MechanismError("writing .dxf needs ezdxf: pip install 'governor-mechanism[dxf]'") from missing


def _draw(space: Any, layer: str, shapes: Iterable[DrawnShape]) -> None:
    """Add shapes to a layer; words and fills are left out."""
    for shape in shapes:
        if isinstance(shape, Circle) and shape.radius > 0.0:
            centre = (MILLIMETRES * shape.x, MILLIMETRES * shape.y)
            space.add_circle(centre, MILLIMETRES * shape.radius, dxfattribs={"layer": layer})
        for points, is_closed in _polylines(shape):
            space.add_lwpolyline((MILLIMETRES * points).tolist(), close=is_closed, dxfattribs={"layer": layer})


def _polylines(shape: DrawnShape) -> Iterator[tuple[FloatArray, bool]]:
    """Yield the lines of a shape, points (n, 2) in m, and whether they are closed."""
    if shape.role in UNDRAWN_ROLES:
        return
    lines: Sequence[Sequence[Vec2]] = ()
    if isinstance(shape, Polygon):
        lines = (shape.points,)
    elif isinstance(shape, Lines):
        lines = shape.lines
    yield from ((np.array(line), isinstance(shape, Polygon)) for line in lines if len(line) > 1)

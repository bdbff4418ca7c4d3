"""Results as a notebook shows them: a row for each quantity, or the text that they print."""

import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import Any, Unpack

import numpy as np

from governor_mechanism.model.results.pictures import Film, FilmKeywords, FilmOptions
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.film.writer import write_film
from governor_mechanism.render.shown_readings import READING_NOISE_RATIO, display_unit_of, format_rounded_up
from governor_mechanism.scenes.described_scene import DescribedPart
from governor_mechanism.scenes.description import describe_scene
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.types import FloatArray, Progress
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.text_table import summarise

CURVE_WIDTH = 120
CURVE_HEIGHT = 24
CURVE_MARGIN = 2
"""Size and margin of a small curve, pixels."""


def format_html_table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],  # cells, as text; a cell that begins with "<svg" is a picture
    *,
    n_text_columns: int = 1,  # number of first columns that are aligned to the left; the others hold numbers
) -> str:
    """Return a table."""
    head = f"<thead><tr>{_format_cells('th', header, n_text_columns)}</tr></thead>" if header else ""
    body = "".join(f"<tr>{_format_cells('td', row, n_text_columns)}</tr>" for row in rows)
    return f"<table>{head}<tbody>{body}</tbody></table>"


def format_paragraph(text: str, *, is_bold: bool = False) -> str:
    """Return a line of text."""
    content = f"<b>{escape(text)}</b>" if is_bold else escape(text)
    return f'<div style="text-align:left">{content}</div>'


def format_printed(text: str) -> str:
    """Return a printed text, with its columns aligned and a bar to scroll long lines."""
    # JupyterLab shows a plain <pre> of a result in a proportional font.
    style = "white-space:pre;overflow-x:auto;line-height:1.3;font-family:Menlo,'DejaVu Sans Mono',Consolas,'Courier New',monospace"
    return f'<pre style="{style}">{escape(text)}</pre>'


def draw_small_curve(
    values: FloatArray,  # values; shape (n,). Those that are not finite are left out
    noise: float,
) -> str:
    """Return a curve over equal steps without axes: a picture as SVG; empty without two finite values."""
    finite = np.flatnonzero(np.isfinite(values))
    if len(finite) < 2:
        return ""
    # Extremes of as many groups as there are pixels, so that the curve of a fast oscillation keeps its height.
    groups = np.array_split(finite, min(CURVE_WIDTH, len(finite)))
    extremes = [index for group in groups for index in (group[np.argmin(values[group])], group[np.argmax(values[group])])]
    shown = np.unique([finite[0], *extremes, finite[-1]])
    low, high = float(values[finite].min()), float(values[finite].max())
    half = max(0.5 * (high - low), noise) or 1.0
    height = CURVE_HEIGHT - 2 * CURVE_MARGIN
    x = CURVE_MARGIN + (CURVE_WIDTH - 2 * CURVE_MARGIN) * shown / (len(values) - 1)
    y = CURVE_HEIGHT / 2 - 0.5 * height * (values[shown] - 0.5 * (low + high)) / half
    points = " ".join(f"{px:.1f},{py:.1f}" for px, py in zip(x, y, strict=True))
    line = f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1.2"/>'
    return f'<svg width="{CURVE_WIDTH}" height="{CURVE_HEIGHT}" role="img">{line}</svg>'


def _format_cells(tag: str, cells: Sequence[str], n_text_columns: int) -> str:
    """Return the cells of a row."""
    texts = (cell if cell.startswith("<svg") else escape(cell) for cell in cells)
    sides = ("left" if k < n_text_columns else "right" for k in range(len(cells)))
    return "".join(f'<{tag} style="text-align:{side}">{text}</{tag}>' for side, text in zip(sides, texts, strict=True))


def speed_curve_html(curve: SpeedCurve) -> str:
    """Return a speed curve as HTML: travel, equilibrium speeds with a small curve, the stable share, folds and poles."""
    has_equilibrium = curve.has_equilibrium
    rows = [("travel", "", f"{curve.coordinate_name} {curve.coordinate[0]:.6g} to {curve.coordinate[-1]:.6g} (SI)")]
    if has_equilibrium.any():
        speeds = curve.speed[has_equilibrium]
        span = f"{speeds.min() / RPM:.6g} to {speeds.max() / RPM:.6g} rpm"
        rows.append(("equilibrium speed", draw_small_curve(speeds, 0.0), span))
        rows.append(("stable", "", f"{curve.stable.sum() / has_equilibrium.sum():.1%} of the travel with an equilibrium"))
    folds = (f"{speed / RPM:.6g} rpm at {coordinate:.6g}" for coordinate, speed in curve.folds)
    rows += [("jumps at", "", text) for text in folds]
    rows += [("no equilibrium beyond", "", f"{pole:.6g}") for pole in curve.poles]
    return format_paragraph("Equilibrium speed over the travel", is_bold=True) + format_html_table((), rows, n_text_columns=3)


MAX_NAMED_ITEMS = 20
"""Largest number of bodies, joints or the like that are listed by name."""

CONSTANT_RATIO = 1e-9
"""Change relative to the largest value below which an array is drawn as constant: rounding."""


def result_html(result: Any) -> str:
    """Return a result as HTML: the text that it prints, with its columns aligned, or else its fields."""
    if "__str__" in {name for owner in type(result).__mro__ if owner not in (Result, object) for name in vars(owner)}:
        return format_printed(str(result))
    title = f"{type(result).__name__} (SI units)"
    rows = [row for field in dataclasses.fields(result) if field.repr for row in _field_rows(field.name, getattr(result, field.name))]
    return format_paragraph(title, is_bold=True) + format_html_table((), rows, n_text_columns=3)


def _field_rows(name: str, value: Any) -> Iterator[tuple[str, str, str]]:
    """Yield the cells of a field: one row for each entry of a mapping, else one."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _field_rows(f"{name}: {key}", entry)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            if field.repr:
                yield from _field_rows(f"{name}: {field.name}", getattr(value, field.name))
    elif not (value is None or (isinstance(value, str | tuple) and not value)):
        yield name.replace("_", " "), _curve_of(value), _text_of(value)


def _curve_of(value: Any) -> str:
    """Return a small curve of an array over one axis, or an empty cell."""
    is_curve = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind == "f"
    return draw_small_curve(value, CONSTANT_RATIO * float(np.max(np.abs(value), initial=0.0))) if is_curve else ""


def _text_of(value: Any) -> str:
    """Return a value in words, of many values their range, of parts with names these names."""
    if isinstance(value, np.ndarray) and value.size and value.dtype.kind == "b":
        return f"{value.mean():.1%} true"
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size and value.dtype.kind in "fi":
        return " to ".join(dict.fromkeys([f"{value.min():.6g}", f"{value.max():.6g}"]))
    if isinstance(value, tuple) and value and all(hasattr(item, "name") for item in value):
        names = [str(item.name) for item in value[:MAX_NAMED_ITEMS]]
        return ", ".join([*names, *(["..."] if len(value) > MAX_NAMED_ITEMS else [])])
    if isinstance(value, tuple) and any(map(dataclasses.is_dataclass, value)):
        return f"{len(value)}"
    return str(value) if isinstance(value, str) else summarise(value)


HEADER = ("reading", "over time", "least", "greatest", "final", "error at most", "unit")
MAX_NAMED_EVENTS = 3
"""Largest number of events that are listed one by one."""
ROUNDING_RATIO = 1e-14
"""Size of rounding errors relative to the scale of a reading, below which a value is zero: some fifty machine epsilons."""


def run_html(run: Trajectory) -> str:
    """Return a run as HTML: title, outcome, accuracy and cost; a table of the readings with small curves; the events."""
    cost = run.cost
    span = f"{len(run.times)} times from {run.times[0]:g} to {run.times[-1]:g} s" if len(run.times) else "no reported time"
    error = "" if run.error_estimate is None else f", relative error at most {format_rounded_up(run.error_estimate)}"
    lines = [
        format_paragraph(run.scene.title, is_bold=True),
        format_paragraph(f"{run.message}{error}"),
        format_paragraph(f"engine {cost.engine}, {cost.steps} steps, {cost.wall_time:.2g} s; {span}"),
    ]
    if len(run.times):
        lines.append(format_html_table(HEADER, _reading_rows(run), n_text_columns=2))
    if run.events:
        shown = "; ".join(map(str, run.events[:MAX_NAMED_EVENTS]))
        more = f"; and {len(run.events) - MAX_NAMED_EVENTS} more" if len(run.events) > MAX_NAMED_EVENTS else ""
        lines.append(format_paragraph(f"events: {shown}{more}"))
    return "".join(lines)


def _reading_rows(run: Trajectory) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each reading, in everyday units."""
    for name, values in run.readings.items():
        unit, factor = display_unit_of(run.units[name])
        rounding = ROUNDING_RATIO * run.scales.get(name, 0.0)
        shown = (0.0 if abs(value) < rounding else value * factor for value in (values.min(), values.max(), values[-1]))
        numbers = (f"{value:.6g}" for value in shown)
        error = run.reading_errors.get(name)
        error_text = "" if error is None else format_rounded_up(error * factor) if error > 0 else "0"
        curve = draw_small_curve(values, READING_NOISE_RATIO * run.scales.get(name, 0.0))
        yield name, curve, *numbers, error_text, unit


def scene_html(scene: Scene) -> str:
    """Return a scene as HTML: title; of each part its machine, dimensions and effects; couplings and readings."""
    description = describe_scene(scene)
    lines = [format_paragraph(scene.title, is_bold=True)]
    for part in description.parts:
        name = f"{part.name}: " if len(description.parts) > 1 else ""
        lines.append(format_paragraph(f"{name}{part.machine}{f', {part.spindle}' if part.spindle else ''}"))
    rows = [row for part in description.parts for row in _part_rows(part, len(description.parts) > 1)]
    rows += [(one.name, one.text) for one in description.couplings]
    rows.append(("readings", ", ".join(one.name for one in description.readings)))
    return "".join([*lines, format_html_table((), rows, n_text_columns=2)])


def _part_rows(part: DescribedPart, is_one_of_many: bool) -> Iterator[tuple[str, str]]:
    """Yield what a part has, and the list of it in words: its dimensions without those that are left out, or else its bodies and joints."""
    end = f" of {part.name}" if is_one_of_many else ""
    dimensions = [f"{one.name} {one.text}" for one in part.dimensions if one.value is not None]
    effects = [f"{one.name} {one.text}".rstrip() for one in part.effects]
    if dimensions:
        yield f"dimensions{end}", ", ".join(dimensions)
    else:
        yield f"bodies{end}", ", ".join(part.bodies)
        yield f"joints{end}", ", ".join(part.joints)
    if effects:
        yield f"effects{end}", ", ".join(effects)


def film_run(
    run: Trajectory | Sequence[Trajectory],
    path: str | os.PathLike[str],  # path of the file: .gif or .mp4, or .html for an interactive page
    *,
    progress: Progress | None = None,  # called with the number of frames done and in total
    **options: Unpack[FilmKeywords],
) -> Film:
    """Write a run, or several side by side, as a film and return its file, which a notebook shows; raise MechanismError as `write_film`."""
    return Film(write_film(run, path, FilmOptions(**options), progress=progress))

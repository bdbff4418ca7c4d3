"""A run as a notebook shows it: how it ended, and a row for each reading."""

from collections.abc import Iterator

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.notebook.html import draw_small_curve, format_html_table, format_paragraph
from governor_mechanism.render.figures.page import READING_NOISE_RATIO
from governor_mechanism.render.number_format import display_unit_of, format_rounded_up

HEADER = ("reading", "over time", "least", "greatest", "final", "error at most", "unit")
MAX_NAMED_EVENTS = 3
"""Largest number of events that are listed one by one."""
ROUNDING_RATIO = 1e-14
"""Size of rounding errors relative to the scale of a reading, below which a value is zero: some fifty machine epsilons."""


def run_html(run: Trajectory) -> str:
    """Return a run as HTML.

    Result: title, outcome, accuracy and cost; a table of the readings with small curves; the events.
    """
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

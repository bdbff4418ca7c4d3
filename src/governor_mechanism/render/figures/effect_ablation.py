"""Figure of effect ablation: the change that each effect causes, and its cost."""

from functools import partial
from typing import Any

from governor_mechanism.render.figures.page import DASHED, Page, Panel
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, VERMILLION
from governor_mechanism.studies.effect_ablation import EffectsStudy

_FIGURE_WIDTH, _ROW_HEIGHT, _HEADER_HEIGHT = 8.4, 0.42, 1.6
"""Figure width, row height, height of header and footer together, inches."""

_MIN_PLOTTED_CHANGE = 1e-16
"""Left end of the bars of changes; smaller changes are not visible."""

_TIME_NOISE_RATIO = 0.1
"""Change of the time below which no bar is drawn: the shortest of three equal runs differs by up to a tenth from one study to the next."""


def effect_ablation_figure(study: EffectsStudy) -> Page:
    """Draw the largest change of any reading by each effect, the requested accuracy, and the time of each effect.

    Result: the figure; `save` writes it.
    """
    rows_height = _ROW_HEIGHT * max(len(study.rows), 1)
    height = _HEADER_HEIGHT + rows_height
    page = Page(_FIGURE_WIDTH, height)
    bottom, axes_height = 0.85 / height, rows_height / height
    add_panel = partial(page.add_panel, label_size=9, tick_colour=INK, grid="x")
    changes = add_panel((0.2, bottom, 0.42, axes_height), "Largest change of a reading [its scale]")
    _draw_changes(changes, study)
    costs = add_panel((0.68, bottom, 0.28, axes_height), "Time with it / time without it [1]")
    costs.sharey(changes)
    _draw_costs(costs, study)
    page.write_title(f"{study.scene.title}: cost of its effects", y=1 - 0.3 / height, size=14)
    return page


def _draw_changes(panel: Panel, study: EffectsStudy) -> None:
    rows = study.rows
    for position, row in enumerate(reversed(rows)):
        if row.relative_change is None:
            panel.text(study.accuracy, position, " cannot be switched off", va="center", fontsize=8, color=MUTED)
            continue
        if row.relative_change < study.accuracy:
            panel.write_note("below it", (study.accuracy, position), (-4, 0), va="center", ha="right", fontsize=8, color=MUTED)
            continue
        panel.barh(position, row.relative_change - _MIN_PLOTTED_CHANGE, left=_MIN_PLOTTED_CHANGE, height=0.6, color=BLUE)
        note = f"{row.relative_change:.1g} ({format_name(row.most_changed_reading)})"
        panel.write_note(note, (row.relative_change, position), (-4, 0), va="center", ha="right", fontsize=7.5, color=PAPER)
    panel.axvline(study.accuracy, color=VERMILLION, linewidth=1.2, linestyle=DASHED)
    point = (study.accuracy, len(rows) - 0.45)
    panel.write_note("requested accuracy", point, (3, 2), color=VERMILLION, fontsize=8, annotation_clip=False)
    panel.set(xscale="log", xlim=(min(1e-2 * study.accuracy, 1e-10), 10.0), ylim=(-0.6, len(rows) - 0.4))
    labels = (format_name(row.effect.replace("spindle.", "")) + ("" if row.listed else " (not listed)") for row in reversed(rows))
    panel.set_yticks(range(len(rows)), list(labels))


def _draw_costs(panel: Panel, study: EffectsStudy) -> None:
    for position, row in enumerate(reversed(study.rows)):
        ratio = row.time_ratio
        style: dict[str, Any] = {"va": "center", "fontsize": 8}
        if ratio is None:
            panel.write_note("a run without it ends early", (1.0, position), (4, 0), color=MUTED, **style)
        elif abs(ratio - 1.0) < _TIME_NOISE_RATIO:
            panel.write_note("below noise", (1.0, position), (4, 0), color=MUTED, **style)
        else:
            panel.barh(position, ratio - 1.0, left=1.0, height=0.6, color=MUTED)
            offset, alignment = (4, "left") if ratio >= 1 else (-4, "right")
            panel.write_note(f"{ratio:.2f}", (ratio, position), (offset, 0), ha=alignment, color=INK, **style)
    panel.axvline(1.0, color=INK, linewidth=0.8)
    shown = [1.0, *(row.time_ratio for row in study.rows if row.time_ratio is not None)]
    panel.set_xlim(min(0.9, min(shown) - 0.25), max(2.0, 1.25 * max(shown)))
    panel.write_note(
        f"noise: ±{_TIME_NOISE_RATIO:.0%}", (1.0, len(study.rows) - 0.45), (3, 2), color=MUTED, fontsize=8, annotation_clip=False
    )
    panel.axvspan(1 - _TIME_NOISE_RATIO, 1 + _TIME_NOISE_RATIO, color=RULE, alpha=0.6, linewidth=0, zorder=0)
    panel.tick_params(labelleft=False)

"""Figure of effect ablation: the change that each effect causes, and its cost."""

from functools import partial

from governor_mechanism.render.figures.page import Page, Panel
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, SKY, VERMILLION
from governor_mechanism.studies.effect_ablation import EffectsStudy

_FIGURE_WIDTH, _ROW_HEIGHT, _HEADER_HEIGHT = 8.4, 0.42, 1.6
"""Figure width, row height, height of header and footer together, inches."""

_MIN_PLOTTED_CHANGE = 1e-16
"""Left end of the bars of changes; smaller changes are not visible."""


def effect_ablation_figure(study: EffectsStudy) -> Page:
    """Draw the largest change of any reading by each effect, the requested accuracy, and the time of each effect.

    Parameters
    ----------
    study
        Result of an effect study.

    Returns
    -------
    Page
        The figure; `save` writes it.
    """
    rows_height = _ROW_HEIGHT * max(len(study.rows), 1)
    height = _HEADER_HEIGHT + rows_height
    page = Page(_FIGURE_WIDTH, height)
    bottom, axes_height = 0.85 / height, rows_height / height
    add_panel = partial(page.add_panel, label_size=9, tick_colour=INK, grid="x")
    changes = add_panel((0.2, bottom, 0.42, axes_height), "largest change of a reading, in units of its scale")
    _draw_changes(changes, study)
    costs = add_panel((0.68, bottom, 0.28, axes_height), "time with it / without it")
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
        width, colour = max(row.relative_change, 2 * _MIN_PLOTTED_CHANGE), SKY if row.relative_change < study.accuracy else BLUE
        panel.barh(position, width, left=_MIN_PLOTTED_CHANGE, height=0.6, color=colour)
    panel.axvline(study.accuracy, color=VERMILLION, linewidth=1.2)
    point = (study.accuracy, len(rows) - 0.45)
    panel.write_note("requested accuracy", point, (3, 2), color=VERMILLION, fontsize=8, annotation_clip=False)
    panel.set(xscale="log", xlim=(min(1e-2 * study.accuracy, 1e-10), 10.0), ylim=(-0.6, len(rows) - 0.4))
    labels = (format_name(row.effect.replace("spindle.", "")) + ("" if row.listed else " (not listed)") for row in reversed(rows))
    panel.set_yticks(range(len(rows)), list(labels))


def _draw_costs(panel: Panel, study: EffectsStudy) -> None:
    for position, row in enumerate(reversed(study.rows)):
        ratio = row.time_ratio
        if ratio is not None:
            panel.barh(position, ratio - 1.0, left=1.0, height=0.6, color=MUTED)
            offset, alignment = (4, "left") if ratio >= 1 else (-4, "right")
            panel.write_note(f"{ratio:.2f}", (ratio, position), (offset, 0), va="center", ha=alignment, fontsize=8, color=INK)
    panel.axvline(1.0, color=INK, linewidth=0.8)
    panel.margins(x=0.25)
    panel.tick_params(labelleft=False)

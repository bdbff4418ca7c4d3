"""Figure of Marks' slide valve: what the finite eccentric rod changes at both ends of the cylinder, and what the paper says of it."""

import math
from dataclasses import replace

from governor_mechanism.closed_form.slide_valve import event_angle
from governor_mechanism.render.figures.errata.canvas import TEXT_SIZE, add_panel, new_page
from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.style import BLUE, INK, MUTED, SKY, VERMILLION
from governor_mechanism.studies.errata.marks import ECCENTRIC, LAPS

PAPER_SENSES = {"compression": 1, "release": 1, "admission": -1, "cut-off": -1}
"""Sense of the change that the paper states for the end whose fill shrinks, by the event that begins it; at the other end the opposite."""

_NAMES = {"compression": "compression", "release": "pre-release", "admission": "pre-admission", "cut-off": "fill"}
_ENDS = {"crank end": (BLUE, 0.19), "head end": (VERMILLION, -0.19)}
"""Colours of the ends, and the heights of their bars above the middle of the row."""


def draw_cylinder_ends() -> Page:
    """Draw the changes as bars, with the senses that the paper states."""
    page = new_page(
        "Marks’ error term at the two ends of the cylinder",
        "three of the four changes go together as the paper states; compression does not",
    )
    panel = add_panel(page, (0.215, 0.155, 0.765, 0.655), "Change by the finite eccentric rod [% of the stroke]", "")
    panel.grid(visible=False, axis="y")
    for row, (event, sense) in enumerate(PAPER_SENSES.items()):
        for end, (colour, height) in _ENDS.items():
            change = _change(end, event)
            stated = sense if end == "crank end" else -sense
            panel.barh(-row + height, change, height=0.34, color=colour, zorder=3)
            is_right = math.copysign(1, change) == stated
            text = ("grows" if stated > 0 else "shrinks") + ("" if is_right else " (wrong)")
            offset, side = ((5, 0), "left") if change > 0 else ((-5, 0), "right")
            style = {"color": MUTED} if is_right else {"color": INK, "fontweight": "bold"}
            panel.annotate_point((change, -row + height), text, offset, ha=side, va="center", fontsize=TEXT_SIZE, **style)
    panel.axvline(0.0, color=INK, linewidth=0.9, zorder=4)
    panel.axhspan(-0.5, 0.5, color=SKY, alpha=0.16, linewidth=0)
    panel.set(
        xlim=(-1.75, 1.75),
        ylim=(-4.35, 0.55),
        yticks=range(0, -len(PAPER_SENSES), -1),
        yticklabels=[_NAMES[event] for event in PAPER_SENSES],
    )
    panel.tick_params(axis="y", length=0, labelsize=TEXT_SIZE + 0.5, labelcolor=INK)
    panel.annotate_point((-1.7, -3.72), "crank end: its fill shrinks", color=BLUE, fontsize=TEXT_SIZE, va="center")
    panel.annotate_point((1.7, -3.72), "head end: its fill grows", color=VERMILLION, fontsize=TEXT_SIZE, va="center", ha="right")
    panel.annotate_point(
        (0, -4.12), "words at the bars: what the paper states of such an end", color=MUTED, fontsize=TEXT_SIZE, va="center", ha="center"
    )
    return page


def _change(end: str, event: str) -> float:
    """Return by how much the rod changes what the event begins or ends, in percent of the stroke; the connecting rod is infinitely long."""
    exact, theory = (_stroke_fraction(end, event, rod) for rod in (ECCENTRIC.rod, math.inf))
    return 100 * (exact - theory) * (-1 if event == "release" else 1)


def _stroke_fraction(end: str, event: str, rod: float) -> float:
    """Return the part of the stroke, from the event's own end, at which the piston is."""
    angle = event_angle(replace(ECCENTRIC, rod=rod), event=f"{end} {event}", **LAPS)
    return (1 - math.cos(angle)) / 2 if end == "crank end" else (1 + math.cos(angle)) / 2

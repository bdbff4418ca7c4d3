"""Figure of a governed engine after a change of its load: speed, sleeve, torque and load over one time axis."""

import math
from typing import Any

import numpy as np

from governor_mechanism.render.figures.band_plot import BAND_OPACITY
from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Page, Panel
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.render.machines.engine_room.torques import engine_torque
from governor_mechanism.render.range_bands import COLUMN_WIDTH, make_range_band
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, VERMILLION
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine
from governor_mechanism.studies.regulation.load_change import LoadChangeStudy
from governor_mechanism.studies.regulation.speed_response import SETTLING_BAND, Verdict
from governor_mechanism.units.constants import RPM


def load_change_figure(study: LoadChangeStudy) -> Page:
    """Draw speed, sleeve lift, and torque with load, over time."""
    page = Page(8.0, 7.4, study.conclusion[:1].upper() + study.conclusion[1:], study.title, subtitle_y=0.915)
    governed = GovernedEngine(study.run.scene)
    run = study.run
    times, begin = run.times, study.change_times[0]
    speed, sleeve, torque = (page.add_panel((0.10, y, 0.86, 0.225), "", label) for y, label in _PANELS)
    angles, n_columns = run.readings[governed.shaft_angle], math.ceil(speed.bbox.width / COLUMN_WIDTH)
    speeds, lift = run.rates[governed.shaft_angle] / RPM, run.readings[governed.sleeve] * MM_PER_M
    bands = [make_range_band(times, values, angles / math.tau, n_columns) for values in (speeds, lift)]
    if not governed.has_mean_torque:
        for panel, band in zip((speed, sleeve), bands, strict=True):
            panel.fill_between(band.times, band.low, band.high, color=BLUE, alpha=BAND_OPACITY, linewidth=0)
        speed.write_note("line: mean over a turn; band: range within it", (0.985, 0.06), **_corner(MUTED))
    speed.plot(study.average.times, study.average.speeds / RPM, color=BLUE, linewidth=1.6)
    _draw_settling(speed, study)
    sleeve.plot(bands[1].mean_times, bands[1].means, color=BLUE, linewidth=1.6)
    _draw_torques(torque, study, governed)
    for panel in (speed, sleeve, torque):
        panel.axvline(begin, color=MUTED, linewidth=0.9, linestyle=DASHED)
        panel.set_xlim(0.0, float(study.run.scene.run.duration))
        panel.label("", panel.get_ylabel())
    torque.label("Time [s]", torque.get_ylabel())
    page.write_footnote(_footnote(study, governed))
    return page


_HALO = {"facecolor": PAPER, "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
"""Ground of a note above curves."""

_PANELS = ((0.635, "Speed of the shaft [rpm]"), (0.36, "Sleeve lift [mm]"), (0.085, "Torque [N m]"))
"""Lower edge and label of each panel."""


def _draw_settling(panel: Panel, study: LoadChangeStudy) -> None:
    """Draw the equilibria of statics, and the settling band where the speed settles."""
    end = study.run.scene.run.duration
    begin = study.change_times[0]
    for point, span in ((study.before, (0.0, begin)), (study.after, (begin, end))):
        if point is not None:
            panel.plot(span, [point.shaft_speed / RPM] * 2, color=VERMILLION, linewidth=1.0, linestyle=DASHED)
    if study.after is not None:
        height = study.after.shaft_speed / RPM
        panel.write_note("equilibrium by statics", (end, height), (-4, 4), ha="right", color=VERMILLION, fontsize=8, bbox=_HALO)
    if study.verdict is Verdict.SETTLES:
        first, _, last = (one / RPM for one in study.mean_speeds)
        half = SETTLING_BAND * abs(last - first)
        panel.axhspan(last - half, last + half, color=GREEN, alpha=0.15, linewidth=0)
        settled = begin + study.settling_time
        panel.axvline(settled, color=GREEN, linewidth=0.9)
        low = panel.get_ylim()[0]
        panel.write_note(f"settled after {study.settling_time:.3g} s", (settled, low), (5, 5), color=GREEN, fontsize=8)


def _draw_torques(panel: Panel, study: LoadChangeStudy, governed: GovernedEngine) -> None:
    """Draw the torque of the engine averaged over a turn, and the load."""
    run = study.run
    part = governed.shaft_angle.rpartition(".")[0]
    if arrangement := find_governed_engine(run.scene):
        panel.plot(*engine_torque(run, arrangement), color=BLUE, linewidth=1.6)
        panel.write_note("engine, mean over a turn" if not governed.has_mean_torque else "engine", (0.985, 0.88), **_corner(BLUE))
    panel.plot(run.times, run.readings[f"{part}.load_torque"], color=INK, linewidth=1.2, linestyle=DASHED)
    panel.write_note("load (dashed)", (0.985, 0.76), **_corner(INK))


def _corner(colour: str) -> dict[str, Any]:
    return {"xycoords": "axes fraction", "ha": "right", "color": colour, "fontsize": 8, "bbox": _HALO}


def _footnote(study: LoadChangeStudy, governed: GovernedEngine) -> str:
    """Return droop, overshoot and fluctuation in a line."""
    droop = f"droop {study.droop:+.3%}, by statics {study.static_droop:+.3%}"
    overshoot = f"overshoot {study.overshoot:.1%} of the change" if np.isfinite(study.overshoot) else ""
    cyclic = (
        "" if governed.has_mean_torque else f"speed fluctuation in a turn {study.fluctuations[0]:.2%}, then {study.fluctuations[1]:.2%}"
    )
    accuracy = f"engine {study.run.cost.engine}"
    return "; ".join(text for text in (droop, overshoot, cyclic, accuracy) if text)

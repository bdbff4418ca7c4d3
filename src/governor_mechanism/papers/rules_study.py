"""The papers' rules about governing, each tested by simulations of the governed engine, and their figure.

Results for the shipped engine under a Porter governor:

- The sleeve shakes at every turn as soon as the coefficient of fluctuation of speed exceeds the insensitivity of the governor, as
  Zehnder writes; clearance in its joints is no remedy, and an oil brake reduces the shaking but makes the governor slow.
- The dead band of speed is W / (P + Q), and K / S of a strong governor is as much smaller as its force is larger.
- A dashpot is necessary. Dry friction stops the hunting only from displacements up to that of harmonic balance.
- An astatic governor hunts. What it passes on to the shaft makes it stable only with a dashpot so strong that it takes hours.
"""

import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.papers.damping import DashpotCheck, DryFrictionCheck, check_dashpot, check_dry_friction
from governor_mechanism.papers.dead_band import DeadBandCheck, RegulatingForceCheck, check_dead_band, check_regulating_force
from governor_mechanism.papers.droop import DroopCheck, check_droop
from governor_mechanism.papers.rule import RuleCheck, Verdict, build_cyclic_engine, find_steady_engine
from governor_mechanism.papers.shaking import ClearanceCheck, OilBrakeCheck, ShakingCheck, check_clearance, check_oil_brake, check_shaking
from governor_mechanism.render.figures.page import (
    DASHED,
    MM_PER_M,
    SERIES_LINE_STYLES,
    SERIES_MARKERS,
    Page,
    Panel,
    add_legend,
    use_plain_decades,
)
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.units.text_table import short_repr

ENGINE = "governed_engine"
MEAN_ENGINE = "governed_engine_mean_torque"
STRONG_ENGINE = "governed_engine_hartung"
"""Shipped scenes of one engine: its gas at every instant, the mean torque of its gas, and a strong governor."""

TEXT_WIDTH = 110
"""Letters of a line of text."""


@dataclass(frozen=True, kw_only=True)
class PaperRules(Result):
    """Rules of the papers with the verdicts of the simulation.

    Attributes
    ----------
    shaking
        The insensitivity of the governor must not be less than the fluctuation of speed.
    oil_brake
        A dashpot reduces the shaking.
    clearance
        Clearance in the joints reduces the shaking.
    dead_band
        Friction makes a dead band of speed.
    force
        A governor with a large force has a small dead band.
    damping
        A governor needs damping, neither too little nor too much.
    dry_friction
        Dry friction is no such damping, or only for small displacements.
    droop
        A governor needs droop.
    """

    shaking: ShakingCheck
    oil_brake: OilBrakeCheck
    clearance: ClearanceCheck
    dead_band: DeadBandCheck
    force: RegulatingForceCheck
    damping: DashpotCheck
    dry_friction: DryFrictionCheck
    droop: DroopCheck

    __repr__ = short_repr

    figure = "papers.rules_study.paper_rules_figure"
    data_files = ("json",)
    record = ("rules=rows",)
    columns = (
        Column("rule", "rule", value="title"),
        Column("source"),
        Column("statement"),
        Column("finding"),
        Column("verdict", "verdict", "{verdict_text}", value="verdict.value"),
        Column("condition"),
        Column("numbers", value=lambda rule: rule.numbers(), in_table=False),
    )

    @property
    def rows(self) -> tuple[RuleCheck, ...]:
        """The rules in their order, which are the rows of tables."""
        return tuple(self)

    def __iter__(self) -> Iterator[RuleCheck]:
        """Return the rules in their order."""
        return (getattr(self, name) for name in self.__dataclass_fields__)

    def __str__(self) -> str:
        """Return a table of rules and verdicts, and for each rule what the paper says and what the simulation shows."""
        numbers = Column("", "", lambda rule: f"{1 + self.rows.index(rule)}")
        table = format_columns((numbers, *self.columns), self.rows)
        return "\n\n".join([table, *(_format_rule(k, rule) for k, rule in enumerate(self, start=1))])


def _format_rule(number: int, rule: RuleCheck) -> str:
    heading = f"{number}. {rule.title}: {rule.verdict.value.upper()}"
    texts = (f"paper: {rule.statement} ({rule.source})", f"simulation: {rule.finding}")
    return "\n".join([heading, *(textwrap.fill(text, TEXT_WIDTH, initial_indent="   ", subsequent_indent="      ") for text in texts)])


def study_paper_rules(
    # called with the number of rules that are done and the number of all, before each rule and at the end
    progress: Callable[[int, int], None] | None = None,
) -> PaperRules:
    """Test the papers' rules about governing on the shipped scenes of the governed engine; raise MechanismError if a run fails."""
    engine, mean_engine, strong_engine = (load_scene(name) for name in (ENGINE, MEAN_ENGINE, STRONG_ENGINE))
    point = find_steady_engine(mean_engine)
    cyclic_engine = build_cyclic_engine(engine, point, {})
    checks: dict[str, Callable[[], RuleCheck]] = {
        "shaking": partial(check_shaking, engine, point, cyclic_engine),
        "oil_brake": partial(check_oil_brake, cyclic_engine),
        "clearance": partial(check_clearance, engine, mean_engine, cyclic_engine),
        "dead_band": partial(check_dead_band, point),
        "force": partial(check_regulating_force, point, mean_engine, strong_engine),
        "damping": partial(check_dashpot, mean_engine, point),
        "dry_friction": partial(check_dry_friction, point),
        "droop": partial(check_droop, mean_engine, point),
    }
    results: dict[str, Any] = {}
    for name, check in checks.items():
        if progress is not None:
            progress(len(results), len(checks))
        results[name] = check()
    if progress is not None:
        progress(len(results), len(checks))
    return PaperRules(**results)


_PAGE_SIZE = 8.0, 13.0
"""Width and height of the figure, inches."""

_VERDICT_COLOURS = {Verdict.HOLDS: GREEN, Verdict.CONDITIONAL: BLUE, Verdict.FAILS: VERMILLION}
_LEGEND: dict[str, Any] = {"fontsize": 8.5, "handlelength": 1.4, "borderaxespad": 0.2, "labelspacing": 0.3}


def paper_rules_figure(rules: PaperRules) -> Page:
    """Draw every rule with its verdict."""
    page = Page(*_PAGE_SIZE)
    page.write_title("The papers' rules about governing, in the simulated engine", y=0.978)
    page.write_title(
        "an air engine of 1853 under a Porter governor; each panel with the verdict of the simulation", y=0.958, size=10.5, colour=MUTED
    )
    grid = page.add_gridspec(4, 2, left=0.095, right=0.975, bottom=0.045, top=0.905, wspace=0.26, hspace=0.62)
    draw: dict[type[RuleCheck], Callable[[Any, Any], None]] = {
        ShakingCheck: _draw_shaking,
        OilBrakeCheck: _draw_oil_brake,
        ClearanceCheck: _draw_clearance,
        DeadBandCheck: _draw_dead_band,
        RegulatingForceCheck: _draw_force,
        DashpotCheck: _draw_damping,
        DryFrictionCheck: _draw_dry_friction,
        DroopCheck: _draw_droop,
    }
    for k, rule in enumerate(rules):
        panel = page.add_panel(grid[divmod(k, 2)], label_size=10, tick_size=8.5)
        panel.write_heading(f"{k + 1}  {rule.title[0].upper()}{rule.title[1:]}", y=1.15, size=12)
        colour = _VERDICT_COLOURS[rule.verdict]
        panel.write_note(rule.verdict_text, (0.0, 1.045), xycoords="axes fraction", color=colour, fontsize=9, fontweight="bold")
        draw[type(rule)](panel, rule)
    return page


_SERIES_STYLES = [
    {"color": colour, "linestyle": line, "marker": marker}
    for colour, line, marker in zip(SERIES_COLOURS, SERIES_LINE_STYLES, SERIES_MARKERS, strict=True)
]
_PAIR_STYLES = ((VERMILLION, "-"), (BLUE, DASHED))
"""Styles of several curves, and of two without markers."""


def _draw_shaking(panel: Panel, check: ShakingCheck) -> None:
    """Draw the motion of the sleeve against insensitivity over fluctuation of speed."""
    panel.label("Insensitivity δ / fluctuation of speed ε [1]", "Sleeve [mm per turn]")
    amplitudes = MM_PER_M * check.amplitudes
    panel.plot(check.ratios, amplitudes, "o-", color=BLUE, linewidth=1.5, markersize=4.5)
    panel.set(xlim=(0.0, float(check.ratios.max())), ylim=(-0.04 * amplitudes.max(), 1.08 * amplitudes.max()))
    threshold = next(iter(check.thresholds.values()))
    panel.axvline(threshold, color=VERMILLION, linewidth=1.1, linestyle=DASHED)
    transform = panel.get_xaxis_transform()
    panel.write_note(f"rests from\n{threshold:.3f} on", (threshold, 0.55), (5, 0), xycoords=transform, color=VERMILLION)
    panel.write_note("shakes", (0.55, 0.10), xycoords=transform, color=BLUE, ha="center")


def _draw_oil_brake(panel: Panel, check: OilBrakeCheck) -> None:
    """Draw motion and rate of recovery against the dashpot, each over its largest value."""
    panel.label("Dashpot at the sleeve [N s/m]", "Relative to the largest [1]")
    panel.plot(check.dampings, check.amplitudes / check.amplitudes.max(), "o-", color=BLUE, markersize=4.5, label="sleeve motion per turn")
    rates = check.decay_rates / check.decay_rates.max()
    panel.plot(check.dampings, rates, "s--", color=VERMILLION, markersize=4.5, label="rate of recovery")
    panel.set(xscale="log", ylim=(0.0, 1.42))
    panel.set_yticks([0.0, 0.5, 1.0])
    use_plain_decades(panel.xaxis)
    add_legend(panel, {"color": INK}, loc="upper right", **_LEGEND)


def _draw_clearance(panel: Panel, check: ClearanceCheck) -> None:
    """Draw the motion of the sleeve over that without clearance."""
    panel.label("Clearance [mm]", "Motion / without clearance [1]")
    panel.axhline(1.0, color=MUTED, linewidth=0.9, linestyle=DASHED)
    for name, style in zip(check.amplitudes, _SERIES_STYLES, strict=False):
        panel.plot(MM_PER_M * check.clearances[1:], check.relative_motion(name)[1:], markersize=4.5, label=name, **style)
    panel.set(xscale="log", yscale="log")
    low, high = panel.get_ylim()
    panel.set_ylim(min(0.6, low), 3.5 * high)
    use_plain_decades(panel.xaxis, panel.yaxis)
    add_legend(panel, {"color": INK}, loc="upper left", ncols=2, **_LEGEND)


def _draw_dead_band(panel: Panel, check: DeadBandCheck) -> None:
    """Draw two runs that come to rest in the band of speeds."""
    panel.label("Time [s]", "Speed [% from equilibrium]")
    low, high = (100 * end for end in check.band)
    panel.axhspan(low, high, color=SKY, alpha=0.18, linewidth=0)
    for (times, deviations), (colour, line), load in zip(
        check.histories, _PAIR_STYLES, (check.loads_before[0], check.loads_before[-1]), strict=True
    ):
        panel.plot(
            times, 100 * deviations, color=colour, linestyle=line, linewidth=1.4, label=f"{load:.0%} to 50 % load".replace("%", " %", 1)
        )
    panel.set_xlim(0.0, 0.5 * float(check.histories[0][0][-1]))
    panel.locator_params(axis="x", nbins=5)
    panel.set_ylim(2.6 * low, 2.6 * high)
    panel.write_note(
        f"dead band {high - low:.2f} % under {check.rest_friction:g} N",
        (0.98, 0.5),
        (0, -3),
        xycoords="axes fraction",
        color=INK,
        ha="right",
    )
    add_legend(panel, {"color": INK}, loc="upper right", **_LEGEND)


def _draw_force(panel: Panel, check: RegulatingForceCheck) -> None:
    """Draw the measured bands over K / S."""
    panel.label("Friction K at the sleeve [N]", "Dead band of speed [%]")
    for k, (name, colour, marker) in enumerate((("Porter", BLUE, "o"), ("Hartung", VERMILLION, "s"))):
        force = check.sleeve_forces[k]
        panel.plot(check.frictions, 100 * check.frictions / force, color=colour, linewidth=1.1)
        panel.plot(check.frictions, 100 * check.widths[k], marker, color=colour, markersize=5, label=f"{name}, S = {force:.0f} N")
    panel.set(xscale="log", yscale="log")
    low, high = panel.get_ylim()
    panel.set_ylim(low, 9 * high)
    use_plain_decades(panel.yaxis)
    panel.set_xticks(check.frictions, [f"{friction:g}" for friction in check.frictions])
    panel.set_xticks([], minor=True)
    panel.write_note("lines: K / S", (0.98, 0.08), xycoords="axes fraction", color=MUTED, ha="right")
    add_legend(panel, {"color": INK}, loc="upper left", **_LEGEND)


def _draw_damping(panel: Panel, check: DashpotCheck) -> None:
    """Draw the settling time against the dashpot."""
    panel.label("Dashpot at the sleeve [N s/m]", "Settling time [s]")
    settled = np.isfinite(check.settling_times)
    panel.plot(check.dampings[settled], check.settling_times[settled], "o-", color=BLUE, linewidth=1.4, markersize=4)
    damping, time = check.best
    panel.plot([damping], [time], "D", color=VERMILLION, markersize=7)
    panel.set(xscale="log", xlim=(0.55 * check.limit, 1.2 * check.dampings[-1]), ylim=(0.0, None))
    panel.axvspan(0.55 * check.limit, check.limit, color=VERMILLION, alpha=0.13, linewidth=0)
    transform = panel.get_xaxis_transform()
    panel.write_note("hunts", (0.74 * check.limit, 0.5), xycoords=transform, color=INK, rotation=90, ha="center", va="center")
    panel.write_note(f"{time:.2g} s with {damping:g} N s/m", (damping, time), (0, 46), color=VERMILLION, ha="center")
    use_plain_decades(panel.xaxis)


def _draw_dry_friction(panel: Panel, check: DryFrictionCheck) -> None:
    """Draw a run that friction stops, and one that it does not."""
    panel.label("Time [s]", "Sleeve [mm from equilibrium]")
    middle = float(np.mean([lifts[-1] for _, _, lifts in check.histories[:1]]))
    for (ratio, times, lifts), (colour, line) in zip(reversed(check.histories), _PAIR_STYLES, strict=True):
        start = MM_PER_M * ratio * check.predicted_limits[0]
        panel.plot(times, MM_PER_M * (lifts - middle), color=colour, linestyle=line, linewidth=1.3, label=f"from {start:.1f} mm")
    highest = MM_PER_M * max(float(np.abs(lifts - middle).max()) for _, _, lifts in check.histories)
    panel.set(xlim=(0.0, float(check.histories[0][1][-1])), ylim=(-1.1 * highest, 1.75 * highest))
    limit = f"no dashpot, {check.friction:g} N dry: limit {MM_PER_M * check.limits[0]:.1f} mm"
    panel.write_note(limit, (0.03, 0.04), xycoords="axes fraction", color=INK)
    add_legend(panel, {"color": INK}, loc="upper right", ncols=2, **_LEGEND)


def _draw_droop(panel: Panel, check: DroopCheck) -> None:
    """Draw the growth rate against the droop."""
    panel.label("Droop over the travel of the throttle [%]", "Growth rate [1/s]")
    panel.axhline(0.0, color=INK, linewidth=0.9)
    for rates, damping, style in zip(check.growth_rates, check.dampings, _SERIES_STYLES, strict=False):
        panel.plot(100 * check.droops, rates, markersize=4, linewidth=1.3, label=f"{damping:g} N s/m", **style)
    panel.set_xlim(-0.15, 103 * float(check.droops.max()))
    panel.write_note("hunts", (0.87, 0.0), (0, 7), xycoords=panel.get_yaxis_transform(), color=INK, ha="center")
    panel.write_note("settles", (0.87, 0.0), (0, -36), xycoords=panel.get_yaxis_transform(), color=INK, ha="center")
    add_legend(panel, {"color": INK}, loc="upper right", **_LEGEND)

"""The papers' rules about governing, each tested by simulations of the governed engine.

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

from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.papers.damping import DashpotCheck, DryFrictionCheck, check_dashpot, check_dry_friction
from governor_mechanism.papers.dead_band import DeadBandCheck, RegulatingForceCheck, check_dead_band, check_regulating_force
from governor_mechanism.papers.droop import DroopCheck, check_droop
from governor_mechanism.papers.rule import RuleCheck, build_cyclic_engine, find_steady_engine
from governor_mechanism.papers.shaking import ClearanceCheck, OilBrakeCheck, ShakingCheck, check_clearance, check_oil_brake, check_shaking
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.units.text_table import short_repr

ENGINE, MEAN_ENGINE, STRONG_ENGINE = "governed_engine", "governed_engine_mean_torque", "governed_engine_hartung"
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

    figure = "papers.rules_figure.paper_rules_figure"
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

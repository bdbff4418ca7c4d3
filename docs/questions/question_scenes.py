"""The scenes of the interactive pages that the questions show beside those of shipped scenes, by the name of the page."""

from __future__ import annotations

import math
from collections.abc import Callable

import governor_mechanism as gm

DASHPOT = "part.governor.effects.dashpot.sleeve"
LAP, RADIUS = 24.0, 60.0
"""Of the slide valve and its eccentric, mm."""


def _engine(dashpot: str) -> gm.Scene:
    """Return an engine that loses half its load, with a dashpot at its governor."""
    return gm.load("governed_engine_mean_torque").replace({DASHPOT: dashpot, "run.duration": "30 s", "run.output_interval": "50 ms"})


def valve_with_lead(lead: float) -> gm.Scene:
    """Return the slide valve with a lead in mm: the advance of its eccentric follows."""
    advance = math.degrees(math.asin((LAP + lead) / RADIUS))
    return gm.load("slide_valve_marks").replace({"dimensions.advance": f"{advance!r} deg"})


def engine_with_flywheel(coefficient: float = 0.02) -> gm.Scene:
    """Return Redtenbacher's engine with the flywheel that a fluctuation of its speed needs."""
    return gm.design_flywheel(load_pressure="closing", coefficient=coefficient).scene


SCENES: dict[str, Callable[[], gm.Scene]] = {
    "question_hunting": lambda: _engine("10 N s/m"),
    "question_settling": lambda: _engine("60 N s/m"),
    "question_no_lead": lambda: valve_with_lead(0.0),
    "question_line": lambda: gm.load("watt_linkage").replace({"run.paths": ["pen"]}),
    "question_flywheel": engine_with_flywheel,
    "question_light_flywheel": lambda: engine_with_flywheel(0.08),
}

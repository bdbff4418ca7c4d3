"""Public functions of the package. Each imports what it needs on its first call, so that the package imports quickly."""

from governor_mechanism.api.crosschecks import crosscheck, errata
from governor_mechanism.api.designs import design_flywheel, design_governed_engine, design_hartnell, design_pendulum
from governor_mechanism.api.kinematics import kinematics, valve_gears, valve_timing
from governor_mechanism.api.regulation import load_change_study, paper_rules, stability_map
from governor_mechanism.api.runs import compile_kernels, film, open_run, run
from governor_mechanism.api.scenes import list_models, load
from governor_mechanism.api.statics import (
    controlling_force,
    equilibria,
    explore,
    insensitivity_band,
    linearise,
    speed_curve,
    stability_limit,
)
from governor_mechanism.api.studies import accuracy_study, compare, effects_study, hard_cases, sweep

__all__ = [
    "accuracy_study",
    "compare",
    "compile_kernels",
    "controlling_force",
    "crosscheck",
    "design_flywheel",
    "design_governed_engine",
    "design_hartnell",
    "design_pendulum",
    "effects_study",
    "equilibria",
    "errata",
    "explore",
    "film",
    "hard_cases",
    "insensitivity_band",
    "kinematics",
    "linearise",
    "list_models",
    "load",
    "load_change_study",
    "open_run",
    "paper_rules",
    "run",
    "speed_curve",
    "stability_limit",
    "stability_map",
    "sweep",
    "valve_gears",
    "valve_timing",
]

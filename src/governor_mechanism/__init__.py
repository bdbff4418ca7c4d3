"""Planar mechanisms of machine control: governors, valve gears and engines.

A scene is described once, simulated by several engines, and verified against closed forms.

Examples
--------
>>> import governor_mechanism as gm
>>> run = gm.run(gm.load("porter"), accuracy=1e-8)
>>> run.outcome.ok
True
"""

from governor_mechanism.api import (
    accuracy_study,
    compile_kernels,
    controlling_force,
    crosscheck,
    design_flywheel,
    design_governed_engine,
    effects_study,
    equilibria,
    film,
    hard_cases,
    insensitivity_band,
    kinematics,
    linearise,
    list_models,
    load,
    load_change_study,
    paper_rules,
    run,
    speed_curve,
    stability_limit,
    stability_map,
    sweep,
    valve_gears,
    valve_timing,
)
from governor_mechanism.errors import GovernorMechanismError, MechanismError, RunFailed, UnsupportedEffect

__version__ = "0.1.0"

__all__ = [
    "GovernorMechanismError",
    "MechanismError",
    "RunFailed",
    "UnsupportedEffect",
    "accuracy_study",
    "compile_kernels",
    "controlling_force",
    "crosscheck",
    "design_flywheel",
    "design_governed_engine",
    "effects_study",
    "equilibria",
    "film",
    "hard_cases",
    "insensitivity_band",
    "kinematics",
    "linearise",
    "list_models",
    "load",
    "load_change_study",
    "paper_rules",
    "run",
    "speed_curve",
    "stability_limit",
    "stability_map",
    "sweep",
    "valve_gears",
    "valve_timing",
]

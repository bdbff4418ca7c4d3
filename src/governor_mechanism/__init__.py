"""Planar mechanisms of machine control: governors, valve gears and engines.

A scene is described once, simulated by several engines, and verified against closed forms.

Examples
--------
>>> import governor_mechanism as gm
>>> run = gm.run(gm.load("porter"), accuracy=1e-8)
>>> run.outcome.ok
True
"""

from typing import TYPE_CHECKING, Any

from governor_mechanism import public_types
from governor_mechanism.api import (
    accuracy_study,
    compare,
    compile_kernels,
    controlling_force,
    crosscheck,
    design_flywheel,
    design_governed_engine,
    design_hartnell,
    design_pendulum,
    effects_study,
    equilibria,
    errata,
    explore,
    film,
    hard_cases,
    insensitivity_band,
    kinematics,
    linearise,
    list_models,
    load,
    load_change_study,
    open_run,
    paper_rules,
    run,
    speed_curve,
    stability_limit,
    stability_map,
    sweep,
    valve_gears,
    valve_timing,
)
from governor_mechanism.errors import GovernorMechanismError, MechanismError, RunFailed, UnsupportedEffect, did_you_mean

if TYPE_CHECKING:
    from governor_mechanism.public_types import (
        AccuracyStudy,
        CheckReport,
        ClusterClient,
        Comparison,
        ControllingForce,
        EffectsStudy,
        Energy,
        Engine,
        Equilibrium,
        Errata,
        Exploration,
        FloatArray,
        FlywheelDesign,
        GovernedEngineDesign,
        HardCasesReport,
        HartnellDesign,
        InputValues,
        InsensitivityBand,
        KernelCompilation,
        KernelReport,
        Kinematics,
        Linearisation,
        LoadChangeStudy,
        Mechanism,
        MechanismBuilder,
        Outcome,
        PaperRules,
        PendulumDesign,
        Progress,
        QuantityValues,
        Reaction,
        Scene,
        SceneDescription,
        SceneSource,
        SpeedCurve,
        StabilityLimit,
        StabilityMap,
        Sweep,
        Trajectory,
        ValveGears,
        ValveTiming,
    )

__version__ = "0.1.0"

__all__ = [
    "AccuracyStudy",
    "CheckReport",
    "ClusterClient",
    "Comparison",
    "ControllingForce",
    "EffectsStudy",
    "Energy",
    "Engine",
    "Equilibrium",
    "Errata",
    "Exploration",
    "FloatArray",
    "FlywheelDesign",
    "GovernedEngineDesign",
    "GovernorMechanismError",
    "HardCasesReport",
    "HartnellDesign",
    "InputValues",
    "InsensitivityBand",
    "KernelCompilation",
    "KernelReport",
    "Kinematics",
    "Linearisation",
    "LoadChangeStudy",
    "Mechanism",
    "MechanismBuilder",
    "MechanismError",
    "Outcome",
    "PaperRules",
    "PendulumDesign",
    "Progress",
    "QuantityValues",
    "Reaction",
    "RunFailed",
    "Scene",
    "SceneDescription",
    "SceneSource",
    "SpeedCurve",
    "StabilityLimit",
    "StabilityMap",
    "Sweep",
    "Trajectory",
    "UnsupportedEffect",
    "ValveGears",
    "ValveTiming",
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


def __getattr__(name: str) -> Any:
    """Return a type of the public functions; it is imported when it is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}.{did_you_mean(name, __all__)}")
    return getattr(public_types, name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])

"""Types of arguments and results of the public functions, each imported on its first use, so that the package imports quickly.

`api` writes its annotations with this module, so that `typing.get_type_hints` finds the types, and `__init__` hands them on.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from governor_mechanism.building.mechanism_builder import MechanismBuilder as MechanismBuilder
    from governor_mechanism.engines import Engine as Engine
    from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics as Kinematics
    from governor_mechanism.model.mechanism import Mechanism as Mechanism
    from governor_mechanism.model.results.energy import Energy as Energy
    from governor_mechanism.model.results.outcome import Outcome as Outcome
    from governor_mechanism.model.results.reaction import Reaction as Reaction
    from governor_mechanism.model.results.trajectory import Trajectory as Trajectory
    from governor_mechanism.model.scene import Scene as Scene
    from governor_mechanism.notebook.exploring.exploration import Exploration as Exploration
    from governor_mechanism.scenes.described_scene import SceneDescription as SceneDescription
    from governor_mechanism.scenes.library import SceneSource as SceneSource
    from governor_mechanism.statics.controlling_force import ControllingForce as ControllingForce
    from governor_mechanism.statics.equilibria import Equilibrium as Equilibrium
    from governor_mechanism.statics.linearisation import Linearisation as Linearisation
    from governor_mechanism.statics.speed_curve import InsensitivityBand as InsensitivityBand
    from governor_mechanism.statics.speed_curve import SpeedCurve as SpeedCurve
    from governor_mechanism.statics.stability_limit import StabilityLimit as StabilityLimit
    from governor_mechanism.studies.comparison.comparison import Comparison as Comparison
    from governor_mechanism.studies.effect_ablation import EffectsStudy as EffectsStudy
    from governor_mechanism.studies.errata.results import Errata as Errata
    from governor_mechanism.studies.flywheel.design import FlywheelDesign as FlywheelDesign
    from governor_mechanism.studies.governed_engine.results import GovernedEngineDesign as GovernedEngineDesign
    from governor_mechanism.studies.hard_cases.results import HardCasesReport as HardCasesReport
    from governor_mechanism.studies.hartnell.results import HartnellDesign as HartnellDesign
    from governor_mechanism.studies.kernel_compilation import KernelCompilation as KernelCompilation
    from governor_mechanism.studies.pendulum.results import PendulumDesign as PendulumDesign
    from governor_mechanism.studies.regulation.load_change import LoadChangeStudy as LoadChangeStudy
    from governor_mechanism.studies.regulation.paper_rules import PaperRules as PaperRules
    from governor_mechanism.studies.regulation.stability_map import StabilityMap as StabilityMap
    from governor_mechanism.studies.sweep.cluster import ClusterClient as ClusterClient
    from governor_mechanism.studies.sweep.results import Sweep as Sweep
    from governor_mechanism.studies.valve_gears import ValveGears as ValveGears
    from governor_mechanism.studies.valve_timing import ValveTiming as ValveTiming
    from governor_mechanism.studies.work_precision.results import AccuracyStudy as AccuracyStudy
    from governor_mechanism.types import FloatArray as FloatArray
    from governor_mechanism.types import InputValues as InputValues
    from governor_mechanism.types import Progress as Progress
    from governor_mechanism.types import QuantityValues as QuantityValues
    from governor_mechanism.verification.report import CheckReport as CheckReport
    from governor_mechanism.verification.user_kernel.report import KernelReport as KernelReport

_MODULES = {
    "AccuracyStudy": "studies.work_precision.results",
    "CheckReport": "verification.report",
    "ClusterClient": "studies.sweep.cluster",
    "Comparison": "studies.comparison.comparison",
    "ControllingForce": "statics.controlling_force",
    "EffectsStudy": "studies.effect_ablation",
    "Energy": "model.results.energy",
    "Engine": "engines",
    "Equilibrium": "statics.equilibria",
    "Errata": "studies.errata.results",
    "Exploration": "notebook.exploring.exploration",
    "FloatArray": "types",
    "FlywheelDesign": "studies.flywheel.design",
    "GovernedEngineDesign": "studies.governed_engine.results",
    "HardCasesReport": "studies.hard_cases.results",
    "HartnellDesign": "studies.hartnell.results",
    "InputValues": "types",
    "InsensitivityBand": "statics.speed_curve",
    "KernelCompilation": "studies.kernel_compilation",
    "KernelReport": "verification.user_kernel.report",
    "Kinematics": "mechanics.kinematics.kinematic_analysis",
    "Linearisation": "statics.linearisation",
    "LoadChangeStudy": "studies.regulation.load_change",
    "Mechanism": "model.mechanism",
    "MechanismBuilder": "building.mechanism_builder",
    "Outcome": "model.results.outcome",
    "PaperRules": "studies.regulation.paper_rules",
    "PendulumDesign": "studies.pendulum.results",
    "Progress": "types",
    "QuantityValues": "types",
    "Reaction": "model.results.reaction",
    "Scene": "model.scene",
    "SceneDescription": "scenes.described_scene",
    "SceneSource": "scenes.library",
    "SpeedCurve": "statics.speed_curve",
    "StabilityLimit": "statics.stability_limit",
    "StabilityMap": "studies.regulation.stability_map",
    "Sweep": "studies.sweep.results",
    "Trajectory": "model.results.trajectory",
    "ValveGears": "studies.valve_gears",
    "ValveTiming": "studies.valve_timing",
}
"""Module of each type inside the package."""


def __getattr__(name: str) -> Any:
    """Return a type by its name."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"governor_mechanism.{_MODULES[name]}"), name)


def list_types() -> list[str]:
    """Return the names of the types.

    Returns
    -------
    list of str
        Names in alphabetical order.
    """
    return list(_MODULES)

"""The engines: each runs a scene, refuses what it cannot model, and says how accurate it was and what it cost."""

from __future__ import annotations

from governor_mechanism.engines.base import Engine
from governor_mechanism.engines.impulse import ImpulseEngine
from governor_mechanism.engines.multibody import MultibodyEngine
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.scene import Scene

ENGINES: dict[str, type[Engine]] = {"impulse": ImpulseEngine, "multibody": MultibodyEngine}


FINE = 1e-7
"""Accuracies below this take impulse long: auto leaves them, and mechanisms of the user's own, to multibody."""


def choose(name: str, scene: Scene, accuracy: float | None = None) -> tuple[Engine, str]:
    """The engine of that name with its default settings, and why it was chosen; 'auto' picks one for the scene.

    accuracy replaces the scene's.
    """
    if name == "auto":
        if scene.part.machine == "custom":
            return MultibodyEngine(), "the default for custom mechanisms"
        if scene.acting:
            return MultibodyEngine(), "the default where something acts along a reading"
        if not {type(joint) for joint in scene.part.mechanism.joints} <= ImpulseEngine.joints:
            return MultibodyEngine(), "impulse lacks a joint of this scene"
        asked = scene.run.accuracy if accuracy is None else accuracy
        if isinstance(asked, int | float) and asked < FINE:  # what is no number the engine refuses
            return MultibodyEngine(), f"the default below an accuracy of {FINE:g}"
        return ImpulseEngine(), "the default"
    if name not in ENGINES:
        known = ["auto", *ENGINES]
        raise MechanismError(f"no engine {name!r}; engines are {known}.{did_you_mean(name, known)}")
    return ENGINES[name](), "asked for"


__all__ = ["ENGINES", "Engine", "ImpulseEngine", "MultibodyEngine", "choose"]

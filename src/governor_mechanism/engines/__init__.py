"""The engines: each runs a scene, refuses what it cannot model, and says how accurate it was and what it cost."""

from __future__ import annotations

from governor_mechanism.engines.base import Engine
from governor_mechanism.engines.impulse import ImpulseEngine
from governor_mechanism.engines.multibody import MultibodyEngine
from governor_mechanism.errors import MechanismError, did_you_mean

ENGINES: dict[str, type[Engine]] = {"impulse": ImpulseEngine, "multibody": MultibodyEngine}


def choose(name: str) -> tuple[Engine, str]:
    """The engine of that name with its default settings, and why it was chosen; 'auto' picks one."""
    if name == "auto":
        return ImpulseEngine(), "the default"
    if name not in ENGINES:
        known = ["auto", *ENGINES]
        raise MechanismError(f"no engine {name!r}; engines are {known}.{did_you_mean(name, known)}")
    return ENGINES[name](), "asked for"


__all__ = ["ENGINES", "Engine", "ImpulseEngine", "MultibodyEngine", "choose"]

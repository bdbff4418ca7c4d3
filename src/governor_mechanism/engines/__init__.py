"""The engines: each runs a scene, refuses what it cannot model, and says how accurate it was and what it cost."""

from __future__ import annotations

from governor_mechanism.engines.auto import ENGINES, choose
from governor_mechanism.engines.base import Engine
from governor_mechanism.engines.impulse import ImpulseEngine
from governor_mechanism.engines.multibody import MultibodyEngine
from governor_mechanism.engines.reduced import ReducedEngine

__all__ = ["ENGINES", "Engine", "ImpulseEngine", "MultibodyEngine", "ReducedEngine", "choose"]

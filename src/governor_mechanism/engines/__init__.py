"""The engines: each runs a scene, refuses what it cannot model, and says how accurate it was and what it cost."""

from __future__ import annotations

from governor_mechanism.engines.base import Engine
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.engines.selection import ENGINES, select_engine

__all__ = ["ENGINES", "Engine", "ImpulseEngine", "MultibodyEngine", "ReducedEngine", "select_engine"]

"""Engines: each runs a scene, refuses what it cannot model, and reports the accuracy and cost of the run."""

from governor_mechanism.engines.base import Engine
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.engines.selection import ENGINES, select_engine

__all__ = ["ENGINES", "Engine", "ImpulseEngine", "MultibodyEngine", "ReducedEngine", "select_engine"]

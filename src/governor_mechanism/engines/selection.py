"""Which engine a scene is given when none is asked for: the cheapest that holds it, by a small model of costs.

The numbers are of one machine, and rough; only their ratios matter. `python benchmarks/reduced.py` prints what they
stand for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, final

from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory

ENGINES: dict[str, type[Engine]] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}

WHOLE_RUN = {"reduced": 0.004, "multibody": 0.006, "impulse": 0.02}
"""Seconds of a run beside its steps: start, readings, certificate."""

EVALUATION = {"reduced": (2e-8, 0.0), "multibody": (1e-6, 2.5e-7), "impulse": (3e-6, 1e-6)}
"""Seconds of an evaluation, or of one of impulse's steps, and what each joint adds to it."""

BUILDING = 4e-5
"""Seconds of one piece of `reduced`'s tables and each joint; a certified run lays some ten."""

STRUCK = 4.0
"""So many times as long take impulse's runs where something acts along a reading."""

STEPS_OF_IMPULSE = 34.0, 1.5, -0.28
"""Of a time scale, over the runs of a certificate: a + b accuracy^c."""


FAILING = (Outcome.DEAD_CENTRE, Outcome.STIFF, Outcome.STALLED, Outcome.ACCURACY_MISSED)
"""What multibody may do better."""


@final
@dataclass(frozen=True, kw_only=True)
class ReducedFirst(Engine):
    """The reduced engine, and multibody in its stead where its coordinate leads no farther, or not as exactly."""

    name: ClassVar[str] = ReducedEngine.name
    effects: ClassVar[frozenset[type[Effect]]] = ReducedEngine.effects
    joints: ClassVar[frozenset[type[Joint]]] = ReducedEngine.joints

    def _refuses(self, scene: Scene) -> str:
        return ReducedEngine().refusal(scene)

    def _run(self, scene: Scene, task: Task) -> Trajectory:
        first = _run(ReducedEngine(), scene, task)
        if first.outcome not in FAILING:
            return first
        told = f"reduced gave it up: {first.message}"
        second = _run(MultibodyEngine(), scene, replace(task, reason=told))
        if second.outcome is Outcome.ACCURACY_MISSED and (first.error_estimate or 1.0) < (second.error_estimate or 1.0):
            return first
        return second


def _run(engine: Engine, scene: Scene, task: Task) -> Trajectory:
    return engine.run(scene, times=task.times, accuracy=task.accuracy, certify=task.certify, reason=task.reason)


def choose(name: str, scene: Scene, accuracy: float | None = None) -> tuple[Engine, str]:
    """The engine of that name with its default settings, and why it was chosen; 'auto' picks one for the scene.

    accuracy replaces the scene's.
    """
    if name != "auto":
        if name not in ENGINES:
            known = ["auto", *ENGINES]
            raise MechanismError(f"no engine {name!r}; engines are {known}.{did_you_mean(name, known)}")
        return ENGINES[name](), "asked for"
    asked = scene.run.accuracy if accuracy is None else accuracy
    engines = {name: kind() for name, kind in ENGINES.items()}
    able = {name: engine for name, engine in engines.items() if not engine.refusal(scene)}
    if not able:  # none holds it; the one that holds most says what is wrong
        return engines["multibody"], "the engine that holds most"
    seconds = {name: expected_seconds(name, scene, asked) for name in able}
    cheapest = min(able, key=lambda name: seconds[name])
    others = ", ".join(f"{name} {spoken_seconds(seconds[name])}" for name in able if name != cheapest)
    missing = ", ".join(name for name in engines if name not in able)
    reason = f"the cheapest: about {spoken_seconds(seconds[cheapest])}"
    reason += f" ({others})" if others else ""
    reason += f"; {missing} cannot hold this scene" if missing else ""
    return (ReducedFirst() if cheapest == "reduced" else able[cheapest]), reason


def expected_seconds(name: str, scene: Scene, accuracy: float) -> float:
    """Seconds that a certified run of an engine takes, roughly."""
    # What is no accuracy the engine refuses.
    asked = accuracy if isinstance(accuracy, int | float) and 0 < accuracy < 1 else 1e-6
    spans, joints = scene.run.duration / time_scale(scene), len(scene.part.mechanism.joints)
    once, each = EVALUATION[name]
    if name == "impulse":
        floor, factor, power = STEPS_OF_IMPULSE
        steps = spans * (floor + factor * float(asked**power))
        return WHOLE_RUN[name] + steps * (once + each * joints) * (STRUCK if scene.acting else 1.0)
    tolerance = max(asked / 100.0, 1e-15)
    evaluations = 2.0 * spans * 0.8 * float(tolerance**-0.125)
    laid = 10 * BUILDING * joints if name == "reduced" else 0.0
    return WHOLE_RUN[name] + laid + evaluations * (once + each * joints)


def spoken_seconds(seconds: float) -> str:
    """As '3 ms', '0.2 s', '40 s'."""
    return f"{seconds * 1e3:.0f} ms" if seconds < 0.1 else f"{seconds:.2g} s"

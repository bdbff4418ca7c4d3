"""One door for every engine: what is asked of it, what it may refuse."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from governor_mechanism.errors import MechanismError, UnsupportedEffect
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray

MOST_TIMES = 5_000_000


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is asked of an engine: reported times (n,) s, accuracy relative to the scales, whether to certify it."""

    times: FloatArray
    accuracy: float
    certify: bool
    reason: str


class Engine(ABC):
    """Runs a scene. Concrete engines are final, own their tuning numbers, and never import one another."""

    name: ClassVar[str]
    effects: ClassVar[frozenset[type[Effect]]]
    joints: ClassVar[frozenset[type[Joint]]]

    @abstractmethod
    def _run(self, scene: Scene, task: Task) -> Trajectory: ...

    @final
    def run(
        self,
        scene: Scene,
        *,
        times: Sequence[float] | FloatArray | None = None,
        accuracy: float | None = None,
        certify: bool = True,
        reason: str = "asked for",
    ) -> Trajectory:
        """Run a scene from its start; a run that cannot go on comes back with a named outcome.

        times (n,) s are reported instead of the scene's own; accuracy replaces the scene's. Raises UnsupportedEffect
        for effects and joints this engine does not have, MechanismError for a start that cannot be made.
        """
        refused = self.refusal(scene)
        if refused:
            raise UnsupportedEffect(refused)
        asked = scene.run.accuracy if accuracy is None else accuracy
        if not (isinstance(asked, int | float) and 0 < asked < 1):
            raise MechanismError(f"accuracy must lie between 0 and 1; got {asked!r}")
        reported = reported_times(scene) if times is None else _checked(times)
        return self._run(scene, Task(times=reported, accuracy=asked, certify=certify, reason=reason))

    @final
    def refusal(self, scene: Scene) -> str:
        """Why this engine cannot run a scene, in a sentence; empty where it can."""
        parts = [part.mechanism for part in scene.parts]
        missing = {type(effect) for effect in scene.effects} - self.effects
        missing_joints = {type(joint) for mechanism in parts for joint in mechanism.joints} - self.joints
        if missing or missing_joints:
            names = sorted(kind.__name__ for kind in missing | missing_joints)
            return f"engine {self.name!r} cannot model {names}; choose another engine or leave them out"
        if len(scene.parts) > 1 or scene.couplings:
            return (
                f"engine {self.name!r} runs scenes of one part without couplings; "
                f"this one has {len(scene.parts)} and {len(scene.couplings)}"
            )
        return self._refuses(scene)

    def _refuses(self, scene: Scene) -> str:
        """What an engine refuses beside effects and joints it does not have."""
        return ""


def reported_times(scene: Scene) -> FloatArray:
    """Multiples of `every` up to the duration, and the duration itself (s)."""
    every, duration = scene.run.every, scene.run.duration
    count = int(np.floor(duration / every * (1 + 1e-12)))
    if count > MOST_TIMES:
        raise MechanismError(f"{count} reported times are too many (at most {MOST_TIMES}); make run.every larger")
    times: FloatArray = every * np.arange(count + 1, dtype=np.float64)
    if duration - times[-1] > 1e-9 * every:
        return np.append(times, duration)
    times[-1] = duration
    return times


def _checked(given: Sequence[float] | FloatArray) -> FloatArray:
    try:
        times = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MechanismError(f"times must be a list of finite numbers (s); got {given!r}") from error
    if times.ndim != 1 or times.size == 0 or not np.all(np.isfinite(times)):
        raise MechanismError(f"times must be a one-dimensional array of finite numbers; got shape {times.shape}")
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        raise MechanismError("times must start at 0 or later and rise from one to the next")
    return times

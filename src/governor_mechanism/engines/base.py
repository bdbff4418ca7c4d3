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

MAX_REPORTED_TIMES = 5_000_000


@dataclass(frozen=True, kw_only=True)
class RunRequest:
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
    def _run(self, scene: Scene, request: RunRequest) -> Trajectory: ...

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
        refusal_reason = self.refusal(scene)
        if refusal_reason:
            raise UnsupportedEffect(refusal_reason)
        requested_accuracy = scene.run.accuracy if accuracy is None else accuracy
        if not (isinstance(requested_accuracy, int | float) and 0 < requested_accuracy < 1):
            raise MechanismError(f"accuracy must lie between 0 and 1; got {requested_accuracy!r}")
        reported = make_reported_times(scene) if times is None else _validate_times(times)
        return self._run(scene, RunRequest(times=reported, accuracy=requested_accuracy, certify=certify, reason=reason))

    @final
    def refusal(self, scene: Scene) -> str:
        """Why this engine cannot run a scene, in a sentence; empty where it can."""
        parts = [part.mechanism for part in scene.parts]
        missing = {type(effect) for effect in scene.effects} - self.effects
        missing_joints = {type(joint) for mechanism in parts for joint in mechanism.joints} - self.joints
        if missing or missing_joints:
            names = sorted(missing_type.__name__ for missing_type in missing | missing_joints)
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


def make_reported_times(scene: Scene) -> FloatArray:
    """Multiples of `output_interval` up to the duration, and the duration itself (s)."""
    output_interval, duration = scene.run.output_interval, scene.run.duration
    count = int(np.floor(duration / output_interval * (1 + 1e-12)))
    if count > MAX_REPORTED_TIMES:
        raise MechanismError(f"{count} reported times are too many (at most {MAX_REPORTED_TIMES}); make run.output_interval larger")
    times: FloatArray = output_interval * np.arange(count + 1, dtype=np.float64)
    if duration - times[-1] > 1e-9 * output_interval:
        return np.append(times, duration)
    times[-1] = duration
    return times


def _validate_times(given: Sequence[float] | FloatArray) -> FloatArray:
    try:
        times = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MechanismError(f"times must be a list of finite numbers (s); got {given!r}") from error
    if times.ndim != 1 or times.size == 0 or not np.all(np.isfinite(times)):
        raise MechanismError(f"times must be a one-dimensional array of finite numbers; got shape {times.shape}")
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        raise MechanismError("times must start at 0 or later and rise from one to the next")
    return times

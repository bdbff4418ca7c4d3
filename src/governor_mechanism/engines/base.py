"""Common interface of all engines: the request of a run and the checks before it."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from governor_mechanism.errors import MechanismError, UnsupportedEffect
from governor_mechanism.mechanics.dynamics.contacts import reading_functions_of
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray

MAX_REPORTED_TIMES = 5_000_000
"""Largest number of reported times of one run: it bounds the memory of the results."""


@dataclass(frozen=True, kw_only=True)
class RunRequest:
    """Request of a run: reported times (n,) s, accuracy relative to the scales, whether to certify it, reason of the choice."""

    times: FloatArray
    accuracy: float
    certify: bool
    reason: str


class Engine(ABC):
    """Abstract engine that runs a scene.

    Concrete engines are final, own their settings, and never import one another.

    Attributes
    ----------
    name
        Name of the engine in scene files and messages.
    effects
        Types of effects the engine can model.
    joints
        Types of joints the engine can model.
    """

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
        """Run a scene from its initial state; a run that ends early returns a trajectory with a named outcome.

        Parameters
        ----------
        scene
            Scene to run.
        times
            Reported times, s, ascending from 0 or later, instead of the scene's own; shape (n,).
        accuracy
            Requested accuracy relative to the scales of the readings, between 0 and 1, instead of the scene's own.
        certify
            Whether to estimate the error by a second run and to refine until it meets the accuracy.
        reason
            Why this engine was chosen; recorded in the cost of the run.

        Returns
        -------
        Trajectory
            Motion, readings, outcome, error estimate and cost.

        Raises
        ------
        UnsupportedEffect
            If the engine cannot model an effect, a joint or another property of the scene.
        MechanismError
            If the accuracy or a time is invalid, or the initial state cannot be assembled.
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
        """Return why this engine cannot run a scene, as a sentence; empty if it can.

        Parameters
        ----------
        scene
            Scene to check.

        Returns
        -------
        str
            Reason, or an empty string.
        """
        missing = {type(effect) for effect in scene.effects} - self.effects
        missing_joints = {type(joint) for joint in scene.mechanism.joints} - self.joints
        if missing or missing_joints:
            names = sorted(missing_type.__name__ for missing_type in missing | missing_joints)
            return f"engine {self.name!r} cannot model {names}; choose another engine or remove them from the scene"
        return self._refuses(scene)

    def _refuses(self, scene: Scene) -> str:
        """Return what an engine refuses in addition to unknown effects and joints; empty if nothing."""
        return ""


def refuse_couplings(engine: str, scene: Scene) -> str:
    """Return why an engine for one part without couplings cannot run a scene, as a sentence; empty if it can.

    Parameters
    ----------
    engine
        Name of the engine.
    scene
        Scene to check.

    Returns
    -------
    str
        Reason, or an empty string.
    """
    if len(scene.parts) > 1 or scene.couplings:
        return (
            f"engine {engine!r} runs scenes with one part and no couplings; this scene has couplings, or the parts "
            f"{[part.name for part in scene.parts]}: choose engine multibody"
        )
    functions = reading_functions_of(scene)
    if functions:
        return f"engine {engine!r} cannot model loads that depend on readings, here {functions[0].reading!r}; choose engine multibody"
    return ""


def make_reported_times(scene: Scene) -> FloatArray:
    """Return the reported times of a scene: multiples of its output interval up to the duration, and the duration itself.

    Parameters
    ----------
    scene
        Scene with its run settings.

    Returns
    -------
    FloatArray
        Times, s; shape (n,).

    Raises
    ------
    MechanismError
        If there are more than MAX_REPORTED_TIMES.
    """
    output_interval, duration = scene.run.output_interval, scene.run.duration
    count = int(np.floor(duration / output_interval * (1 + 1e-12)))
    if count > MAX_REPORTED_TIMES:
        raise MechanismError(f"{count} reported times are too many (at most {MAX_REPORTED_TIMES}); increase run.output_interval")
    times: FloatArray = output_interval * np.arange(count + 1, dtype=np.float64)
    if duration - times[-1] > 1e-9 * output_interval:
        return np.append(times, duration)
    times[-1] = duration
    return times


def _validate_times(given: Sequence[float] | FloatArray) -> FloatArray:
    """Return the given times as an array (n,) s, or raise MechanismError."""
    try:
        times = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MechanismError(f"times must be a list of finite numbers (s); got {given!r}") from error
    if times.ndim != 1 or times.size == 0 or not np.all(np.isfinite(times)):
        raise MechanismError(f"times must be a one-dimensional array of finite numbers; got shape {times.shape}")
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        raise MechanismError("times must start at 0 or later and be strictly increasing")
    return times

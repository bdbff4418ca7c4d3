"""What a run returns: plain arrays, how it ended, how accurate it is, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import RunFailed
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


class Outcome(Enum):
    """How a run ended; each value is a sentence a user can act on."""

    DONE = "ran to the end within the asked accuracy"
    UNCERTIFIED = "ran to the end; its accuracy was not certified"
    ACCURACY_MISSED = "ran to the end, but the asked accuracy was not reached; ask for less (multibody goes furthest)"
    LEFT_RANGE = "the mechanism leaves the range in which its description holds, and the run ends there"
    DEAD_CENTRE = "the coordinate that the engine follows leads no farther there; try engine multibody"
    STIFF = "the motion gets stiff, and this engine steps explicitly; try engine multibody"
    STEP_LIMIT = "the run needs more steps than the engine allows; shorten it, slow it, or raise max_steps"
    STALLED = "the motion could not be followed any further: its steps shrank to nothing, as where a drive locks"
    JOINT_OPENED = "a joint opened by more than a second-order step explains; try engine multibody"

    @property
    def ok(self) -> bool:
        """True when the run reached its end and nothing promised was missed."""
        return self in (Outcome.DONE, Outcome.UNCERTIFIED)


@dataclass(frozen=True, kw_only=True)
class Energy:
    """The energy ledger at each reported time, (n,) arrays in J.

    kinetic: in the plane; potential: of gravity and springs; rotation: of the parts about the spindle, J omega^2 / 2,
    and of a free spindle with them. jacobi, constant in an exact run, is kinetic + potential - rotation (+ rotation
    where the spindle is free), less the work that drives, dampers, forces and torques have done; its changes are
    errors. dissipated: what dashpots, dry friction and stops have taken up to then.
    """

    kinetic: FloatArray
    potential: FloatArray
    rotation: FloatArray
    jacobi: FloatArray
    dissipated_energy: FloatArray
    scale: float

    @property
    def drift(self) -> float:
        """Largest change of the Jacobi integral, relative to `scale`."""
        return float(np.max(np.abs(self.jacobi - self.jacobi[0]))) / self.scale if self.jacobi.size else 0.0


@dataclass(frozen=True, kw_only=True)
class Reaction:
    """What a joint does to its second body, at its second point, at each reported time.

    force (n, 2) N along the plane's x and y; moment (n,) N m, anticlockwise. The first body takes the opposite force at
    that point, but for gears and racks, whose first body takes a moment of its own: -ratio times the second's, or
    radius times the force along the rack.
    determined (n,): whether rigid bodies settle it; False where joints are redundant, and one choice of many is given.
    """

    force: FloatArray
    moment: FloatArray
    determined: NDArray[np.bool_]

    @property
    def magnitude(self) -> FloatArray:
        """(n,) N: how large the force is."""
        return np.hypot(self.force[:, 0], self.force[:, 1])


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What the run took. `evaluations` counts the calls of each law, over all the runs of the certificate.

    step (s) is the longest of the finest run's, or the last one; rejected are steps that had to be repeated; iterations
    are those of the joint solver, where it iterates; building (s) is what making tables took, which wall_time leaves
    out; method says how the engine stepped, where it has a choice; events is how often something stuck, slipped, struck
    or went slack; assembled counts what was put together.
    """

    engine: str
    reason: str
    step: float
    steps: int
    runs: int
    evaluations: Mapping[str, int]
    wall_time: float
    setup_time: float = 0.0
    rejected: int = 0
    iterations: int = 0
    method: str = ""
    events: int = 0
    model_size: Mapping[str, int] = field(default_factory=dict)


class DeferredResults(Protocol):
    """What can be told of a motion once it is known, and costs nothing until it is asked for."""

    def reactions(self) -> Mapping[str, Reaction]:
        """By joint name."""

    def events(self) -> tuple[Event, ...]:
        """In the order of time."""


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """A run. Poses are of mass centres, (n, bodies, 3): x (m), y (m), angle (rad), in the plane of the part.

    times (n,) s are the reported times. readings maps names to (n,) SI arrays (`units`), rates to the speeds of those
    that are positions. joint_gap (n,) m is the widest opening of any joint. error_estimate is the largest error of any
    reading or rate at any reported time, in units of its scale (`scales`); reading_errors the same one by one in SI;
    None and empty where the run was not certified; excluded counts the samples so near an event that its own time,
    which is promised instead, decides on which side of it they are. mobility counts the freedoms that joints and drives
    leave; notes are sentences on how the start was assembled.
    """

    scene: Scene
    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    units: Mapping[str, str]
    scales: Mapping[str, float]
    joint_gap: FloatArray
    energy: Energy
    outcome: Outcome
    cost: Cost
    detail: str = ""
    error_estimate: float | None = None
    reading_errors: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    n_excluded: int = 0
    mobility: int = 1
    notes: tuple[str, ...] = ()
    deferred_results: DeferredResults | None = field(default=None, repr=False, compare=False)

    @cached_property
    def reactions(self) -> Mapping[str, Reaction]:
        """What each joint did, by its name; reckoned when first asked for."""
        return {} if self.deferred_results is None else self.deferred_results.reactions()

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """What it passed, in the order of time: what stuck or struck, dead centres, change points (looked for now)."""
        return () if self.deferred_results is None else self.deferred_results.events()

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of `poses`."""
        return tuple(body.name for part in self.scene.parts for body in part.mechanism.bodies)

    @property
    def message(self) -> str:
        """What happened, its cause first where there is one."""
        return f"{self.detail}: {self.outcome.value}" if self.detail else self.outcome.value

    def raise_if_failed(self) -> None:
        """Raise RunFailed unless the run reached its end within what was promised."""
        if not self.outcome.ok:
            raise RunFailed(self.message)

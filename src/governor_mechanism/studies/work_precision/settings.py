"""The ladders of a study of accuracy: every way to use an engine, from coarse settings to fine ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.scene import Scene

TOLERANCES = tuple(10.0**-k for k in range(2, 15))
"""Where these do not bound the steps, several give the same run; it is told once."""

STEPS = tuple(0.25 / 2**k for k in range(17))
"""In time scales."""


@dataclass(frozen=True)
class Ladder:
    """A variant's settings, coarse ones first; `stepped` where they are steps, whose order is fitted."""

    name: str
    rungs: tuple[tuple[str, Engine], ...]
    stepped: bool


def ladders_of(scene: Scene) -> Iterator[Ladder]:
    """Those of every engine, the quickest first."""

    def toleranced(kind: type[ReducedEngine | MultibodyEngine]) -> Ladder:
        rungs = tuple((f"tolerance {tolerance:g}", kind(tolerance=tolerance)) for tolerance in TOLERANCES)
        return Ladder(kind.name, rungs, stepped=False)

    def stepped(name: str, engine: ImpulseEngine) -> Ladder:
        steps = [share * time_scale(scene) for share in STEPS]
        return Ladder(name, tuple((spoken_step(h), replace(engine, step=h)) for h in steps), stepped=True)

    yield toleranced(ReducedEngine)
    yield toleranced(MultibodyEngine)
    yield stepped("impulse extrapolated", ImpulseEngine(step=1.0, runs=3))
    yield stepped("impulse staggered", ImpulseEngine(step=1.0, runs=1))
    yield stepped("impulse plain", ImpulseEngine(step=1.0, plain=True))


def spoken_step(step: float) -> str:
    """As 'step 2.5 ms', 'step 78 µs'."""
    return f"step {step * 1e3:.3g} ms" if step >= 1e-4 else f"step {step * 1e6:.3g} µs"

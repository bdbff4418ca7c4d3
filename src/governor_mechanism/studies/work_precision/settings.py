"""The ladders of a study of accuracy: every way to use an engine, from coarse settings to fine ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.scene import Scene

LADDER_TOLERANCES = tuple(10.0**-k for k in range(2, 15))
"""Where these do not bound the steps, several give the same run; it is told once."""

LADDER_STEP_RATIOS = tuple(0.25 / 2**k for k in range(17))
"""In time scales."""


@dataclass(frozen=True)
class SettingsLadder:
    """A variant's settings, coarse ones first; `stepped` where they are steps, whose order is fitted."""

    name: str
    settings: tuple[tuple[str, Engine], ...]
    varies_step: bool


def build_ladders(scene: Scene) -> Iterator[SettingsLadder]:
    """Those of every engine, the quickest first."""

    def tolerance_ladder(engine_class: type[ReducedEngine | MultibodyEngine]) -> SettingsLadder:
        settings = tuple((f"tolerance {tolerance:g}", engine_class(tolerance=tolerance)) for tolerance in LADDER_TOLERANCES)
        return SettingsLadder(engine_class.name, settings, varies_step=False)

    def step_ladder(name: str, engine: ImpulseEngine) -> SettingsLadder:
        steps = [ratio * time_scale(scene) for ratio in LADDER_STEP_RATIOS]
        return SettingsLadder(name, tuple((format_step(h), replace(engine, step=h)) for h in steps), varies_step=True)

    yield tolerance_ladder(ReducedEngine)
    yield tolerance_ladder(MultibodyEngine)
    yield step_ladder("impulse extrapolated", ImpulseEngine(step=1.0, runs=3))
    yield step_ladder("impulse staggered", ImpulseEngine(step=1.0, runs=1))
    yield step_ladder("impulse plain", ImpulseEngine(step=1.0, plain=True))


def format_step(step: float) -> str:
    """As 'step 2.5 ms', 'step 78 µs'."""
    return f"step {step * 1e3:.3g} ms" if step >= 1e-4 else f"step {step * 1e6:.3g} µs"

"""The ladders of settings of a work-precision study, from coarse to fine."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.scene import Scene

LADDER_TOLERANCES = tuple(10.0**-k for k in range(2, 15))
"""Tolerances; where they do not limit the step, several give the same run, which is listed once."""

LADDER_STEP_RATIOS = tuple(0.25 / 2**k for k in range(17))
"""Steps in time scales of the scene."""


@dataclass(frozen=True)
class SettingsLadder:
    """Settings of one engine variant, coarse first; `varies_step` if they are steps, so that an order can be fitted."""

    name: str
    settings: tuple[tuple[str, Engine], ...]
    varies_step: bool


def build_ladders(scene: Scene) -> Iterator[SettingsLadder]:
    """Yield the ladders of every engine, the fastest first."""

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
    """Return a step (s) as text, such as "step 2.5 ms" or "step 78 µs"."""
    return f"step {step * 1e3:.3g} ms" if step >= 1e-4 else f"step {step * 1e6:.3g} µs"

"""The motion of Hartung's governor against Lagrange's equation along its lever angle."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.verification.comparisons import (
    compare_reading,
    integrate_governor,
    is_linear_sleeve_dashpot,
    name_effects,
    sleeve_damping,
)
from governor_mechanism.verification.report import ComparisonRow

LEVER_ANGLE_READING = "lever_angle"


def hartung_spring_force(scene: Scene, lever_angle: float) -> float:
    """Return the force (N) of each spring at a lever angle (rad), from the scene's dimensions."""
    dimensions = scene.part.dimensions
    weight_radius = dimensions["fulcrum_radius"] - dimensions["weight_arm"] * math.sin(lever_angle)
    return dimensions["spring_preload"] + dimensions["spring_rate"] * (weight_radius - dimensions["preload_radius"])


def check_hartung_motion(scene: Scene, governor: closed.HartungGovernor, run: Trajectory) -> Iterator[ComparisonRow | str]:
    """Yield the comparison of a run with the equation of motion until the first impact; a note if an effect is not included."""
    output_effects = (effect for effect in scene.effects if isinstance(effect, OutputEffect))
    unsupported_effects = [effect for effect in output_effects if not (is_linear_sleeve_dashpot(effect) or isinstance(effect, Stops))]
    if unsupported_effects:
        yield f"motion is not checked: the closed form does not include {name_effects(unsupported_effects)}"
        return
    impact_times = [event.time for event in run.events if event.kind is EventKind.IMPACT]
    n_compared = int(np.searchsorted(run.times, impact_times[0])) if impact_times else len(run.times)
    if impact_times:
        yield f"motion is checked until {impact_times[0]:.4g} s, when the lever strikes its stop"
    if n_compared < 2:
        return
    spindle, damping = scene.spindle, sleeve_damping(scene)

    def lever_acceleration(angle: float, rate: float, speed: float) -> float:
        force, state = hartung_spring_force(scene, angle), {"lever_angle": angle, "lever_rate": rate, "spindle_speed": speed}
        return float(closed.lever_acceleration(governor, **state, spring_force=force, damping=damping))

    def spindle_acceleration(angle: float, rate: float, speed: float, torque: float) -> float:
        inertia = spindle.inertia if isinstance(spindle, FreeSpindle) else 0.0
        state = {"lever_angle": angle, "lever_rate": rate, "spindle_speed": speed}
        return float(closed.spindle_acceleration(governor, **state, constant_inertia=inertia, torque=torque))

    angles, _, speeds = integrate_governor(run, n_compared, LEVER_ANGLE_READING, lever_acceleration, spindle_acceleration)
    yield compare_reading(run, LEVER_ANGLE_READING, angles)
    if isinstance(spindle, FreeSpindle):
        yield compare_reading(run, "spindle_speed", speeds)

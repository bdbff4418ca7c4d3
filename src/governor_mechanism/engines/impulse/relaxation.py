"""Where a simulated mechanism comes to rest when its motion is taken away: artificial damping, no formula."""

from __future__ import annotations

import numpy as np

from governor_mechanism.engines.impulse.pymunk import Assembly
from governor_mechanism.engines.impulse.run import settle
from governor_mechanism.engines.impulse.time_inputs import Clock
from governor_mechanism.errors import RunFailed
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

ITERATIONS = 60
STEP = 0.05
"""In time scales. At rest the step leaves no error, so it need only be stable."""

STILL = 1e-12
"""In machine sizes per time scale: the fastest speed of the whole mass that counts as rest."""

MOST_STEPS = 400_000


def settled(scene: Scene, start: float) -> float:
    """The value of the leading coordinate at which the mechanism comes to rest, let go at `start`.

    The spindle keeps its first speed; friction and stops do not hold it. Raises RunFailed where it leaves its range or
    does not come to rest.
    """
    mechanism, scale = scene.part.mechanism, time_scale(scene)
    name = mechanism.coordinate
    mass = sum(body.mass for body in mechanism.bodies)

    def inside(poses: FloatArray) -> bool:
        return all(
            limit.low < float(reading_value(mechanism, limit.reading, poses)) < limit.high for limit in mechanism.limits
        )

    result = settle(
        Assembly(scene, iterations=ITERATIONS),
        STEP * scale,
        Clock(scene),
        Assembler(mechanism).poses(start),
        still=0.5 * mass * (STILL * mechanism.size / scale) ** 2,
        inside=inside,
        most=MOST_STEPS,
    )
    value = float(reading_value(mechanism, name, result.poses))
    if not (result.at_rest and np.isfinite(value)):
        raise RunFailed(f"from {name} = {start:.6g} the mechanism did not come to rest; it was last at {value:.6g}")
    return value

"""What counts as standing, as touching a stop and as bouncing no more, and how long the last bounces take.

One set of numbers for every engine: each lets the same motions end in the same way.
"""

from __future__ import annotations

import math

CONTACT_TOLERANCE = 1e-10
"""Machine sizes, or rad: what moves nearer than this to a stop is at it."""

REST_TOLERANCE = 3e-12
"""Machine sizes, or rad: what stands nearer than this to a stop rests on it; farther off friction alone holds it."""

MIN_REBOUND_HEIGHT = 1e-11
"""Machine sizes, or rad: bounces that would rise no higher are over, and what is left of their time is reckoned.

Of lower ones rounding (1e-16 of a height) would time each worse than the whole sum is off by taking forces as constant:
both are about 1e-10 of a time scale. It is more than STANDING: at the top of a bounce that is followed nothing rests.
"""

STICTION_RATE_TOLERANCE = 1e-11
"""Machine sizes, or rad, in a time scale: slower than this a reading stands still."""


def zeno_time(rebound_rate: float, deceleration: float, return_acceleration: float, restitution: float) -> float:
    """How long (s) bounces go on that begin at a rate `away` and are slowed by `back`, and fetched by `returning`.

    Friction makes these accelerations differ; where it fetches nothing, the first way up is all there is.
    """
    if not return_acceleration > 0.0:
        return rebound_rate / deceleration
    first_bounce_time = rebound_rate * (1.0 / deceleration + 1.0 / math.sqrt(deceleration * return_acceleration))
    return first_bounce_time / (1.0 - restitution * math.sqrt(return_acceleration / deceleration))

"""Contact tolerances, and the remaining time of a bouncing sequence.

Every engine uses these numbers, so that the same motions end in the same way. Lengths are relative to the length scale
of the mechanism; angles are in rad.
"""

from __future__ import annotations

import math

SIMULTANEITY_TOLERANCE = 1e-12
"""Events closer than this, in units of the time scale, are simultaneous."""

CONTACT_TOLERANCE = 1e-10
"""Distance to a stop, in length scales or rad, below which a moving output is in contact with it."""

REST_TOLERANCE = 3e-12
"""Distance to a stop, in length scales or rad, below which an output at rest is held by the stop.

Farther away friction alone holds it.
"""

MIN_REBOUND_HEIGHT = 1e-11
"""Rebound height, in length scales or rad, below which the rest of a bouncing sequence is summed by `zeno_time`.

Rounding (1e-16 of a length scale) would time each lower bounce worse than the sum is off by assuming constant forces:
both errors are about 1e-10 of a time scale. The height exceeds REST_TOLERANCE, so that no output is taken as held at
the top of a simulated bounce.
"""

STICTION_RATE_TOLERANCE = 1e-11
"""Rate of an output, in length scales or rad per time scale, below which it is at rest."""


def zeno_time(rebound_rate: float, deceleration: float, return_acceleration: float, restitution: float) -> float:
    """Return the time until an infinite sequence of bounces comes to rest, a geometric series.

    Friction makes the accelerations away from the stop and back to it differ. Without an acceleration back, the time is
    that of the first rise alone.

    Parameters
    ----------
    rebound_rate
        Rate at which the first bounce leaves the stop, m/s or rad/s; positive.
    deceleration
        Deceleration while the output moves away from the stop, m/s2 or rad/s2; positive.
    return_acceleration
        Acceleration back to the stop, m/s2 or rad/s2.
    restitution
        Coefficient of restitution, 0 to 1.

    Returns
    -------
    float
        Time, s.
    """
    if not return_acceleration > 0.0:
        return rebound_rate / deceleration
    first_bounce_time = rebound_rate * (1.0 / deceleration + 1.0 / math.sqrt(deceleration * return_acceleration))
    return first_bounce_time / (1.0 - restitution * math.sqrt(return_acceleration / deceleration))

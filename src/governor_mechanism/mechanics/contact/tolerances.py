"""Contact tolerances of every engine, so that the same motions end in the same way; lengths in length scales, angles in rad."""

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

MODE_CONSISTENCY_TOLERANCE = 1e-9
"""Largest violation of consistent contact states, in units of the scales of force and acceleration."""

JAM_VIOLATION = 1e-6
"""Violation of the best contact states, in the same units, above which no rounding explains it: friction jams what slides."""

TURNING_POINT_ACCELERATION_TOLERANCE = 1e-6
"""Largest acceleration of a held output, in length scales (or rad) per time scale squared, that is rounding."""

MIN_COMPLIANCE_RATIO = 1e-12
"""Acceleration of an output by a force along it, in units of their scales, below which the output is at a turning point.

There a force along it moves nothing. This is the square of the output's derivative by the motion.
"""

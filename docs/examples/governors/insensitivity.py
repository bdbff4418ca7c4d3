"""
What 40 N of resistance cost
============================

Friction in the regulating gear holds the sleeve over a band of speeds.
"""

import governor_mechanism as gm

band = gm.insensitivity_band("porter", over=["20 deg", "30 deg", "40 deg"], resistance="40 N")
for falling, rising, insensitivity in zip(band.falling_speed, band.rising_speed, band.insensitivity, strict=True):
    print(f"sinks below {falling:.3f} rad/s, rises above {rising:.3f} rad/s: {100 * insensitivity:.1f} % of its speed")
gm.speed_curve("porter", resistance="40 N").plot().save("band.png")

"""
What 40 N of resistance cost
============================

Friction in the regulating gear holds the sleeve over a band of speeds.
"""

import governor_mechanism as gm

band = gm.insensitivity_band("porter", over=["20 deg", "30 deg", "40 deg"], resistance="40 N")
for falling, rising in zip(band.falling_speed, band.rising_speed, strict=True):
    print(f"sinks below {falling:.3f} rad/s, rises above {rising:.3f} rad/s")
print("the band as a part of the speed:", band.insensitivity)
gm.speed_curve("porter", resistance="40 N").plot().save("band.png")

# %%
# More: :doc:`what friction does </questions/friction>`.

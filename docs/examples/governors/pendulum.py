"""
A pendulum keeps bad time when it swings far
============================================

The frequency of a simple pendulum over its amplitude, beside the exact one by the arithmetic-
geometric mean.
"""

import math

import governor_mechanism as gm

pendulum = gm.load("pendulum_iftomm")
starts = ["-80 deg", "-60 deg", "-30 deg", "0 deg"]  # from the horizontal
found = gm.sweep(pendulum, {"start.angle": starts}, ["frequency of angle"])
for simulated, swing in zip(found.column("frequency of angle"), (10, 30, 60, 90), strict=True):
    mean, other = 1.0, math.cos(math.radians(swing) / 2)
    for _ in range(5):
        mean, other = (mean + other) / 2, math.sqrt(mean * other)
    exact = mean * math.sqrt(9.81) / (2 * math.pi)
    print(f"{swing} degrees: {simulated:.6f} Hz, exactly {exact:.6f} Hz")
gm.film(gm.run(pendulum), "pendulum.gif", stop="2.4 s", readings=["angle"])

# %%
# More: :doc:`sweeps </how_to/sweep>`.

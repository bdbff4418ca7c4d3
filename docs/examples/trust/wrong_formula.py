"""
A wrong formula is found out
============================

Without pytest, one call compares a formula with the simulation. This one forgets the offset of
the arms.
"""

import math

import governor_mechanism as gm


def speed(arm_angle, arm, ball_mass, sleeve_mass, gravity):
    return math.sqrt(gravity * (1 + sleeve_mass / ball_mass) / (arm * math.cos(arm_angle)))


report = gm.crosscheck(
    "porter", kernel=speed, quantity="equilibrium_speed", over={"arm_angle": "20 deg:40 deg:11"}
)
print(report.describe_worst())
report.plot().save("errors.png")

# %%
# More: :doc:`checking a formula </how_to/crosscheck_kernel>`.

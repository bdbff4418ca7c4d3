"""
What matters most
=================

By how many per cent does the frequency change if a dimension grows by one? Derivatives from
certified runs, each with its error.
"""

import matplotlib.pyplot as plt

import governor_mechanism as gm

by = ["dimensions.arm", "dimensions.ball_mass", "dimensions.sleeve_mass", "spindle.speed"]
found = gm.sensitivities("porter", ["frequency of arm_angle"], by)
print(found)
figure, axes = plt.subplots(figsize=(6, 2.6), layout="constrained")
axes.barh([row.by.split(".")[-1] for row in found.rows], [row.elasticity for row in found.rows])
axes.set(xlabel="change of the frequency, % for 1 %")
figure.savefig("sensitivities.png", dpi=110)

# %%
# More: :doc:`sensitivities </how_to/fit>`.

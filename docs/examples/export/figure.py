"""
A figure for a paper
====================

Vector figures, and your own with matplotlib: readings are arrays in SI units.
"""

import matplotlib.pyplot as plt

import governor_mechanism as gm

run = gm.run("porter")
run.plot("arm_angle").save("angle.svg")

figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(run.readings["arm_angle"], run.readings["sleeve_lift"] * 1000)
axes.set(xlabel="arm angle, rad", ylabel="sleeve lift, mm")
figure.savefig("own.png", dpi=120)

# %%
# More: :doc:`exporting results </how_to/export>`.

"""
Dimensions from a measurement
=============================

Which friction and which dashpot does a measured swing have? Here a run with noise takes the place
of the measurement.
"""

import numpy as np

import governor_mechanism as gm

friction, dashpot = "effects.dry_friction.sleeve_lift", "effects.dashpot.sleeve_lift"
swing = gm.load("porter").replace({"start.arm_angle": "55 deg", "run.duration": "3 s"})
worn = swing.replace({friction: "2 N", dashpot: "10 N s/m"})
truth = gm.run(worn, engine="multibody", accuracy=1e-8)
noise = np.random.default_rng(1).normal(0.0, 1e-4, len(truth.times))
data = {"time": truth.times, "sleeve_lift": truth.readings["sleeve_lift"] + noise}

guess = worn.replace({friction: "4 N", dashpot: "20 N s/m"})
bounds = {friction: ("0.5 N", "5 N"), dashpot: ("3 N s/m", "30 N s/m")}
fit = gm.fit(guess, data, bounds, noise="0.1 mm")
print(fit)
fit.plot().save("fit.png")

# %%
# More: :doc:`fits </how_to/fit>`.

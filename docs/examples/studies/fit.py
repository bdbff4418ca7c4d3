"""
Dimensions from a measurement
=============================

Which friction and which dashpot does a measured swing have? Here a run with noise takes the place of the measurement.
"""

import numpy as np

import governor_mechanism as gm

worn = (
    gm.load("porter")
    .replace({"effects.dry_friction": {"sleeve_lift": "2 N"}, "effects.dashpot": {"sleeve_lift": "10 N s/m"}, "start.arm_angle": "55 deg"})
    .replace({"run.duration": "3 s"})
)
truth = gm.run(worn, engine="multibody", accuracy=1e-8)
noise = np.random.default_rng(1).normal(0.0, 1e-4, len(truth.times))
data = {"time": truth.times, "sleeve_lift": truth.readings["sleeve_lift"] + noise}

guess = worn.replace({"effects.dry_friction.sleeve_lift": "4 N", "effects.dashpot.sleeve_lift": "20 N s/m"})
bounds = {"effects.dry_friction.sleeve_lift": ("0.5 N", "5 N"), "effects.dashpot.sleeve_lift": ("3 N s/m", "30 N s/m")}
fit = gm.fit(guess, data, bounds, noise="0.1 mm")
print(fit)
fit.plot().save("fit.png")

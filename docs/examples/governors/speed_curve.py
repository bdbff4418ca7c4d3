"""
Where a governor stands at each speed
=====================================

The speed curve has every equilibrium over the travel. Where it falls, the governor is unstable
and jumps.
"""

import governor_mechanism as gm

curve = gm.speed_curve("watt_improved")
for fold in curve.folds:
    print("jumps from", fold)
for equilibrium in gm.equilibria("watt_improved", spindle_speed="6.4 rad/s"):
    print(equilibrium.coordinate, "stable" if equilibrium.stable else "unstable")
curve.plot().save("speed_curve.png")

# %%
# More: :doc:`why the sleeve jumps </questions/jump>`.

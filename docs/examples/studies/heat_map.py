"""
A sweep with its heat map
=========================

Where the sleeve of a governor comes to rest, over its speed and its mass. With ``out=`` a sweep
that is stopped goes on where it was.
"""

import numpy as np

import governor_mechanism as gm

vary = ["spindle.speed=90rpm:160rpm:10", "dimensions.sleeve_mass=5kg:40kg:10"]
governor = gm.load("porter_dashpot").replace({"effects.dashpot.sleeve": "200 N s/m"})
found = gm.sweep(governor, vary, ["sleeve_lift"])
lifts = 1000 * found.column("sleeve_lift")  # mm; nan where the sleeve was too heavy to rise
lowest, highest = np.nanmin(lifts), np.nanmax(lifts)
print(f"{len(lifts)} runs; the sleeve ends between {lowest:.1f} and {highest:.1f} mm")
found.plot().save("heat_map.png")

# %%
# More: :doc:`sweeps </how_to/sweep>`.

"""
A map of stability
==================

Which flywheels and which dashpots settle, and which hunt.
"""

import governor_mechanism as gm

vary = [
    "part.governor.effects.dashpot.sleeve=5 N s/m:60 N s/m:13",
    "part.engine.dimensions.inertia=300 kg m^2:1500 kg m^2:13",
]
chart = gm.stability_map("governed_engine_mean_torque", vary)
print(chart)
chart.plot().save("stability.png")

# %%
# More: :doc:`governed engines </machines/governed_engine>`.

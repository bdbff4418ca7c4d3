"""
An engine loses half its load
=============================

Engine, flywheel and Porter governor together. The load falls by half: how far does the speed
rise, and how soon does it settle?
"""

import governor_mechanism as gm

response = gm.load_change_study("governed_engine_mean_torque", "100%:50%")
print(response)
response.plot().save("load_change.png")

# %%
# More: :doc:`governed engines </machines/governed_engine>`.

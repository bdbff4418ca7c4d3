"""
Simulation against closed forms
===============================

Every formula of the package that applies to a scene, compared with the simulation.
"""

import governor_mechanism as gm

print(gm.crosscheck("watt_crossed"))
gm.run("watt_crossed").plot("arm_angle", "spindle_torque").save("watt_crossed.png")

# %%
# More: :doc:`how machines are checked </machines/index>`.

"""
Controlling force
=================

The force that holds one ball on its circle, over the radius. Effort and power are for a change of
speed of 1 %.
"""

import governor_mechanism as gm

forces = gm.controlling_force("porter", between={"arm_angle": ("20 deg", "45 deg")})
effort, power = forces.effort.effort.max(), forces.effort.power.max()
print(f"largest effort {effort:.3f} N, power {1000 * power:.1f} mJ")
print(f"sensitiveness {100 * forces.working_range.sensitiveness:.2f} %")
forces.plot().save("controlling_force.png")

# %%
# More: :doc:`equilibria and controlling force </how_to/statics>`.

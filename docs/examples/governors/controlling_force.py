"""
Controlling force
=================

The force that holds one ball on its circle, over the radius. Effort and power are for a change of speed of 1 %.
"""

import governor_mechanism as gm

forces = gm.controlling_force("porter", between={"arm_angle": ("20 deg", "45 deg")})
print(f"largest effort {forces.effort.effort.max():.3f} N, power {1000 * forces.effort.power.max():.1f} mJ")
print(f"sensitiveness {100 * forces.working_range.sensitiveness:.2f} %")
forces.plot().save("controlling_force.png")

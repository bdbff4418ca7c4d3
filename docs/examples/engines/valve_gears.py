"""
Two link motions compared
=========================

Lead and cut-off of Stephenson's and Gooch's gears, from full gear to the middle: Gooch's link
keeps the lead.
"""

import governor_mechanism as gm

gears = gm.valve_gears(["stephenson_arc_middle", "gooch"], count=25)
print(gears)
gears.plot().save("gears.png")

# %%
# More: :doc:`Stephenson's link motion </machines/stephenson>`.

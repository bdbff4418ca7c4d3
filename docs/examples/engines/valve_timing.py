"""
When a valve opens and shuts
============================

Admission, cut-off, release and compression of Walschaerts' gear, and its film from forward to
back gear.
"""

import governor_mechanism as gm

print(gm.valve_timing("walschaerts"))
gm.film(gm.run("walschaerts"), "walschaerts.gif", stop="2 s")

# %%
# More: :doc:`valve gears </machines/valve_gears>`.

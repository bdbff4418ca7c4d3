"""
A cam whose follower jumps
==========================

A spring holds the roller on the cam, until the cam turns too fast. The gap between both says
where the roller leaves.
"""

import governor_mechanism as gm

cam = gm.load("disc_cam")
for rate in ("600 rpm", "800 rpm"):
    run = gm.run(cam.replace({"joint.motor.rate": rate, "run.duration": "0.3 s"}))
    print(rate, "largest gap, mm:", 1000 * run.readings["roller_gap"].max())
gm.film(run, "cam.gif", slow_down=8)

# %%
# More: :doc:`parts that touch </how_to/own_mechanism>`.

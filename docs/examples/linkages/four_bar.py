"""
A four-bar linkage
==================

Name bodies, join them, drive one, and the package finds where the parts stand. Only the crank
gets an angle.
"""

import governor_mechanism as gm

m = gm.Mechanism.build("Crank and rocker")
crank = m.rod("crank", length="100 mm", mass=1.0, angle="60 deg")
coupler = m.rod("coupler", length="350 mm", mass=1.5)
rocker = m.rod("rocker", length="250 mm", mass=2.0)
m.pin(m.ground(0, 0), crank.start)
m.pin(crank.end, coupler.start)
m.pin(coupler.end, rocker.end)
m.pin(m.ground("400 mm", 0), rocker.start)
m.motor(crank, rate="90 rpm")
m.reading("rocker_angle", angle=rocker)

run = gm.run(m.scene(duration="2 s"))
print(run.message)
gm.film(run, "four_bar.gif", stop="0.667 s", readings=["rocker_angle"])

# %%
# More: :doc:`a mechanism of your own </tutorials/own_mechanism>`.

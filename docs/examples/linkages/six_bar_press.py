"""
A press of six bars
===================

A crank moves a rocker, the rocker moves a ram in a straight guide. Arrows show the velocities of
the pins.
"""

import governor_mechanism as gm

m = gm.Mechanism.build("Six-bar press")
crank = m.rod("crank", length="100 mm", mass=1.0, angle="60 deg")
coupler = m.rod("coupler", length="300 mm", mass=2.0)
rocker = m.rod("rocker", length="250 mm", mass=2.0)
thrust_rod = m.rod("thrust rod", length="350 mm", mass=2.0)
ram = m.block("ram", mass=5.0)
m.pin(m.ground(0, 0), crank.start)
m.pin(crank.end, coupler.start)
m.pin(coupler.end, rocker.end, thrust_rod.start)  # three rods on one pin
m.pin(m.ground("300 mm", 0), rocker.start)
m.pin(thrust_rod.end, ram.centre)
m.slider(m.ground(0, "100 mm"), ram.centre)  # a guide along x
m.motor(crank, rate="90 rpm")
m.reading("ram_x", x=ram.centre)

run = gm.run(m.scene(duration="0.667 s"))
print("travel of the ram, m:", run.readings["ram_x"].max() - run.readings["ram_x"].min())
gm.film(run, "press.gif", layers=["velocity"])

# %%
# More: :doc:`films and their options </how_to/film>`.

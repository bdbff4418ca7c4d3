"""
The path of a point
===================

A point beside the line of the coupler draws a coupler curve. A path needs no run: the linkage is
solved at every degree of its crank.
"""

import governor_mechanism as gm

m = gm.Mechanism.build("Coupler curve")
crank = m.rod("crank", length="100 mm", mass=1.0, angle="60 deg")
coupler = m.rod("coupler", length="350 mm", mass=1.5)
rocker = m.rod("rocker", length="250 mm", mass=2.0)
m.pin(m.ground(0, 0), crank.start)
m.pin(crank.end, coupler.start)
m.pin(coupler.end, rocker.end)
m.pin(m.ground("400 mm", 0), rocker.start)
m.motor(crank, rate="90 rpm")
m.reading("crank_angle", angle=crank)
coupler.point("150 mm", "-90 mm", name="pen")

turn = gm.kinematics(
    m.scene(duration="1 s"), over="crank_angle", values=[f"{angle} deg" for angle in range(361)]
)
pen = turn.paths["pen"]  # x and y, m
print("width and height of the curve, mm:", 1000 * (pen.max(axis=0) - pen.min(axis=0)))
turn.plot_paths("pen").save("coupler_curve.png")

# %%
# More: :doc:`paths of points </how_to/kinematics>`.

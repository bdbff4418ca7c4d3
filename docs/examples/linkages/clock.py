"""
A clock ticks
=============

Graham's dead-beat escapement: a tooth of the wheel rests on a pallet, pushes the pendulum on as it
leaves it, and the next tooth falls on the other pallet. Both meet once in each beat.
"""

import governor_mechanism as gm

run = gm.run(gm.load("graham_escapement").replace({"run.duration": "2 s"}))
strikes = [event.time for event in run.events if "strikes" in str(event)]
print("tooth and pallet meet at", [round(time, 3) for time in strikes], "s")
gm.film(run, "clock.gif", readings=["pendulum_angle", "wheel_angle"])

# %%
# More: :doc:`parts that touch </how_to/own_mechanism>`.

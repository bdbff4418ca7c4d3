"""
A Geneva wheel
==============

A pin enters a slot, turns the wheel by one step, and leaves it; a lock then holds the wheel. Each
touch is an event of the run.
"""

import governor_mechanism as gm

run = gm.run("geneva")
for event in run.events[:6]:
    print(event)
gm.film(run, "geneva.gif")

# %%
# More: :doc:`parts that touch </how_to/own_mechanism>`.

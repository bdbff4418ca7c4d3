"""
Zeuner's valve diagram
======================

A plain slide valve: one turn of its engine beside the diagram that engineers drew by hand, and
how far its rules are from the exact motion.
"""

import governor_mechanism as gm

print(gm.valve_timing("slide_valve_marks"))
gm.film(gm.run("slide_valve_marks"), "slide_valve.gif")

# %%
# More: :doc:`what lead does </questions/lead>`.

"""
All ways in which joints close
==============================

Bars of the same lengths can often be pinned together in several ways. Here are all of them, with
numbers by which a scene takes one.
"""

import governor_mechanism as gm

ways = gm.assemblies("klann")
print(ways)
ways.plot().save("ways.png")

# %%
# More: :doc:`how one of them is chosen </tutorials/own_mechanism>`.

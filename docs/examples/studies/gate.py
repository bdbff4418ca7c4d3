"""
A four-bar through three positions
==================================

A gate, given in three positions, and one of its pivots: the linkage that carries it, and the
second pivots that would do.
"""

import governor_mechanism as gm

gate = [["0 mm", "0 mm", "0 deg"], ["40 mm", "25 mm", "15 deg"], ["70 mm", "60 mm", "40 deg"]]
found = gm.synthesise_positions(gate, moving_pivots=[["0 mm", "0 mm"], ["30 mm", "10 mm"]])
print(found)
found.plot().save("gate.png")

# %%
# More: :doc:`synthesis </how_to/synthesis>`.

"""
A four-bar whose pen passes four points
=======================================

The search starts at random linkages, and keeps those without defects.
"""

import governor_mechanism as gm

points = [["0 mm", "0 mm"], ["40 mm", "25 mm"], ["70 mm", "60 mm"], ["80 mm", "110 mm"]]
found = gm.synthesise_path(points, starts=60)
print(found)
found.plot().save("path.png")

# %%
# More: :doc:`synthesis </how_to/synthesis>`.

"""
A Porter governor swings
========================

A shipped scene, with one dimension changed. Every run says how accurate it is.
"""

import governor_mechanism as gm

run = gm.run(gm.load("porter").replace({"dimensions.arm": "320 mm"}))
print(run.message)
print("estimated error, relative to the size of each reading:", run.error_estimate)
gm.film(run, "porter.gif", stop="2 s", labels=True)

# %%
# More: :doc:`a first governor </tutorials/first_governor>`.

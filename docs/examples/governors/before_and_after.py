"""
Before and after a change
=========================

Two runs side by side: the arms of a Porter governor grow by 20 mm, and it swings more slowly.
"""

import governor_mechanism as gm

before = gm.load("porter")
after = before.replace({"title": "Porter governor, longer arms", "dimensions.arm": "320 mm"})
both = gm.compare(before, after)
print(both)
both.plot().save("before_and_after.png")

# %%
# More: :doc:`comparing scenes </how_to/compare>`.

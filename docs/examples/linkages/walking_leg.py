"""
A leg from the catalogue
========================

More than forty classic mechanisms are shipped with named dimensions. Theo Jansen's leg, with a
longer crank, walks with a longer stride.
"""

import governor_mechanism as gm

jansen = gm.load("jansen")
longer = jansen.replace({"dimensions.crank": "16 mm"})
for scene in (jansen, longer):
    foot = gm.kinematics(scene).paths["foot"]
    print("stride and lift, mm:", 1000 * (foot.max(axis=0) - foot.min(axis=0)))
gm.film(gm.run(jansen), "jansen.gif", paths=["foot"])

# %%
# More: :doc:`the catalogue </machines/catalogue>`.

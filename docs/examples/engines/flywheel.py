"""
How heavy must a flywheel be?
=============================

Redtenbacher's engine of 1853, by his procedure: flywheel, rim and arms. The design is a scene
too, which is run beside it.
"""

import governor_mechanism as gm

design = gm.design_flywheel(load_pressure="closing", coefficient=0.02)
print(design)
gm.film(gm.run(design.scene), "flywheel.gif")

# %%
# More: :doc:`the same in words </questions/flywheel>`.

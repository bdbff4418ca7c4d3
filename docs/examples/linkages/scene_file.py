"""
A linkage as a text file
========================

The same kind of mechanism without Python: a scene file, which ``governor-mechanism run
yoke.toml`` runs too.
"""

from pathlib import Path

import governor_mechanism as gm

Path("yoke.toml").write_text("""
title = "Scotch yoke"
machine = "custom"
ground = { O = [0, 0], guide = [0, 0] }
body = [
  { name = "crank", mass = "1 kg", rod = { length = "80 mm" }, angle = "40 deg" },
  { name = "yoke", mass = "2 kg", plate = { width = "24 cm", height = "4 cm" }, at = ["61 mm", 0] },
]
joint = [
  { type = "pin", first = "ground.O", second = "crank.start" },
  { type = "driven_turn", first = "ground", second = "crank", rate = "60 rpm" },
  { type = "prismatic", first = "ground.guide", second = "yoke.centre", angle = 0 },
  { type = "slider", first = "yoke.centre", second = "crank.end", angle = "90 deg" },
]
readings = { yoke_x = { x = "yoke.centre" } }
run = { duration = "1 s" }
""")
run = gm.run("yoke.toml")
print(run.message, run.readings["yoke_x"].max())  # the length of the crank
gm.film(run, "yoke.gif")

# %%
# More: :doc:`all joints and forces </how_to/own_mechanism>`.

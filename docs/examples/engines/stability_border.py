"""
How much damping an engine needs
================================

The dashpot below which the speed hunts for ever, from the eigenvalues of engine and governor
together, and a run with half of it.
"""

import governor_mechanism as gm

engine = gm.load("governed_engine_mean_torque")
dashpot = "part.governor.effects.dashpot.sleeve"
border = gm.stability_limit(engine, dashpot, "5 N s/m", "100 N s/m")
print(f"{border.value:.3f} N s/m; just there it swings at {border.frequency:.4f} rad/s")
hunting = gm.run(engine.replace({dashpot: "10 N s/m", "run.duration": "30 s"}))
hunting.plot("engine.shaft_speed", "governor.sleeve_lift").save("hunting.png")

# %%
# More: :doc:`why a governor hunts </questions/hunting>`.

"""
Forces in the bearings of an engine
===================================

A slider crank at constant speed: the force on its crank pin, as a reading with an error estimate,
and over a turn.
"""

import governor_mechanism as gm

run = gm.run("slider_crank")
for name, reaction in run.reactions.items():
    print(f"{name}: at most {float((reaction.force**2).sum(axis=-1).max() ** 0.5):.1f} N")
run.plot_reactions().save("bearings.png")

# %%
# More: :doc:`the slider crank </machines/slider_crank>`.

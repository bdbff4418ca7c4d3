"""
Friction that really sticks
===========================

With dry friction the sleeve comes to rest between two speeds and stays there. A run names each
time at which it sticks.
"""

import governor_mechanism as gm

run = gm.run("porter_dry_friction")
for event in run.events[:4]:
    print(event)
run.plot("sleeve_lift").save("sleeve.png")

# %%
# More: :doc:`events and contact </theory/events_and_contact>`.

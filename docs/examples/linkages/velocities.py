"""
Velocities, transmission angle, dead centres
============================================

No run is needed: one call follows a drag link through a turn and draws what was asked for.
"""

import governor_mechanism as gm

wanted = [
    "velocity.coupler",
    "transmission_angle.coupler",
    "mechanical_advantage.crank_angle.follower_angle",
]
study = gm.kinematics("drag_link", rate="60 rpm", readings=wanted)
print(study)
study.plot().save("drag_link.png")

# %%
# More: :doc:`all readings of this kind </how_to/kinematics>`.

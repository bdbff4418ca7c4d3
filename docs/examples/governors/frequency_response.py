"""
How a governor answers a speed that swings
==========================================

A Porter governor with a dashpot, linearised about its equilibrium: its natural frequency, and the
sleeve over the frequency of the speed.
"""

import matplotlib.pyplot as plt
import numpy as np

import governor_mechanism as gm

linear = gm.linearise("porter_dashpot")
print(linear)
frequency = np.geomspace(0.5, 50.0, 300)  # rad/s
response = linear.state_space(["spindle_speed"], ["sleeve_lift"]).frequency_response(frequency)[
    :, 0, 0
]
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
axes.loglog(frequency, 1000 * abs(response))
axes.set(xlabel="frequency of the speed, rad/s", ylabel="sleeve, mm for 1 rad/s")
figure.savefig("response.png", dpi=110)

# %%
# More: :doc:`equilibria and their stability </how_to/statics>`.

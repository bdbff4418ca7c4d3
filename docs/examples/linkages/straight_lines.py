"""
How straight is a straight line?
================================

The pen of Watt's linkage strays from its line, that of Peaucellier's does not. Both are followed
over a travel, without a run.
"""

import matplotlib.pyplot as plt

import governor_mechanism as gm

turn = [f"{angle} deg" for angle in range(-20, 21)]
watt = gm.kinematics("watt_linkage", values=turn).paths["pen"]
peaucellier = gm.kinematics("peaucellier").paths["upper outer bar.end"]
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
for name, pen in {"Watt": watt, "Peaucellier": peaucellier}.items():
    stray, rise = 1000 * (pen.max(axis=0) - pen.min(axis=0))  # mm
    print(f"{name}: over {rise:.1f} mm the pen strays by {stray:.1e} mm")
    axes.plot(pen[:, 1] - pen[:, 1].mean(), 1000 * (pen[:, 0] - pen[:, 0].mean()), label=name)
axes.set(xlabel="along the line, m", ylabel="off the line, mm")
axes.legend()
figure.savefig("straight_lines.png", dpi=110)

# %%
# More: :doc:`why Watt's line bends </questions/line>`.

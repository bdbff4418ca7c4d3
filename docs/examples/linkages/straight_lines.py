"""
How straight is a straight line?
================================

The pen of Watt's linkage strays from its line, that of Peaucellier's does not. Both are followed over a travel, without a run.
"""

import matplotlib.pyplot as plt

import governor_mechanism as gm

watt = gm.kinematics("watt_linkage", values=[f"{angle} deg" for angle in range(-20, 21)]).paths["pen"]
peaucellier = gm.kinematics("peaucellier").paths["upper outer bar.end"]
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
for name, (x, y) in {"Watt": watt.T, "Peaucellier": peaucellier.T}.items():
    print(f"{name}: over {1000 * (y.max() - y.min()):.1f} mm the pen strays by {1000 * (x.max() - x.min()):.1e} mm")
    axes.plot((y - y.min()) / (y.max() - y.min()), 1000 * (x - x.mean()), label=name)
axes.set(xlabel="part of the travel", ylabel="off the line, mm")
axes.legend()
figure.savefig("straight_lines.png", dpi=110)

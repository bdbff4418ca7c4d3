"""
What accuracy costs
===================

Every engine at several tolerances: its true error over its time on this machine.
"""

import governor_mechanism as gm

study = gm.accuracy_study("porter", longest="0.3 s")
print(study.advice(1e-6))
study.plot().save("accuracy.png")

# %%
# More: :doc:`accuracy and time </theory/accuracy_and_time>`.

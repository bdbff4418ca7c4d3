"""
Two engines, one answer
=======================

The equations of all bodies, and one equation for one coordinate: they agree within what both say
of their errors.
"""

import governor_mechanism as gm

one = gm.run("watt", engine="multibody", accuracy=1e-8)
other = gm.run("watt", engine="reduced", accuracy=1e-8)
difference = abs(one.readings["arm_angle"] - other.readings["arm_angle"]).max()
estimates = f"{one.error_estimate:.1e} and {other.error_estimate:.1e}"
print(f"largest difference {difference:.1e} rad; estimates {estimates}")
one.plot_diagnostics().save("diagnostics.png")

# %%
# More: :doc:`the engines </theory/engines>`.

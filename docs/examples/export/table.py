"""
Readings as a table
===================

A run on disk: CSV for every program, netCDF for arrays, and the run itself again, bit by bit.
"""

from pathlib import Path

import governor_mechanism as gm

run = gm.run("porter")
run.save("results", name="porter")
print(*sorted(path.name for path in Path("results").iterdir()))
for line in Path("results/porter.csv").read_text().splitlines()[:12]:
    print(line[:100])
again = gm.open_run("results")
print(again.readings["arm_angle"][-1] == run.readings["arm_angle"][-1])

# %%
# More: :doc:`exporting results </how_to/export>`.

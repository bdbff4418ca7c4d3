"""
A four-bar that computes 1/x
============================

Freudenstein's equation, solved for four pairs of angles. What is found is a scene, which runs.
"""

import governor_mechanism as gm

found = gm.synthesise_function(
    function="1/x",
    over=[1, 2],
    input_angles=["30 deg", "120 deg"],
    output_angles=["240 deg", "330 deg"],
    count=4,
    ground="100 mm",
)
print(found)
found.plot().save("function.png")

# %%
# More: :doc:`synthesis </how_to/synthesis>`.

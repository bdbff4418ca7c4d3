"""
The best dimensions
===================

Masses and offset that make a governor least insensitive to 20 N of friction, if it shall rise at
130 rpm and not weigh more than 300 N.
"""

import governor_mechanism as gm


def weight(scene):
    dimensions = scene.part.dimensions
    return 9.81 * (2 * dimensions["ball_mass"] + dimensions["sleeve_mass"])


governor = gm.load("porter").replace(
    {
        "effects.stops": {"arm_angle": ["20 deg", "45 deg"]},
        "effects.dry_friction": {"sleeve_lift": "20 N"},
    }
)
over = {
    "dimensions.ball_mass": ("2 kg", "8 kg"),
    "dimensions.sleeve_mass": ("10 kg", "40 kg"),
    "dimensions.offset": ("0 mm", "60 mm"),
}
conditions = ["highest equilibrium speed = 130 rpm", "weight <= 300 N"]
found = gm.optimise(
    governor, over, minimise="insensitivity", subject_to=conditions, quantities={"weight": weight}
)
print(found)
found.plot().save("optimum.png")

# %%
# More: :doc:`optima and trade-offs </how_to/optimise>`.

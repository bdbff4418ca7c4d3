"""
A formula of your own under pytest
==================================

pytest fills the arguments by their names and compares what the function returns with the
simulated machine.
"""

import math

import pytest


@pytest.mark.governor(
    scene="porter", quantity="equilibrium_speed", over={"arm_angle": "15 deg:45 deg:25"}
)
def test_speed(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    return math.sqrt(
        gravity
        * (1 + sleeve_mass / ball_mass)
        * math.tan(arm_angle)
        / (offset + arm * math.sin(arm_angle))
    )


if __name__ == "__main__":
    pytest.main(["test_of_a_formula.py", "-p", "governor_mechanism.pytest_plugin", "--quiet"])

# %%
# More: :doc:`a kernel in continuous integration </how_to/kernel_in_ci>`.

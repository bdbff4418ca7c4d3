"""The machines: dimensions in, Mechanism out. `MACHINES` maps the names used in scene files to their classes."""

from __future__ import annotations

from governor_mechanism.machines.dimensions import Machine
from governor_mechanism.machines.parabolic import ParabolicGovernor
from governor_mechanism.machines.pendulum import PendulumGovernor

MACHINES: dict[str, type[Machine]] = {"pendulum_governor": PendulumGovernor, "parabolic_governor": ParabolicGovernor}

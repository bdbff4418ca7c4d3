"""Registry of machines: the names in scene files, and their classes."""

from governor_mechanism.later_module import LaterClasses
from governor_mechanism.machines.base import Machine

MACHINES: LaterClasses[type[Machine]] = LaterClasses(
    __package__,
    {
        "pendulum_governor": "pendulum.PendulumGovernor",
        "proell": "proell.ProellGovernor",
        "parabolic_governor": "parabolic.ParabolicGovernor",
        "hartnell": "hartnell.HartnellGovernor",
        "hartung": "hartung.HartungGovernor",
        "slide_valve": "slide_valve.SlideValve",
        "slider_crank": "slider_crank.SliderCrank",
        "stephenson": "stephenson.StephensonGear",
        "flywheel_engine": "flywheel_engine.FlywheelEngine",
    },
)
"""Classes of machines by name, each with the module in this folder."""

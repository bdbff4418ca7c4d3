"""Registry of machines. `MACHINES` maps the names in scene files to classes."""

from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.flywheel_engine import FlywheelEngine
from governor_mechanism.machines.hartnell import HartnellGovernor
from governor_mechanism.machines.hartung import HartungGovernor
from governor_mechanism.machines.parabolic import ParabolicGovernor
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.machines.proell import ProellGovernor
from governor_mechanism.machines.slide_valve import SlideValve
from governor_mechanism.machines.slider_crank import SliderCrank
from governor_mechanism.machines.stephenson import StephensonGear

MACHINES: dict[str, type[Machine]] = {
    machine.name: machine
    for machine in (
        PendulumGovernor,
        ProellGovernor,
        ParabolicGovernor,
        HartnellGovernor,
        HartungGovernor,
        SlideValve,
        SliderCrank,
        StephensonGear,
        FlywheelEngine,
    )
}

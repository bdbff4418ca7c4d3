"""Registry of machine drawings. Every mechanism that is not listed is drawn from its bodies and joints."""

from governor_mechanism.later_module import LaterClasses
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.machines.machine_drawing import MachineDrawing

MACHINE_DRAWINGS: LaterClasses[type[MachineDrawing]] = LaterClasses(
    __package__,
    {
        "pendulum_governor": "pendulum.PendulumDrawing",
        "proell": "proell.ProellDrawing",
        "hartnell": "hartnell.HartnellDrawing",
        "hartung": "hartung.HartungDrawing",
        "parabolic_governor": "parabolic.ParabolicDrawing",
        "slide_valve": "slide_valve.SlideValveDrawing",
        "stephenson": "stephenson.StephensonDrawing",
        "slider_crank": "slider_crank.SliderCrankDrawing",
        "flywheel_engine": "flywheel_engine.FlywheelEngineDrawing",
    },
)
"""Classes of drawings by the name of the machine, each with the module in this folder."""


DRAWN_WITH_WHEEL = frozenset({"stephenson"})
"""Machines whose drawings show the flywheel of another part on their shaft."""


def find_drawing_class(part: Part, run: Trajectory | None = None) -> type[MachineDrawing]:
    """Return the class that draws a part; a valve gear that does not move as one in its run is drawn as any mechanism is."""
    if (listed := MACHINE_DRAWINGS.get(part.machine)) is not None:
        return listed
    # Drawings of listed machines do without these imports, which take long.
    if part.mechanism.valve is not None:
        from governor_mechanism.render.machines.valve_gear import ValveGearDrawing
        from governor_mechanism.render.machines.valve_gear_proportions import is_valve_gear, may_be_valve_gear

        if may_be_valve_gear(part) and (run is None or is_valve_gear(run, part)):
            return ValveGearDrawing
    from governor_mechanism.render.machines.generic.drawing import GenericDrawing

    return GenericDrawing


def drawing_of(run: Trajectory, part: Part, slow_down: float = 1.0, magnification: float = 1.0) -> MachineDrawing:
    """Return the drawing of a part of a run whose seconds take `slow_down` seconds of film, and whose motion is magnified by a factor."""
    return find_drawing_class(part, run)(run=run, part=part, slow_down=slow_down, magnification=magnification)

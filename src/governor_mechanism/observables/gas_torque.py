"""Mean torque of the gas in the cylinders of an engine."""

import math

from governor_mechanism.effects.gas_pressure import work_per_stroke
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.scene import Scene


def mean_gas_torque(scene: Scene) -> float:
    """Return the mean torque of gas in cylinders over a stroke: its work over half a turn, whatever the connecting rods.

    Result: torque, N m; positive if it drives. Raises MechanismError if a throttle or a cut-off moves, so
    that strokes differ, or the scene has no gas in cylinders.
    """
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    if not gases:
        raise MechanismError("the mean gas torque is that of an engine; this scene has no gas in cylinders")
    if any(gas.strokes_differ for gas in gases):
        raise MechanismError("the mean gas torque is that of an engine whose throttle and cut-off are at rest; here one moves")
    return work_per_stroke(gases) / math.pi

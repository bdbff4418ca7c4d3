"""Kinematics with the readings that follow from positions and rates alone."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics, solve_kinematics
from governor_mechanism.model.output_variables import ShaftSpeed
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import evaluate_positional_readings
from governor_mechanism.types import FloatArray


def analyse_kinematics(
    scene: Scene, over: str, values: Sequence[float] | FloatArray, rate: float = 1.0, acceleration: float = 0.0
) -> Kinematics:
    """Return the kinematics over values of a reading or over time, with all readings that they determine.

    Parameters
    ----------
    scene
        The scene.
    over
        Name of a reading, or "time".
    values
        Values of the reading, SI, or times, s; shape (n,).
    rate
        First time derivative of the reading at each value, SI/s.
    acceleration
        Second time derivative of the reading at each value, SI/s2.

    Returns
    -------
    Kinematics
        The motion. Its readings include shaft speeds, forces of springs and weights, and pressures of gas without a control. A static
        force is left out if it is not defined, as where the mechanism has several degrees of freedom.

    Raises
    ------
    MechanismError
        As `solve_kinematics`.
    """
    motion = solve_kinematics(scene, over, values, rate, acceleration)
    outputs = scene.mechanism.derived_readings
    derived = {one.name: motion.rates[one.reading] for one in outputs if isinstance(one, ShaftSpeed) and one.reading in motion.rates}
    with suppress(MechanismError):
        derived |= evaluate_positional_readings(scene, motion.poses)
    return replace(motion, readings={**motion.readings, **derived})

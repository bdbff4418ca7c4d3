"""Kinematics with the readings that follow from positions and rates alone."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, Kinematics, solve_kinematics
from governor_mechanism.model.output_variables import ShaftSpeed
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import evaluate_positional_readings
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import convert_texts, parse_quantity

MAX_DERIVATIVE = 1e100
"""Largest rate or acceleration, SI: its square is still a number."""

_RATE_KINDS: Final = {"angle": "angular_speed", "length": "speed", "time": "number"}
_ACCELERATION_KINDS: Final = {"angle": "angular_acceleration", "length": "acceleration", "time": "number"}
"""Kinds of the derivatives by the kind of the reading; time itself has none, and its numbers are not used."""


def analyse_kinematics(
    scene: Scene,
    over: str,
    # values of the reading, SI, or times, s, or texts with a unit; shape (n,)
    values: Sequence[float | str] | FloatArray,
    rate: float | str = 1.0,  # first time derivative of the reading at each value, SI/s, or text with a unit
    # second time derivative of the reading at each value, SI/s2, or text with a unit
    acceleration: float | str = 0.0,
) -> Kinematics:
    """Return the kinematics over values of a reading or over time, with all readings that they determine.

    Result: the motion. Its readings include shaft speeds, forces of springs and weights, and pressures of gas
    without a control. A static force is left out if it is not defined, as where the mechanism has several
    degrees of freedom. Raises MechanismError as `solve_kinematics`; also for a text of another unit, and for
    a rate or acceleration that no machine has.
    """
    kind = _kind_of(scene, over)
    samples = convert_texts(values, kind, over)
    derivatives = [
        _parse_derivative(rate, _RATE_KINDS.get(kind, kind), f"rate of {over}"),
        _parse_derivative(acceleration, _ACCELERATION_KINDS.get(kind, kind), f"acceleration of {over}"),
    ]
    motion = solve_kinematics(scene, over, samples, *derivatives)
    outputs = scene.mechanism.derived_readings
    derived = {one.name: motion.rates[one.reading] for one in outputs if isinstance(one, ShaftSpeed) and one.reading in motion.rates}
    with suppress(MechanismError):
        derived |= evaluate_positional_readings(scene, motion.poses)
    return replace(motion, readings={**motion.readings, **derived})


def _kind_of(scene: Scene, over: str) -> str:
    """Return the kind of quantity of a reading or of time; an unknown name is refused later, with the known ones."""
    mechanism = scene.part.mechanism if len(scene.parts) == 1 else scene.mechanism
    kinds = {reading.name: reading.quantity for reading in mechanism.readings}
    return "time" if over == TIME_VARIABLE else kinds.get(over, "number")


def _parse_derivative(value: float | str, kind: str, what: str) -> float:
    """Return a rate or an acceleration, SI."""
    number = parse_quantity(value, kind, what)
    if abs(number) > MAX_DERIVATIVE:
        raise MechanismError(f"{what} must be at most {MAX_DERIVATIVE:g} in SI; found {number:g}")
    return number

"""The quantities of a sweep whose caller names none: what characterises the motion of its scene."""

import math

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.model.joints import RotationalDriver
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.part import EQUILIBRIUM, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.statics.equilibria import has_damping
from governor_mechanism.studies.sweep.quantities import find_reading_units
from governor_mechanism.studies.sweep.rules import DURATION_RULE, SETTLING_FRACTION, VALVE_RULES

SLIP_READING = "die_slip"
"""Reading whose range over a run is the slip of a die block."""

TRIAL_ACCURACY = 1e-3
"""Accuracy of the run that shows whether a crank turns."""


def choose_quantities(
    scene: Scene,  # the scene as it is before a key is varied
) -> tuple[list[str], str]:
    """Return the names of the quantities that characterise the motion of a scene, and the reason for them.

    Results: names, names of quantities; reason, a clause, as "nothing damps the motion".
    """
    readings = find_reading_units(scene)
    if has_valve_events(scene):
        slip = [f"span {SLIP_READING}"] if SLIP_READING in readings else []
        return [*VALVE_RULES, *slip], "a turning crank drives a valve"
    if scene.mechanism.stall_limits:
        return ["mean speed", "speed fluctuation"], "gas drives the crank of an engine"
    leading = next((name for name in _leading_readings(scene) if name in readings), None)
    if leading is None:
        return [DURATION_RULE], "the scene has no reading"
    if not scene.start.values and scene.mechanism.count_drivers():
        return [f"span {leading}", f"max rate of {leading}"], "drivers prescribe the whole motion"
    return _choose_of_free_motion(scene, leading)


def _choose_of_free_motion(scene: Scene, leading: str) -> tuple[list[str], str]:
    """Return quantities of the leading reading of a scene that moves freely, and the reason."""
    spindles = [part.spindle for part in scene.parts if part.turns and isinstance(part.spindle, Spindle)]
    if any(spindle.speed_fluctuation for spindle in spindles):
        return [f"mean {leading}", f"amplitude of {leading}"], "the speed of the spindle fluctuates"
    is_damped = has_damping(scene) or any(isinstance(effect, DryFriction) for effect in scene.output_effects)
    last_change = max((spindle.times[-1] for spindle in spindles), default=0.0)
    if last_change > (1.0 - SETTLING_FRACTION) * scene.run.duration:
        return [f"min {leading}", f"max {leading}"], "the speed of the spindle changes until the run ends"
    if is_damped:
        return [f"settled {leading}"], "friction or dashpots damp the motion"
    if any(len(spindle.times) > 1 for spindle in spindles):
        return [f"min {leading}", f"max {leading}"], "the speed of the spindle changes, and nothing damps the motion"
    if EQUILIBRIUM in scene.start.values.values():
        return [f"settled {leading}"], "the motion starts in equilibrium"
    if _turns_fully(scene, leading):
        return [f"mean speed of {leading}", f"speed fluctuation of {leading}"], "a crank turns"
    return [f"mean {leading}", f"amplitude of {leading}", f"frequency of {leading}"], "nothing damps the motion"


def _leading_readings(scene: Scene) -> list[str]:
    """Return the readings, the leading one first: of a governor its coordinate, of a driven mechanism what is not the driver's angle."""
    if len(scene.parts) > 1:
        # Governors turn with a spindle; they come first.
        parts = sorted(scene.parts, key=lambda part: not part.turns)
        return [f"{part.name}.{part.mechanism.coordinate}" for part in parts]
    mechanism = scene.part.mechanism
    names = [mechanism.coordinate, *(reading.name for reading in mechanism.readings)]
    driven_bodies = {joint.second.body for joint in mechanism.joints if isinstance(joint, RotationalDriver)}
    driven = [one.name for one in mechanism.readings if isinstance(one, BodyAngle) and one.body in driven_bodies]
    return sorted(names, key=lambda name: name in driven)


def _turns_fully(scene: Scene, reading: str) -> bool:
    """Return whether a reading of a mechanism in a fixed plane is an angle that makes a whole turn in a run of the scene."""
    part, own_name = scene.part_of(reading)
    if part.turns or part.mechanism.reading(own_name).quantity != "angle":
        return False
    try:
        engine, reason = select_engine(scene.run.engine, scene, TRIAL_ACCURACY)
        angles = engine.run(scene, accuracy=TRIAL_ACCURACY, certify=False, reason=reason).readings[reading]
    except GovernorMechanismError:  # its rows say why it cannot run
        return False
    return len(angles) > 1 and abs(float(angles[-1] - angles[0])) >= math.tau

"""Why engine `reduced` cannot run a scene: it integrates one coordinate of one part and one shaft."""

from collections.abc import Iterator

from governor_mechanism.mechanics.dynamics.contacts import reading_functions_of
from governor_mechanism.mechanics.dynamics.inputs import output_of_reading
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.reduction.shaft import ShaftTrain, find_shaft_train, parts_with_coordinate, shaft_readings
from governor_mechanism.model.force_elements import Torque, TorsionDamper
from governor_mechanism.model.joints import GROUND, Gear
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import TableFunction


def find_refusal(scene: Scene) -> str:
    """Return why engine `reduced` cannot run a scene, as a sentence; empty if it can.

    Parameters
    ----------
    scene
        Scene to check.

    Returns
    -------
    str
        Reason, or an empty string.
    """
    parts = parts_with_coordinate(scene)
    if len(parts) != 1:
        return (
            "engine 'reduced' integrates one coordinate and one shaft, a part in a fixed plane whose bodies are pinned to the ground at "
            f"their mass centres; of {[part.name for part in scene.parts]}, {len(parts)} are more than a shaft; choose engine 'multibody'"
        )
    prefix, part = parts[0]
    position_solver = PositionSolver(part.mechanism)
    if position_solver.equations.is_driven.any():
        return "engine 'reduced' integrates one free coordinate, but drives move this mechanism; choose engine 'multibody'"
    if position_solver.mobility != 1:
        return (
            f"engine 'reduced' integrates one degree of freedom; this mechanism has mobility {position_solver.mobility}; "
            "choose engine 'multibody'"
        )
    own_readings = {prefix + reading.name for reading in (*part.mechanism.readings, *part.mechanism.internal_outputs)}
    for problem in _shaft_problems(scene, find_shaft_train(scene), own_readings):
        return f"engine 'reduced' cannot model {problem}; choose engine 'multibody'"
    return ""


def _shaft_problems(scene: Scene, train: ShaftTrain, own_readings: set[str]) -> Iterator[str]:
    """Yield what the model of one coordinate and one shaft cannot describe."""
    rotors = {GROUND, *train.rotors}
    for name in train.rotors:
        if name not in train.motion:
            yield f"body {name!r}, which turns independently of {next(iter(train.motion))!r}"
    for joint in scene.mechanism.joints:
        if isinstance(joint, Gear) and len({joint.first.body, joint.second.body} & set(train.rotors)) == 1:
            yield f"gear {joint.name!r} between a shaft and a body that does more than rotate"
    for name in scene.system.breaking_gears:
        yield f"gear {name!r}, which breaks"
    for effect in scene.output_effects:
        if effect.reading not in own_readings:
            yield f"the effect {type(effect).__name__} on {effect.reading!r}, an angle of the shaft"
    for element in scene.mechanism.force_elements:
        bodies = set(element.bodies)
        if bodies & set(train.rotors) and not (isinstance(element, Torque | TorsionDamper) and bodies <= rotors):
            yield f"force element {element.name!r} on the shaft, which is neither a torque nor a torsion damper"
    readings = own_readings | shaft_readings(scene, train).keys()
    for function in reading_functions_of(scene):
        if function.lag:
            yield f"a load that follows {function.reading!r} with a lag"
        if isinstance(function, TableFunction):
            yield f"a load that depends on {function.reading!r} by a table, whose kinks are events"
        if output_of_reading(function.reading)[0] not in readings:
            yield f"a load that depends on {function.reading!r}, which is no reading of {train.rotors} nor of the part with the coordinate"

"""The part of a scene that turns with a spindle, alone at a given speed: what equilibria and studies of regulation are about."""

from dataclasses import replace

from governor_mechanism.engines.initial_state import initial_speed, initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.coupling.coupled_system import SPINDLE_TORQUE
from governor_mechanism.model.coupling.couplings import ControlCoupling
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.scene import Scene


def rotating_part_alone(scene: Scene) -> Scene:
    """Return the part that turns with a spindle as a scene of its own, at the spindle speed and the position of the start.

    Parameters
    ----------
    scene
        A scene of any parts.

    Returns
    -------
    Scene
        Scene of one part without couplings. Its spindle speed is given; a single part on a free spindle keeps it.

    Raises
    ------
    MechanismError
        If no part or several parts turn with a spindle, or if a load of the part depends on other parts.
    """
    if len(scene.parts) == 1:
        return _with_start_speed(scene)
    planes = scene.system.planes
    remedy = "gm.linearise and `equilibria --linearise` find the steady state of all parts together"
    if len(planes) != 1:
        names = ", ".join(repr(plane.prefix.removesuffix(".")) for plane in planes) or "none"
        raise MechanismError(
            f"this works on one part that turns with a spindle, and in this scene these parts turn: {names}; "
            f"write the part that is meant in a scene file of its own, with a given spindle.speed; {remedy}"
        )
    plane, prefix = planes[0], planes[0].prefix
    part = scene.part_of(prefix + SPINDLE_TORQUE)[0]
    for control in scene.couplings:
        if isinstance(control, ControlCoupling) and control.target.startswith(prefix) and control.target != prefix + SPINDLE_TORQUE:
            raise MechanismError(
                f"{control.target!r} depends on other parts through coupling {control.name!r}, so that part {part.name!r} has no "
                f"equilibria of its own; {remedy}"
            )
    poses, velocities = initial_state(scene)
    speed = Spindle(speeds=(initial_speed(scene, plane, velocities),))
    coordinate = part.mechanism.coordinate
    position = float(evaluate_output_value(scene.mechanism, prefix + coordinate, poses))
    alone = replace(part, spindle=speed, start=Start(values={coordinate: position}))
    return Scene(title=scene.title, parts=(alone,), run=scene.run, source=scene.source)


def _with_start_speed(scene: Scene) -> Scene:
    """Return a scene of one part in which a free spindle has the start speed that follows from the equilibrium of the whole scene."""
    spindle = scene.part.spindle
    if isinstance(spindle, Spindle) or spindle.start_speed is not None:
        return scene
    _, velocities = initial_state(scene)
    return scene.with_changes(spindle=replace(spindle, start_speed=initial_speed(scene, scene.system.planes[0], velocities)))

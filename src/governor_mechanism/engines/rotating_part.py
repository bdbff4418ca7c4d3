"""The part of a scene that turns with a spindle, alone at a given speed: what equilibria and studies of regulation are about."""

from dataclasses import replace

from governor_mechanism.engines.initial_state import initial_speed, initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.coupling.coupled_system import SPINDLE_TORQUE, rename
from governor_mechanism.model.coupling.couplings import ControlCoupling
from governor_mechanism.model.part import EQUILIBRIUM, Spindle, Start
from governor_mechanism.model.scene import Scene


def rotating_part_alone(scene: Scene) -> Scene:
    """Return the part that turns with a spindle as a scene of its own, at the spindle speed and the position of the start."""
    # A single part on a free spindle keeps it; else the speed of the spindle is given. The title says
    # what the scene is.
    if len(scene.parts) == 1:
        return _with_start_speed(scene)
    planes = scene.system.planes
    remedy = "The steady state of all parts together is found by gm.linearise and `equilibria --linearise`"
    if len(planes) != 1:
        names = ", ".join(repr(plane.prefix.removesuffix(".")) for plane in planes) or "none"
        raise MechanismError(
            f"this works on one part that turns with a spindle, and in this scene these parts turn: {names}; "
            f"write the part that is meant in a scene file of its own, with a given spindle.speed. {remedy}"
        )
    plane, prefix = planes[0], planes[0].prefix
    part = scene.part_of(prefix + SPINDLE_TORQUE)[0]
    for control in scene.couplings:
        if isinstance(control, ControlCoupling) and control.target.startswith(prefix) and control.target != prefix + SPINDLE_TORQUE:
            raise MechanismError(
                f"{control.target!r} depends on other parts through coupling {control.name!r}, so that part {part.name!r} has no "
                f"equilibria of its own. {remedy}"
            )
    poses, velocities = initial_state(scene)
    speed, coordinate = initial_speed(scene, plane, velocities), part.mechanism.coordinate
    position = float(evaluate_output_value(scene.mechanism, prefix + coordinate, poses))
    own = rename((part.mechanism, part.effects), lambda name: name.removeprefix(prefix))
    start = Start(values={coordinate: position})
    alone = replace(part, mechanism=own[0], effects=own[1], spindle=Spindle(speeds=(speed,)), start=start)
    title = f"{scene.title} (part {part.name!r} alone, started at {speed:.6g} rad/s)"
    try:
        return Scene(title=title, parts=(alone,), run=scene.run, source=scene.source)
    except MechanismError as error:  # it reads other parts
        raise MechanismError(
            *(f"part {part.name!r} has no equilibria of its own: {problem.rstrip('.')}. {remedy}" for problem in error.problems)
        ) from None


def _with_start_speed(scene: Scene) -> Scene:
    """Return a scene of one part in which a free spindle has the start speed that follows from the equilibrium of the whole scene."""
    spindle = scene.part.spindle
    if isinstance(spindle, Spindle) or spindle.start_speed is not None or EQUILIBRIUM not in scene.start.values.values():
        return scene
    speed = initial_speed(scene, scene.system.planes[0], initial_state(scene)[1])
    return scene.with_changes(title=f"{scene.title} (started at {speed:.6g} rad/s)", spindle=replace(spindle, start_speed=speed))

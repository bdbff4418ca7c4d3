"""How a scene starts: assembled, at rest or moving, and refused where it cannot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from governor_mechanism.effects.clearance import PLAY
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import keepers_of
from governor_mechanism.mechanics.dynamics.lowering import lever_pin
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import EQUILIBRIUM, Scene
from governor_mechanism.numerics.jit import announce
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.equilibrium_speed import turns
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import spoken


def starting_state(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Poses and velocities (bodies, 3) with which a scene starts.

    Start values and rates are met exactly; what they leave open stays nearest to the sketch, and slowest. Raises
    MechanismError where that cannot be assembled, an equilibrium does not exist, joints or drives contradict each
    other, or nothing can move.
    """
    mechanism = scene.part.mechanism
    announce("gradients_of", 3)
    for body in mechanism.bodies:
        lever_pin(mechanism, body)  # refuses those that cannot turn
    assembler = Assembler(mechanism)
    values = scene.start.values
    if assembler.equations.driven.any():
        _refuse_idle_drives(mechanism)
    if EQUILIBRIUM in values.values():
        poses = _resting(scene)
    else:
        numbers = {name: float(value) for name, value in values.items()}
        for name, value in numbers.items():
            _refuse_outside(mechanism, name, value)
        poses = _assembled(assembler, numbers)
        _refuse_outside_at(mechanism, poses)
    _refuse_immobile(assembler, poses)
    _refuse_beyond_stops(scene, poses)
    return poses, assembler.velocities(poses, scene.start.rates)


def _resting(scene: Scene) -> FloatArray:
    mechanism, values = scene.part.mechanism, scene.start.values
    if PLAY in values:
        raise MechanismError(
            f"start = '{EQUILIBRIUM}' is not settled with play, which leaves the sleeve free between two ends; give "
            f"start.{mechanism.coordinate} as a number"
        )
    if list(values) != [mechanism.coordinate] or Assembler(mechanism).mobility != 1:
        raise MechanismError(
            f"start = '{EQUILIBRIUM}' is for one coordinate of a mechanism of mobility one, {mechanism.coordinate!r}; "
            f"found {list(values)}; give numbers"
        )
    return resting_poses(scene)


def _refuse_idle_drives(mechanism: Mechanism) -> None:
    """Drives that joints or other drives leave nothing to move; seen where the joints alone are closed."""
    assembler = Assembler(mechanism)
    driven = assembler.equations.driven
    names = list(dict.fromkeys(assembler.equations.joints[k].name for k in assembler.equations.owner[driven]))
    undriven = replace(mechanism, joints=tuple(joint for joint in mechanism.joints if joint.name not in names))
    poses = Assembler(undriven).at({})
    without, mobility = assembler.freedoms(poses, drives=False), assembler.freedoms(poses)
    if without - mobility < np.sum(driven) and np.sum(driven) <= without:
        raise MechanismError(
            f"drives {names} find only {without - mobility} of the mobility {without} that the joints leave to move "
            "where the sketch stands: at a dead centre, or two of them the same; sketch it a little further on"
        )
    if without - mobility < np.sum(driven):
        raise MechanismError(
            f"drives {names} contradict each other or the joints: the joints leave mobility {without}, "
            f"and of {int(np.sum(driven))} drives only {without - mobility} find something to move; leave one drive out"
        )


def _refuse_immobile(assembler: Assembler, poses: FloatArray) -> None:
    if assembler.equations.driven.any() or assembler.freedoms(poses) > 0:
        return
    mechanism = assembler.mechanism
    fewer = {
        joint.name: replace(mechanism, joints=tuple(other for other in mechanism.joints if other is not joint))
        for joint in mechanism.joints
    }
    freeing = [name for name, one in fewer.items() if Assembler(one).freedoms(poses) > 0]
    which = f"any one of {freeing}" if freeing else "more than one of them"
    raise MechanismError(f"the mechanism cannot move: its joints leave mobility 0; without {which} it could")


BEYOND = 1e-9
"""Machine sizes, or rad: less than this beyond a stop is at it."""


def _refuse_beyond_stops(scene: Scene, poses: FloatArray) -> None:
    mechanism = scene.part.mechanism
    for keeper in keepers_of(scene):
        angle = mechanism.reading(keeper.reading).quantity == "angle"
        unit, size = ("rad", 1.0) if angle else ("m", mechanism.size)
        value = float(reading_value(mechanism, keeper.reading, poses))
        if not keeper.low - BEYOND * size <= value <= keeper.high + BEYOND * size:
            ends = " to ".join(spoken(end, unit) for end in (keeper.low, keeper.high))
            raise MechanismError(
                f"the start lies beyond the stops of {keeper.reading!r}, {ends}: it is at {spoken(value, unit)}; "
                "start between them, or move the stops"
            )


def _assembled(assembler: Assembler, numbers: Mapping[str, float]) -> FloatArray:
    """Assembled at start values; where drives are in the way, they are named."""
    try:
        return assembler.at(numbers)
    except MechanismError as error:
        driven = assembler.equations.owner[assembler.equations.driven]
        if not numbers or not driven.size:
            raise
        names = [assembler.equations.joints[k].name for k in dict.fromkeys(driven.tolist())]
        raise MechanismError(
            f"start values {dict(numbers)} and drives {names} contradict each other at t = 0: "
            "leave the values out, or let the drives begin there"
        ) from error


def _refuse_outside_at(mechanism: Mechanism, poses: FloatArray) -> None:
    for limit in mechanism.limits:
        value = float(reading_value(mechanism, limit.reading, poses))
        if not limit.low < value < limit.high:
            raise MechanismError(
                f"the start lies outside the range of {limit.reading!r}, {limit.low:.6g} to {limit.high:.6g}: it is at "
                f"{value:.6g}; {limit.below if value <= limit.low else limit.above}"
            )


def _refuse_outside(mechanism: Mechanism, name: str, value: float) -> None:
    for limit in mechanism.limits:
        if limit.reading == name and not limit.low < value < limit.high:
            raise MechanismError(
                f"start.{name} = {value:.6g} lies outside the travel, "
                f"{limit.low:.6g} to {limit.high:.6g}: {limit.below if value <= limit.low else limit.above}"
            )


def resting_poses(scene: Scene) -> FloatArray:
    """Poses of the one stable equilibrium at the scene's first spindle speed; refuses none, and more than one."""
    try:
        found = find_equilibria(scene)
    except MechanismError as error:
        start = f"start.{scene.part.mechanism.coordinate} = 'equilibrium'"
        cure = "change spindle.speed, or give a number" if turns(scene) else "give a number"
        raise MechanismError(f"{start}: {error.problems[0]}; {cure}") from error
    stable = [rest for rest in found if rest.stable]
    if len(stable) == 1:
        return stable[0].poses
    name, at_speed = scene.part.mechanism.coordinate, _at_first_speed(scene)
    if stable:
        at = ", ".join(f"{rest.coordinate:.6g}" for rest in stable)
        raise MechanismError(
            f"start.{name} = 'equilibrium' is not definite: {at_speed}there are stable ones at {at}; give one"
        )
    if found[0].astatic:
        low, high = found[0].extent
        raise MechanismError(
            f"start.{name} = 'equilibrium' is not definite: {at_speed}the mechanism is astatic and rests "
            f"anywhere from {low:.6g} to {high:.6g}; give a number"
        )
    at = ", ".join(f"{rest.coordinate:.6g}" for rest in found)
    cure = ", or change spindle.speed" if at_speed else ""
    raise MechanismError(
        f"start.{name} = 'equilibrium': {at_speed}only an unstable one exists, at {name} = {at}; "
        f"start there by number{cure}"
    )


def _at_first_speed(scene: Scene) -> str:
    """The words for the scene's first spindle speed; none where nothing turns with a spindle."""
    return f"at {SpeedProgram(scene.spindle).start_speed * 30 / np.pi:.6g} rpm " if turns(scene) else ""

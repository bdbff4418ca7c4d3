"""Where a mechanism of mobility one stands still: generalised forces along its coordinate, and their zeros."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.equations.assembly import Assembler
from governor_mechanism.equations.compiled import announce
from governor_mechanism.equations.motion import generalised_forces
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.system import from_centres, make_system
from governor_mechanism.equations.timing import SpeedProgram
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.scene import EQUILIBRIUM, Scene

SCAN = 200
"""Points of the travel between which a change of sign is looked for; two equilibria closer than that are missed."""

EDGE = 1e-6
"""Fraction of the travel left out at each end, where the linkage stands at a dead centre."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A position of rest: value of the leading coordinate, whether it is stable, and the poses (bodies, 3)."""

    coordinate: float
    stable: bool
    poses: Array


class _Loads:
    """Generalised forces along the leading coordinate of a scene at its start."""

    def __init__(self, scene: Scene) -> None:
        self.assembler = Assembler(scene.part.mechanism)
        self._system, curves = make_system(scene)
        self._cubics = np.array([curve.cubics_from(np.zeros(1))[0] for curve in curves])

    def along(self, poses: Array) -> tuple[float, float]:
        """Forces along the coordinate: (at rest, of the spindle's turning at 1 rad/s). N m per rad, or N per m."""
        tangent = self.assembler.tangent(poses)
        there, motion = from_centres(self._system, poses, tangent)
        still, found = np.zeros_like(poses), []
        for square in (0.0, 1.0):
            force = np.empty_like(poses)
            generalised_forces(self._system, there, still, self._cubics, 0.0, square, force)
            found.append(float(np.sum(force * motion)))
        return found[0], found[1] - found[0]


def equilibrium_speed(scene: Scene, values: Array) -> Array:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Raises MechanismError where no speed holds it, or where it cannot be assembled.
    """
    if not (scene.centrifugal and scene.gravity):
        raise MechanismError("an equilibrium speed needs both effects, gravity and centrifugal; list them in the scene")
    loads, poses = _Loads(scene), None
    speeds = []
    for value in values:
        poses = loads.assembler.poses(float(value), near=poses)
        falling, turning = loads.along(poses)
        if turning == 0.0 or falling / turning > 0.0:
            name = scene.part.mechanism.coordinate
            raise MechanismError(
                f"no spindle speed holds the mechanism at {name} = {value:.6g}: the loads do not oppose"
            )
        speeds.append(np.sqrt(-falling / turning))
    return np.array(speeds)


def find_equilibria(scene: Scene, spindle_speed: float) -> tuple[Equilibrium, ...]:
    """All positions of rest at a given spindle speed (rad/s) over the travel, in ascending order of the coordinate."""
    loads = _Loads(scene)
    assembler = loads.assembler
    low, high = travel(scene.part.mechanism)
    values = np.linspace(low, high, SCAN + 1)
    poses = [assembler.poses(float(values[0]))]
    for value in values[1:]:
        poses.append(assembler.poses(float(value), near=poses[-1]))

    def force(value: float, near: Array) -> float:
        falling, turning = loads.along(assembler.poses(value, near=near))
        return falling + turning * spindle_speed**2

    along = np.array([force(float(value), pose) for value, pose in zip(values, poses, strict=True)])
    found = []
    for index in np.flatnonzero(np.sign(along[:-1]) != np.sign(along[1:])):
        if along[index] == 0.0 and index > 0:
            continue  # this zero was the end of the interval before
        root = brentq(force, values[index], values[index + 1], args=(poses[index],), xtol=1e-15, rtol=1e-15)
        rest = assembler.poses(float(root), near=poses[index])
        stable = bool(along[index + 1] < along[index])
        found.append(Equilibrium(coordinate=float(root), stable=stable, poses=rest))
    return tuple(found)


def travel(mechanism: Mechanism) -> tuple[float, float]:
    """The range of the leading coordinate, a hair inside its limits."""
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate:
            hair = EDGE * (limit.high - limit.low)
            return limit.low + hair, limit.high - hair
    raise MechanismError(
        f"the travel of {mechanism.coordinate!r} is not known; give a start value instead of 'equilibrium'"
    )


def starting_state(scene: Scene) -> tuple[Array, Array]:
    """Poses and velocities (bodies, 3) with which a scene starts.

    Start values and rates are met exactly; what they leave open stays nearest to the sketch, and slowest. Raises
    MechanismError where that cannot be assembled, an equilibrium does not exist, joints or drives contradict each
    other, or nothing can move.
    """
    mechanism = scene.part.mechanism
    announce("gradients_of", 3)
    make_system(scene)  # refuses bodies that cannot turn
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
        poses = assembler.at(numbers)
    _refuse_immobile(assembler, poses)
    return poses, assembler.velocities(poses, scene.start.rates)


NOTED = 1e-9
"""A guess open by less than this fraction of the machine's size was no guess."""


def assembly_notes(scene: Scene) -> tuple[str, ...]:
    """What there is to say about how the start came about."""
    mechanism = scene.part.mechanism
    joint, gap = Assembler(mechanism).guess_gap()
    if gap < NOTED * mechanism.size or scene.start.values:
        return ()
    return (f"the start was a guess: joint {joint!r} was open by {gap:.3g} m in it, and was closed",)


def _resting(scene: Scene) -> Array:
    mechanism, values = scene.part.mechanism, scene.start.values
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
    if without - mobility < np.sum(driven):
        raise MechanismError(
            f"drives {names} contradict each other or the joints: the joints leave mobility {without}, "
            f"and of {int(np.sum(driven))} drives only {without - mobility} find something to move; leave one drive out"
        )


def _refuse_immobile(assembler: Assembler, poses: Array) -> None:
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


def _refuse_outside(mechanism: Mechanism, name: str, value: float) -> None:
    for limit in mechanism.limits:
        if limit.reading == name and not limit.low < value < limit.high:
            raise MechanismError(
                f"start.{name} = {value:.6g} lies outside the travel, "
                f"{limit.low:.6g} to {limit.high:.6g}: {limit.below if value <= limit.low else limit.above}"
            )


def resting_poses(scene: Scene) -> Array:
    """Poses of the one stable equilibrium at the scene's first spindle speed; refuses none, and more than one."""
    speed = SpeedProgram(scene.spindle).start_speed
    found = find_equilibria(scene, speed)
    stable = [rest for rest in found if rest.stable]
    if len(stable) == 1:
        return stable[0].poses
    rpm = speed * 30 / np.pi
    name = scene.part.mechanism.coordinate
    if stable:
        at = ", ".join(f"{rest.coordinate:.6g}" for rest in stable)
        raise MechanismError(
            f"start.{name} = 'equilibrium' is not definite: at {rpm:.6g} rpm there are stable ones at {at}; give one"
        )
    if found:
        at = ", ".join(f"{rest.coordinate:.6g}" for rest in found)
        raise MechanismError(
            f"start.{name} = 'equilibrium': at {rpm:.6g} rpm only an unstable one exists, at {name} = {at}; "
            "start there by number, or change spindle.speed"
        )
    raise MechanismError(
        f"start.{name} = 'equilibrium': there is none at {rpm:.6g} rpm within the travel{_speeds_of_rest(scene)}; "
        "change spindle.speed, or give a number"
    )


def _speeds_of_rest(scene: Scene) -> str:
    """The range of speeds at which the mechanism rests somewhere in the middle of its travel, for a message."""
    low, high = travel(scene.part.mechanism)
    try:
        speeds = equilibrium_speed(scene, np.linspace(0.95 * low + 0.05 * high, 0.05 * low + 0.95 * high, 40))
    except MechanismError:
        return ""
    rpm = speeds * 30 / np.pi
    return f" (it rests at speeds from about {np.min(rpm):.4g} to {np.max(rpm):.4g} rpm)"

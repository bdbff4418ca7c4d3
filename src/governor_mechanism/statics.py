"""Where a mechanism of mobility one stands still: generalised forces along its coordinate, and their zeros."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.equations.assembly import Assembler
from governor_mechanism.equations.forces import centrifugal_force, centrifugal_moment, weight
from governor_mechanism.equations.points import Array
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.scene import EQUILIBRIUM, Scene
from governor_mechanism.speed import SpeedProgram

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


def generalised_forces(scene: Scene, assembler: Assembler, poses: Array) -> tuple[float, float]:
    """Forces along the coordinate: (of gravity, of the spindle's turning at 1 rad/s). N m per rad, or N per m."""
    tangent = assembler.tangent(poses)
    falling = turning = 0.0
    for body, pose, motion in zip(assembler.mechanism.bodies, poses, tangent, strict=True):
        if scene.gravity:
            falling += weight(body.mass, scene.gravity) * motion[1]
        if scene.centrifugal:
            turning += centrifugal_force(body.mass, pose[0], 1.0) * motion[0]
            turning += centrifugal_moment(*body.moments.in_plane, pose[2], 1.0) * motion[2]
    return falling, turning


def equilibrium_speed(scene: Scene, values: Array) -> Array:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Raises MechanismError where no speed holds it, or where it cannot be assembled.
    """
    if not (scene.centrifugal and scene.gravity):
        raise MechanismError("an equilibrium speed needs both effects, gravity and centrifugal; list them in the scene")
    assembler = Assembler(scene.part.mechanism)
    speeds, poses = [], None
    for value in values:
        poses = assembler.poses(float(value), near=poses)
        falling, turning = generalised_forces(scene, assembler, poses)
        if turning == 0.0 or falling / turning > 0.0:
            name = assembler.mechanism.coordinate
            raise MechanismError(
                f"no spindle speed holds the mechanism at {name} = {value:.6g}: the loads do not oppose"
            )
        speeds.append(np.sqrt(-falling / turning))
    return np.array(speeds)


def find_equilibria(scene: Scene, spindle_speed: float) -> tuple[Equilibrium, ...]:
    """All positions of rest at a given spindle speed (rad/s) over the travel, in ascending order of the coordinate."""
    assembler = Assembler(scene.part.mechanism)
    low, high = travel(scene.part.mechanism)
    values = np.linspace(low, high, SCAN + 1)
    poses = [assembler.poses(float(values[0]))]
    for value in values[1:]:
        poses.append(assembler.poses(float(value), near=poses[-1]))

    def force(value: float, near: Array) -> float:
        falling, turning = generalised_forces(scene, assembler, assembler.poses(value, near=near))
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

    Raises MechanismError where it asks for an equilibrium that does not exist, or cannot be assembled.
    """
    mechanism = scene.part.mechanism
    assembler = Assembler(mechanism)
    value = scene.start.values[mechanism.coordinate]
    if value == EQUILIBRIUM:
        poses = resting_poses(scene)
    else:
        _refuse_outside(mechanism, float(value))
        poses = assembler.poses(float(value))
    return poses, assembler.tangent(poses) * scene.start.rates.get(mechanism.coordinate, 0.0)


def _refuse_outside(mechanism: Mechanism, value: float) -> None:
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate and not limit.low < value < limit.high:
            raise MechanismError(
                f"start.{mechanism.coordinate} = {value:.6g} lies outside the travel, "
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

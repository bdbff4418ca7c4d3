"""The time in which a scene's motion changes, which its accuracies of speeds refer to."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import switches
from governor_mechanism.model.force_elements import Force, Load, Spring, Torque, TorsionSpring
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import FreeSpindle, Scene, Spindle

SLOWER = 8.0
"""How many times the time scale a scene's pace is at most."""


def time_scale(scene: Scene) -> float:
    """The time (s) in which the scene's motion changes, from what sets it going: one radian, or one machine size.

    The shortest of those of the spindle's fastest speed, a free fall, rates at the start, springs, drives and loads.
    """
    return 1 / (max(_spindle_rate(scene), _other_rate(scene)) or 1.0)


def pace(scene: Scene) -> float:
    """The time (s) that bounds steps: the time scale, unless that is a steady spindle's and nothing has to be watched.

    In the plane that turns with it a steady spindle pulls as any force does, which error control sees to.
    """
    second, spindle = time_scale(scene), scene.spindle
    steady = isinstance(spindle, Spindle) and spindle.program.constant and not spindle.unevenness
    if not steady or switches(scene):
        return second
    return min(1 / (_other_rate(scene) or 1.0), SLOWER * second)


def _spindle_rate(scene: Scene) -> float:
    """The spindle's fastest speed (rad/s), where it matters."""
    if not scene.centrifugal:
        return 0.0
    spindle = scene.spindle
    return abs(spindle.start_speed) if isinstance(spindle, FreeSpindle) else max(map(abs, spindle.speeds))


def _other_rate(scene: Scene) -> float:
    """The fastest of all others (1/s)."""
    size = scene.part.mechanism.size
    squares = [
        scene.gravity / size,
        *(_square_of_load(scene.part.mechanism, load) for load in scene.part.mechanism.loads),
    ]
    rates = [0.0, *(math.sqrt(square) for square in squares)]
    for name, rate in scene.start.rates.items():
        rates.append(abs(rate) / (1.0 if scene.part.mechanism.reading(name).quantity == "angle" else size))
    for joint in scene.part.mechanism.joints:
        if isinstance(joint, DrivenTurn | DrivenSlide):
            ways, times = np.diff(joint.motion.values), np.diff(joint.motion.times)
            rates.append(float(np.max(np.abs(ways / times))) / (1.0 if isinstance(joint, DrivenTurn) else size))
    return max(rates)


def _square_of_load(mechanism: Mechanism, load: Load) -> float:
    """The square (1/s2) of the rate at which a load alone would change the motion of its lighter body."""
    bodies = [body for body in mechanism.bodies if body.name in load.bodies]
    mass = min(body.mass for body in bodies)
    inertia = min((body.moments.xx + body.moments.yy or body.mass * mechanism.size**2) for body in bodies)
    if isinstance(load, Spring):
        return load.stiffness / mass
    if isinstance(load, TorsionSpring):
        return load.stiffness / inertia
    if isinstance(load, Torque):
        return max(map(abs, load.moment.values)) / inertia
    if isinstance(load, Force):
        return max(map(abs, (*load.x.values, *load.y.values))) / (mass * mechanism.size)
    return 0.0

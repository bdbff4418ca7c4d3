"""The time in which a scene's motion changes, which its accuracies of speeds refer to."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.force_elements import Force, ForceElement, Spring, Torque, TorsionSpring
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import FreeSpindle, Scene, Spindle

MAX_STEP_SCALE_RATIO = 8.0
"""How many times the time scale a scene's pace is at most."""


def time_scale(scene: Scene) -> float:
    """The time (s) in which the scene's motion changes, from what sets it going: one radian, or one machine size.

    The shortest of those of the spindle's fastest speed, a free fall, rates at the start, springs, drives and loads.
    """
    return 1 / (max(_max_spindle_rate(scene), _max_other_rate(scene)) or 1.0)


def max_step_scale(scene: Scene) -> float:
    """The time (s) that bounds steps: the time scale, unless that is a steady spindle's and nothing has to be watched.

    In the plane that turns with it a steady spindle pulls as any force does, which error control sees to.
    """
    motion_time_scale, spindle = time_scale(scene), scene.spindle
    is_steady = isinstance(spindle, Spindle) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    if not is_steady or has_contacts(scene):
        return motion_time_scale
    return min(1 / (_max_other_rate(scene) or 1.0), MAX_STEP_SCALE_RATIO * motion_time_scale)


def _max_spindle_rate(scene: Scene) -> float:
    """The spindle's fastest speed (rad/s), where it matters."""
    if not scene.has_centrifugal:
        return 0.0
    spindle = scene.spindle
    return abs(spindle.start_speed) if isinstance(spindle, FreeSpindle) else max(map(abs, spindle.speeds))


def _max_other_rate(scene: Scene) -> float:
    """The fastest of all others (1/s)."""
    length_scale = scene.part.mechanism.length_scale
    rates_squared = [
        scene.gravity / length_scale,
        *(_force_element_rate_squared(scene.part.mechanism, load) for load in scene.part.mechanism.force_elements),
    ]
    rates = [0.0, *(math.sqrt(square) for square in rates_squared)]
    for name, rate in scene.start.rates.items():
        rates.append(abs(rate) / (1.0 if scene.part.mechanism.reading(name).quantity == "angle" else length_scale))
    for joint in scene.part.mechanism.joints:
        if isinstance(joint, RotationalDriver | TranslationalDriver):
            displacements, times = np.diff(joint.motion.values), np.diff(joint.motion.times)
            rates.append(float(np.max(np.abs(displacements / times))) / (1.0 if isinstance(joint, RotationalDriver) else length_scale))
    return max(rates)


def _force_element_rate_squared(mechanism: Mechanism, load: ForceElement) -> float:
    """The square (1/s2) of the rate at which a load alone would change the motion of its lighter body."""
    bodies = [body for body in mechanism.bodies if body.name in load.bodies]
    mass = min(body.mass for body in bodies)
    inertia = min((body.second_moments.xx + body.second_moments.yy or body.mass * mechanism.length_scale**2) for body in bodies)
    if isinstance(load, Spring):
        return load.stiffness / mass
    if isinstance(load, TorsionSpring):
        return load.stiffness / inertia
    if isinstance(load, Torque):
        return max(map(abs, load.moment.values)) / inertia
    if isinstance(load, Force):
        return max(map(abs, (*load.x.values, *load.y.values))) / (mass * mechanism.length_scale)
    return 0.0

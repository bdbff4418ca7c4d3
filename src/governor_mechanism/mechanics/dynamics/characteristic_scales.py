"""Characteristic time of a scene, which scales tolerances of rates and bounds steps."""

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.inputs import loads_of
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.force_elements import CylinderGas, Force, ForceElement, Spring, Torque, TorsionSpring
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object

MAX_STEP_SCALE_RATIO = 8.0
"""Upper bound of `max_step_scale` relative to `time_scale`."""


@once_per_object
def time_scale(scene: Scene) -> float:
    """Return the shortest time (s) in which what moves a scene moves it by one radian or one length scale; 1 s if nothing does."""
    return 1 / (max(loading_rate(scene), _max_spring_rate(scene)) or 1.0)


@once_per_object
def loading_rate(scene: Scene) -> float:
    """Return the largest characteristic rate (1/s) of what moves a scene, but for springs, stiff ones need not swing; 0 without any."""
    return max(_max_spindle_rate(scene), _max_load_rate(scene))


@once_per_object
def max_step_scale(scene: Scene) -> float:
    """Return the time (s) that bounds the steps of an integration."""
    # In the turning plane a constant spindle speed acts as any force, and error control limits the
    # steps: without contacts it sets no bound.
    motion_time_scale = time_scale(scene)
    speeds = [plane.given_speed for plane in scene.system.planes]
    is_steady = all(speed and speed.speed_function.is_constant and not speed.speed_fluctuation for speed in speeds)
    if not is_steady or has_contacts(scene):
        return motion_time_scale
    other_rate = max(_max_load_rate(scene), _max_spring_rate(scene))
    return min(1 / (other_rate or 1.0), MAX_STEP_SCALE_RATIO * motion_time_scale)


def _max_spindle_rate(scene: Scene) -> float:
    """Return the largest spindle speed (rad/s), or 0 without centrifugal forces."""
    planes = [plane for plane in scene.system.planes if plane.is_loaded]
    given_speeds = [abs(plane.ratio * speed) for plane in planes if plane.given_speed for speed in plane.given_speed.speeds]
    start_speeds = [abs(scene.start.rates.get(f"{plane.prefix}{SPINDLE_ANGLE}", 0.0)) for plane in planes]
    return max([*given_speeds, *start_speeds], default=0.0)


def _max_spring_rate(scene: Scene) -> float:
    """Return the largest characteristic rate (1/s) of a spring."""
    springs = [element for element in scene.mechanism.force_elements if isinstance(element, Spring | TorsionSpring)]
    return math.sqrt(max((_force_element_rate_squared(scene.mechanism, spring) for spring in springs), default=0.0))


def _max_load_rate(scene: Scene) -> float:
    """Return the largest characteristic rate (1/s) of everything but the spindle and springs."""
    mechanism, length_scale = scene.mechanism, scene.mechanism.length_scale
    rates_squared = [max(scene.system.gravity, default=0.0) / length_scale]
    loads = [element for element in mechanism.force_elements if not isinstance(element, Spring | TorsionSpring)]
    rates_squared += [_force_element_rate_squared(mechanism, load) for load in loads]
    rates = [0.0, *(math.sqrt(square) for square in rates_squared)]
    spindle_angles = {f"{plane.prefix}{SPINDLE_ANGLE}" for plane in scene.system.planes}
    rates += [abs(rate) / mechanism.output_scale(name) for name, rate in scene.start.rates.items() if name not in spindle_angles]
    for joint in mechanism.joints:
        if isinstance(joint, RotationalDriver | TranslationalDriver):
            motion = joint.motion
            scale = 1.0 if isinstance(joint, RotationalDriver) else length_scale
            rates.append(float(np.max(np.abs(np.diff(motion.values) / np.diff(motion.times)))) / scale)
            rates += [2 * math.pi * harmonic.frequency for harmonic in motion.harmonics if harmonic.amplitude]
    # Also of effects and of controls: whatever loads a body may swing with the time.
    rates += [2 * math.pi * harmonic.frequency for load in loads_of(scene) for harmonic in load.harmonics if harmonic.amplitude]
    return max(rates)


def _force_element_rate_squared(mechanism: Mechanism, element: ForceElement) -> float:
    """Return the square (1/s2) of the rate at which a force element alone would change the motion of its lighter body."""
    bodies = [body for body in mechanism.bodies if body.name in element.bodies]
    mechanism_mass = sum(body.mass for body in mechanism.bodies)
    mass = min(body.mass or mechanism_mass for body in bodies)
    inertia = min((body.planar_inertia or (body.mass or mechanism_mass) * mechanism.length_scale**2) for body in bodies)
    match element:
        case Spring():
            return element.stiffness / mass
        case TorsionSpring():
            return element.stiffness / inertia
        case Torque():
            return max(map(abs, element.moment.range_in_time)) / inertia
        case Force():
            return max(map(abs, (*element.x.range_in_time, *element.y.range_in_time))) / (mass * mechanism.length_scale)
        case CylinderGas():
            return abs(element.area * element.pressure) * element.stroke / (mass * mechanism.length_scale**2)
    return 0.0

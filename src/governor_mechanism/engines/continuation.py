"""Scenes that start in a state of an earlier motion."""

import math
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.constrained_solution import StateProjector
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_equations import constraint_equations_of
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.coupling.couplings import GearCoupling
from governor_mechanism.model.joints.drivers import Driver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.motion_state import MotionState
from governor_mechanism.model.part import FreeSpindle, Part, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import Harmonic, InputFunction, PrescribedMotion
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value

STATE_GAP_RATIO: Final = 1e-6
"""Largest gap of a joint in a state to start from, in length scales: runs keep joints closed far better, another geometry does not."""

DRIVE_TOLERANCE: Final = 1e-9
"""Gap of the constraint of a drive, in length scales, up to which the drive is where its motion says: rounding."""


def continue_scene(scene: Scene, state: MotionState) -> Scene:
    """Return a scene whose run goes on from a state; time 0 of the run is the time of the state.

    What the scene prescribes over time goes on from that time. A drive goes on from where it stands, also where its motion was changed.

    Parameters
    ----------
    scene
        The scene, which may differ in its numbers from that of the state.
    state
        The state.

    Returns
    -------
    Scene
        The scene, without document.

    Raises
    ------
    MechanismError
        If the state is that of other bodies, or its joints do not close.
    """
    if not isinstance(state, MotionState):
        raise MechanismError(f"start is a state of a run, as run.state(); found {format_value(state)}")
    delay = state.time - (scene.state.time if scene.state else 0.0)
    poses, velocities = (np.array(rows) for rows in state.motion_of([body.name for body in scene.mechanism.bodies]))
    parts = tuple(_continue_part(scene, part, delay, poses, velocities) for part in scene.parts)
    couplings = tuple(_delayed(coupling, delay) for coupling in scene.couplings)
    return replace(scene, parts=parts, couplings=couplings, state=state, document={})


def motion_at_start(scene: Scene, state: MotionState) -> tuple[FloatArray, FloatArray]:
    """Return poses and velocities (bodies, 3) at the start of a scene that goes on from a state; a drive changes velocities at once."""
    poses, velocities = (np.array(rows) for rows in state.motion_of([body.name for body in scene.mechanism.bodies]))
    equations = PositionSolver(scene.mechanism).equations
    joint, gap = equations.largest_gap(poses) if equations.joints else (None, 0.0)
    if not abs(gap) < STATE_GAP_RATIO * scene.mechanism.length_scale:
        name = joint.name if joint else ""
        raise MechanismError(
            f"the state to start from does not fit the scene: joint {name!r} is open by {abs(gap):.6g} m; "
            "dimensions must be those of the run that the state is from"
        )
    poses, velocities = (one[0] for one in StateProjector(scene).project(np.zeros(1), poses[np.newaxis], velocities[np.newaxis]))
    return poses, velocities


def _continue_part(scene: Scene, part: Part, delay: float, poses: FloatArray, velocities: FloatArray) -> Part:
    """Return a part whose inputs begin later, by a delay (s), with drives and a free spindle as they move in a state."""
    prefix = f"{part.name}." if len(scene.parts) > 1 else ""
    own_poses = poses[[scene.mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies]]
    delayed: Part = _delayed(part, delay)
    mechanism = _continue_drives(delayed.mechanism, own_poses)
    spindle = delayed.spindle
    if isinstance(spindle, FreeSpindle) and spindle.start_speed is not None:
        plane = next(one for one in scene.system.planes if one.prefix == prefix)
        speed = plane.ratio * float(velocities[scene.mechanism.body_index(plane.shaft), 2])
        spindle = replace(spindle, start_speed=speed)
    continued: Part = replace(delayed, mechanism=mechanism, spindle=spindle)
    return continued


def _continue_drives(mechanism: Mechanism, poses: FloatArray) -> Mechanism:
    """Return a mechanism whose drives pass through poses (bodies, 3) at the start."""
    if not any(isinstance(joint, Driver) for joint in mechanism.joints):
        return mechanism
    equations = constraint_equations_of(mechanism)
    residuals = equations.residuals(poses)
    scales = equations.rows.table["drive_scale"]
    joints = list(mechanism.joints)
    for row in np.flatnonzero(equations.is_driven).tolist():
        index = int(equations.joint_indices[row])
        offset = float(residuals[row] / scales[row])
        joint = joints[index]
        if isinstance(joint, Driver) and abs(residuals[row]) > DRIVE_TOLERANCE * mechanism.length_scale:
            motion = joint.motion
            joints[index] = replace(joint, motion=replace(motion, values=tuple(value + offset for value in motion.values)))
    return mechanism if joints == list(mechanism.joints) else replace(mechanism, joints=tuple(joints))


def _delayed(value: Any, delay: float) -> Any:
    """Return a description in which every function of time begins later; what has none is returned as it is."""
    match value:
        case InputFunction() | PrescribedMotion() if len(value.times) > 1 or value.harmonics:
            return replace(value, times=_earlier(value.times, delay), harmonics=tuple(_delayed(one, delay) for one in value.harmonics))
        case InputFunction():
            return value
        case Harmonic():
            return replace(value, phase=math.remainder(value.phase + math.tau * value.frequency * delay, math.tau))
        case Spindle():
            turned = CubicTimeFunction(value.speed_function).integrals(0.0, np.array([delay])) if value.speed_fluctuation else [0.0]
            return replace(value, times=_earlier(value.times, delay), turned_angle=value.turned_angle + float(turned[0]))
        case GearCoupling(until=float(until)):
            return replace(value, until=max(until - delay, 0.0))
        case tuple():
            items = [_delayed(item, delay) for item in value]
            return value if all(new is old for new, old in zip(items, value, strict=True)) else tuple(items)
    if not is_dataclass(value) or isinstance(value, type):
        return value
    own = {one.name: getattr(value, one.name) for one in fields(value) if one.init}
    changes = {name: new for name, item in own.items() if (new := _delayed(item, delay)) is not item}
    return replace(value, **changes) if changes else value


def _earlier(times: tuple[float, ...], delay: float) -> tuple[float, ...]:
    """Return times (s) on a clock that begins later; that of a constant does not matter."""
    return times if len(times) == 1 else tuple(time - delay for time in times)

"""Extents over a whole run that a drawing needs: length scale, ranges of motion, largest loads."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque
from governor_mechanism.model.joints import ArcSlot, CurveSlot, Gear, Joint, RackAndPinion, Slider, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.film.layout import ELEVATION_RECT
from governor_mechanism.render.geometry.body_points import point_path, point_path_in_axes, separation_path, value_range
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.reading_loads import LoadFunctions, load_inputs
from governor_mechanism.types import FloatArray

ELEVATION_ASPECT_RATIO = (ELEVATION_RECT[2] - ELEVATION_RECT[0]) / (ELEVATION_RECT[3] - ELEVATION_RECT[1])
"""Width over height of the machine's rectangle in the frame."""


@dataclass(frozen=True, kw_only=True)
class RunExtents:
    """Extents of a run of a part with poses (n, bodies, 3) at times (n,) s, at one time.

    `length_scale` (m) sizes what the scene leaves open, such as the width of a bar; `mean_height` (m) is the mean of the drawn points.
    `joint_travels` are the smallest and largest displacement (m, or rad in an arc slot) of a joint's second point in the axes of its first;
    `element_lengths` (m) the shortest and longest length of a spring or damper. `load_functions` are the loads over time and
    `largest_loads` the largest of each type over the run (N or N m). `time` (s) is the shown time.
    """

    part: Part
    poses: FloatArray
    times: FloatArray
    length_scale: float
    mean_height: float
    joint_travels: Mapping[str, Vec2]
    element_lengths: Mapping[str, Vec2]
    load_functions: Mapping[str, LoadFunctions]
    largest_loads: Mapping[type[ForceElement], float]
    effect_state: EffectState = NO_EFFECTS
    time: float = 0.0

    def at_time(self, time: float) -> RunExtents:
        """Return the same extents at another time (s)."""
        return dataclasses.replace(self, time=time)

    def load_fractions(self, load: Force | Torque) -> Vec2:
        """Return the components of a force, or a torque and 0, relative to the largest load of its type over the run."""
        largest = self.largest_loads[type(load)]
        if not largest > 0.0:
            return 0.0, 0.0
        times = np.array([self.time])
        x, y, *_ = (*(float(function(times)[0]) / largest for function in self.load_functions[load.name]), 0.0)
        return x, y


def measure_run_extents(part: Part, poses: FloatArray, times: FloatArray, effect_state: EffectState = NO_EFFECTS) -> RunExtents:
    """Return the extents of a run with poses (n, bodies, 3) at times (n,) s."""
    mechanism = part.mechanism
    paths = drawn_point_paths(mechanism, poses)
    sides = np.ptp(paths.reshape(-1, 2), axis=0)
    length_scale = float(max(sides[0], ELEVATION_ASPECT_RATIO * sides[1]))
    own_scale = 2 * flywheel_radius(mechanism) or mechanism.length_scale
    load_functions: dict[str, LoadFunctions] = {
        load.name: tuple(map(CubicTimeFunction, load_inputs(load))) for load in mechanism.force_elements if isinstance(load, Force | Torque)
    }
    load_functions |= effect_state.load_functions
    return RunExtents(
        part=part,
        poses=poses,
        times=times,
        # A mechanism that hardly moves and has no extent is measured by its flywheel, or by its own length scale.
        length_scale=length_scale if length_scale > 1e-3 * mechanism.length_scale else own_scale,
        mean_height=float(paths[..., 1].mean()),
        joint_travels={joint.name: travel for joint in mechanism.joints if (travel := _joint_travel(mechanism, poses, joint)) is not None},
        element_lengths={
            load.name: value_range(np.hypot(*separation_path(mechanism, poses, load.first, load.second).T))
            for load in mechanism.force_elements
            if isinstance(load, TWO_POINT_ELEMENTS)
        },
        load_functions=load_functions,
        largest_loads={kind: _largest_load(mechanism, load_functions, kind, times) for kind in (Force, Torque)},
        effect_state=effect_state,
    )


def flywheel_radius(mechanism: Mechanism) -> float:
    """Return the radius (m) of a rim with the mass and the moment of inertia of the only body; 0 for several bodies or a point mass."""
    if len(mechanism.bodies) > 1:
        return 0.0
    body = mechanism.bodies[0]
    xx, yy, _ = body.second_moments.in_plane
    return math.sqrt(max(xx + yy, 0.0) / body.mass) if body.can_rotate else 0.0


TWO_POINT_ELEMENTS = (Spring, Damper)
"""Force elements between two points."""


def drawn_point_paths(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Return the paths (n, m, 2) m of all drawn points: mass centres, ends of joints and elements, rims of wheels."""
    points = [point for joint in mechanism.joints for point in (joint.first, joint.second)]
    points += [point for load in mechanism.force_elements if isinstance(load, TWO_POINT_ELEMENTS) for point in (load.first, load.second)]
    points += [load.point for load in mechanism.force_elements if isinstance(load, Force)]
    paths = [poses[:, :, :2], *(point_path(mechanism, poses, point)[:, None] for point in dict.fromkeys(points))]
    for joint in mechanism.joints:
        if isinstance(joint, Gear | RackAndPinion):
            centres = [point_path(mechanism, poses, point) for point in (joint.first, joint.second)]
            distance = np.hypot(*(centres[1] - centres[0]).T)
            radii = [np.full(len(poses), abs(joint.radius))] if isinstance(joint, RackAndPinion) else wheel_radii(joint.ratio, distance)
            for centre, radius in zip(centres, radii, strict=False):
                paths += [(centre + sign * radius[:, None])[:, None] for sign in (-1, 1)]
    return np.concatenate(paths, axis=1)


def wheel_radii(ratio: float, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the radii (m) of two wheels in contact at a centre distance (m): external for a negative ratio, else internal.

    Wheels of equal size that turn in the same sense do not touch; a belt can connect them.
    """
    second_radius = distance / abs(ratio - 1) if abs(ratio - 1) > 0.05 else 0.3 * distance
    return abs(ratio) * second_radius, second_radius


def _joint_travel(mechanism: Mechanism, poses: FloatArray, joint: Joint) -> Vec2 | None:
    """Return the smallest and largest displacement of a joint over the run, or None for a joint without one."""
    match joint:
        case Slider() | CurveSlot() | TranslationalDriver():
            travel = point_path_in_axes(mechanism, poses, joint.first, joint.angle, joint.second)[:, 0]
        case ArcSlot():
            x, y = point_path_in_axes(mechanism, poses, joint.first, 0.0, joint.second).T
            travel = np.unwrap(np.arctan2(y, x))
        case RackAndPinion():
            travel = separation_path(mechanism, poses, joint.first, joint.second) @ np.array([math.cos(joint.angle), math.sin(joint.angle)])
        case _:
            return None
    return value_range(travel)


def _largest_load(mechanism: Mechanism, load_functions: Mapping[str, LoadFunctions], kind: type[ForceElement], times: FloatArray) -> float:
    """Return the largest load of one type over the run (N or N m)."""
    magnitudes = [0.0]
    for load in mechanism.force_elements:
        if isinstance(load, kind):
            x, y, *_ = (*(function(times) for function in load_functions[load.name]), np.zeros(len(times)))
            magnitudes.append(float(np.hypot(x, y).max()))
    return max(magnitudes)

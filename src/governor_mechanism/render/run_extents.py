"""What a drawing must know of the whole run: its measure, how far everything moves, how large loads become."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque
from governor_mechanism.model.joints import ArcSlot, CurveSlot, DrivenSlide, Gear, Joint, Rack, Slider
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.film.layout import ELEVATION
from governor_mechanism.render.geometry.body_points import seen_from, track
from governor_mechanism.render.geometry.primitives import Pair
from governor_mechanism.types import FloatArray

Programs = tuple[TimeCurve, TimeCurve | None]

ASPECT = (ELEVATION[2] - ELEVATION[0]) / (ELEVATION[3] - ELEVATION[1])
"""Width of the picture's place for the machine, of its height."""


@dataclass(frozen=True, kw_only=True)
class Stage:
    """unit (m) measures what a scene does not say, such as the width of a bar; middle (m) is the mean height.

    ways: by joint, between what values (m, or rad in an arc slot) its second point moves in its first one's axes;
    reaches: by spring or damper, its shortest and longest length (m). programs: by load, its parts in time, and
    largest what their largest is over the run (N or N m). acting is what the scene's effects do. time (s) is the moment
    shown.
    """

    unit: float
    middle: float
    ways: Mapping[str, Pair]
    reaches: Mapping[str, Pair]
    programs: Mapping[str, Programs]
    largest: Mapping[type[Load], float]
    acting: Acting = NOTHING
    time: float = 0.0

    def at(self, time: float) -> Stage:
        """The same at another moment (s)."""
        return dataclasses.replace(self, time=time)

    def push(self, load: Force | Torque) -> Pair:
        """The force's parts, or the torque and 0, each as a fraction of the largest of its kind over the run."""
        whole = self.largest[type(load)]
        if not whole > 0.0:
            return 0.0, 0.0
        now = np.array([self.time])
        x, y = (0.0 if curve is None else float(curve(now)[0]) / whole for curve in self.programs[load.name])
        return x, y


def stage_of(part: Part, poses: FloatArray, times: FloatArray, acting: Acting = NOTHING) -> Stage:
    """The stage for a run with poses (n, bodies, 3) at times (n,) s, and what acts in it."""
    mechanism = part.mechanism
    marks = tracks(mechanism, poses)
    sides = np.ptp(marks.reshape(-1, 2), axis=0)
    unit = float(max(sides[0], ASPECT * sides[1]))
    programs = {
        load.name: (TimeCurve(load.x), TimeCurve(load.y)) if isinstance(load, Force) else (TimeCurve(load.moment), None)
        for load in mechanism.loads
        if isinstance(load, Force | Torque)
    }
    return Stage(
        # What hardly moves and has no extent is measured by the mechanism's own size.
        unit=unit if unit > 1e-3 * mechanism.size else mechanism.size,
        middle=float(marks[..., 1].mean()),
        ways={joint.name: way for joint in mechanism.joints if (way := _way(mechanism, poses, joint)) is not None},
        reaches={load.name: _reach(mechanism, poses, load) for load in mechanism.loads if isinstance(load, SPANS)},
        programs=programs,
        largest={kind: _largest(mechanism, programs, kind, times) for kind in (Force, Torque)},
        acting=acting,
    )


SPANS = (Spring, Damper)


def tracks(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Where all that is marked stands over a run: mass centres, ends of joints and loads, rims of wheels (n, m, 2)."""
    points = [point for joint in mechanism.joints for point in (joint.first, joint.second)]
    points += [point for load in mechanism.loads if isinstance(load, SPANS) for point in (load.first, load.second)]
    points += [load.point for load in mechanism.loads if isinstance(load, Force)]
    found = [poses[:, :, :2], *(track(mechanism, poses, point)[:, None] for point in dict.fromkeys(points))]
    for joint in mechanism.joints:
        if isinstance(joint, Gear | Rack):
            centres = [track(mechanism, poses, point) for point in (joint.first, joint.second)]
            apart = np.hypot(*np.moveaxis(centres[1] - centres[0], -1, 0))
            radii = [np.full(len(poses), abs(joint.radius))] if isinstance(joint, Rack) else rims(joint.ratio, apart)
            for centre, radius in zip(centres, radii, strict=False):
                found += [(centre + sign * radius[:, None])[:, None] for sign in (-1, 1)]
    return np.concatenate(found, axis=1)


def rims(ratio: float, apart: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radii (m) of two wheels that touch, with centres so far apart (m): outside for a negative ratio, else inside.

    Wheels of one size that turn alike do not touch; a belt may run round them.
    """
    second = apart / abs(ratio - 1) if abs(ratio - 1) > 0.05 else 0.3 * apart
    return abs(ratio) * second, second


def _way(mechanism: Mechanism, poses: FloatArray, joint: Joint) -> Pair | None:
    match joint:
        case Slider() | CurveSlot() | DrivenSlide():
            way = seen_from(mechanism, poses, joint.first, joint.angle, joint.second)[:, 0]
        case ArcSlot():
            x, y = seen_from(mechanism, poses, joint.first, 0.0, joint.second).T
            way = np.unwrap(np.arctan2(y, x))
        case Rack():
            apart = track(mechanism, poses, joint.second) - track(mechanism, poses, joint.first)
            way = apart @ np.array([math.cos(joint.angle), math.sin(joint.angle)])
        case _:
            return None
    return float(way.min()), float(way.max())


def _reach(mechanism: Mechanism, poses: FloatArray, load: Spring | Damper) -> Pair:
    apart = track(mechanism, poses, load.second) - track(mechanism, poses, load.first)
    lengths = np.hypot(apart[:, 0], apart[:, 1])
    return float(lengths.min()), float(lengths.max())


def _largest(mechanism: Mechanism, programs: Mapping[str, Programs], kind: type[Load], times: FloatArray) -> float:
    sizes = [0.0]
    for load in mechanism.loads:
        if isinstance(load, kind):
            x, y = (np.zeros(len(times)) if curve is None else curve(times) for curve in programs[load.name])
            sizes.append(float(np.hypot(x, y).max()))
    return max(sizes)

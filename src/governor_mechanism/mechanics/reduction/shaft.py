"""The shaft of a scene with one coordinate: the bodies that only rotate, all at fixed ratios to one of them, and their outputs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, ConstraintRows, evaluate_rows
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows, rows_of_readings
from governor_mechanism.model.joints import GROUND, Gear, Pin
from governor_mechanism.model.part import FIXED_PLANE, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import GROUND_INDEX, FloatArray


@dataclass(frozen=True, kw_only=True)
class ShaftTrain:
    """Bodies geared to one shaft, itself included; without bodies if there is no shaft."""

    rotors: tuple[str, ...]  # names of all bodies that only rotate
    # ratio to the shaft, and angle (rad) where that of the shaft is zero, of each body that turns with it;
    # the shaft is the first
    motion: dict[str, tuple[float, float]]
    spindle_ratio: float  # ratio of the spindle speed to that of the shaft; 0 if the speed of the spindle is given
    has_reaction: bool  # whether the bodies of the turning plane act on the shaft

    def ratio(self, body: str) -> float:
        """Return the ratio of a body to the shaft; 0 for the ground."""
        return self.motion.get(body, (0.0, 0.0))[0]


def parts_with_coordinate(scene: Scene) -> list[tuple[str, Part]]:
    """Return prefix and part of all parts that are more than a shaft."""
    if len(scene.parts) == 1:
        return [("", scene.part)]
    return [(f"{part.name}.", part) for part in scene.parts if not _is_shaft(part)]


def _is_shaft(part: Part) -> bool:
    """Return whether each body of a part in a fixed plane is pinned to the ground at its mass centre, and nothing else joins them."""
    joints = part.mechanism.joints
    pinned = [point for joint in joints if isinstance(joint, Pin) for point in (joint.first, joint.second) if point.body != GROUND]
    return (
        part.plane == FIXED_PLANE
        and all(isinstance(joint, Pin) or (isinstance(joint, Gear) and not joint.is_carried) for joint in joints)
        and sorted(point.body for point in pinned) == sorted(body.name for body in part.mechanism.bodies)
        and all(point.x == point.y == 0.0 for point in pinned)
    )


def find_shaft_train(scene: Scene) -> ShaftTrain:
    """Return the shaft of a scene, which the spindle turns with unless its speed is given."""
    mechanism, (prefix, part) = scene.mechanism, parts_with_coordinate(scene)[0]
    moving = {prefix + body.name for body in part.mechanism.bodies}
    rotors = tuple(body.name for body in mechanism.bodies if body.name not in moving)
    plane = next((plane for plane in scene.system.planes if plane.shaft), None)
    motion = {name: (1.0, 0.0) for name in ([plane.shaft] if plane else rotors[:1])}
    gears = [joint for joint in mechanism.joints if isinstance(joint, Gear) and not {joint.first.body, joint.second.body} & moving]
    for _ in rotors:
        for gear in gears:
            first, second = gear.first.body, gear.second.body
            if first in motion:
                ratio, angle = motion[first]
                motion.setdefault(second, (gear.ratio * ratio, gear.ratio * angle + gear.offset))
            elif second in motion:
                ratio, angle = motion[second]
                motion[first] = ratio / gear.ratio, (angle - gear.offset) / gear.ratio
    return ShaftTrain(
        rotors=rotors, motion=motion, spindle_ratio=plane.ratio if plane else 0.0, has_reaction=plane is not None and plane.has_reaction
    )


def shaft_readings(scene: Scene, train: ShaftTrain) -> set[str]:
    """Return the names of the readings that are functions of the angle of the shaft: angles, travels of the bodies that turn with it."""
    mechanism, (prefix, part) = scene.mechanism, parts_with_coordinate(scene)[0]
    own = {prefix + reading.name for reading in part.mechanism.readings}
    readings = [reading for reading in mechanism.readings if reading.name not in own]
    if not readings:
        return set()
    rotors = [mechanism.body_index(body) for body in train.motion]
    bodies = rows_of_readings(mechanism, readings, {}).row_bodies
    follows_shaft = (np.isin(bodies, rotors) | (bodies == GROUND_INDEX)).all(axis=1) & (bodies != GROUND_INDEX).any(axis=1)
    return {readings[k].name for k in np.flatnonzero(follows_shaft)}


class ShaftOutputs(NamedTuple):
    """Output rows of bodies on the shaft, and the arrays of their evaluation."""

    rows: ConstraintRows  # the output rows
    # poses of the mass centres where the angle of the shaft is zero, m and rad; shape (bodies, 3), or (0, 3)
    # without rows
    poses: FloatArray
    tangents: FloatArray  # their derivatives by the angle of the shaft, with the shape of `poses`
    turned_poses: FloatArray  # poses at the last evaluation, with the shape of `poses`
    row_values: FloatArray  # values of the rows at the last evaluation; shape (rows, columns)
    jacobian: FloatArray  # derivatives of the rows by the poses of both bodies there; shape (rows, 2, 3)
    derivatives: FloatArray  # derivatives of the rows by the angle of the shaft there, m/rad or 1; shape (rows,)

    def with_own_results(self) -> "ShaftOutputs":
        """Return the outputs with arrays of their own for the results of an evaluation."""
        results = (np.zeros_like(array) for array in (self.turned_poses, self.row_values, self.jacobian, self.derivatives))
        return ShaftOutputs(self.rows, self.poses, self.tangents, *results)


def lower_shaft_outputs(
    scene: Scene,
    train: ShaftTrain,
    names: Sequence[str],  # names of the readings, in the order of the outputs
) -> ShaftOutputs:
    """Return the outputs of bodies on the shaft."""
    mechanism = scene.mechanism
    poses, tangents = np.zeros((2, len(mechanism.bodies) if names else 0, 3))
    for joint in mechanism.joints:
        points = {point.body: point for point in (joint.first, joint.second)} if isinstance(joint, Pin) else {}
        for body in points.keys() & train.motion.keys() if GROUND in points and names else ():
            poses[mechanism.body_index(body), :2] = points[GROUND].x, points[GROUND].y
    for body, (ratio, angle) in train.motion.items() if names else ():
        index = mechanism.body_index(body)
        poses[index, 2], tangents[index, 2] = angle, ratio
    rows, n_rows = make_output_rows(mechanism, names, {}), len(names)
    results = np.zeros_like(poses), np.zeros((n_rows, N_ROW_COLUMNS)), np.zeros((n_rows, 2, 3)), np.zeros(n_rows)
    return ShaftOutputs(rows, poses, tangents, *results)


@jit_in_place
def evaluate_shaft_outputs(
    outputs: ShaftOutputs,
    angle: float,  # angle of the shaft, rad
) -> None:
    """Evaluate the outputs at an angle of the shaft (rad) into their arrays."""
    if outputs.rows.table.size == 0:
        return
    for k in range(outputs.poses.shape[0]):
        for c in range(3):
            outputs.turned_poses[k, c] = outputs.poses[k, c] + angle * outputs.tangents[k, c]
    evaluate_rows(outputs.rows, outputs.turned_poses, outputs.tangents, outputs.row_values, outputs.jacobian)
    for i in range(outputs.derivatives.size):
        outputs.derivatives[i] = output_rate(outputs.rows, outputs.jacobian, i, outputs.tangents)

"""Outputs of the bodies that turn with the shaft, as functions of its angle: travels of massless pistons and angles."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, ConstraintRows, evaluate_rows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.mechanics.reduction.shaft import ShaftTrain
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray


class ShaftOutputs(NamedTuple):
    """Output rows of bodies on the shaft, and the arrays of their evaluation.

    Attributes
    ----------
    rows
        The output rows.
    poses
        Poses of the mass centres where the angle of the shaft is zero, m and rad; shape (bodies, 3), or (0, 3) without rows.
    tangents
        Their derivatives by the angle of the shaft, with the shape of `poses`.
    turned_poses
        Poses at the last evaluation, with the shape of `poses`.
    row_values
        Values of the rows at the last evaluation; shape (rows, columns).
    jacobian
        Derivatives of the rows by the poses of both bodies there; shape (rows, 2, 3).
    derivatives
        Derivatives of the rows by the angle of the shaft there, m/rad or 1; shape (rows,).
    """

    rows: ConstraintRows
    poses: FloatArray
    tangents: FloatArray
    turned_poses: FloatArray
    row_values: FloatArray
    jacobian: FloatArray
    derivatives: FloatArray

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

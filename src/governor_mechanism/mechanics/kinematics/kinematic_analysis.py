"""Kinematics: how a driven mechanism stands and moves along its coordinate, or in the time of its drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import measure
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import INDEPENDENT
from governor_mechanism.types import FloatArray

TIME = "time"
"""The name of what drives follow."""


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """A mechanism at n values of a coordinate, or at n times: nothing is integrated.

    poses, velocities, accelerations (n, bodies, 3) of mass centres in m, rad, s; readings map names to (n,) SI arrays,
    rates and accelerations_of them to their first and second time derivatives.
    """

    over: str
    values: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    accelerations_of: Mapping[str, FloatArray]


def follow(
    scene: Scene, over: str, values: Sequence[float] | FloatArray, rate: float = 1.0, acceleration: float = 0.0
) -> Kinematics:
    """Positions, velocities and accelerations of a scene's mechanism over values (n,) of a reading, or over times.

    Over a reading (SI), the scene's drives are taken off, and the reading moves at `rate` and `acceleration` (SI/s,
    SI/s2) at each value. Over "time" (s), the drives themselves move it. Raises MechanismError for a mechanism that
    this does not settle, and where it cannot be assembled or stands at a dead centre.
    """
    wanted = _checked(over, values, rate, acceleration)
    mechanism = scene.part.mechanism
    if over == TIME:
        path = _Path(mechanism, [], {})
        _refuse_unsettled(mechanism, path.freedoms(), 0, "over 'time' its drives must hold it")
    else:
        mechanism.reading(over)
        joints = tuple(joint for joint in mechanism.joints if not isinstance(joint, DrivenTurn | DrivenSlide))
        mechanism = replace(mechanism, joints=joints)
        start = {name: value for name, value in scene.start.values.items() if isinstance(value, float | int)}
        path = _Path(mechanism, [over], start)
        _refuse_unsettled(mechanism, path.freedoms(), 1, f"over {over!r} one reading must settle it")
    states = [path.at(float(value), rate, acceleration) for value in wanted]
    poses, velocities, accelerations = (np.array(column) for column in zip(*states, strict=True))
    found = {reading.name: measure(mechanism, reading.name, poses, velocities) for reading in mechanism.readings}
    axes = (-2, -1)
    return Kinematics(
        over=over,
        values=wanted,
        poses=poses,
        velocities=velocities,
        accelerations=accelerations,
        readings={name: one.value for name, one in found.items()},
        rates={name: np.sum(one.gradient * velocities, axis=axes) for name, one in found.items()},
        accelerations_of={
            name: np.sum(one.gradient * accelerations, axis=axes) + one.bend for name, one in found.items()
        },
    )


class _Path:
    """Goes from value to value, each assembled from the one before."""

    def __init__(self, mechanism: Mechanism, names: list[str], start: Mapping[str, float | str]) -> None:
        self._mechanism, self._names = mechanism, names
        self._near = Assembler(mechanism).at({name: float(value) for name, value in start.items()})

    def freedoms(self) -> int:
        return Assembler(self._mechanism).freedoms(self._near)

    def at(self, value: float, rate: float, acceleration: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Poses, velocities and accelerations (bodies, 3) at one value, or one time."""
        mechanism, names = self._mechanism, self._names
        time = 0.0 if names else value
        assembler = Assembler(mechanism, time)
        try:
            poses = assembler.at(dict.fromkeys(names, value), self._near)
        except MechanismError as error:
            where = "" if names else f"at t = {value:.6g} s, where its drives stand then: "
            raise MechanismError(f"{where}{error}") from error
        self._near = poses
        equations, free = assembler.equations, assembler.free
        asked = equations.asked(np.array(time))
        lead = [measure(mechanism, name, poses) for name in names]
        rows = [equations.gradients(poses).reshape(len(equations.owner), free.size)]
        rows += [one.gradient.reshape(1, -1) for one in lead]
        matrix = np.concatenate(rows)[:, free]
        _refuse_dead_centre(assembler, matrix, names, value)
        velocities, accelerations = np.zeros(poses.shape), np.zeros(poses.shape)
        velocities.ravel()[free] = _solved(matrix, np.append(asked[:, 1], [rate] * len(names)))
        bends = equations.bends(poses, velocities, time)
        turned = [acceleration - float(measure(mechanism, name, poses, velocities).bend) for name in names]
        accelerations.ravel()[free] = _solved(matrix, np.append(bends, turned))
        return poses, velocities, accelerations


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)


def _refuse_dead_centre(assembler: Assembler, matrix: FloatArray, names: list[str], value: float) -> None:
    size = assembler.mechanism.size
    unit = np.tile([size, size, 1.0], len(assembler.mechanism.bodies))[assembler.free]
    scaled = matrix * unit
    lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
    values = np.linalg.svd(scaled / np.where(lengths > 0, lengths, 1.0), compute_uv=False)
    if np.sum(values > INDEPENDENT * values[0]) < len(unit):
        where = f"{names[0]} = {value:.6g}" if names else f"t = {value:.6g} s"
        raise MechanismError(
            f"at {where} the mechanism stands at a dead centre or change point: what drives it there does not settle "
            "how it moves; leave that value out, or drive it elsewhere"
        )


def _refuse_unsettled(mechanism: Mechanism, freedoms: int, wanted: int, why: str) -> None:
    if freedoms != wanted:
        raise MechanismError(f"kinematics need mobility {wanted}: {why}; this mechanism has mobility {freedoms} then")


def _checked(over: str, values: Sequence[float] | FloatArray, rate: float, acceleration: float) -> FloatArray:
    for what, number in (("rate", rate), ("acceleration", acceleration)):
        if not isinstance(number, int | float):
            raise MechanismError(f"{what} of {over!r} must be a number in SI; got {number!r}")
        require_finite(number, "", f"{what} of {over!r}")
    try:
        wanted = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        wanted = np.array([np.nan])
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted)):
        raise MechanismError(f"values of {over!r} must be a list of finite numbers in SI; got {values!r}")
    return wanted

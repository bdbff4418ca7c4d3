"""Put a mechanism together: poses at values of its readings, the directions in which it can move, its mobility."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import JointEquations
from governor_mechanism.mechanics.kinematics.output_variables import measure, reading_value
from governor_mechanism.model.joints import Distance
from governor_mechanism.model.mechanism import LineAngle, Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import rank, smallest_change
from governor_mechanism.types import FloatArray

MAX_STEP = 0.1
"""Largest change of a reading (rad, or machine sizes) in one continuation step: Newton stays on its branch."""

FARTHEST = 200.0
"""rad, or machine sizes: some thirty turns; farther away a value is a slip."""

CLOSED = 1e-13
"""Joints count as closed at this fraction of the machine's size; rounding leaves about 1e-15."""

NUDGE = 1e-3
"""Machine sizes, and rad: how near a dead centre an assembly that begins there goes off it first, and how far."""

LONGEST = 0.3
"""rad, and machine sizes: the longest step of Newton's iteration, which near a dead centre would go round and round."""


class Assembler:
    """Assembles one mechanism at any values of its readings, from its sketch or from poses near by.

    Drives stand where they are at `time` (s).
    """

    def __init__(self, mechanism: Mechanism, time: float = 0.0) -> None:
        self.mechanism, self.time = mechanism, time
        self.equations = JointEquations(mechanism)
        turns = [body.turns for body in mechanism.bodies]
        self.free = np.array([[True, True, turn] for turn in turns], dtype=np.bool_).ravel()
        """(3 bodies,) which coordinates may change: a body that does not turn keeps its angle."""
        self.unit = np.tile([mechanism.size, mechanism.size, 1.0], len(turns))[self.free]
        """(free coordinates,) what a machine size, or a radian, of each is in SI."""
        asked = self.equations.asked(np.array(time))
        self._asked_rates = asked[:, 1]

    @property
    def mobility(self) -> int:
        """Freedoms that joints and drives leave at the sketch: free coordinates less the rank of the equations."""
        return self.freedoms(self._sketch())

    def freedoms(self, poses: FloatArray, *, drives: bool = True) -> int:
        """Freedoms left at these poses by the joints, and by the drives if they count."""
        rows = self.joint_rows(poses)
        return int(self.free.sum()) - rank(rows if drives else rows[~self.equations.driven])

    def joint_rows(self, poses: FloatArray) -> FloatArray:
        """Joint equations (equations, free coordinates) at poses (bodies, 3), lengths in machine sizes."""
        rows = self.equations.gradients(poses).reshape(len(self.equations.owner), self.free.size)[:, self.free]
        scaled: FloatArray = rows * self.unit / self.mechanism.size
        return scaled

    def poses(self, value: float, near: FloatArray | None = None) -> FloatArray:
        """Poses (bodies, 3) at a value of the leading coordinate, on the branch of `near` (or of the sketch).

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        return self.at({self.mechanism.coordinate: value}, near)

    def at(self, values: Mapping[str, float], near: FloatArray | None = None) -> FloatArray:
        """Poses (bodies, 3) at values of any readings, on the branch of `near` (or of the sketch), else nearest to it.

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        poses = self._off_dead_centre(self._newton(self._sketch() if near is None else near, {}), values)
        ways = {name: value - float(reading_value(self.mechanism, name, poses)) for name, value in values.items()}
        for name in ways:
            if isinstance(self.mechanism.reading(name), LineAngle):
                ways[name] = math.remainder(ways[name], math.tau)
        longest = max((abs(way) / self._scale(name) for name, way in ways.items()), default=0.0)
        if longest > FARTHEST:
            raise MechanismError(
                f"{list(values)} lie {longest:.6g} rad or machine sizes away from where the mechanism stands; "
                f"at most {FARTHEST:g} are gone: sketch it nearer, or leave out whole turns"
            )
        count = max(1, math.ceil(longest / MAX_STEP))
        for left in np.arange(count - 1, -1, -1) / count:
            poses = self._newton(poses, {name: value - float(left) * ways[name] for name, value in values.items()})
        return poses

    def velocities(self, poses: FloatArray, rates: Mapping[str, float]) -> FloatArray:
        """Velocities (bodies, 3) that follow the drives and have these rates of readings; of all such the slowest.

        Slowest in kinetic energy. Raises MechanismError where joints, drives and rates contradict each other.
        """
        matrix = self._rows(poses, list(rates))
        right = np.append(self._asked_rates, list(rates.values()))
        weight = 1 / np.sqrt(self._masses())
        moving = weight * smallest_change(matrix * weight, right)
        left = matrix @ moving - right
        largest = max(float(np.max(np.abs(right), initial=0.0)), 1e-300)
        if np.max(np.abs(left), initial=0.0) > 1e-9 * largest:
            raise MechanismError(self._contradiction(left, list(rates)))
        return self.spread(moving)

    def _off_dead_centre(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """Poses a little further on where a reading stands and would not say which way to go."""
        moved = [name for name, value in values.items() if abs(self._off(name, value, poses)) > CLOSED]
        if len(moved) != 1 or self.freedoms(poses) != 1:
            return poses
        motion = np.linalg.svd(self.joint_rows(poses))[2][-1]
        along = measure(self.mechanism, moved[0], poses).gradient.ravel()[self.free]
        change = float(np.sum(along * self.unit * motion))
        if abs(change) > NUDGE * self._scale(moved[0]):
            return poses
        return self._newton(poses + self.spread(NUDGE * self.unit * motion * np.sign(motion[0] or 1.0)), {})

    def guess_gap(self) -> tuple[str, float]:
        """The joint that is open widest in the sketch as it was given, and by how much (m)."""
        if not self.equations.joints:
            return "", 0.0
        joint, gap = self.equations.widest(self._sketch(), self.time)
        return joint.name, abs(gap)

    def _contradiction(self, left: FloatArray, rates: list[str]) -> str:
        worst = int(np.argmax(np.abs(left)))
        joints = len(self.equations.owner)
        if worst >= joints:
            return f"the rate of {rates[worst - joints]!r} at the start contradicts joints, drives, or another rate"
        name = self.equations.joints[self.equations.owner[worst]].name
        return (
            f"joint {name!r} cannot follow the drives and rates of the start: they contradict each other there, "
            "or the start is a change point, where the joints do not say which way to go"
        )

    def _masses(self) -> FloatArray:
        """Masses and moments of inertia of the free coordinates; a lever's about its mass centre count as small."""
        size = self.mechanism.size
        masses = [
            [body.mass, body.mass, body.moments.xx + body.moments.yy or 1e-6 * body.mass * size**2]
            for body in self.mechanism.bodies
        ]
        return np.array(masses).ravel()[self.free]

    def _scale(self, name: str) -> float:
        return 1.0 if self.mechanism.reading(name).quantity == "angle" else self.mechanism.size

    def _sketch(self) -> FloatArray:
        return np.array(self.mechanism.sketch, dtype=np.float64)

    def _rows(self, poses: FloatArray, names: list[str]) -> FloatArray:
        """Joint equations and, last, the readings of these names, by the free coordinates."""
        rows = [self.equations.gradients(poses).reshape(len(self.equations.owner), self.free.size)]
        rows += [measure(self.mechanism, name, poses).gradient.reshape(1, -1) for name in names]
        return np.concatenate(rows)[:, self.free]

    def _newton(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """Gauss-Newton on the joints and on the readings that values are asked for, with the smallest changes."""
        names, size = list(values), self.mechanism.size
        weight = np.array([size] * len(self.equations.owner) + [self._scale(name) for name in names])
        closed = False
        for _ in range(60):
            off = [self._off(name, values[name], poses) for name in names]
            residual = np.append(self.equations.openings(poses, self.time), off) / weight
            if closed:
                return poses
            closed = np.max(np.abs(residual), initial=0.0) < CLOSED  # one step more, and rounding alone is left
            matrix = self._rows(poses, names) * self.unit / weight[:, np.newaxis]
            step = smallest_change(matrix, -residual)
            largest = float(np.max(np.abs(step)))
            poses = poses + self.spread(self.unit * step * min(1.0, LONGEST / max(largest, 1e-300)))
            if largest < 1e-15:
                break
        return self._closed_or_refused(poses, values)

    def _off(self, name: str, value: float, poses: FloatArray) -> float:
        off = float(reading_value(self.mechanism, name, poses)) - value
        return math.remainder(off, math.tau) if isinstance(self.mechanism.reading(name), LineAngle) else off

    def _closed_or_refused(self, poses: FloatArray, values: Mapping[str, float]) -> FloatArray:
        off = {name: self._off(name, value, poses) for name, value in values.items()}
        wrong = [name for name in off if not abs(off[name]) < 1e3 * CLOSED * self._scale(name)]
        where = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        where = f" at {where}" if where else ""
        joint, gap = self.equations.widest(poses, self.time) if self.equations.joints else (None, 0.0)
        if math.isfinite(gap) and abs(gap) < 1e3 * CLOSED * self.mechanism.size:
            if not wrong:
                return poses
            raise MechanismError(
                f"the mechanism cannot be assembled{where}: its joints close, but {wrong[0]} stays off by "
                f"{abs(off[wrong[0]]):.6g}; the values contradict each other or its joints"
            )
        cure = ""
        if isinstance(joint, Distance):
            stretched = joint.length + gap
            cure = f"; a length near {stretched:.6g} m instead of {joint.length:.6g} m would close it"
        name = joint.name if joint else ""
        raise MechanismError(
            f"the mechanism cannot be assembled{where}: joint {name!r} stays open by {abs(gap):.6g} m{cure}"
        )

    def spread(self, free: NDArray[np.floating]) -> FloatArray:
        """Free coordinates back to (bodies, 3), with zeros for bodies that do not turn."""
        everything = np.zeros(self.free.size)
        everything[self.free] = free
        return everything.reshape(-1, 3)


NOTED = 1e-9
"""A guess open by less than this fraction of the machine's size was no guess."""


def assembly_notes(scene: Scene) -> tuple[str, ...]:
    """What there is to say about the dimensions, and about how the start came about."""
    mechanism = scene.part.mechanism
    joint, gap = Assembler(mechanism).guess_gap()
    if gap < NOTED * mechanism.size or scene.start.values:
        return mechanism.notes
    return (*mechanism.notes, f"the start was a guess: joint {joint!r} was open by {gap:.3g} m in it, and was closed")

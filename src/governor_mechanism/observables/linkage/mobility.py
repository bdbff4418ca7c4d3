"""Mobility of a mechanism: by Grübler's count of bodies and joints, and the true one by the rank of the joint equations."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints import Joint, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.types import FloatArray
from governor_mechanism.units.fields import class_words

MAX_EXAMINED_POSES = 7
"""Number of poses at which the rank is examined: at single ones, as in a change point, it is smaller than in general."""


@dataclass(frozen=True)
class CountedJoints(Recorded):
    """Joints of one kind.

    Attributes
    ----------
    kind
        Word for the joint, as "pin".
    count
        Number of them.
    constraints
        Number of constraints of each.
    """

    kind: str
    count: int
    constraints: int

    def __str__(self) -> str:
        """Return the term of the count, as "2 x 4 pins"."""
        return f"{self.constraints} x {self.count} {self.kind}{'s' if self.count > 1 else ''}"


@dataclass(frozen=True, kw_only=True)
class Mobility(Recorded):
    """Mobility of a mechanism without its drives.

    Attributes
    ----------
    bodies
        Number of moving bodies.
    guided
        Number of coordinates that are given because bodies are described as ones that do not turn, or only turn.
    joints
        Joints by their kind.
    true
        Degrees of freedom: coordinates minus the rank of the joint equations, where it is largest in the motion.
    """

    bodies: int
    guided: int
    joints: tuple[CountedJoints, ...]
    true: int

    derived = ("gruebler", "redundant")

    @property
    def gruebler(self) -> int:
        """Grübler's count: 3 for each moving body, less the constraints."""
        return 3 * self.bodies - self.guided - sum(one.count * one.constraints for one in self.joints)

    @property
    def redundant(self) -> int:
        """Number of constraints that follow from the others."""
        return self.true - self.gruebler

    def __str__(self) -> str:
        """Return both numbers, with the count behind Grübler's."""
        terms = [f"3 x {self.bodies} {'bodies' if self.bodies > 1 else 'body'}"]
        terms += [f"{self.guided} for bodies that do not turn"] if self.guided else []
        count = f"{' - '.join([*terms, *map(str, self.joints)])} = {self.gruebler}"
        if not self.redundant:
            return f"mobility {self.true}: by Grübler's count {count}"
        noun = "constraint is" if self.redundant == 1 else "constraints are"
        return f"mobility {self.true}; Grübler's count is {count}, but {self.redundant} {noun} redundant"


def find_mobility(
    mechanism: Mechanism,
    poses: FloatArray,  # poses of its motion, in which the joints close; shape (n, bodies, 3)
) -> Mobility:
    """Return the mobility of a mechanism without its drives."""
    undriven = tuple(joint for joint in mechanism.joints if not isinstance(joint, RotationalDriver | TranslationalDriver))
    solver = PositionSolver(replace(mechanism, joints=undriven))
    examined = np.unique(np.linspace(0, len(poses) - 1, MAX_EXAMINED_POSES).astype(int))
    kinds = Counter((joint.noun or class_words(joint), _count_constraints(joint)) for joint in undriven)
    return Mobility(
        bodies=len(mechanism.bodies),
        guided=sum(3 - sum(body.moves) for body in mechanism.bodies),
        joints=tuple(CountedJoints(kind, count, constraints) for (kind, constraints), count in kinds.items()),
        true=min(solver.count_degrees_of_freedom(poses[k]) for k in examined),
    )


def _count_constraints(joint: Joint) -> int:
    return len(joint.constraint_rows(1.0))

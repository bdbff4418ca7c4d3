"""Where loads press a roller or a curve onto an outline, so that a mechanism with one degree of freedom rests there."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.contacts import outline_gaps_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import BoolArray, FloatArray

N_SEARCH_POSITIONS = 1001
"""Positions of the travel between which a contact closes or opens at most once."""

OVERLAP_TOLERANCE = 1e-9
"""Overlap that is rounding, relative to the size of the mechanism."""


@dataclass(frozen=True)
class Rest:
    """A position in which a contact bears the loads."""

    coefficients: PathCoefficients
    contact: str  # name of the contact
    push: float  # normal force, N


def is_free(reduction: SingleDofReduction, poses: FloatArray) -> BoolArray:
    """Return at which of poses (n, bodies, 3) no parts of contacts overlap."""
    least = -OVERLAP_TOLERANCE * reduction.mechanism.length_scale
    free = np.ones(len(poses), dtype=np.bool_)
    for gap in outline_gaps_of(reduction.scene):
        free &= evaluate_output_value(reduction.mechanism, gap.name, poses) >= least
    return free


def find_rests(reduction: SingleDofReduction, force: Callable[[PathCoefficients], FloatArray]) -> Iterator[Rest]:
    """Yield the positions in which a contact is closed and the generalised force (n,) of the loads presses it."""
    gaps = outline_gaps_of(reduction.scene)
    if not gaps:
        return
    travel = reduction.range_of_motion
    searched = reduction.evaluate(np.linspace(travel.low, travel.high, N_SEARCH_POSITIONS)[1:-1])
    for gap in gaps:
        values = evaluate_output_value(reduction.mechanism, gap.name, searched.poses)
        is_open = values > 0.0  # a gap may be exactly closed at a searched position
        for k in np.flatnonzero(is_open[:-1] != is_open[1:]).tolist():
            here = reduction.evaluate([_locate(reduction, gap, (float(searched.coordinate[k]), float(searched.coordinate[k + 1])))])
            push = -float(force(here)[0] / reduction.output_derivative(here, gap.name)[0])
            if push > 0.0 and is_free(reduction, here.poses)[0]:
                yield Rest(here, gap.contact, push)


def _locate(reduction: SingleDofReduction, gap: OutlineGap, bracket: tuple[float, float]) -> float:
    """Return the coordinate between two others at which a contact closes."""
    return find_root(lambda one: float(evaluate_output_value(reduction.mechanism, gap.name, reduction.evaluate([one]).poses)[0]), *bracket)

"""Joint gaps of runs with steps that are halved from one to the next: whether the steps explain them."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.impulse.records import FixedStepSolution
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import BoolArray, FloatArray

MIN_SIGNIFICANT_GAP_RATIO = 1e-11
"""Joint gap, relative to the length scale, below which it is rounding and no sign of unsolved joints."""


def has_open_joints(evaluator: ReadingEvaluator, solutions: Sequence[FixedStepSolution], times: FloatArray) -> bool:
    """Return whether joint gaps at the monitor times (n,) s do not shrink as the step is halved (second order divides them by four)."""
    return any(bool(_open_joint_mask(evaluator, pair, times)[-1]) for pair in pairwise(solutions))


def count_closed_times(evaluator: ReadingEvaluator, solutions: Sequence[FixedStepSolution], times: FloatArray) -> int:
    """Return the number of the monitor times (n,) s that the finest two runs reach with joint gaps that their steps explain."""
    count = min(len(times), *(len(solution.raw_poses) for solution in solutions))
    is_open = _open_joint_mask(evaluator, (solutions[-2:][0], solutions[-1]), times[:count])
    return int(np.argmax(is_open)) if is_open.any() else count


def _open_joint_mask(evaluator: ReadingEvaluator, pair: tuple[FixedStepSolution, FixedStepSolution], times: FloatArray) -> BoolArray:
    """Return up to which monitor times (n,) s the largest joint gap so far is larger than the steps of two runs explain."""
    min_gap = MIN_SIGNIFICANT_GAP_RATIO * evaluator.mechanism.length_scale
    gaps = [evaluator.evaluate_joint_gap(solution.raw_poses[: len(times)], times) for solution in pair]
    coarser, finer = np.maximum.accumulate(gaps, axis=1)
    is_open: BoolArray = finer > np.maximum(0.5 * coarser, min_gap)
    return is_open

"""Location of the time at which a motion leaves the range in which its description is valid."""

from collections.abc import Callable

import numpy as np

from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import FloatArray


def locate_exit(is_inside: Callable[[float], bool | None], inside: float, outside: float, max_bisections: int) -> float | None:
    """Return the first time at which a motion is outside its range, by bisection.

    Parameters
    ----------
    is_inside
        Function of a time (s): whether the motion is inside its range there; None if that is not known.
    inside
        Time at which it is inside, s.
    outside
        Later time at which it is outside, s.
    max_bisections
        Largest number of bisections.

    Returns
    -------
    float | None
        Time, s; None if some state between the two times is not known.
    """
    for _ in range(max_bisections):
        middle = 0.5 * (inside + outside)
        if not inside < middle < outside:
            break
        answer = is_inside(middle)
        if answer is None:
            return None
        inside, outside = (middle, outside) if answer else (inside, middle)
    return outside


def describe_stall(
    evaluator: ReadingEvaluator,
    motion_at: Callable[[float], tuple[FloatArray, FloatArray] | None],
    span: tuple[float, float],
    poses: FloatArray,
    max_bisections: int,
) -> str:
    """Return how, where and when a shaft stalls, located by bisection.

    Parameters
    ----------
    evaluator
        Evaluator of the scene.
    motion_at
        Function of a time (s) that returns poses and velocities (bodies, 3), or None if the shaft has turned back before.
    span
        Time at which the shaft turns forward, and a later one at which it has turned back, s.
    poses
        Poses at the first of them; shape (bodies, 3).
    max_bisections
        Largest number of bisections.

    Returns
    -------
    str
        The sentence of the limit, with angle and time.
    """

    def is_inside(time: float) -> bool:
        nonlocal poses
        motion = motion_at(time)
        if motion is None or evaluator.find_first_stall(motion[0][np.newaxis], motion[1][np.newaxis]) is not None:
            return False
        poses = motion[0]
        return True

    time = locate_exit(is_inside, *span, max_bisections)
    return f"{evaluator.describe_stall(evaluator.mechanism.stall_limits[0], poses)}, at t = {time:.9g} s"

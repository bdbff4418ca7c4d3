"""The period of a swing, measured on a run."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.trajectory import Trajectory


def measured_period(run: Trajectory, reading: str, middle: float) -> float:
    """Time (s) between the first and the last upward passage of a reading through `middle`, per whole swing."""
    curve = CubicHermiteSpline(run.times, run.readings[reading] - middle, run.rates[reading])
    passages = np.asarray(curve.roots(extrapolate=False))
    upward = passages[curve(passages, 1) > 0]
    if len(upward) < 2:
        raise MechanismError(
            f"{reading} swings less than once through {middle:.6g} in {run.times[-1]:.6g} s: no period"
        )
    return float((upward[-1] - upward[0]) / (len(upward) - 1))

"""Studies of the regulation by a governor, with many runs of one scene: cyclic motion, clearance, settling, jump.

Results for the shipped scenes:

- The sleeve starts to move as soon as the speed fluctuation exceeds the insensitivity band; the amplitude first grows
  with the square of the excess.
- Zehnder names clearance between links and sleeve as a remedy against cyclic motion. A small clearance is none. The
  weight of a loaded sleeve (porter_clearance) keeps the clearance closed, and the motion does not change. If friction
  carries the sleeve (watt_clearance), the balls move freely: they strike the ends of the clearance and drive the sleeve
  ten times as far and more, until the clearance is as wide as their free oscillation; only then the sleeve is at rest.
  In between the impacts are irregular, and a single amplitude means little. Such a clearance causes cyclic motion even
  if the speed fluctuation is below the insensitivity band.
- The settling time has a minimum over the damping: with less damping the governor oscillates, with more it creeps.
- The jump of the improved Watt governor is later than the equilibrium speeds predict: by rate^(2/3) at the fold, where
  it falls, and by nearly the rate itself, except for a logarithm, where it leaves its stop.

Pure functions: they run scenes and return arrays. SI units and radians.
"""

from __future__ import annotations

import numpy as np

from governor_mechanism.studies.regression import FittedParameter
from governor_mechanism.studies.regulation.cyclic_irregularity import (
    ClearanceStudy,
    CyclicMotionStudy,
    study_clearance,
    study_cyclic_motion,
)
from governor_mechanism.studies.regulation.fold_jump import FoldJumpStudy, study_fold_jump
from governor_mechanism.studies.regulation.settling_time import SettlingStudy, study_settling

FLUCTUATION_RATIOS = np.concatenate([np.linspace(0.0, 0.95, 12), 1 + np.geomspace(1e-4, 1.0, 29)])
"""Speed fluctuations over the insensitivity band, for a curve of cyclic motion."""

CLEARANCES = np.geomspace(1e-5, 4e-2, 33)
"""Clearances, m, for a curve of the clearance study."""

DAMPING_COEFFICIENTS = np.geomspace(35.0, 1200.0, 60)
"""Damping coefficients, N s/m, for a curve of the settling time."""

RAMP_RATES = np.geomspace(1e-5, 4e-3, 14)
"""Ramp rates of the spindle speed, rad/s2, for a curve of the jump."""

__all__ = [
    "CLEARANCES",
    "DAMPING_COEFFICIENTS",
    "FLUCTUATION_RATIOS",
    "RAMP_RATES",
    "ClearanceStudy",
    "CyclicMotionStudy",
    "FittedParameter",
    "FoldJumpStudy",
    "SettlingStudy",
    "study_clearance",
    "study_cyclic_motion",
    "study_fold_jump",
    "study_settling",
]

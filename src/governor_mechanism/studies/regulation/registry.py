"""How a governor regulates, by many runs of one scene: twitching, play, settling, and the jump.

What was found with the shipped scenes:

- It twitches as soon as the speed fluctuation of the spindle exceeds the insensitivity band, and at first with the square of the
  excess.
- Play between links and sleeve, which Zehnder names as a remedy against twitching, is none as long as it is small. The
  weight of a loaded sleeve (porter_clearance) keeps the play closed and the twitch remains what it was. Where friction can
  carry the sleeve (watt_clearance), the balls get loose: they knock on the ends of the play and drive the sleeve farther
  than without, ten times as far and more, until the play is as wide as their free swing; only then the sleeve stands
  still. In between, where they reach the ends now and then, the knocking is irregular: a single amplitude means little.
  Such play sets off twitching even where the speed fluctuation is less than the insensitivity band.
- The shortest settling needs a brake of a definite strength: less lets it swing, more lets it creep.
- The jump of the improved Watt governor comes later than the static speeds say: by rate^(2/3) at the fold, where it
  falls, and nearly by the rate itself, but for a logarithm, where it leaves its stop.

Pure functions: they run scenes and return arrays. SI and radians throughout.
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
"""Unevenness over the insensitivity band, for a curve of twitching."""

CLEARANCES = np.geomspace(1e-5, 4e-2, 33)
"""m, for a curve of play."""

DAMPING_COEFFICIENTS = np.geomspace(35.0, 1200.0, 60)
"""N s/m, for a curve of settling."""

RAMP_RATES = np.geomspace(1e-5, 4e-3, 14)
"""rad/s2, for a curve of the jump."""

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

"""Coefficients of DOP853, the Runge-Kutta method of order 8 of Dormand and Prince, as contiguous arrays for compiled code.

Stages 0 to 11 are those of the step, 12 is its end, and 13 to 15 are the additional stages of the dense output.

References
----------
E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition 1993, section II.10.
"""

from typing import Final

import numpy as np
from scipy.integrate import DOP853

NODES: Final = np.concatenate([DOP853.C, [1.0], DOP853.C_EXTRA])
"""Abscissas of the stages as fractions of the step; shape (16,)."""

STAGES: Final = np.vstack([np.pad(DOP853.A, ((0, 0), (0, 4))), np.pad(DOP853.B, (0, 4)), DOP853.A_EXTRA])
"""Coefficients of each stage; shape (16, 16)."""

FIRST_NONZERO_STAGE: Final = 1 + np.argmax(STAGES[:, 1:] != 0.0, axis=1)
"""First stage after stage 0 with a nonzero coefficient, for each stage; shape (16,)."""

ERROR_5: Final = np.ascontiguousarray(DOP853.E5)
"""Weights of the stages and the final derivative in the error estimate of order 5; shape (13,)."""

ERROR_3: Final = np.ascontiguousarray(DOP853.E3)
"""Weights in the error estimate of order 3; shape (13,)."""

DENSE_WEIGHTS: Final = np.ascontiguousarray(DOP853.D)
"""Weights of all 16 stages in the dense output of order 7; shape (4, 16)."""

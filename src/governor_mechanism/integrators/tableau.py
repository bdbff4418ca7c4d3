"""Coefficients of DOP853, the Runge-Kutta method of order 8 of Dormand and Prince, as contiguous arrays for compiled code.

References
----------
E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition 1993, section II.10.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.integrate import DOP853

NODES: Final = np.ascontiguousarray(DOP853.C)
"""Abscissas of the stages as fractions of the step; shape (12,)."""

STAGES: Final = np.ascontiguousarray(DOP853.A)
"""Coefficients of each stage; shape (12, 12)."""

WEIGHTS: Final = np.ascontiguousarray(DOP853.B)
"""Weights of the stages in the solution of order 8; shape (12,)."""

ERROR_5: Final = np.ascontiguousarray(DOP853.E5)
"""Weights of the stages and the final derivative in the error estimate of order 5; shape (13,)."""

ERROR_3: Final = np.ascontiguousarray(DOP853.E3)
"""Weights in the error estimate of order 3; shape (13,)."""

DENSE_NODES: Final = np.ascontiguousarray(DOP853.C_EXTRA)
"""Abscissas of the three additional stages of the dense output; shape (3,)."""

DENSE_STAGES: Final = np.ascontiguousarray(DOP853.A_EXTRA)
"""Coefficients of the additional stages; shape (3, 16)."""

DENSE_WEIGHTS: Final = np.ascontiguousarray(DOP853.D)
"""Weights of all 16 stages in the dense output of order 7; shape (4, 16)."""

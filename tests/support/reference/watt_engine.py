"""An engine under a pendulum governor whose spindle follows it: equations of motion, and numbers computed from them.

Source: L. S. Pontryagin, Ordinary Differential Equations (1962), section 27, after I. A. Vyshnegradskii (1877). Two balls on massless
arms hang on the spindle axis. The spindle turns at a fixed ratio to the engine and returns no torque. With the arm angle x from the
downward vertical, in SI units and scaled (length arm, time sqrt(arm / gravity)):

    2 m l^2 x'' = m l^2 omega^2 sin 2x - 2 m g l sin x - b x'        x'' = z^2 sin x cos x - sin x - epsilon x'
    J W' = gain (zero_lift - 2 l (1 - cos x)) - load, omega = r W    z'  = alpha (cos x - beta)

2 l (1 - cos x) is the lift of a sleeve that hangs on links as long as the arms.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_files import read_data

FloatArray = NDArray[np.float64]

MOTIONS = read_data(__file__)
HUNTING_MOTION, STABLE_MOTION = MOTIONS["HUNTING_MOTION"], MOTIONS["STABLE_MOTION"]


@dataclass(frozen=True, kw_only=True)
class GovernedEngine:
    """Dimensions in SI units; `zero_torque_lift` is the lift of the sleeve at which the engine's torque is zero."""

    arm: float = 0.3
    ball_mass: float = 5.0
    arm_damping: float = 3.3
    engine_inertia: float = 100.0
    ratio: float = 2.0
    torque_gain: float = 2000.0
    zero_torque_lift: float = 0.54
    gravity: float = 9.81

    def lift(self, angle: FloatArray | float) -> FloatArray | float:
        """Return the lift of the sleeve, m."""
        return 2 * self.arm * (1 - np.cos(angle))

    def derivative(self, state: FloatArray, load: float) -> FloatArray:
        """Return the time derivative of arm angle, arm rate and engine speed under a load torque."""
        angle, rate, speed = state
        inertia = 2 * self.ball_mass * self.arm**2
        centrifugal = self.ball_mass * self.arm**2 * (self.ratio * speed) ** 2 * np.sin(2 * angle)
        moment = centrifugal - 2 * self.ball_mass * self.gravity * self.arm * np.sin(angle) - self.arm_damping * rate
        torque = self.torque_gain * (self.zero_torque_lift - self.lift(angle)) - load
        return np.array([rate, moment / inertia, torque / self.engine_inertia])

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

FloatArray = NDArray[np.float64]

# Time, arm angle, arm rate, engine speed, by the extrapolated midpoint rule of order 16 in 64-bit mantissas, with steps of 0.02 s. The
# dimensions are those of GovernedEngine, with arms damped by 3.3 N m s/rad, below the limit, and by 6.0 N m s/rad, above it; the load
# falls from 800 N m to 600 N m at 1 s.
HUNTING_MOTION = [
    (2.0, 0.8795483509127328, -0.8967133113927443, 3.4509464587831538),
    (3.0, 0.9400026019540856, -1.0251265044773362, 3.4292614176058656),
    (5.0, 1.0743470187716572, -0.8566940915378704, 3.4946731722857299),
    (10.0, 0.9785553871410427, 1.8009746832511645, 4.2116504393261270),
    (20.0, 1.3319302703476869, -0.8677573070948449, 3.6680715970409924),
    (30.0, 1.1333980349960564, -2.4609895702645873, 3.2228839468022166),
    (40.0, 0.8785946785702868, -2.5253762825327228, 3.1402244724135304),
]
STABLE_MOTION = [
    (2.0, 0.9762231966330434, -0.4713932154928007, 3.5642559429054610),
    (3.0, 0.9706228322911923, -0.0024239483840517, 3.7179586706468627),
    (5.0, 0.9203232607571696, 0.0327632539619225, 3.6991134127640325),
    (10.0, 0.9272208981742907, 0.0008123263212913, 3.6914543861407665),
    (20.0, 0.9272952420516509, 0.0000002509576353, 3.6912058686315777),
    (30.0, 0.9272952180213911, 0.0000000000099390, 3.6912057650731757),
]


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

"""An engine under a pendulum governor whose spindle follows it: equations of motion integrated by scipy, and numbers computed so.

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
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult, fsolve

FloatArray = NDArray[np.float64]

# Numbers with the dimensions of GovernedEngine; the load falls from LOADS[0] to LOADS[1] at STEP_TIME.
LOADS, STEP_TIME = (800.0, 600.0), 1.0
"""N m; s."""
HUNTING_DAMPING, STABLE_DAMPING = 3.3, 6.0
"""N m s/rad: below and above the limit under the second load."""

# Time, arm angle, arm rate, engine speed: extrapolated midpoint rule of order 16 in 64-bit mantissas, step 0.02 s. `trajectory` departs
# from it by 5e-13 at 10 s and 1e-11 at 40 s where it hunts, by 5e-13 where it settles.
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

# By `limit_cycle`, to 10 digits; started from other guesses it gives the same to 11 or 12.
HUNTING_CYCLE = {"period": 1.100450997, "highest": 1.408824854, "lowest": 0.4503799807, "fastest": 4.689903696, "slowest": 3.135486704}
"""What the motion with HUNTING_DAMPING settles to, in SI units: s, rad, and rad/s of the engine; the arms swing from 25.8 to 80.7 deg."""
SOFT = {"alpha": 0.75, "beta": 0.6, "limit": 0.6971370023}
SOFT_CYCLES = {
    0.65: {"period": 6.316416663, "highest": 1.436199808, "lowest": 0.4246798732, "fastest": 1.671646631, "slowest": 1.085553536},
    0.69: {"period": 6.121598270, "highest": 1.129170774, "lowest": 0.7248601751, "fastest": 1.420481926, "slowest": 1.185650592},
}
"""Scaled, by epsilon: stable cycles, Floquet multipliers 0.736 and 0.969."""
HARD = {"alpha": 0.3, "beta": 0.9, "limit": 0.5122889809}
HARD_CYCLES = {
    0.515: {"period": 13.82358947, "highest": 0.5550837771, "lowest": 0.3484497745, "fastest": 1.086175415, "slowest": 1.027078013}
}
"""Scaled, by epsilon: an unstable cycle, Floquet multiplier 1.017; smaller oscillations die out, larger ones grow."""

TOLERANCES = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


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

    def equilibrium(self, load: float) -> FloatArray:
        """Return arm angle, arm rate and engine speed of the equilibrium under a load torque."""
        cosine = 1 - (self.zero_torque_lift - load / self.torque_gain) / (2 * self.arm)
        return np.array([np.arccos(cosine), 0.0, np.sqrt(self.gravity / (self.arm * cosine)) / self.ratio])

    def trajectory(self, times: FloatArray, loads: tuple[float, float], step_time: float) -> FloatArray:
        """Return arm angle, arm rate and engine speed, shape (3, n), at increasing times, from the equilibrium under the first load.

        The load changes to the second at step_time; the last time is later.
        """
        state = self.equilibrium(loads[0])
        before, after = times[times < step_time], times[times >= step_time]
        run = solve_ivp(
            lambda _, values: self.derivative(values, loads[1]), (step_time, times[-1] + 1e-9), state, dense_output=True, **TOLERANCES
        )
        return np.hstack([np.repeat(state[:, None], len(before), axis=1), run.sol(after)])


def scaled_derivative(state: FloatArray, alpha: float, beta: float, epsilon: float) -> FloatArray:
    """Return the derivative of x, x' and z by the scaled time."""
    angle, rate, speed = state
    return np.array([rate, (speed**2 * np.cos(angle) - 1) * np.sin(angle) - epsilon * rate, alpha * (np.cos(angle) - beta)])


def scaled_trajectory(times: FloatArray, start: FloatArray, alpha: float, beta: float, epsilon: float) -> FloatArray:
    """Return x, x' and z, shape (3, n), at increasing scaled times; `start` holds at time 0."""
    arguments = (alpha, beta, epsilon)
    run = solve_ivp(lambda _, state: scaled_derivative(state, *arguments), (0.0, times[-1]), start, dense_output=True, **TOLERANCES)
    return np.asarray(run.sol(times))


def limit_cycle(alpha: float, beta: float, epsilon: float, amplitude: float, settling_time: float) -> dict[str, float]:
    """Return period, turning points of x, extremes of z and the largest Floquet multiplier (without the trivial 1), found by shooting.

    The guess is the last cycle of a motion that starts `amplitude` (rad) above the equilibrium and goes on for the settling time, long if
    the cycle is stable, two periods if it is unstable. The unknowns are x and z at the upper turning point, and the period.
    """

    def flow(start: FloatArray, duration: float, **options: object) -> OptimizeResult:
        return solve_ivp(lambda _, state: scaled_derivative(state, alpha, beta, epsilon), (0.0, duration), start, **options, **TOLERANCES)

    def mismatch(unknowns: FloatArray) -> FloatArray:
        start = np.array([unknowns[0], 0.0, unknowns[1]])
        return np.asarray(flow(start, unknowns[2]).y[:, -1] - start)

    def turning(_: float, state: FloatArray) -> float:
        return float(state[1])

    def reversal(_: float, state: FloatArray) -> float:
        return float(np.cos(state[0]) - beta)

    settled = flow(np.array([np.arccos(beta) + amplitude, 0.0, beta**-0.5]), settling_time, events=turning)
    times, tops = settled.t_events[0], settled.y_events[0]
    last = len(tops) - (1 if tops[-1, 0] > tops[-2, 0] else 2)
    guess = [tops[last, 0], tops[last, 2], times[last] - times[last - 2]]
    highest, speed, period = fsolve(mismatch, guess, xtol=1e-13)
    start, step = np.array([highest, 0.0, speed]), 1e-5
    ends = [[flow(start + sign * direction, period).y[:, -1] for sign in (-1, 1)] for direction in step * np.eye(3)]
    multipliers = np.linalg.eigvals(np.array([(end - begin) / (2 * step) for begin, end in ends]).T)
    nontrivial = np.delete(multipliers, np.argmin(abs(multipliers - 1)))
    cycle = flow(start, 1.01 * period, events=[turning, reversal])
    return {
        "period": float(period),
        "highest": float(highest),
        "lowest": float(cycle.y_events[0][:, 0].min()),
        "fastest": float(cycle.y_events[1][:, 2].max()),
        "slowest": float(cycle.y_events[1][:, 2].min()),
        "multiplier": float(abs(nontrivial).max()),
    }

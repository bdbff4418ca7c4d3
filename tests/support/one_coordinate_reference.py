"""The other witness: the one-coordinate equation of motion of the closed forms, integrated by scipy at 1e-13."""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction


def integrate_one_coordinate(scene, times, governor=None):
    """Arm angle and rate (n,) of a scene at the given times."""
    if governor is None:
        governor = closed.PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)
    program = SpindleSpeedFunction(scene.spindle)
    state = np.array([scene.start.values["arm_angle"], scene.start.rates.get("arm_angle", 0.0)])
    breaks = [time for time in program.breakpoints if 0 < time < times[-1]]
    constant_speed = program.start_speed if program.is_constant else None
    knots = [0.0, *breaks, float(times[-1])]
    found = np.empty((2, len(times)))
    found[:, times == 0.0] = state[:, np.newaxis]
    for start, end in pairwise(knots):

        def slope(time, y, start=start):
            speed = float(program(np.array([time]), left_limit=time > start)[0]) if constant_speed is None else constant_speed
            return [y[1], float(closed.arm_acceleration(governor, arm_angle=y[0], arm_rate=y[1], spindle_speed=speed))]

        mine = (times > start) & (times <= end)
        wanted = np.unique(np.append(times[mine], end))
        piece = solve_ivp(slope, (start, end), state, method="DOP853", t_eval=wanted, rtol=1e-13, atol=1e-14)
        found[:, mine] = piece.y[:, : int(mine.sum())]
        state = piece.y[:, -1]
    return found

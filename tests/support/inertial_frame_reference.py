"""A further witness: the Porter governor as points in space, seen from where nothing turns, by scipy alone.

Eight coordinates: two balls (x, y, z), the sleeve's height, the spindle's angle. Its joints are equations between
them: an arm and a link to each ball, and the plane of the arms, which turns with the spindle and takes the balls
along. Newton's law with one force for each equation gives the motion; no rotating frame, no reduced equation, and
nothing of governor_mechanism enters. z points up from the points of suspension; the sleeve has no inertia of turning
but what the spindle's own holds.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

SIDE_SIGNS = (1.0, -1.0)
HEIGHT_INDEX, ANGLE_INDEX = 6, 7  # where the sleeve's height and the spindle's angle stand among the coordinates
RTOL, ATOL = 1e-13, 1e-14  # as fine as rounding lets DOP853 be; scipy takes no rtol below 2.2e-14


@dataclass(frozen=True, kw_only=True)
class Governor:
    """Four equal rods without mass, two balls, a sleeve, and a spindle of its own moment of inertia (SI)."""

    arm: float
    offset: float
    ball_mass: float
    sleeve_mass: float
    spindle_inertia: float = 0.0
    gravity: float = 9.81

    @property
    def masses(self):
        """Inertia of each coordinate (8,)."""
        return np.array([self.ball_mass] * 6 + [self.sleeve_mass, self.spindle_inertia])

    @property
    def weights(self):
        """Gravity's force along each coordinate (8,)."""
        force = np.zeros(8)
        force[[2, 5]] = -self.ball_mass * self.gravity
        force[HEIGHT_INDEX] = -self.sleeve_mass * self.gravity
        return force


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Arrays (n,) at the times, in SI units; torque is that of the drive about the axis."""

    times: np.ndarray
    arm_angle: np.ndarray
    arm_rate: np.ndarray
    theta: np.ndarray
    omega: np.ndarray
    torque: np.ndarray
    angular_momentum: np.ndarray


def driven_motion(governor, *, speed, arm_angle, arm_rate, times):
    """The motion while a drive keeps the spindle at `speed`."""
    return _motion(governor, speed, arm_angle, arm_rate, times, driven=True)


def free_motion(governor, *, speed, arm_angle, arm_rate, times):
    """The motion of a spindle that starts at `speed` and is left to itself."""
    return _motion(governor, speed, arm_angle, arm_rate, times, driven=False)


def _motion(governor, speed, arm_angle, arm_rate, times, driven):
    times = np.asarray(times, dtype=float)

    def slope(time, state):
        return np.concatenate([state[8:], _accelerations(governor, state, driven)[0]])

    start = _start(governor, speed, arm_angle, arm_rate)
    found = solve_ivp(slope, (0.0, times.max()), start, method="DOP853", t_eval=times, rtol=RTOL, atol=ATOL)
    return _as_motion(governor, times, found.y.T, driven)


def _start(governor, speed, angle, rate):
    """Coordinates and velocities (16,) with the arms in the plane y = 0."""
    q, v = np.zeros(8), np.zeros(8)
    radius = governor.offset + governor.arm * np.sin(angle)
    for ball, side in enumerate(SIDE_SIGNS):
        q[3 * ball : 3 * ball + 3] = side * radius, 0.0, -governor.arm * np.cos(angle)
        outward = governor.arm * np.cos(angle) * rate
        v[3 * ball : 3 * ball + 3] = side * outward, side * radius * speed, governor.arm * np.sin(angle) * rate
    q[HEIGHT_INDEX], v[HEIGHT_INDEX] = 2 * q[2], 2 * v[2]  # the rhombus: the sleeve hangs twice as deep as the balls
    v[ANGLE_INDEX] = speed
    return np.concatenate([q, v])


def _plane_axes(theta):
    """The direction out along the arms' plane, and the one square to that plane, both level."""
    return np.array([np.cos(theta), np.sin(theta), 0.0]), np.array([-np.sin(theta), np.cos(theta), 0.0])


def _joint_equations(governor, q, v):
    """Values of the six joints' equations, their Jacobian (6, 8), and what their second derivatives have without it.

    For each ball: half the square of the arm, half that of the link, and the distance from the turning plane.
    """
    out, across = _plane_axes(q[ANGLE_INDEX])
    turning = v[ANGLE_INDEX]
    values, jacobian, rest = np.zeros(6), np.zeros((6, 8)), np.zeros(6)
    for ball, side in enumerate(SIDE_SIGNS):
        here = slice(3 * ball, 3 * ball + 3)
        lug = side * governor.offset * out
        lug_by_angle = side * governor.offset * across
        for row, height, carried in ((3 * ball, 0.0, 0.0), (3 * ball + 1, q[HEIGHT_INDEX], 1.0)):
            rod = q[here] - lug - [0.0, 0.0, height]
            rod_rate = v[here] - lug_by_angle * turning - [0.0, 0.0, carried * v[HEIGHT_INDEX]]
            values[row] = (rod @ rod - governor.arm**2) / 2
            jacobian[row, here] = rod
            jacobian[row, HEIGHT_INDEX] = -carried * rod[2]
            jacobian[row, ANGLE_INDEX] = -rod @ lug_by_angle
            rest[row] = rod_rate @ rod_rate + rod @ lug * turning**2  # a point on a circle: its second derivative is -r
        row = 3 * ball + 2
        values[row] = across @ q[here]
        jacobian[row, here] = across
        jacobian[row, ANGLE_INDEX] = -out @ q[here]
        rest[row] = -2 * turning * (out @ v[here]) - turning**2 * (across @ q[here])
    return values, jacobian, rest


def _accelerations(governor, state, driven):
    """Accelerations (8,) and the drive's torque: inertia times acceleration is weight and the forces of the joints."""
    q, v = state[:8], state[8:]
    _, jacobian, rest = _joint_equations(governor, q, v)
    if driven:  # one joint more: the spindle's angle is speed times time, so its acceleration is none
        jacobian, rest = np.vstack([jacobian, np.eye(8)[ANGLE_INDEX]]), np.append(rest, 0.0)
    count = len(rest)
    system = np.block([[np.diag(governor.masses), -jacobian.T], [jacobian, np.zeros((count, count))]])
    solution = np.linalg.solve(system, np.concatenate([governor.weights, -rest]))
    return solution[:8], solution[-1] if driven else 0.0


def _as_motion(governor, times, states, driven):
    """The motion in the words of a governor, from the states (n, 16)."""
    first = np.array([_arm(governor, state, 0) for state in states]).T
    return Motion(
        times=times,
        arm_angle=first[0],
        arm_rate=first[1],
        theta=states[:, ANGLE_INDEX],
        omega=states[:, 8 + ANGLE_INDEX],
        torque=np.array([_accelerations(governor, state, driven)[1] for state in states]),
        angular_momentum=np.array([_angular_momentum(governor, state) for state in states]),
    )


def _arm(governor, state, ball):
    """Angle of one arm from the vertical and its rate, from where its ball is and how it moves."""
    out, across = _plane_axes(state[ANGLE_INDEX])
    place, velocity = state[3 * ball : 3 * ball + 3], state[8 + 3 * ball : 11 + 3 * ball]
    side = SIDE_SIGNS[ball]
    radial = side * (out @ place) - governor.offset
    radial_rate = side * (out @ velocity + across @ place * state[8 + ANGLE_INDEX])
    depth, depth_rate = -place[2], -velocity[2]
    rate = (depth * radial_rate - radial * depth_rate) / (depth**2 + radial**2)
    return np.arctan2(radial, depth), rate


def _angular_momentum(governor, state):
    """About the axis (kg m2/s), of balls and spindle."""
    x, y = state[[0, 3]], state[[1, 4]]
    vx, vy = state[[8, 11]], state[[9, 12]]
    return governor.ball_mass * np.sum(x * vy - y * vx) + governor.spindle_inertia * state[8 + ANGLE_INDEX]

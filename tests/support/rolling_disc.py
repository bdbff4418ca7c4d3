"""A disc that flies, strikes, slides and rolls along a straight line or an arc under gravity, integrated by scipy with events.

It shares nothing with the package: the coordinates are those of the centre in flight, and its way along the path with the angle of the
disc while it touches.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

LEAST_REBOUND = 1e-7
"""Speed, m/s, from which on rebounds are a geometric series, which has the impulse of a steady force: its height is 1e-15 m."""

PRECISION = {"rtol": 1e-13, "atol": 1e-15, "method": "DOP853", "dense_output": True, "max_step": 5e-3}


@dataclass(frozen=True)
class Line:
    """The path of the centre at a distance above a slope that falls to the right by an angle, from the origin."""

    angle: float
    distance: float

    def at(self, way):
        """Return position, tangent, normal toward the disc, and curvature toward the normal."""
        tangent = np.array([math.cos(self.angle), -math.sin(self.angle)])
        normal = np.array([math.sin(self.angle), math.cos(self.angle)])
        return self.distance * normal + way * tangent, tangent, normal, 0.0

    def way(self, place):
        """Return the way along the path that belongs to a place."""
        return float(np.dot(place, self.at(0.0)[1]))

    def gap(self, place):
        """Return the distance from the path."""
        return float(np.dot(place, self.at(0.0)[2])) - self.distance


@dataclass(frozen=True)
class Arc:
    """The path of the centre on a circle of a radius about the origin: inside a bowl (hollow), or outside a cylinder."""

    radius: float
    is_hollow: bool = True

    def at(self, way):
        """Return position, tangent, normal toward the disc, and curvature toward the normal."""
        angle, side = way / self.radius, 1.0 if self.is_hollow else -1.0
        normal = np.array([-side * math.sin(angle), math.cos(angle)])
        return -side * self.radius * normal, np.array([normal[1], -normal[0]]), normal, side / self.radius

    def way(self, place):
        """Return the way along the path that belongs to a place."""
        return self.radius * math.atan2(place[0], -place[1] if self.is_hollow else place[1])

    def gap(self, place):
        """Return the distance from the path."""
        return (self.radius - math.hypot(*place)) * (1.0 if self.is_hollow else -1.0)


@dataclass(frozen=True, kw_only=True)
class Disc:
    """A disc with gravity (m/s2), friction and restitution."""

    mass: float
    inertia: float
    radius: float
    gravity: float
    friction: float
    restitution: float


@dataclass
class Motion:
    """States (x, y, angle and their rates) at the times asked for, events by kind, and the energy that strikes and sliding took."""

    times: np.ndarray
    states: np.ndarray
    events: dict = field(default_factory=lambda: {"impact": [], "rest": [], "stick": [], "slip": [], "separation": []})
    impact_losses: list = field(default_factory=list)


def simulate(disc, path, start, times):
    """Return the motion from a state in flight (x, y, angle, and their rates)."""
    motion = Motion(times, np.full((len(times), 6), np.nan))
    time, state, phase = float(times[0]), np.array(start, dtype=float), "flight"
    while time < times[-1]:
        if phase == "flight":
            time, state, phase = _fly(disc, path, time, state, motion)
        else:
            time, state, phase = _touch(disc, path, time, state, phase, motion)
    return motion


def _fly(disc, path, time, state, motion):
    """Fly until the next strike and through it."""

    def strike(t, y):
        return path.gap(y[:2]) if t > time + 1e-13 else 1.0

    strike.terminal, strike.direction = True, -1
    motion_in_flight = lambda t, y: [*y[3:], 0.0, -disc.gravity, 0.0]  # noqa: E731
    solution = solve_ivp(motion_in_flight, (time, motion.times[-1]), state, events=strike, **PRECISION)
    _record(motion, solution, time, lambda y: y)
    if solution.status != 1:
        return float(solution.t[-1]), solution.y[:, -1], "end"
    time, state = float(solution.t[-1]), solution.y[:, -1].copy()
    _, tangent, normal, curvature = path.at(path.way(state[:2]))
    approach, slip = -float(normal @ state[3:5]), float(tangent @ state[3:5]) + disc.radius * state[5]
    is_last = disc.restitution * approach <= LEAST_REBOUND
    # A steady force replaces the rebounds after the last one, so that this one stops the disc.
    push = disc.mass * approach * (1.0 if is_last else 1 + disc.restitution)
    compliance = 1 / disc.mass + disc.radius**2 / disc.inertia
    rub = float(np.clip(-slip / compliance, -disc.friction * push, disc.friction * push))
    before = _kinetic_energy(disc, state)
    state[3:5] += (push * normal + rub * tangent) / disc.mass
    state[5] += disc.radius * rub / disc.inertia
    motion.impact_losses.append(before - _kinetic_energy(disc, state))
    motion.events["impact"].append(time)
    if not is_last:
        return time, state, "flight"
    speed = float(tangent @ state[3:5])
    fall = disc.gravity * normal[1] + curvature * speed**2
    motion.events["rest"].append(time + 2 * disc.restitution * approach / fall / (1 - disc.restitution))
    slip = speed + disc.radius * state[5]
    way = [path.way(state[:2]), state[2], speed, state[5]]
    return time, np.array(way), "roll" if abs(slip) < 1e-12 else "slide"


def _touch(disc, path, time, state, phase, motion):
    """Slide or roll until that ends; the state is way, angle, and their rates."""
    sign = math.copysign(1.0, state[2] + disc.radius * state[3])
    compliance = 1 / disc.mass + disc.radius**2 / disc.inertia

    def forces(y):
        _, tangent, normal, curvature = path.at(y[0])
        push = disc.mass * (curvature * y[2] ** 2 + disc.gravity * normal[1])
        pull = -disc.gravity * tangent[1]
        return push, pull, (-pull / compliance if phase == "roll" else -sign * disc.friction * push)

    def rates(t, y):
        _, pull, rub = forces(y)
        return [y[2], y[3], pull + rub / disc.mass, disc.radius * rub / disc.inertia]

    def leaves(t, y):
        return forces(y)[0]

    def changes(t, y):
        push, _, rub = forces(y)
        if phase == "roll":
            return disc.friction * push - abs(rub)
        return sign * (y[2] + disc.radius * y[3])

    for event in (leaves, changes):
        event.terminal, event.direction = True, -1
    solution = solve_ivp(rates, (time, motion.times[-1]), state, events=(leaves, changes), **PRECISION)
    _record(motion, solution, time, lambda y: _whole_state(path, y))
    time, state = float(solution.t[-1]), solution.y[:, -1].copy()
    if solution.status != 1:
        return time, state, "end"
    if len(solution.t_events[0]):
        motion.events["separation"].append(time)
        return time, _whole_state(path, state), "flight"
    if phase == "roll":
        motion.events["slip"].append(time)
    push, pull, _ = forces(state)
    state[3] = -state[2] / disc.radius
    if phase == "slide" and abs(pull / compliance) <= disc.friction * push:
        motion.events["stick"].append(time)
        return time, state, "roll"
    state[2] += math.copysign(1e-15, pull)  # it slides the way that it is pulled without friction
    return time, state, "slide"


def _whole_state(path, state):
    place, tangent, _, _ = path.at(state[0])
    return np.array([*place, state[1], *(state[2] * tangent), state[3]])


def _record(motion, solution, start, expand):
    """Take the states at the times of one phase."""
    here = (motion.times >= start) & (motion.times <= solution.t[-1])
    if here.any():
        motion.states[here] = [expand(state) for state in solution.sol(motion.times[here]).T]


def _kinetic_energy(disc, state):
    return disc.mass / 2 * float(state[3] ** 2 + state[4] ** 2) + disc.inertia / 2 * float(state[5] ** 2)

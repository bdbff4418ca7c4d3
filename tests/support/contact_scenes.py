"""Scenes of rollers that touch outlines, and an integration of their motion by scipy with events."""

import math

import numpy as np
from scipy.integrate import solve_ivp

import governor_mechanism as gm

GRAVITY, ROLLER = 10.0, 0.02

DISC = [[0.1, 0, 0.1], [-0.1, 0, 0.1]]
"""The upper half of a disc of radius 0.1 m; the point (0, 0) is its centre."""

BOWL = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0], [0.15, 0, -0.15], [-0.15, 0], [-0.2, 0]]
"""A block with a hollow half circle of radius 0.15 m about (0, 0)."""

CUP = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.2], [0.1, 0.2], [0.1, 0], [-0.1, 0], [-0.1, 0.2], [-0.2, 0.2]]
"""A block with a rectangular pit, whose bottom is at y = 0 and whose walls stand at x = 0.1 and -0.1 m."""


def ball_document(outline, place, rates=(0.0, 0.0), **contact):
    """A ball of 1 kg under gravity, and a block that rests; the ball is a roller of radius 0.02 m."""
    contact = {"name": "ball", "first": "ball.origin", "radius": ROLLER, "second": "block", **contact}
    return {
        "machine": "custom",
        "size": 0.1,
        "ground": {"O": [0, 0]},
        "body": [
            {"name": "block", "mass": 1.0, "inertia": 1.0, "outline": outline},
            {"name": "ball", "mass": 1.0, "point": True, "at": list(place)},
        ],
        "joint": [{"type": "weld", "first": "ground.O", "second": "block.origin"}],
        "contact": [contact],
        "readings": {"x": {"x": "ball.origin"}, "y": {"y": "ball.origin"}},
        "effects": {"gravity": GRAVITY},
        "start": {"x": place[0], "y": place[1], "x_rate": rates[0], "y_rate": rates[1]},
        "run": {"duration": 1.0, "output_interval": 0.05, "accuracy": 1e-9},
    }


def run_ball(outline, place, rates=(0.0, 0.0), times=None, **contact):
    """Run the ball."""
    return gm.run(gm.Scene.from_dict(ball_document(outline, place, rates, **contact)), times=times)


def events_of(run, kind):
    """Return the times of the events of a kind."""
    return [event.time for event in run.events if event.kind is kind]


def bounce_on_disc(place, rates, restitution, times, radius=0.1 + ROLLER):
    """Return the states (n, 4) of a ball that falls on a disc and bounces, and the times of its impacts."""

    def fall(time, state):
        return [state[2], state[3], 0.0, -GRAVITY]

    def strike(time, state):
        return math.hypot(state[0], state[1]) - radius

    strike.terminal, strike.direction = True, -1
    state, time, states, impacts = np.array([*place, *rates]), 0.0, np.empty((len(times), 4)), []
    while True:
        precision = {"rtol": 1e-13, "atol": 1e-15, "method": "DOP853", "max_step": 2e-3}
        solution = solve_ivp(fall, (time, times[-1]), state, events=strike, dense_output=True, **precision)
        is_here = (times >= time) & (times <= solution.t[-1])
        states[is_here] = solution.sol(times[is_here]).T
        if solution.status != 1:
            return states, impacts
        state, time = solution.y[:, -1].copy(), float(solution.t[-1])
        normal = state[:2] / math.hypot(*state[:2])
        state[2:] -= (1 + restitution) * (normal @ state[2:]) * normal
        state[:2] = normal * radius * (1 + 1e-15)
        impacts.append(time)

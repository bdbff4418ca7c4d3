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


FLOOR = [[-2, -0.2], [2, -0.2], [2, 0], [-2, 0]]
"""A block whose upper side is y = 0."""

READINGS = ("x", "y", "turn")


def readings_of(body):
    """The readings x, y and turn of a body."""
    return {"x": {"x": f"{body}.origin"}, "y": {"y": f"{body}.origin"}, "turn": {"angle": body}}


def start_of(place, rates):
    """The start of the readings x, y and turn, of as many as there are."""
    return {**dict(zip(READINGS, place, strict=False)), **{f"{name}_rate": rate for name, rate in zip(READINGS, rates, strict=False)}}


def contact_document(outline, bodies, contacts, readings, start, joints=(), run=(1.0, 0.05), **tables):
    """Bodies under gravity and a block that rests; `run` gives duration and output interval."""
    block = {"name": "block", "mass": 1.0, "inertia": 1.0, "outline": outline}
    joints = [{"type": "weld", "first": "ground.O", "second": "block.origin"}, *joints]
    document = {"machine": "custom", "size": 0.1, "ground": {"O": [0, 0]}, "body": [block, *bodies], "joint": joints, "contact": contacts}
    document |= {"readings": readings, "effects": {"gravity": GRAVITY}, "start": start}
    return document | {"run": {"duration": run[0], "output_interval": run[1], "accuracy": 1e-9}} | tables


def ball_document(outline, place, rates=(0.0, 0.0), **contact):
    """A ball of 1 kg under gravity, and a block that rests; the ball is a roller of radius 0.02 m."""
    ball = {"name": "ball", "mass": 1.0, "point": True, "at": list(place)}
    contact = {"name": "ball", "first": "ball.origin", "radius": ROLLER, "second": "block", **contact}
    readings = {"x": {"x": "ball.origin"}, "y": {"y": "ball.origin"}}
    return contact_document(outline, [ball], [contact], readings, start_of(place, rates))


def outlines_document(outline, touched, **contact):
    """A ball and a block that touch with their outlines."""
    ball = {"name": "ball", "mass": 1.0, "inertia": 1.0, "at": [0.0, 2.0], "outline": outline}
    document = ball_document(touched, (0.0, 2.0))
    document["body"][1] = ball
    return document | {"contact": [{"first": "ball", "second": "block", **contact}]}


def disc_document(outline, place, rates, mass=1.5, inertia=4e-4, run=(1.0, 0.05), **contact):
    """A disc that turns, of the radius of the ball; its place and rates are those of x, y and turn."""
    disc = {"name": "ball", "mass": mass, "inertia": inertia, "at": list(place)}
    contacts = ball_document(outline, place, rates, **contact)["contact"]
    return contact_document(outline, [disc], contacts, readings_of("ball"), start_of(place, rates), run=run)


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

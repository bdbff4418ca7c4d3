"""Hard cases of weights on a straight line, all with an exact solution: stiffness, friction, stops, flight, tables."""

import math

import numpy as np
from scipy.linalg import eigh

from governor_mechanism.model.results.records import Outcome
from governor_mechanism.studies.hard_cases.case import (
    GRAVITY,
    Document,
    HardCase,
    Solution,
    bouncing_fall,
    linear_oscillation,
    rebounds_between_stops,
    run_table,
    slider_document,
)
from governor_mechanism.types import FloatArray

SPINDLE_SPEED = 20.0
"""Speed of the turning line, rad/s."""


def _nearly_astatic(ratio: float) -> Document:
    spring = {"position": {"rate": SPINDLE_SPEED**2 * (1 + ratio)}}
    effects = {"centrifugal": True, "spring": spring}
    return slider_document(start=0.1, rate=0.1, duration=2.0, effects=effects, spindle_speed=SPINDLE_SPEED)


def _solve_nearly_astatic(ratio: float, times: FloatArray) -> Solution:
    return {"position": linear_oscillation(times, 0.1, 0.1, stiffness=SPINDLE_SPEED**2 * ratio)}


def _stiff_dashpot(damping_ratio: float) -> Document:
    effects = {"spring": {"position": {"rate": 100.0}}, "dashpot": {"position": 20.0 * damping_ratio}}
    return slider_document(start=0.1, rate=1.0, duration=1.0, effects=effects)


def _solve_stiff_dashpot(damping_ratio: float, times: FloatArray) -> Solution:
    return {"position": linear_oscillation(times, 0.1, 1.0, stiffness=100.0, damping=20.0 * damping_ratio)}


def _stiff_spring(stiffness: float) -> Document:
    bodies = [{"name": name, "mass": 1.0, "turns": False, "at": [at, 0.0]} for name, at in (("near", 1.0), ("far", 2.0))]
    ends = [("ground.O", "near.origin", 1.0), ("near.origin", "far.origin", stiffness)]
    return {
        "machine": "custom",
        "ground": {"O": [0.0, 0.0]},
        "body": bodies,
        "joint": [{"type": "slider", "first": "ground.O", "second": f"{body['name']}.origin", "angle": 0.0} for body in bodies],
        "force": [{"type": "spring", "first": a, "second": b, "stiffness": k, "free_length": 1.0} for a, b, k in ends],
        "readings": {name: {"x": f"{name}.origin"} for name in ("near", "far")},
        "effects": {"gravity": False},
        "start": {"near": 1.1, "far": 2.1, "near_rate": 0.0, "far_rate": 0.01},
        "run": run_table(3.0),
    }


def _solve_stiff_spring(stiffness: float, times: FloatArray) -> Solution:
    squares, modes = eigh([[1.0 + stiffness, -stiffness], [-stiffness, stiffness]])
    amplitudes, rates = modes.T @ [0.1, 0.1], modes.T @ [0.0, 0.01]
    # The product of the squared frequencies is the stiffness; the small one, as a difference, would lose digits.
    squares[0] = stiffness / squares[1]
    parts = [linear_oscillation(times, *at, stiffness=float(square)) for *at, square in zip(amplitudes, rates, squares, strict=True)]
    displacements, velocities = (modes @ np.array(part) for part in zip(*parts, strict=True))
    return {name: (at + displacements[i], velocities[i]) for i, (name, at) in enumerate((("near", 1.0), ("far", 2.0)))}


def _friction_on_a_fall(ratio: float) -> Document:
    effects = {"gravity": GRAVITY, "dry_friction": {"position": ratio * GRAVITY}}
    return slider_document(start=0.0, duration=1.0, effects=effects, vertical=True)


def _solve_friction_on_a_fall(ratio: float, times: FloatArray) -> Solution:
    acceleration = -GRAVITY * max(1 - ratio, 0.0)
    return {"position": (0.5 * acceleration * times**2, acceleration * times)}


def _breakaway(time: float) -> Document:
    """Return a weight that friction of decreasing force holds until a time."""
    effects = {"gravity": GRAVITY, "dry_friction": {"position": [[0.0, 2 * GRAVITY], [2 * time, 0.0]]}}
    return slider_document(start=0.0, duration=1.0, effects=effects, vertical=True)


def _solve_breakaway(time: float, times: FloatArray) -> Solution:
    since = np.maximum(times - time, 0.0)
    return {"position": (-GRAVITY * since**3 / (6 * time), -GRAVITY * since**2 / (2 * time))}


def _bouncing(restitution: float) -> Document:
    effects = {"gravity": GRAVITY, "stops": {"position": [0.0, "none"], "restitution": restitution}}
    return slider_document(start=0.1, duration=3.0, effects=effects, vertical=True)


def _solve_bouncing(restitution: float, times: FloatArray) -> Solution:
    return {"position": bouncing_fall(times, 0.1, 0.0, restitution)}


def _started_on_stop(speed: float) -> Document:
    effects = {"gravity": GRAVITY, "stops": {"position": [0.0, "none"], "restitution": 0.5}}
    return slider_document(start=0.0, rate=-speed, duration=1.0, effects=effects, vertical=True)


def _solve_started_on_stop(speed: float, times: FloatArray) -> Solution:
    return {"position": bouncing_fall(times, 0.0, 0.5 * speed, 0.5)}


def _between_stops(gap: float) -> Document:
    effects = {"gravity": False, "stops": {"position": [0.0, gap], "restitution": 0.9}}
    return slider_document(start=0.5 * gap, rate=1.0, duration=1.0, effects=effects)


def _solve_between_stops(gap: float, times: FloatArray) -> Solution:
    return {"position": rebounds_between_stops(times, gap, 1.0, 0.9)}


def _flight(speed: float) -> Document:
    return slider_document(start=0.1, duration=10.0, effects={"centrifugal": True}, spindle_speed=speed)


def _solve_flight(speed: float, times: FloatArray) -> Solution:
    return {"position": (0.1 * np.cosh(speed * times), 0.1 * speed * np.sinh(speed * times))}


def _motion_table(n_points: float) -> Document:
    times = np.linspace(0.0, 3.0, int(n_points))
    document = slider_document(start=0.0, duration=3.0, effects={"gravity": False})
    motion = np.column_stack([times, 0.1 * times**3]).tolist()
    drive = {"type": "driven_slide", "first": "ground.O", "second": "weight.origin", "angle": 0.0, "motion": motion}
    return document | {"joint": [*document["joint"], drive], "start": {}}


def _solve_motion_table(n_points: float, times: FloatArray) -> Solution:
    return {"position": (0.1 * times**3, 0.3 * times**2)}


def _not_a_number(value: float) -> Document:
    effects = {"gravity": GRAVITY, "dry_friction": {"position": [[0.0, 1.0], [1.0, value]]}}
    return slider_document(start=0.0, duration=1.0, effects=effects, vertical=True)


CASES = (
    HardCase(
        name="nearly-astatic",
        title="Spring that nearly balances the centrifugal load",
        parameter="stiffness that remains, relative to the spring",
        values=(1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
        short_values=(1e-12,),
        make_document=_nearly_astatic,
        solve=_solve_nearly_astatic,
    ),
    HardCase(
        name="stiff-dashpot",
        title="Dashpot far beyond critical damping",
        parameter="damping ratio",
        values=(1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6),
        short_values=(1e6,),
        make_document=_stiff_dashpot,
        solve=_solve_stiff_dashpot,
        named_ends={
            Outcome.STIFF: "reduced integrates explicitly",
            Outcome.STEP_LIMIT: "an explicit engine needs too many steps",
            Outcome.JOINT_OPENED: "impulse applies the force of a whole step at once, and its joints do not hold it",
        },
    ),
    HardCase(
        name="stiff-spring",
        title="Two weights joined by a stiff spring",
        parameter="ratio of the stiffnesses",
        values=(1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6),
        short_values=(1e2,),
        make_document=_stiff_spring,
        solve=_solve_stiff_spring,
        named_ends={Outcome.STEP_LIMIT: "the fast oscillation has to be followed"},
    ),
    HardCase(
        name="sticking",
        title="Dry friction from almost none to a thousand times the load",
        parameter="friction relative to the load",
        values=(1e-12, 1e-6, 1e-3, 0.5, 1 - 1e-9, 1.0, 1 + 1e-9, 1e3),
        short_values=(1.0, 1 - 1e-9),
        make_document=_friction_on_a_fall,
        solve=_solve_friction_on_a_fall,
    ),
    HardCase(
        name="breakaway",
        title="Friction that holds until late in the run",
        parameter="time of the breakaway, s; the run ends at 1 s",
        values=(0.5, 0.9, 0.99, 0.9999, 1 - 1e-9, 1.0),
        short_values=(0.99,),
        make_document=_breakaway,
        solve=_solve_breakaway,
    ),
    HardCase(
        name="bouncing",
        title="Weight that bounces on a stop until it rests",
        parameter="restitution",
        values=(0.0, 0.3, 0.7, 0.9, 0.99, 0.999),
        short_values=(0.7,),
        make_document=_bouncing,
        solve=_solve_bouncing,
    ),
    HardCase(
        name="start-on-stop",
        title="Weight that starts on a stop, with a velocity into it",
        parameter="speed into the stop, m/s",
        values=(0.0, 1e-9, 1e-6, 1e-3, 1.0),
        short_values=(0.0, 1.0),
        make_document=_started_on_stop,
        solve=_solve_started_on_stop,
    ),
    HardCase(
        name="two-stops",
        title="Weight that rebounds between two close stops",
        parameter="distance of the stops, m",
        values=(1e-1, 1e-2, 1e-3, 1e-4, 1e-5),
        short_values=(1e-3,),
        make_document=_between_stops,
        solve=_solve_between_stops,
    ),
    HardCase(
        name="flight",
        title="Weight that flies out in the turning plane",
        parameter="spindle speed, rad/s",
        values=(0.1, 1.0, 1e1, 1e2, 1e3),
        short_values=(1e2,),
        make_document=_flight,
        solve=_solve_flight,
        named_ends={Outcome.LEFT_RANGE: "the weight leaves every bound", Outcome.STEP_LIMIT: "the weight leaves every bound"},
    ),
    HardCase(
        name="motion-table",
        title="Table of motion with points of a cubic",
        parameter="number of points",
        values=(4.0, 10.0, 100.0, 1000.0, 5000.0),
        short_values=(4.0,),
        make_document=_motion_table,
        solve=_solve_motion_table,
        named_ends={Outcome.STEP_LIMIT: "every point of the table ends a step"},
    ),
    HardCase(
        name="not-a-number",
        title="Table of friction with a value that is no number",
        parameter="the value",
        values=(math.nan, math.inf),
        short_values=(math.nan,),
        make_document=_not_a_number,
        refused_values=(math.nan, math.inf),
    ),
)

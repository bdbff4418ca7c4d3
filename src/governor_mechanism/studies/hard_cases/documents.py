"""Scenes that several hard cases vary."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any

from governor_mechanism.scenes.library import load_scene
from governor_mechanism.studies.hard_cases.case import Document

SAMPLES_PER_RUN = 100
"""Number of output intervals of a run."""

GRAVITY = 9.81
"""Gravity of all cases, m/s2."""


def run_table(duration: float, accuracy: float = 1e-6) -> Document:
    """Return the table of a run of a duration, s."""
    return {"duration": duration, "output_interval": duration / SAMPLES_PER_RUN, "accuracy": accuracy}


def slider_document(
    *,
    start: float,  # position at the start, m
    rate: float = 0.0,  # velocity at the start, m/s
    duration: float,  # duration, s
    effects: Mapping[str, Any],
    # speed, rad/s, of the spindle that the line turns with; None: the plane is fixed
    spindle_speed: float | None = None,
    vertical: bool = False,
    accuracy: float = 1e-6,
) -> Document:
    """Return a weight of 1 kg on a straight line, with its position as the reading `position`."""
    turning = {} if spindle_speed is None else {"plane": "turning", "spindle": {"speed": spindle_speed}}
    return {
        "machine": "custom",
        "size": 1.0,
        "ground": {"O": [0.0, 0.0]},
        "body": [{"name": "weight", "mass": 1.0, "turns": False, "at": [0.0, start] if vertical else [start, 0.0]}],
        "joint": [{"type": "slider", "first": "ground.O", "second": "weight.origin", "angle": "90 deg" if vertical else 0.0}],
        "readings": {"position": {"y" if vertical else "x": "weight.origin"}},
        "effects": dict(effects),
        "start": {"position": start, "position_rate": rate},
        "run": run_table(duration, accuracy),
        **turning,
    }


def rod(name: str, length: float, *, at: Sequence[float] = (0.0, 0.0), angle: float = 0.0, mass: float = 1.0) -> Document:
    """Return a uniform rod as a body, with its start at a point and its angle, rad."""
    return {"name": name, "mass": mass, "rod": {"length": length}, "at": list(at), "angle": angle}


def pin(first: str, second: str) -> Document:
    """Return a pin joint between two points."""
    return {"type": "pin", "first": first, "second": second}


def governor_document(
    *,
    ball_mass: float = 5.0,
    sleeve_mass: float = 20.0,
    size: float = 1.0,
    spindle: Mapping[str, Any],
    start: Mapping[str, Any],
    duration: float,
) -> Document:
    """Return a Porter governor with gravity and centrifugal load; `size` multiplies its lengths."""
    return {
        "machine": "pendulum_governor",
        "dimensions": {"arm": f"{0.3 * size!r} m", "offset": f"{0.04 * size!r} m", "ball_mass": ball_mass, "sleeve_mass": sleeve_mass},
        "effects": {"gravity": GRAVITY, "centrifugal": True},
        "spindle": dict(spindle),
        "start": dict(start),
        "run": run_table(duration),
    }


def shipped_document(name: str, changes: Mapping[str, Any]) -> Document:
    """Return a shipped scene with changed values of its tables, by keys such as "effects.clearance"."""
    document: Document = copy.deepcopy(dict(load_scene(name).document))
    for key, value in changes.items():
        table, _, last = key.rpartition(".")
        document[table] = {**document[table], last: value}
    return document

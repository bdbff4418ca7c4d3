"""Documents of scenes for the tests, as scene files give them: of a mechanism of one's own, a line for each part, and of a governor."""

from collections.abc import Mapping, Sequence
from typing import Any

from governor_scenes import PORTER

Table = dict[str, Any]

ORIGIN = {"A": [0, 0]}
"""Ground with a point at the origin."""


def custom_document(*, ground: Table = ORIGIN, body: Sequence[Table], joint: Sequence[Table], readings: Table, **tables: Any) -> Table:
    """A mechanism of one's own that runs for a second; further tables are added."""
    own = {"machine": "custom", "ground": ground, "body": [*body], "joint": [*joint], "readings": readings, "run": {"duration": "1 s"}}
    return own | tables


def governor_document(dimensions: Mapping[str, Any] = PORTER, **tables: Any) -> Table:
    """A pendulum governor, the Porter governor if no other is given, under gravity at 12.2 rad/s for a second; further tables are added."""
    given = {"machine": "pendulum_governor", "dimensions": {**dimensions}, "effects": {"gravity": True, "centrifugal": True}}
    return given | {"spindle": {"speed": 12.2}, "start": {"arm_angle": 0.5}, "run": {"duration": 1.0}} | tables


def rod(name: str, length: float | str = 1, mass: float | str = 1, **keys: Any) -> Table:
    """A body that is a rod."""
    return {"name": name, "mass": mass, "rod": {"length": length}, **keys}


def between(kind: str, first: str, second: str, **keys: Any) -> Table:
    """A joint or a force of a kind between two points or two bodies."""
    return {"type": kind, "first": first, "second": second, **keys}


def pin(first: str, second: str, **keys: Any) -> Table:
    """A pin joint of two points."""
    return between("pin", first, second, **keys)

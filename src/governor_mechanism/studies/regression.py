"""What studies share: a run without a certificate, and a slope with its scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines import choose
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray

SLEEVE = "sleeve_lift"
"""The reading of a governor's sleeve."""


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """A number fitted to runs: its value, and its scatter (one standard deviation, from how the runs stray)."""

    value: float
    scatter: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ± {self.scatter:.1g}"


def uncertified(scene: Scene) -> Trajectory:
    """Uncertified: many runs are compared, and their tolerance stays that of the scene's accuracy."""
    engine, reason = choose(scene.run.engine, scene)
    run = engine.run(scene, certify=False, reason=reason)
    run.raise_if_failed()
    return run


def slope(x: FloatArray, y: FloatArray, more: FloatArray | None = None) -> Fitted:
    """Of a straight line through the points, by least squares, beside a multiple of `more` where that is given."""
    columns = np.column_stack([x, np.ones_like(x), *([] if more is None else [more])])
    spare = len(x) - columns.shape[1]
    if spare < 1:
        return Fitted(value=math.nan, scatter=math.nan)
    found = np.linalg.lstsq(columns, y, rcond=None)[0]
    variance = float(np.sum((y - columns @ found) ** 2)) / spare
    return Fitted(value=float(found[0]), scatter=math.sqrt(variance * np.linalg.inv(columns.T @ columns)[0, 0]))

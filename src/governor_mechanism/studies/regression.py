"""Shared by the studies: a run without certificate, and a linear regression with its standard error."""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines import select_engine
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

SLEEVE_READING = "sleeve_lift"
"""Name of the reading that measures the lift of a governor's sleeve."""


@dataclass(frozen=True, kw_only=True)
class FittedParameter:
    """A fitted parameter.

    Attributes
    ----------
    value
        Least-squares estimate.
    standard_error
        Standard error of the estimate, from the residuals of the fit.
    """

    value: float
    standard_error: float

    def __str__(self) -> str:
        """Return value and standard error."""
        return f"{self.value:.4g} ± {self.standard_error:.1g}"


def run_uncertified(scene: Scene) -> Trajectory:
    """Run a scene without certificate at the tolerance of its accuracy, for studies that compare many runs."""
    engine, reason = select_engine(scene.run.engine, scene)
    run = engine.run(scene, certify=False, reason=reason)
    run.raise_if_failed()
    return run


def fit_slope(x: FloatArray, y: FloatArray) -> FittedParameter:
    """Return the slope of a least-squares line y(x), shape (n,) each."""
    design_matrix = np.column_stack([x, np.ones_like(x)])
    degrees_of_freedom = len(x) - design_matrix.shape[1]
    if degrees_of_freedom < 1:
        return FittedParameter(value=math.nan, standard_error=math.nan)
    coefficients = np.linalg.lstsq(design_matrix, y, rcond=None)[0]
    residual_variance = float(np.sum((y - design_matrix @ coefficients) ** 2)) / degrees_of_freedom
    slope_variance = residual_variance * np.linalg.inv(design_matrix.T @ design_matrix)[0, 0]
    return FittedParameter(value=float(coefficients[0]), standard_error=math.sqrt(slope_variance))

"""Points fixed in bodies, as fields of records."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism

Origins = Mapping[str, tuple[float, float]]
"""Origin of each body by name, in body axes (m); the mass centre if left out."""


def rotate_vector(angle: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the components of the vector (x, y), floats or arrays, rotated by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def attachment_fields(mechanism: Mechanism, first: Point, second: Point, origins: Origins) -> tuple[float, ...]:
    """Return the fields of two points in a record: both bodies, then x and y (m) of each relative to its body's origin."""
    bodies = [mechanism.body_index(point.body) for point in (first, second)]
    coordinates = []
    for point in (first, second):
        x, y = origins.get(point.body, (0.0, 0.0))
        coordinates += [point.x - x, point.y - y]
    return (*bodies, *coordinates)

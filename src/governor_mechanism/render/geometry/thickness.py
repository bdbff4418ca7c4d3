"""How thick shapes are across the plane in which they turn with a spindle, and what they look like from outside."""

import numpy as np

from governor_mechanism.render.geometry.recording import RecordedShape

SPHERE_ROLE = "ball"
SEEN_AS = {"weight section": SPHERE_ROLE}
"""Role that a shape in section has from outside."""

_MAX_RATIO = 0.018
"""Largest half thickness of a bar or plate, relative to the larger side of the drawing; a weight is as thick as it is high."""
_PIN_LENGTH_RATIO = 1.6
"""Half the length of a pin, relative to its radius: it ends outside the bars that it joins."""


def find_half_thickness(shape: RecordedShape, size: float) -> float | None:
    """Return half the thickness of a shape of a drawing whose larger side is `size`, or None for what does not turn.

    The thickness of a ball is its diameter, and that of a bar its width.
    """
    if not shape.part.turns or shape.part.section_only or shape.changing or shape.kind == "text" or not shape.points.size:
        return None
    if shape.kind == "circle":
        radius = float(shape.radii[0])
        return radius if shape.role == SPHERE_ROLE else _PIN_LENGTH_RATIO * radius
    if shape.kind == "lines":
        return 0.0
    outline = shape.points[0] - shape.points[0].mean(axis=0)
    _, _, axes = np.linalg.svd(outline, full_matrices=False)
    half_width = float(np.ptp(outline @ axes.T, axis=0).min()) / 2
    return half_width if SEEN_AS.get(shape.role, shape.role) == SPHERE_ROLE else min(half_width, _MAX_RATIO * size)

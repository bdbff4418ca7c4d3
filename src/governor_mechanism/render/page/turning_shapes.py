"""Which shapes of a plane that turns with a spindle turn with it, for the view from outside, and how thick they are.

Bodies of revolution look the same from all sides, and what is fixed to the frame stays where it is.
"""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.render.page.recording import PICTURE_SIZE, RecordedShape

FIXED_ROLES = frozenset(
    {
        "axis",
        "bearing",
        "bearing hatching",
        "hatching",
        "scale",
        "pointer",
        "dashpot",
        "bore",
        "oil",
        "piston",
        "piston rod",
        "wall",
        "guide",
        "lens",
        "division",
        "leader",
        "spindle",
        "spindle shade",
        "engraving",
        "shoe",
        "held shoe",
        "burst",
        "struck",
        "eyelet",
        "drive",
    }
)
"""Roles of shapes that are fixed to the frame or round."""
FIXED_GROUPS = frozenset({"throttle", "gearing"})
"""First words of such roles."""
HIDDEN_ROLES = frozenset(
    {
        "ball shine",
        "weight bore",
        "trace",
        "lens",
        "force",
        "reaction",
        "tracer",
        "angle arc",
        "angle ray",
        "letter",
        "weight section hatching",
    }
)
"""Roles that the view from outside leaves out: what only a section shows, and the shine, which is on the front of a ball anyway."""
KEYED_ROLES = frozenset({"frame", "frame plate", "rod", "coil", "coil behind", "coil edge", "arm", "link", "plate"})
"""Roles of shapes that turn though they are as long to the left of the axis as to the right."""
SPHERE_ROLE = "ball"
SEEN_AS = {"weight section": SPHERE_ROLE}
"""Role that a shape in section has from outside."""

_MAX_HALF_THICKNESS = 0.018 * PICTURE_SIZE
"""Largest half thickness of a bar or plate; a weight is as thick as it is high."""
_CAPTION_RATIO = 0.3
"""Height of the caption above an enlarged detail, relative to that of the detail."""
_PIN_LENGTH_RATIO = 1.6
"""Half the length of a pin, relative to its radius: it ends outside the bars that it joins."""
_SYMMETRY_RATIO = 0.04
"""Difference of the extents to both sides of the axis, relative to their sum, below which a shape is round."""


def find_details(shapes: Sequence[RecordedShape]) -> set[int]:
    """Return the indices of the shapes of enlarged details, which are no part of the machine: those in a lens, and its caption."""
    boxes = [(shape.points[0].min(axis=0), shape.points[0].max(axis=0)) for shape in shapes if shape.role == "lens"]
    details = set()
    for low, high in boxes:
        caption_low = low - [0.0, _CAPTION_RATIO * (high[1] - low[1])]
        for index, shape in enumerate(shapes):
            edge = caption_low if shape.kind == "text" else low
            if shape.points.size and bool(np.all(shape.points >= edge - 1.0) and np.all(shape.points <= high + 1.0)):
                details.add(index)
    return details


def find_half_thickness(shape: RecordedShape, axis: float) -> float | None:
    """Return half the thickness of a shape across its plane (units of the picture) if it turns about the axis at x = `axis`, or None.

    The thickness of a ball is its diameter, and that of a bar its width.
    """
    if (
        shape.role in FIXED_ROLES
        or shape.role.split()[0] in FIXED_GROUPS
        or shape.changing
        or shape.kind == "text"
        or not shape.points.size
    ):
        return None
    reach = shape.points[..., 0] - axis
    radius = float(shape.radii[0]) if len(shape.radii) else 0.0
    right, left = float(reach.max()) + radius, radius - float(reach.min())
    if shape.role not in KEYED_ROLES and abs(right - left) <= _SYMMETRY_RATIO * (right + left):
        return None
    if shape.kind == "circle":
        return radius if shape.role == SPHERE_ROLE else _PIN_LENGTH_RATIO * radius
    if shape.kind == "lines":
        return 0.0
    outline = shape.points[0] - shape.points[0].mean(axis=0)
    _, _, axes = np.linalg.svd(outline, full_matrices=False)
    half_width = float(np.ptp(outline @ axes.T, axis=0).min()) / 2
    return half_width if SEEN_AS.get(shape.role, shape.role) == SPHERE_ROLE else min(half_width, _MAX_HALF_THICKNESS)

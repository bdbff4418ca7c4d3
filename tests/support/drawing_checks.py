"""Drawings of runs: what they show at each report, and what every drawing keeps."""

import itertools
from functools import cached_property

from governor_mechanism.render.geometry.primitives import TextShape, bounding_box
from governor_mechanism.render.machines.registry import drawing_of


class Drawn:
    """The drawing of a part of a run: what stands still, and what moves, by report."""

    def __init__(self, run, part=None):
        self.run, self.drawing = run, drawing_of(run, part or run.scene.part)

    @cached_property
    def still(self):
        return list(self.drawing.background_shapes())

    @cached_property
    def moving(self):
        return [self.at(k) for k in range(len(self.run.times))]

    def at(self, k):
        """Return what moves at report k."""
        return list(self.drawing.moving_shapes(self.run.poses[k], float(self.run.times[k])))

    def roles(self, k=0):
        """Return the roles of all shapes at report k."""
        return {shape.role for shape in (*self.still, *self.at(k))}

    def shown_lift(self, k):
        """Return the lift (m) that the pointer of a governor shows on its scale, which has a number at either end, at report k."""
        low, *_, high = (one for one in of_role(self.still, "scale", TextShape) if not one.text.isalpha())  # not the key of shoes
        first, last = (float(mark.text.removesuffix(" mm")) / 1e3 for mark in (low, high))
        tip = of_role(self.at(k), "pointer")[0].points[0][1]
        return first + (tip - low.y) / (high.y - low.y) * (last - first)


def of_role(shapes, role, kind=object):
    """Return the shapes of a role, of one kind if asked."""
    return [shape for shape in shapes if shape.role == role and isinstance(shape, kind)]


def assert_within(shapes, box, *, margin: float = 0.0) -> None:
    """Assert that shapes stay within a box (left, right, bottom, top), strictly, or up to a margin."""
    x0, x1, y0, y1 = bounding_box(shapes)
    left, right, bottom, top = box
    assert left - margin < x0 < x1 < right + margin
    assert bottom - margin < y0 < y1 < top + margin


def assert_shapes_keep(drawn: Drawn, every: int = 1) -> None:
    """Assert that the moving shapes have the same kinds and roles at every pose, and that all shapes stay within the view."""
    moving = [drawn.at(k) for k in range(0, len(drawn.run.times), every)]
    assert len({tuple((type(shape), shape.role) for shape in shapes) for shapes in moving}) == 1
    assert_within([*drawn.still, *itertools.chain(*moving)], drawn.drawing.bounds)

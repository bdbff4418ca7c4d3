"""What every drawing of a machine keeps at every pose of a run."""

import itertools

from governor_mechanism.render.geometry.primitives import bounding_box


def assert_shapes_keep(drawing, run, every: int = 1) -> None:
    """Assert that the moving shapes have the same kinds and roles at every pose, and that all shapes stay within the view."""
    poses = zip(run.poses[::every], run.times[::every], strict=True)
    moving = [list(drawing.moving_shapes(pose, float(time))) for pose, time in poses]
    assert len({tuple((type(shape), shape.role) for shape in shapes) for shapes in moving}) == 1
    left, right, bottom, top = drawing.bounds
    x0, x1, y0, y1 = bounding_box([*drawing.background_shapes(), *itertools.chain(*moving)])
    assert left < x0 < x1 < right
    assert bottom < y0 < y1 < top

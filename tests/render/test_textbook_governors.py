"""Drawings of the Hartnell and the Proell governor: parts stand where the mechanism stands, with their effects."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from drawing_checks import assert_shapes_keep
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon
from governor_mechanism.render.machines.hartnell import HartnellDrawing
from governor_mechanism.render.machines.proell import ProellDrawing
from governor_mechanism.render.machines.registry import drawing_of

HARTNELL = {
    "run.duration": "1 s",
    "effects.stops": {"sleeve": ["0 mm", "15 mm"], "restitution": 0.0},
    "effects.dry_friction": {"sleeve": "1 N"},
}
PROELL = {"run.duration": "1 s", "dimensions.offset": "20 mm", "dimensions.lug_offset": "35 mm"}


@pytest.fixture(scope="module", params=["hartnell", "proell"])
def drawn(request):
    run = gm.run(gm.load(request.param).replace(HARTNELL if request.param == "hartnell" else PROELL))
    return run, drawing_of(run, run.scene.part)


def test_every_pose_has_the_same_shapes_within_the_view(drawn):
    run, drawing = drawn
    assert_shapes_keep(drawing, run)
    assert len(list(drawing.plan_shapes(run.poses[0], 0.3))) == len(list(drawing.plan_shapes(run.poses[-1], 2.0)))


def test_the_balls_and_the_traced_path_are_those_of_the_readings(drawn):
    run, drawing = drawn
    path = drawing.traced_path(run.poses)
    np.testing.assert_allclose(path[:, 0], run.readings["ball_radius"], atol=1e-12)
    shapes = drawing.moving_shapes(run.poses[-1], float(run.times[-1]))
    balls = [shape for shape in shapes if isinstance(shape, Circle) and shape.role == "ball"]
    assert [ball.x for ball in balls] == pytest.approx([-path[-1, 0], path[-1, 0]], rel=1e-9)


def test_the_flange_of_a_hartnell_sleeve_lies_on_the_rollers_under_the_spring():
    run = gm.run(gm.load("hartnell").replace(HARTNELL))
    drawing = drawing_of(run, run.scene.part)
    assert isinstance(drawing, HartnellDrawing)
    for row in (0, len(run.times) // 2, -1):
        shapes = list(drawing.moving_shapes(run.poses[row], float(run.times[row])))
        rollers = [shape for shape in shapes if isinstance(shape, Circle) and shape.role == "eyelet"]
        (sleeve,) = (shape for shape in shapes if isinstance(shape, Polygon) and shape.role == "sleeve")
        heights = {round(y, 9) for _, y in sleeve.points}
        for roller in rollers:
            assert round(roller.y + roller.radius, 9) in heights
            assert abs(roller.x) < max(x for x, _ in sleeve.points)
        assert rollers[1].y == pytest.approx(run.readings["sleeve_lift"][row], abs=1e-9)  # pivots and rollers are level at zero lift
        (spring,) = (shape for shape in shapes if isinstance(shape, Lines) and shape.role == "spring")
        ys = [y for line in spring.lines for _, y in line]
        assert min(ys) == pytest.approx(max(y for _, y in sleeve.points), abs=1e-9)
        assert max(ys) == pytest.approx(drawing.cap_height, rel=1e-12)


def test_stops_of_the_arms_are_drawn_where_they_hold_the_sleeve():
    """A stop of the balls' radius at 130 mm holds the rollers where their arm of 80 mm has turned by asin(10 / 120)."""
    scene = gm.load("hartnell").replace({"run.duration": "20 ms", "effects.stops": {"ball_radius": ["119 mm", "130 mm"]}})
    run = gm.run(scene)
    drawing = drawing_of(run, run.scene.part)
    assert isinstance(drawing, HartnellDrawing)
    assert drawing.stop_heights == pytest.approx((-0.08 / 120, 0.08 / 12), rel=1e-12)


def test_the_extension_of_a_proell_arm_ends_in_the_ball():
    run = gm.run(gm.load("proell").replace(PROELL))
    drawing = drawing_of(run, run.scene.part)
    assert isinstance(drawing, ProellDrawing)
    for side in drawing.sides(run.poses[-1]):
        assert math.dist(side.link_joint, side.ball) == pytest.approx(0.1, rel=1e-9)
        assert math.dist(side.arm_pivot, side.link_joint) == pytest.approx(0.25, rel=1e-9)
        assert math.dist(side.link_joint, side.link_end) == pytest.approx(0.25, rel=1e-9)

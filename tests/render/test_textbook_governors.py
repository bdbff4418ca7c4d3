"""Drawings of the Hartnell and the Proell governor: parts stand where the mechanism stands, with their effects."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon
from governor_mechanism.render.machines.hartnell import HartnellDrawing
from governor_mechanism.render.machines.proell import ProellDrawing

HARTNELL = {
    "run.duration": "1 s",
    "effects.stops": {"sleeve": ["0 mm", "15 mm"], "restitution": 0.0},
    "effects.dry_friction": {"sleeve": "1 N"},
}
PROELL = {"run.duration": "1 s", "dimensions.offset": "20 mm", "dimensions.lug_offset": "35 mm"}


@pytest.fixture(scope="module", params=["hartnell", "proell"])
def drawn(request):
    return draw(request.param)


def draw(name):
    return Drawn(gm.run(gm.load(name).replace(HARTNELL if name == "hartnell" else PROELL)))


def test_every_pose_has_the_same_shapes_within_the_view(drawn):
    assert_shapes_keep(drawn)
    first, last = (list(drawn.drawing.plan_shapes(drawn.run.poses[k], angle)) for k, angle in ((0, 0.3), (-1, 2.0)))
    assert len(first) == len(last)


def test_the_balls_and_the_traced_path_are_those_of_the_readings(drawn):
    path = drawn.drawing.traced_path(drawn.run.poses)
    np.testing.assert_allclose(path[:, 0], drawn.run.readings["ball_radius"], atol=1e-12)
    assert [ball.x for ball in of_role(drawn.at(-1), "ball", Circle)] == pytest.approx([-path[-1, 0], path[-1, 0]], rel=1e-9)


def test_the_pointer_shows_the_lift_on_the_scale(drawn):
    for row in (0, len(drawn.run.times) // 2, -1):
        assert drawn.shown_lift(row) == pytest.approx(drawn.run.readings["sleeve_lift"][row], abs=1e-9)


def test_the_flange_of_a_hartnell_sleeve_lies_on_the_rollers_under_the_spring():
    drawn = draw("hartnell")
    assert isinstance(drawn.drawing, HartnellDrawing)
    for row in (0, len(drawn.run.times) // 2, -1):
        shapes = drawn.at(row)
        rollers = of_role(shapes, "eyelet", Circle)
        (sleeve,) = of_role(shapes, "sleeve", Polygon)
        heights = {round(y, 9) for _, y in sleeve.points}
        for roller in rollers:
            assert round(roller.y + roller.radius, 9) in heights
            assert abs(roller.x) < max(x for x, _ in sleeve.points)
        assert rollers[1].y == pytest.approx(drawn.run.readings["sleeve_lift"][row], abs=1e-9)  # pivots and rollers are level at zero lift
        (spring,) = of_role(shapes, "spring", Lines)
        ys = [y for line in spring.lines for _, y in line]
        assert min(ys) == pytest.approx(max(y for _, y in sleeve.points), abs=1e-9)
        assert max(ys) == pytest.approx(drawn.drawing.cap_height, rel=1e-12)


def test_stops_of_the_arms_are_drawn_where_they_hold_the_sleeve():
    """A stop of the balls' radius at 130 mm holds the rollers where their arm of 80 mm has turned by asin(10 / 120)."""
    scene = gm.load("hartnell").replace({"run.duration": "20 ms", "effects.stops": {"ball_radius": ["119 mm", "130 mm"]}})
    assert Drawn(gm.run(scene)).drawing.stop_heights == pytest.approx((-0.08 / 120, 0.08 / 12), rel=1e-12)


def test_the_extension_of_a_proell_arm_ends_in_the_ball():
    drawn = draw("proell")
    assert isinstance(drawn.drawing, ProellDrawing)
    for side in drawn.drawing.sides(drawn.run.poses[-1]):
        assert math.dist(side.link_joint, side.ball) == pytest.approx(0.1, rel=1e-9)
        assert math.dist(side.arm_pivot, side.link_joint) == pytest.approx(0.25, rel=1e-9)
        assert math.dist(side.link_joint, side.link_end) == pytest.approx(0.25, rel=1e-9)
